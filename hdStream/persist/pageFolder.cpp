// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/pageFolder.h"

#include "hdStream/persist/pageSegment.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <random>

namespace hds {

namespace fs = std::filesystem;

namespace {

struct SegmentFile {
    std::string path;
    std::uint64_t bytes = 0;
    timespec used{}; ///< last time of modification
};

bool IsOlder(const SegmentFile& a, const SegmentFile& b) {
    return a.used.tv_sec != b.used.tv_sec ? a.used.tv_sec < b.used.tv_sec
                                          : a.used.tv_nsec < b.used.tv_nsec;
}

/// Bytes of disk of a file that may have holes; file systems that do not say tell its length.
std::uint64_t DiskBytes(const struct stat& status) {
    const auto length = static_cast<std::uint64_t>(status.st_size);
    const std::uint64_t taken = static_cast<std::uint64_t>(status.st_blocks) * 512U;
    return taken > 0 ? std::min(length, taken) : length;
}

std::vector<SegmentFile> ListFiles(const std::string& directory) {
    std::vector<SegmentFile> files;
    for (const std::string& path : ListSegments(directory)) {
        struct stat status {};
        if (::lstat(path.c_str(), &status) == 0) {
            files.push_back({path, DiskBytes(status), status.st_mtim});
        }
    }
    return files;
}

} // namespace

std::vector<std::string> ListSegments(const std::string& directory) {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::directory_iterator it(directory, error), end; !error && it != end;
         it.increment(error)) {
        if (it->path().extension() == kSegmentExtension) {
            paths.push_back(it->path().string());
        }
    }
    std::sort(paths.begin(), paths.end());
    return paths;
}

std::string NewSegmentPath(const std::string& directory) {
    static std::atomic<std::uint64_t> counter{0};
    Hasher hasher;
    hasher.Append(static_cast<std::uint64_t>(::getpid()));
    hasher.Append(counter.fetch_add(1));
    hasher.Append(
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count()));
    hasher.Append(static_cast<std::uint64_t>(std::random_device()()));
    return (fs::path(directory) / ("pages-" + hasher.Hex().substr(0, 16))).string() +
           std::string(kSegmentExtension);
}

std::uint64_t SegmentBytes(const std::string& directory) {
    std::uint64_t total = 0;
    for (const SegmentFile& file : ListFiles(directory)) {
        total += file.bytes;
    }
    return total;
}

std::uint64_t TrimSegments(const std::string& directory, std::uint64_t maxBytes) {
    std::vector<SegmentFile> files = ListFiles(directory);
    std::uint64_t total = 0;
    for (const SegmentFile& file : files) {
        total += file.bytes;
    }
    std::sort(files.begin(), files.end(), IsOlder);
    for (const SegmentFile& file : files) {
        if (total <= maxBytes) {
            break;
        }
        const File opened = File::Open(file.path);
        if (opened.IsOpen() && RemoveSegmentFile(file.path, opened)) {
            total -= file.bytes;
        }
    }
    return total;
}

std::uint64_t RemoveSegments(const std::string& directory) {
    std::uint64_t freed = 0;
    for (const SegmentFile& file : ListFiles(directory)) {
        if (::unlink(file.path.c_str()) == 0) {
            freed += file.bytes;
        }
    }
    return freed;
}

} // namespace hds
