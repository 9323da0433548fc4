// SPDX-License-Identifier: Apache-2.0
// Counts the edits of a scene by what they leave of the last commit (scene/primEdits.h).
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/primEdits.h"

#include <cstdint>
#include <map>
#include <string>

namespace hds {

/// Externally synchronised.
class EditCounts {
public:
    /// \param cache of the scene's commits; must outlive the object.
    explicit EditCounts(CommitCache* cache) : _cache(*cache) {}

    /// Of all edits.
    std::uint64_t Scene() const { return _scene; }
    /// Of those that do not leave what the cache has of prims (CommitCache::contentVersion).
    std::uint64_t Content() const { return _content; }

    /// Before a prim of a path comes into the place of what is there.
    template <typename Prim>
    void Count(const std::map<std::string, Prim>& prims, const std::string& path,
               const Prim& after) {
        const auto before = prims.find(path);
        ++_scene;
        const bool leavesPrims = before != prims.end() && (LeavesPrims(before->second, after) ||
                                                           Reshapes(path, before->second, after));
        _content += leavesPrims ? 0 : 1;
    }

    /// Any other edit.
    void Count() {
        ++_scene;
        ++_content;
    }

private:
    template <typename Prim>
    bool Reshapes(const std::string& /*path*/, const Prim& /*before*/, const Prim& /*after*/) {
        return false;
    }

    /// Notes a prim of which all but the shape is left. \return false where it is not, or where
    /// nobody would ask, since nothing of prims is kept.
    bool Reshapes(const std::string& path, const GeometryPrim& before, const GeometryPrim& after) {
        const bool reshapes = _cache.prims && LeavesAllButShape(before, after);
        if (reshapes) {
            _cache.reshaped.insert(path);
        }
        return reshapes;
    }

    CommitCache& _cache;
    std::uint64_t _scene = 1;
    std::uint64_t _content = 1;
};

} // namespace hds
