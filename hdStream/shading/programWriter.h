// SPDX-License-Identifier: Apache-2.0
// Expressions -> the words of a program (kernels/shared/program.h) for one prim. Part of the
// material compiler. Explained in docs/shading.md.
#pragma once

#include "hdStream/shading/valueResolver.h"
#include "kernels/shared/compat.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// An input and what sets it.
struct ProgramInput {
    std::uint32_t input = 0; ///< HDS_INPUT_*
    ShaderValue value;       ///< of a ValueResolver: its primvars are all there
};

/// Displacement that hits are bumped by (HDS_OP_AUTOBUMP).
struct ProgramRelief {
    ShaderValue value;                  ///< as ProgramInput's; empty: none
    std::uint32_t space = 0;            ///< HDS_DISPLACES_*
    std::uint32_t movedSlot = HDS_NONE; ///< attribute slots; HDS_NONE: there is none
    std::uint32_t normalSlot = HDS_NONE;
    std::uint32_t coordinateSlot = HDS_NONE;
};

/// A program that sets the inputs: first those that a mask needs, then HDS_OP_MASK_END, then the
/// others, at the bumped normal if there is a relief. An expression that feeds several inputs is
/// evaluated once.
/// \param textures index in the scene of each texture that tiles name.
/// \param tangentSlot of the coordinates that the surface's tangent belongs to; HDS_NONE: of none
/// \return empty when the expressions are too deep or too long for the machine.
std::vector<std::uint32_t> WriteProgram(const std::vector<ProgramInput>& inputs,
                                        const std::vector<std::uint32_t>& textures,
                                        const SlotCallback& findSlot,
                                        std::uint32_t tangentSlot = HDS_NONE,
                                        const ProgramRelief& relief = {});

/// Adds to the offsets of all positions and carried points of a space (HDS_SPACE_*) in programs
/// that lie one after another.
void OffsetPositions(std::vector<std::uint32_t>* programs, std::uint32_t space,
                     const std::array<float, 3>& offset);

/// Whether some instruction belongs to patterns (HDS_FEATURE_PATTERNS).
bool HasPatterns(const std::vector<std::uint32_t>& programs);

/// Whether some hit takes one of several closures, or scales what it reflects
/// (HDS_FEATURE_CLOSURES).
bool HasClosures(const std::vector<std::uint32_t>& programs);

/// Whether some instruction asks for the side of glass that is seen (HDS_LOBE_COVERED).
bool HasInside(const std::vector<std::uint32_t>& programs);

/// Whether some program carries points or vectors to another space (HDS_FEATURE_TRANSFORMS).
bool HasTransforms(const std::vector<std::uint32_t>& programs);

/// Whether some hit is bumped by what its triangles lack of displacement (HDS_FEATURE_AUTOBUMP).
bool HasAutobump(const std::vector<std::uint32_t>& programs);

/// Whether a program computes more than sums and products: these may be of chosen texels, as what a
/// surface reflects is, but a threshold, a root or a slope is of the filter's value.
bool NeedsFilteredTexels(const std::vector<std::uint32_t>& program);

/// Whether an expression is evaluated beside the place that was hit (Kind::Shifted).
bool HasSlope(const ShaderValue& value);

/// Whether an image is looked up somewhere in an expression at coordinates that have derivatives:
/// tangent space is that of the first such coordinates.
bool HasFrame(const ShaderValue& value);

/// Look-ups of textures in a program.
std::uint32_t CountLookups(const std::vector<std::uint32_t>& program);

} // namespace hds
