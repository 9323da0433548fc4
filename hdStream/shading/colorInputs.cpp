// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/colorInputs.h"

#include <algorithm>
#include <array>

namespace hds {

namespace {

bool Has(const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
}

template <std::size_t N>
bool HasOne(const std::string& text, const std::array<const char*, N>& parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return Has(text, part); });
}

/// Nodes whose numbers are no light although their type is a colour, and inputs of that kind.
constexpr std::array<const char*, 4> kNoColorNodes = {"hsvtorgb", "transformcolor", "extract",
                                                      "convert_vector"};
constexpr std::array<const char*, 10> kNoColorInputs = {
    "lumacoeffs", "radius",     "extinction", "absorption", "ior",
    "amount",     "lacunarity", "opacity",    "offset",     "texcoord"};
constexpr std::array<const char*, 6> kColorInputs = {"olor",    "tint",        "emissive",
                                                     "diffuse", "reflectance", "reflectivity"};

} // namespace

bool IsColorImage(const std::string& identifier) {
    return Has(identifier, "UsdUVTexture") || Has(identifier, "_color3") ||
           Has(identifier, "_color4") || Has(identifier, "colorimage");
}

bool IsColorInput(const std::string& identifier, const std::string& input) {
    if (HasOne(identifier, kNoColorNodes) || HasOne(input, kNoColorInputs)) {
        return false;
    }
    const bool isOfColors = Has(identifier, "_color3") || Has(identifier, "_color4");
    return isOfColors || HasOne(input, kColorInputs);
}

} // namespace hds
