// SPDX-License-Identifier: Apache-2.0
// Reads light path expressions into nondeterministic automata. Of film/lightPaths alone.
#pragma once

#include <bitset>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// What can happen to light: the letters of the words that expressions match.
struct LightEvent {
    char type = 'C';       ///< C, R, T, V, L or O
    char scattering = '.'; ///< D, G or S, of R and T
    bool isDome = false;   ///< of L
    std::string label;     ///< of L: its group
};

constexpr std::size_t kMaxLightEvents = 256;
using LightEventSet = std::bitset<kMaxLightEvents>;

/// A nondeterministic automaton with one start and one end.
struct LightPathMachine {
    struct Node {
        LightEventSet events;            ///< that lead to `next`
        std::uint32_t next = 0;          ///< where any event does
        std::vector<std::uint32_t> free; ///< nodes that are reached without an event
    };
    std::vector<Node> nodes;
    std::uint32_t start = 0;
    std::uint32_t end = 0;
};

/// Labels that an expression names. \throws as ParseLightPath.
std::vector<std::string> LabelsOf(const std::string& expression);

/// \param events of all words. \throws Error (Usage) that names expression and column.
LightPathMachine ParseLightPath(const std::string& expression,
                                const std::vector<LightEvent>& events);

} // namespace hds
