// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/cacheDirectory.h"

#include <cstdlib>

namespace hds {

std::string ResolveCacheDirectory(const std::string& asked) {
    if (!asked.empty()) {
        return asked;
    }
    if (const char* own = std::getenv("HDSTREAM_CACHE_DIR"); own != nullptr && *own != 0) {
        return own;
    }
    if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg != nullptr && *xdg != 0) {
        return std::string(xdg) + "/hdStream";
    }
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0) {
        return std::string(home) + "/.cache/hdStream";
    }
    return {};
}

} // namespace hds
