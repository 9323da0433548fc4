// SPDX-License-Identifier: Apache-2.0
// Parts of a scene that are drawn, by the paths of their prims: what a collection of Hydra holds.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace hds {

/// Whether a prim lies at or below a path. What an instancer places, "INSTANCER{PATH}", lies below
/// the instancer.
inline bool IsAtOrBelow(const std::string& prim, const std::string& path) {
    const std::size_t length = path.size();
    return prim.compare(0, length, path) == 0 &&
           (prim.size() == length || prim[length] == '/' || prim[length] == '{' ||
            (length > 0 && path.back() == '/'));
}

/// Whether a prim lies at or below one of `drawn` (empty: all do) and of none of `hidden`.
inline bool IsDrawnPath(const std::string& prim, const std::vector<std::string>& drawn,
                        const std::vector<std::string>& hidden) {
    const auto holds = [&prim](const std::string& path) { return IsAtOrBelow(prim, path); };
    return (drawn.empty() || std::any_of(drawn.begin(), drawn.end(), holds)) &&
           std::none_of(hidden.begin(), hidden.end(), holds);
}

} // namespace hds
