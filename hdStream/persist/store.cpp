// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/store.h"

#include "hdStream/base/hash.h"
#include "hdStream/persist/cacheDirectory.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace hds {

namespace fs = std::filesystem;

namespace {

constexpr char kMagic[8] = {'h', 'd', 's', 'C', 'a', 'c', 'h', 'e'};
constexpr std::uint32_t kFormatVersion = 2;
constexpr const char* kExtension = ".hdsc";

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
};

std::vector<Entry> ListEntries(const std::string& directory) {
    std::vector<Entry> entries;
    std::error_code error;
    for (fs::directory_iterator it(directory, error), end; !error && it != end;
         it.increment(error)) {
        if (it->path().extension() == kExtension) {
            std::error_code ignored;
            entries.push_back({it->path(), it->file_size(ignored), it->last_write_time(ignored)});
        }
    }
    return entries;
}

} // namespace

Store::Store(StoreOptions options, Warnings* warnings)
    : _directory(ResolveCacheDirectory(options.directory)), _enabled(options.enabled),
      _maxBytes(options.maxBytes), _warnings(warnings) {
    if (_directory.empty()) {
        _enabled = false;
    }
}

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
    const fs::path path = PathOf(kind, key);
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        return std::nullopt;
    }
    EntryHeader header{};
    std::error_code error;
    const std::uint64_t fileBytes = fs::file_size(path, error);
    file.read(reinterpret_cast<char*>(&header), sizeof(header));
    const bool headerIsGood = file && std::memcmp(header.magic, kMagic, sizeof(kMagic)) == 0 &&
                              header.version == kFormatVersion && !error &&
                              header.payloadBytes == fileBytes - sizeof(header);
    if (headerIsGood) {
        std::vector<std::uint8_t> payload(header.payloadBytes);
        file.read(reinterpret_cast<char*>(payload.data()),
                  static_cast<std::streamsize>(payload.size()));
        header.checksum[sizeof(header.checksum) - 1] = 0;
        if (file && Checksum(payload.data(), payload.size()) == header.checksum) {
            fs::last_write_time(path, fs::file_time_type::clock::now(), error);
            return payload;
        }
    }
    fs::remove(path, error); // corrupt or of another version: rebuilt by the caller
    return std::nullopt;
}

void Store::Save(const std::string& kind, const std::string& key, const void* data,
                 std::size_t bytes) {
    if (!_enabled) {
        return;
    }
    std::error_code error;
    fs::create_directories(_directory, error);
    if (error) {
        Disable(error.message());
        return;
    }
    static std::atomic<unsigned> counter{0};
    const fs::path path = PathOf(kind, key);
    const fs::path temporary =
        fs::path(_directory) / (kind + "-" + key + "." + std::to_string(getpid()) + "." +
                                std::to_string(counter.fetch_add(1)) + ".tmp");
    EntryHeader header{};
    std::memcpy(header.magic, kMagic, sizeof(kMagic));
    header.version = kFormatVersion;
    header.payloadBytes = bytes;
    const std::string checksum = Checksum(data, bytes);
    std::memcpy(header.checksum, checksum.data(), checksum.size());
    bool isWritten = false;
    {
        std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
        file.write(reinterpret_cast<const char*>(&header), sizeof(header));
        file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
        file.flush();
        isWritten = static_cast<bool>(file);
    }
    if (isWritten) {
        fs::rename(temporary, path, error);
        isWritten = !error;
    }
    if (!isWritten) {
        fs::remove(temporary, error);
        Disable("an entry could not be written");
        return;
    }
    Trim();
}

void Store::Disable(const std::string& reason) {
    _enabled = false;
    if (_warnings != nullptr) {
        _warnings->Add(_directory, "the cache is not used: " + reason);
    }
}

void Store::Trim() {
    std::vector<Entry> entries = ListEntries(_directory);
    std::uint64_t total = 0;
    for (const Entry& entry : entries) {
        total += entry.bytes;
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.used < b.used; });
    for (const Entry& entry : entries) {
        if (total <= _maxBytes) {
            break;
        }
        std::error_code error;
        fs::remove(entry.path, error);
        total -= entry.bytes;
    }
}

std::vector<std::string> Store::Keys(const std::string& kind) const {
    std::vector<std::string> keys;
    for (const Entry& entry : ListEntries(_directory)) {
        const std::string name = entry.path.stem().string();
        if (name.compare(0, kind.size() + 1, kind + "-") == 0) {
            keys.push_back(name.substr(kind.size() + 1));
        }
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

std::uint64_t Store::Clear() {
    std::uint64_t freed = 0;
    for (const Entry& entry : ListEntries(_directory)) {
        std::error_code error;
        if (fs::remove(entry.path, error)) {
            freed += entry.bytes;
        }
    }
    return freed;
}

std::uint64_t Store::Size() const {
    std::uint64_t total = 0;
    for (const Entry& entry : ListEntries(_directory)) {
        total += entry.bytes;
    }
    return total;
}

} // namespace hds
