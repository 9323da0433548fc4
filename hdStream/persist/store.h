// SPDX-License-Identifier: Apache-2.0
// The persistent cache's few large entries: a file each, in a folder that several processes may
// share. Many small pages are pageStore.h's.
// Invariant: an entry is either complete and verified, or absent. A cache that cannot be used (no
// folder, read-only, full disk) is silent after one warning, and read as before; it never fails a
// render.
// Explained in docs/cache-format.md.
#pragma once

#include "hdStream/base/log.h"

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Options of a store.
struct StoreOptions {
    std::string directory; ///< as ResolveCacheDirectory takes it
    bool enabled = true;
    std::uint64_t maxBytes = 10ULL << 30U; ///< least recently used entries go first above this
};

/// Entries by (kind, key). Thread-safe; safe between processes (temporary name, then rename).
class Store {
public:
    Store(StoreOptions options, Warnings* warnings);

    /// The payload, verified against its checksum; a corrupt entry is deleted, where it may be.
    /// Empty: not there.
    std::optional<std::vector<std::uint8_t>> Load(const std::string& kind, const std::string& key);

    /// Whether there is such an entry; it may be corrupt.
    bool Contains(const std::string& kind, const std::string& key) const;

    /// Keeps the payload. Failure warns once, and nothing more is kept.
    void Save(const std::string& kind, const std::string& key, const void* data, std::size_t bytes);

    /// The keys of all entries of a kind, sorted.
    std::vector<std::string> Keys(const std::string& kind) const;

    /// Deletes all entries, and what writers left half-done; returns their bytes.
    std::uint64_t Clear();

    /// Bytes of all entries, and of what is being written or was left half-done.
    std::uint64_t Size() const;

    const std::string& Directory() const { return _directory; }
    /// Whether entries are kept.
    bool IsWriting() const { return _isWriting; }

private:
    std::string PathOf(const std::string& kind, const std::string& key) const;
    void StopWriting(const std::string& reason);
    void Trim();

    std::string _directory;
    bool _enabled; ///< entries are looked for
    std::atomic<bool> _isWriting;
    std::uint64_t _maxBytes;
    Warnings* _warnings;
};

} // namespace hds
