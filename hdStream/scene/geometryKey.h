// SPDX-License-Identifier: Apache-2.0
// What the pages of geometry are known by in the persistent cache.
#pragma once

#include "hdStream/persist/pageKey.h"
#include "hdStream/scene/geometryCommit.h"

namespace hds {

/// Hash of all that the pages are made of. Reads every array, on all cores.
PageKey MakeGeometryKey(const GeometryInputs& inputs);

} // namespace hds
