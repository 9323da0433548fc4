// SPDX-License-Identifier: Apache-2.0
// Which shader nodes there are, for front ends, documentation and tests.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hds {

/// The names of all pattern nodes, sorted: MaterialX's categories and USD's names. Nodes whose ids
/// differ in their types alone, or in a primvar reader's type, are one.
std::vector<std::string> PatternNames();

/// The ids of all BSDF, EDF and VDF nodes of MaterialX that are drawn, sorted.
std::vector<std::string> ClosureIds();

/// Whether an id is that of a surface shader that is drawn.
bool IsSurfaceShader(const std::string& identifier);

/// An input of a surface shader.
struct SurfaceInput {
    std::string_view name;
    std::uint32_t numComponents;
    std::array<float, 3> fallback; ///< of each component

    constexpr SurfaceInput(std::string_view theName, std::uint32_t count, float value)
        : SurfaceInput(theName, count, {value, value, value}) {}
    constexpr SurfaceInput(std::string_view theName, std::uint32_t count,
                           const std::array<float, 3>& values)
        : name(theName), numComponents(count), fallback(values) {}
};

/// The inputs of a layered surface that are read and have defaults; of others none.
std::vector<SurfaceInput> SurfaceInputs(const std::string& identifier);

/// Whether an id is that of a pattern node or of a surface shader.
bool IsKnownShader(const std::string& identifier);

} // namespace hds
