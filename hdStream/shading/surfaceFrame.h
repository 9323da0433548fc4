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

/// Normal maps and bumps count, which are in tangent space, and blends of these and of the
/// surface's own normal; of others, which warn, and of none it is empty: the surface's own.
ShaderValue EvaluateNormal(NetworkEvaluator& network, const MaterialNode& node,
                           const std::string& input);

/// Where a tangent in world space lies, which is any network: a scalar, in turns about the normal
/// from dP/ds of the first coordinates, counter-clockwise as seen from where the normal points. 0
/// of none, and of the surface's own.
ShaderValue EvaluateTangent(NetworkEvaluator& network, const MaterialNode& node,
                            const std::string& input);

} // namespace hds
