// SPDX-License-Identifier: Apache-2.0
// Which pages of the persistent cache belong to which stage: pages are named by hashes of what they
// are made of, so each stage has an entry of its own that names those that renders of it have used.
// Explained in docs/cache-format.md.
#pragma once

#include "hdStream/persist/pageStore.h"
#include "hdStream/persist/store.h"

#include <string>
#include <vector>

namespace hds {

/// What the cache holds of a stage. Pages of several stages are counted for each.
struct StagePages {
    std::string stage;
    PageAmount amount;
};

/// Adds the pages that were used to those that are noted of a stage, and forgets those that the
/// cache does not hold any more. Of two processes that do so at once one may be forgotten. \param
/// stage names it: the path of its file.
void NoteStagePages(const std::string& stage, const PageStore& used, Store* store);

/// All stages of which something is left, by name. \param[out] rest pages of none of them.
std::vector<StagePages> ListStagePages(Store* store, const PageStore& pages, PageAmount* rest);

} // namespace hds
