// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/poclCache.h"

#include <sys/stat.h>
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

/// Whether it is a folder of this user's that nobody else writes to: PoCL loads code from it.
bool IsOurOwn(const fs::path& folder) {
    struct stat status {};
    return ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
           status.st_uid == ::getuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Work-around: PoCL (3.1 to 6) reports no device, or aborts, when it cannot create its own kernel
/// cache, as with a read-only home folder in a container or on a farm. Points POCL_CACHE_DIR to a
/// folder of ours in the temporary directory when it is not set and the folder PoCL would take
/// cannot be written. Can go when testenv/cli's test of a read-only home passes without it.
void EnsurePoclCache() {
    const fs::path folder = DefaultPoclFolder();
    if (IsSet("POCL_CACHE_DIR") || folder.empty() || CanWrite(folder)) {
        return;
    }
    std::error_code error;
    const fs::path temporary = fs::temp_directory_path(error);
    if (error) {
        return;
    }
    std::string own = (temporary / ("hdStream-kernels-" + std::to_string(::getuid()))).string();
    ::mkdir(own.c_str(), S_IRWXU);
    if (!IsOurOwn(own)) { // somebody else has made it
        own += "-XXXXXX";
        if (::mkdtemp(own.data()) == nullptr) {
            return;
        }
    }
    ::setenv("POCL_CACHE_DIR", own.c_str(), 1);
}

/// PoCL compiles a kernel for work-groups of any size when it hands out a binary, and once more for
/// each size, and for large and small ranges, when it is launched. From here on it launches what is
/// in the binary. The bits are the same, and so is the time of our kernels (docs/device.md).
void ShareWorkGroupSizes() {
    ::setenv("POCL_WORK_GROUP_SPECIALIZATION", "0", 0);
}

/// PoCL sets the variable by which hwloc loads no plug-ins whenever it looks for devices. From here
/// on it is there already.
void SetHwlocPlugins() {
    ::setenv("HWLOC_PLUGINS_PATH", "/dev/null", 0);
}

} // namespace

void ReadyPoclEnvironment() {
    static std::once_flag once;
    std::call_once(once, [] {
        EnsurePoclCache();
        ShareWorkGroupSizes();
        SetHwlocPlugins();
    });
}

} // namespace hds
