// SPDX-License-Identifier: Apache-2.0
// A file that appears whole or not at all: written under a temporary name in the target's folder,
// renamed when it is complete. Whatever fails, the file that was there before stays as it was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace hds {

/// Writes one file atomically. Not thread-safe. After the first failure further writes do nothing.
class AtomicFile {
public:
    /// Creates the temporary file. A link is followed: the file it points to is replaced.
    /// \throws Error that names the target and the reason (no such folder, no permission, target is
    ///         a folder or a device ...)
    explicit AtomicFile(const std::string& target);

    /// Removes the temporary file unless Commit has succeeded.
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Bytes written at the present position; fewer than asked for after a failure.
    std::size_t Write(const void* data, std::size_t bytes);

    /// Position in bytes from the start.
    bool Seek(std::int64_t position);
    std::int64_t Tell() const;

    /// Where the bytes are until Commit: for who must open a file by its name, and closes it
    /// before.
    const std::string& TemporaryPath() const { return _temporaryPath; }

    /// \throws Error that names the target and the reason when a write or a seek has failed
    void ThrowIfFailed() const;

    /// Closes and renames.
    /// \throws Error that names the target and the reason when any write, or this, has failed
    void Commit();

private:
    [[noreturn]] void Fail(int reason) const;

    std::string _target;    ///< as the user named it, for messages
    std::string _finalPath; ///< links resolved
    std::string _temporaryPath;
    std::FILE* _file = nullptr;
    int _failure = 0; ///< errno of the first failure
};

} // namespace hds
