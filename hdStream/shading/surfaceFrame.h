// SPDX-License-Identifier: Apache-2.0
// The inputs of surfaces and closures that say where x and z of their frame are: normals and
// tangents. Part of the material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"

#include <string>

namespace hds {

/// Of a frame that counts for nothing: what is told of its input.
constexpr const char* kSurfacesFrame = "is not supported; that of the surface is used";

/// A radian in turns.
constexpr float kTurnsOfRadian = 0.15915494309F;

/// Warns of an input of a node.
void WarnOf(NetworkEvaluator& network, const MaterialNode& node, const std::string& input,
            const std::string& what);

/// Whether a normal or tangent is not connected, or connected to the surface's own, as exporters do
/// that connect all.
bool IsSurfaces(const NetworkEvaluator& network, const MaterialNode& node,
                const std::string& input);

/// A direction in world or object space (HDS_SPACE_*), on the front, in tangent space: that of the
/// coordinates of the first image below it, else of the node's.
ShaderValue InTangentSpace(NetworkEvaluator& network, const MaterialNode& node,
                           const ShaderValue& direction, std::uint32_t space);

/// A normal in tangent space: of normal maps and bumps, of blends of these and of the surface's own
/// normal, and of any vector in world space. Empty: the surface's own, as also of other networks
/// with maps, which warn.
ShaderValue EvaluateNormal(NetworkEvaluator& network, const MaterialNode& node,
                           const std::string& input);

/// Where a tangent in world space lies, which is any network: a scalar, in turns about the normal
/// from dP/ds of the first coordinates, counter-clockwise as seen from where the normal points. 0
/// of none, and of the surface's own.
ShaderValue EvaluateTangent(NetworkEvaluator& network, const MaterialNode& node,
                            const std::string& input);

} // namespace hds
