// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/lightPathTable.h"

#include "hdStream/base/error.h"
#include "kernels/shared/lightPaths.h"

namespace hds {

static_assert(kScatterings.size() == HDS_SCATTERINGS);
static_assert(kMaxLightPaths == HDS_MAX_LIGHT_PATHS);
static_assert(kMaxLightPathStates == HDS_LIGHT_PATH_STATE_MASK + 1);

std::vector<std::uint32_t> MakeLightPathTable(const LightPathAutomaton& automaton,
                                              const std::vector<std::string>& groups) {
    std::vector<std::uint32_t> words(HDS_LIGHT_PATH_GROUPS);
    words.push_back(automaton.EndOfLight("", false) / 2);
    for (const std::string& group : groups) {
        words.push_back(automaton.EndOfLight(group, false) / 2);
    }
    words[HDS_LIGHT_PATH_STRIDE] = HDS_SCATTERINGS + automaton.NumEnds();
    words[HDS_LIGHT_PATH_STATES] = static_cast<std::uint32_t>(words.size());
    for (const LightPathState& state : automaton.states) {
        words.insert(words.end(), state.next.begin(), state.next.end());
        words.insert(words.end(), state.accepts.begin(), state.accepts.end());
    }
    if (words.size() > kMaxLightPathWords) {
        throw Error("light path expressions: with the scene's " + std::to_string(groups.size()) +
                        " groups of lights they need too large a table",
                    ErrorKind::Usage);
    }
    return words;
}

std::uint32_t NumLightPathSums(std::size_t numExpressions) {
    std::uint32_t count = numExpressions > 0 ? 1 : 0;
    while (count < numExpressions) {
        count *= 2;
    }
    return count;
}

} // namespace hds
