// SPDX-License-Identifier: Apache-2.0
// Prepares grids: reads OpenVDB files, and keeps the result in the persistent store, where later
// processes find it. Explained in docs/volumes.md, section "Grids".
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/volume/preparedGrid.h"
#include "hdStream/volume/vdbFile.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace hds {

/// One grid, or those of the components of a vector.
using PreparedGrids = std::vector<std::shared_ptr<const PreparedGrid>>;

/// Makes PreparedGrids, each once. Externally synchronised.
class GridPreparer {
public:
    /// \param store may be null: bricks then stay in host memory. \param warnings takes what is
    /// found to be damaged later; may be null
    explicit GridPreparer(std::shared_ptr<PageStore> store, Warnings* warnings = nullptr)
        : _store(std::move(store)), _warnings(warnings) {}

    /// A grid of a file. \param bytes of the file in a package; 0: to its end. \return nothing when
    /// it cannot be read; `error` says why.
    PreparedGrids Prepare(const VdbRequest& request, std::uint64_t bytes, std::string* error);
    /// A grid in memory.
    PreparedGrids Prepare(const std::shared_ptr<const VoxelGrid>& grid);

    /// Forgets what was not asked for since the last call.
    void ForgetUnused();

private:
    struct Entry {
        PreparedGrids grids;
        std::shared_ptr<const VoxelGrid> source; ///< null: a file's
        bool isUsed = true;
    };

    PreparedGrids Load(const VdbRequest& request, std::uint64_t bytes, const PageKey& key) const;
    PreparedTexture::Make Restorer(const VdbRequest& request, std::uint64_t bytes,
                                   const PageKey& key, std::size_t component) const;

    std::shared_ptr<PageStore> _store;
    Warnings* _warnings;
    std::unordered_map<PageKey, Entry> _entries;
};

} // namespace hds
