// SPDX-License-Identifier: Apache-2.0
// A file by its descriptor: whole reads and writes at an offset, locks between processes, a
// mapping. Nothing here throws; a failure is `false` and errno.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hds {

/// What became of a try to lock.
enum class LockResult {
    Acquired,
    Busy,       ///< another open file holds a lock that excludes it
    Unsupported ///< this file system knows no such locks
};

/// An open file; closed at the end. Reading, writing and locking are thread-safe, the rest is not.
class File {
public:
    File() = default;
    ~File() { Close(); }
    File(File&& other) noexcept;
    File& operator=(File&& other) noexcept;
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    /// For reading and writing, else for reading only, else not open. A symbolic link is not open:
    /// for files of our own.
    static File Open(const std::string& path);
    /// For reading only, else not open. For files of others: links are followed, and a pipe is not
    /// waited for.
    static File OpenForReading(const std::string& path);
    /// For reading and writing; not open if the path exists (errno EEXIST) or cannot be made.
    static File Create(const std::string& path);

    bool IsOpen() const { return _descriptor >= 0; }
    bool IsWritable() const { return _isWritable; }

    /// \return false unless all bytes were read.
    bool Read(std::uint64_t offset, void* data, std::size_t bytes) const;
    /// \return false unless all bytes were written.
    bool Write(std::uint64_t offset, const void* data, std::size_t bytes) const;
    bool Resize(std::uint64_t bytes) const;

    /// Length in bytes; 0 if it cannot be told.
    std::uint64_t Size() const;
    /// Whether the file's name is gone (its content lives on until it is closed).
    bool IsUnlinked() const;
    /// Sets the time of the last modification to now; failure does not matter.
    void Touch() const;

    /// Locks bytes [first, first + count) for the life of this open file, or converts its lock of
    /// them. Never waits. Locks belong to the open file, not to the process: two File objects of
    /// one process exclude each other as those of two processes do. They are advisory.
    LockResult TryLock(std::uint64_t first, std::uint64_t count, bool isExclusive) const;
    void Unlock(std::uint64_t first, std::uint64_t count) const;

    /// A shared read-only mapping of [0, bytes), which may end behind the end of the file; only
    /// what is in the file may be touched. \return null if it cannot be made.
    const std::uint8_t* Map(std::size_t bytes) const;

private:
    File(int descriptor, bool isWritable) : _descriptor(descriptor), _isWritable(isWritable) {}
    void Close();

    int _descriptor = -1;
    bool _isWritable = false;
};

} // namespace hds
