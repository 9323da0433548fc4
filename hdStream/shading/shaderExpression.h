// SPDX-License-Identifier: Apache-2.0
// What feeds a shader input, as an expression: constants, primvars, coordinate transforms, texture
// look-ups, positions and normals, and functions of them. Immutable; a node that feeds several
// inputs is one object. Explained in docs/shading.md.
#pragma once

#include "hdStream/shading/materialNetwork.h"
#include "kernels/shared/program.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

struct ShaderExpression;

/// An expression, or one channel of it. Empty: nothing.
struct ShaderValue {
    std::shared_ptr<const ShaderExpression> expression;
    std::uint32_t channel = HDS_CHANNEL_ALL; ///< 0 to 3: that one
    std::uint32_t numComponents = 0;         ///< 1 to 4

    explicit operator bool() const { return expression != nullptr; }
};

/// A node. Components that a value does not have are 0.
struct ShaderExpression {
    enum class Kind {
        Constant,
        Primvar,     ///< of the prim; operands: fallback
        Transform2d, ///< operands: in, rotation (degrees), scale, translation
        Texture,     ///< operands: st, fallback, scale, bias
        Affine,      ///< of coordinates by `rows`; operands: in
        Math,        ///< HDS_MATH_* `code` of the operands
        Position,    ///< in HDS_SPACE_* `code`
        Normal,      ///< in HDS_SPACE_* `code`
        Tangent,     ///< in HDS_SPACE_* `code`, with HDS_TANGENT_ACROSS; operands: coordinates
        View,        ///< unit direction from the viewer
        ToSpace,     ///< carried to HDS_SPACE_* `code`, with HDS_CARRIES_*; operands: value
        Chance,      ///< the number of the hit by which it takes one of several closures
        Inside,      ///< 1 where the viewer is inside of a surface that is no thin wall, else 0
        Shifted,     ///< as it is where HDS_SHIFT_* `code` leads; operands: value, coordinates
    };
    Kind kind = Kind::Constant;
    std::array<float, 4> constant{}; ///< Constant
    std::string primvar;             ///< Primvar: without "primvars:"
    std::vector<ShaderValue> operands;
    std::vector<std::uint32_t> tiles; ///< Texture: of CompiledMaterial::textures; HDS_NONE: a hole
    std::uint32_t lookup = 0;         ///< Texture: HDS_LOOKUP_* without those the writer decides
    std::uint32_t code = 0;           ///< Math, Position, Normal, Tangent, ToSpace, Shifted
    std::uint32_t numComponents = 0;  ///< Math: of its value; 1: it is in all four components
    std::array<double, 6> rows{};     ///< Affine: (m00, m01, m02), (m10, m11, m12)
};

/// A constant of 1 to 4 components.
ShaderValue MakeConstant(const std::array<float, 4>& value, std::uint32_t numComponents);

/// One of four channels; of a constant, a constant.
ShaderValue SelectChannel(const ShaderValue& value, std::uint32_t channel);

bool IsConstant(const ShaderValue& value);
/// \pre IsConstant.
const std::array<float, 4>& ConstantOf(const ShaderValue& value);

/// UsdTransform2d as rows (m00, m01, m02), (m10, m11, m12): in * scale * rotation + translation.
/// Source: UsdPreviewSurface specification 2.5, UsdTransform2d.
std::array<double, 6> Transform2dRows(double degrees, const std::array<float, 4>& scale,
                                      const std::array<float, 4>& translation);

/// UsdTransform2d; of constants, a constant. \param operands as Kind::Transform2d
ShaderValue MakeTransform2d(std::vector<ShaderValue> operands);

/// Maps coordinates by rows as those of Transform2dRows; of constants, a constant.
ShaderValue MakeAffine(const ShaderValue& in, const std::array<double, 6>& rows);

/// Rows that map by `inner` first.
std::array<double, 6> ComposeRows(const std::array<double, 6>& outer,
                                  const std::array<double, 6>& inner);

} // namespace hds
