// SPDX-License-Identifier: Apache-2.0
// Which inputs of shader nodes are colours, where the network itself does not say so.
// Explained in docs/color.md.
#pragma once

#include <string>

namespace hds {

/// Whether three or four numbers at an input are a colour: those of MaterialX's nodes of colours
/// (ND_mix_color3) but for coefficients and hue, saturation, value; those of surfaces and closures
/// by their names (base_color, diffuseColor, tint, emissive, reflectance).
bool IsColorInput(const std::string& identifier, const std::string& input);

/// Whether a node gives the colours of an image, of which MaterialX converts the colour space:
/// UsdUVTexture and nodes of the types color3 and color4.
bool IsColorImage(const std::string& identifier);

} // namespace hds
