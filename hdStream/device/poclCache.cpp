// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/poclCache.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string>

namespace hds {

namespace {

namespace fs = std::filesystem;

bool IsSet(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != 0;
}

/// Where PoCL keeps kernels by itself (pocl_cache.c); empty: it has a fallback of its own.
fs::path DefaultPoclFolder() {
    if (IsSet("XDG_CACHE_HOME")) {
        return fs::path(std::getenv("XDG_CACHE_HOME")) / "pocl";
    }
    return IsSet("HOME") ? fs::path(std::getenv("HOME")) / ".cache" / "pocl" : fs::path();
}

bool CanWrite(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    return !error && ::access(folder.c_str(), W_OK | X_OK) == 0;
}

} // namespace

void EnsurePoclCache() {
    const fs::path folder = DefaultPoclFolder();
    if (IsSet("POCL_CACHE_DIR") || folder.empty() || CanWrite(folder)) {
        return;
    }
    std::error_code error;
    const fs::path own =
        fs::temp_directory_path(error) / ("hdStream-pocl-" + std::to_string(::getuid()));
    if (!error && CanWrite(own)) {
        ::setenv("POCL_CACHE_DIR", own.c_str(), 1);
    }
}

void ShareWorkGroupSizes() {
    ::setenv("POCL_WORK_GROUP_SPECIALIZATION", "0", 0);
}

void SetHwlocPlugins() {
    ::setenv("HWLOC_PLUGINS_PATH", "/dev/null", 0);
}

void ReadyPoclEnvironment() {
    static std::once_flag once;
    std::call_once(once, [] {
        EnsurePoclCache();
        ShareWorkGroupSizes();
        SetHwlocPlugins();
    });
}

} // namespace hds
