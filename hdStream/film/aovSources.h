// SPDX-License-Identifier: Apache-2.0
// What hosts and render vars call AOVs.
#pragma once

#include <string>

namespace hds {

/// The AOV that the source name of a render var of the type `raw` or `intrinsic` means: an AOV's
/// own name, or a usual one (Ci, rgba, beauty, a, z, N, P, id, st, uv). Empty: there is none.
std::string AovOfSource(const std::string& sourceName);

} // namespace hds
