// SPDX-License-Identifier: Apache-2.0
// Where the persistent cache lies.
#pragma once

#include <string>

namespace hds {

/// \param asked a folder, returned as it is; empty: $HDSTREAM_CACHE_DIR, else
/// $XDG_CACHE_HOME/hdStream, else ~/.cache/hdStream.
/// \return empty where none of them is known: no cache then.
std::string ResolveCacheDirectory(const std::string& asked);

} // namespace hds
