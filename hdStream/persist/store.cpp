// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/store.h"

#include "hdStream/base/hash.h"
#include "hdStream/persist/cacheDirectory.h"
#include "hdStream/persist/file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <random>
#include <system_error>

namespace hds {

namespace fs = std::filesystem;

namespace {

constexpr char kMagic[8] = {'h', 'd', 's', 'C', 'a', 'c', 'h', 'e'};
constexpr std::uint32_t kFormatVersion = 2;
constexpr const char* kExtension = ".hdsc";
constexpr const char* kTemporaryExtension = ".hdsc-tmp";
/// Nobody writes to one entry for so long.
constexpr std::chrono::hours kOldestTemporary(1);

/// The fixed start of every entry; the payload follows.
struct EntryHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t reserved;
    std::uint64_t payloadBytes;
    char checksum[40]; ///< Hasher::Hex of the payload, zero padded
};

std::string Checksum(const void* data, std::size_t bytes) {
    Hasher hasher;
    hasher.Append(data, bytes);
    return hasher.Hex();
}

struct Entry {
    fs::path path;
    std::uint64_t bytes;
    fs::file_time_type used;
    bool isTemporary; ///< being written, or left by a process that was killed
};

std::vector<Entry> ListFiles(const std::string& directory) {
    std::vector<Entry> entries;
    std::error_code error;
    for (fs::directory_iterator it(directory, error), end; !error && it != end;
         it.increment(error)) {
        const bool isTemporary = it->path().extension() == kTemporaryExtension;
        if (isTemporary || it->path().extension() == kExtension) {
            std::error_code ignored;
            entries.push_back(
                {it->path(), it->file_size(ignored), it->last_write_time(ignored), isTemporary});
        }
    }
    return entries;
}

/// A name that no other process has, not even one of another container with the same number.
std::string TemporaryName(const std::string& kind, const std::string& key) {
    static std::atomic<std::uint64_t> counter{0};
    Hasher hasher;
    hasher.Append(static_cast<std::uint64_t>(::getpid()));
    hasher.Append(counter.fetch_add(1));
    hasher.Append(static_cast<std::uint64_t>(std::random_device()()));
    return kind + "-" + key + "." + hasher.Hex().substr(0, 16) + kTemporaryExtension;
}

} // namespace

Store::Store(StoreOptions options, Warnings* warnings)
    : _directory(ResolveCacheDirectory(options.directory)),
      _enabled(options.enabled && !_directory.empty()), _isWriting(_enabled),
      _maxBytes(options.maxBytes), _warnings(warnings) {}

std::string Store::PathOf(const std::string& kind, const std::string& key) const {
    return (fs::path(_directory) / (kind + "-" + key + kExtension)).string();
}

bool Store::Contains(const std::string& kind, const std::string& key) const {
    std::error_code error;
    return _enabled && fs::exists(PathOf(kind, key), error);
}

std::optional<std::vector<std::uint8_t>> Store::Load(const std::string& kind,
                                                     const std::string& key) {
    if (!_enabled) {
        return std::nullopt;
    }
    const std::string path = PathOf(kind, key);
    const File file = File::Open(path);
    if (!file.IsOpen()) {
        return std::nullopt;
    }
    EntryHeader header{};
    const bool headerIsGood = file.Read(0, &header, sizeof(header)) &&
                              std::memcmp(header.magic, kMagic, sizeof(kMagic)) == 0 &&
                              header.version == kFormatVersion && file.Size() >= sizeof(header) &&
                              header.payloadBytes == file.Size() - sizeof(header);
    if (headerIsGood) {
        std::vector<std::uint8_t> payload(header.payloadBytes);
        header.checksum[sizeof(header.checksum) - 1] = 0;
        if (file.Read(sizeof(header), payload.data(), payload.size()) &&
            Checksum(payload.data(), payload.size()) == header.checksum) {
            file.Touch();
            return payload;
        }
    }
    // Corrupt or of another version: rebuilt by the caller, unless another process has done so.
    if (!file.IsUnlinked()) {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
    return std::nullopt;
}

void Store::Save(const std::string& kind, const std::string& key, const void* data,
                 std::size_t bytes) {
    if (!_isWriting) {
        return;
    }
    std::error_code error;
    fs::create_directories(_directory, error);
    if (error) {
        StopWriting(error.message());
        return;
    }
    EntryHeader header{};
    std::memcpy(header.magic, kMagic, sizeof(kMagic));
    header.version = kFormatVersion;
    header.payloadBytes = bytes;
    const std::string checksum = Checksum(data, bytes);
    std::memcpy(header.checksum, checksum.data(), checksum.size());
    const fs::path temporary = fs::path(_directory) / TemporaryName(kind, key);
    errno = 0;
    bool isWritten = false;
    {
        const File file = File::Create(temporary.string());
        isWritten = file.IsOpen() && file.Write(0, &header, sizeof(header)) &&
                    file.Write(sizeof(header), data, bytes);
        error = std::error_code(errno, std::generic_category());
    }
    if (isWritten) {
        fs::rename(temporary, PathOf(kind, key), error);
        if (error == std::errc::no_such_file_or_directory) {
            return; // the cache was cleared meanwhile
        }
        isWritten = !error;
    }
    if (!isWritten) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        StopWriting(error.message());
        return;
    }
    Trim();
}

void Store::StopWriting(const std::string& reason) {
    if (_isWriting.exchange(false) && _warnings != nullptr) {
        _warnings->Add(_directory, "nothing more is kept in the cache: " + reason);
    }
}

void Store::Trim() {
    std::vector<Entry> entries = ListFiles(_directory);
    const fs::file_time_type now = fs::file_time_type::clock::now();
    std::uint64_t total = 0;
    for (const Entry& entry : entries) {
        std::error_code error;
        if (entry.isTemporary && now - entry.used > kOldestTemporary) {
            fs::remove(entry.path, error);
        }
        total += entry.isTemporary ? 0 : entry.bytes;
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.used < b.used; });
    for (const Entry& entry : entries) {
        if (total <= _maxBytes) {
            break;
        }
        if (entry.isTemporary) {
            continue;
        }
        std::error_code error;
        fs::remove(entry.path, error);
        total -= entry.bytes;
    }
}

std::vector<std::string> Store::Keys(const std::string& kind) const {
    std::vector<std::string> keys;
    for (const Entry& entry : ListFiles(_directory)) {
        const std::string name = entry.path.stem().string();
        if (!entry.isTemporary && name.compare(0, kind.size() + 1, kind + "-") == 0) {
            keys.push_back(name.substr(kind.size() + 1));
        }
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

std::uint64_t Store::Clear() {
    std::uint64_t freed = 0;
    for (const Entry& entry : ListFiles(_directory)) {
        std::error_code error;
        if (fs::remove(entry.path, error)) {
            freed += entry.bytes;
        }
    }
    return freed;
}

std::uint64_t Store::Size() const {
    std::uint64_t total = 0;
    for (const Entry& entry : ListFiles(_directory)) {
        total += entry.bytes;
    }
    return total;
}

} // namespace hds
