// SPDX-License-Identifier: Apache-2.0
// Counts the edits of a scene by what they leave of the last commit (scene/primEdits.h).
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/primCommit.h"
#include "hdStream/scene/primEdits.h"

#include <cstdint>
#include <map>
#include <memory>
#include <set>
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

    /// What has happened to the scene since the last commit, beside shapes and materials, of which
    /// the cache knows; null: other things as well.
    const PrimCommit::Edits* Mendable() const { return _isMendable ? &_edits : nullptr; }
    /// There is a commit of the scene as it is now.
    void NoteCommit() {
        _edits = {};
        _isMendable = true;
    }

    /// Before a prim of a path comes into the place of what is there.
    template <typename Prim>
    void Count(const std::map<std::string, Prim>& prims, const std::string& path,
               const Prim& after) {
        const auto before = prims.find(path);
        ++_scene;
        const bool isKnown = before != prims.end();
        if (isKnown &&
            (LeavesPrims(before->second, after) || Reshapes(path, before->second, after))) {
            NoteMoved(path, after);
            return;
        }
        _isMendable = false;
        ++_content;
    }

    /// Before a material gets a network.
    void CountMaterial(const std::map<std::string, std::shared_ptr<const MaterialNetwork>>& before,
                       const std::string& path) {
        if (!_cache.prims || before.count(path) == 0) {
            Count();
            return;
        }
        ++_scene;
        _cache.prims->recoloured.insert(path);
    }

    /// Any other edit.
    void Count() {
        ++_scene;
        ++_content;
        _isMendable = false;
    }

private:
    void NoteMoved(const std::string& path, const GeometryPrim& /*prim*/) {
        if (_isMendable) { // else nobody asks
            _edits.prims.insert(path);
        }
    }
    void NoteMoved(const std::string& /*path*/, const LightPrim& /*prim*/) {
        _edits.areLights = true;
    }
    /// It places others.
    void NoteMoved(const std::string& /*path*/, const InstancerPrim& /*prim*/) {
        _isMendable = false;
    }

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
    PrimCommit::Edits _edits;
    bool _isMendable = false;
};

} // namespace hds
