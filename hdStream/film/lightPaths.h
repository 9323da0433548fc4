// SPDX-License-Identifier: Apache-2.0
// Light path expressions: regular expressions over what happens to light on its way, compiled into
// one automaton for all that a render asks for. The grammar is that of Open Shading Language.
// Knows no scene: lights are told apart by the labels that expressions name.
// Explained in docs/film.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// The group of lights that name none.
constexpr const char* kDefaultLightGroup = "default";

/// Most expressions of a render.
constexpr std::uint32_t kMaxLightPaths = 32;
/// Most states of their automaton.
constexpr std::uint32_t kMaxLightPathStates = 1024;
/// Most words of the table that kernels read, which is in constant memory (64 KiB on any device).
constexpr std::uint32_t kMaxLightPathWords = 12U << 10U;

/// What surfaces do with light, in the order of LightPathState::next.
constexpr std::array<const char*, 7> kScatterings{"RD", "RG", "RS", "TD", "TG", "TS", "V."};

/// A state: what has happened since the camera, as far as it matters.
struct LightPathState {
    std::array<std::uint32_t, kScatterings.size()> next{}; ///< state after each scattering
    /// By what emits at the end (LightPathAutomaton::EndOf*): a bit for each expression that
    /// matches.
    std::vector<std::uint32_t> accepts;
};

/// A deterministic automaton that reads paths from the camera to what emits.
struct LightPathAutomaton {
    std::vector<std::string> labels;    ///< that expressions name, in the order of names
    std::vector<LightPathState> states; ///< the first: at the camera

    std::uint32_t NumEnds() const {
        return 2 * (static_cast<std::uint32_t>(labels.size()) + 1) + 1;
    }
    /// A light of a group; domes are told apart.
    std::uint32_t EndOfLight(const std::string& group, bool isDome) const;
    /// A surface that is no light and emits.
    std::uint32_t EndOfObject() const { return NumEnds() - 1; }
};

/// \throws Error (Usage) that names the column, for an expression that cannot be read; or that says
/// which limit is exceeded.
LightPathAutomaton CompileLightPaths(const std::vector<std::string>& expressions);

} // namespace hds
