// SPDX-License-Identifier: Apache-2.0
// What the prims of a scene take, counted as they come and go: no edit looks at other prims.
#pragma once

#include "hdStream/scene/hostRecords.h"
#include "hdStream/scene/keptArrays.h"
#include "hdStream/scene/sceneDescription.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace hds {

/// Sums over the geometry and the instancers of a scene. Externally synchronised.
class SceneSizes {
public:
    /// Puts a prim, a GeometryPrim or an InstancerPrim, at a path in the place of what was there.
    template <typename Prim>
    void Set(std::map<std::string, Prim>* prims, const std::string& path, Prim prim) {
        const auto [entry, isNew] = prims->try_emplace(path);
        if (!isNew) {
            Count(*entry, -1);
        }
        entry->second = std::move(prim);
        Count(*entry, 1);
    }

    /// Removes what is at a path, if anything.
    template <typename Prim>
    void Erase(std::map<std::string, Prim>* prims, const std::string& path) {
        const auto entry = prims->find(path);
        if (entry != prims->end()) {
            Count(*entry, -1);
            prims->erase(entry);
        }
    }

    /// About the bytes of what front ends have said, without arrays.
    std::uint64_t DescribedBytes() const { return _describedBytes; }
    const KeptArrays& Arrays() const { return _arrays; }

private:
    /// \param sign 1: a prim comes; -1: it leaves, as it came. Sums wrap, so that this is exact.
    template <typename Prim>
    void Count(const std::pair<const std::string, Prim>& entry, int sign) {
        const auto factor = static_cast<std::uint64_t>(sign);
        const KeptArrays arrays = KeptArraysOf(entry.second);
        _describedBytes += factor * hds::DescribedBytes(entry.first, entry.second);
        _arrays.geometryBytes += factor * arrays.geometryBytes;
        _arrays.instanceBytes += factor * arrays.instanceBytes;
    }

    std::uint64_t _describedBytes = 0;
    KeptArrays _arrays;
};

} // namespace hds
