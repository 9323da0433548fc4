// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace hds {

namespace {

/// Calls until it is not interrupted by a signal.
template <typename Call>
auto Uninterrupted(const Call& call) {
    auto result = call();
    while (result < 0 && errno == EINTR) {
        result = call();
    }
    return result;
}

/// \return false with EAGAIN or EACCES when another open file holds the lock.
bool SetLock(int descriptor, int type, std::uint64_t first, std::uint64_t count) {
#ifdef F_OFD_SETLK
    struct flock range {};
    range.l_type = static_cast<short>(type);
    range.l_whence = SEEK_SET;
    range.l_start = static_cast<off_t>(first);
    range.l_len = static_cast<off_t>(count);
    return Uninterrupted([&] { return ::fcntl(descriptor, F_OFD_SETLK, &range); }) == 0;
#else
    static_cast<void>(descriptor), static_cast<void>(type);
    static_cast<void>(first), static_cast<void>(count);
    errno = ENOTSUP;
    return false;
#endif
}

} // namespace

File::File(File&& other) noexcept
    : _descriptor(std::exchange(other._descriptor, -1)), _isWritable(other._isWritable) {}

File& File::operator=(File&& other) noexcept {
    if (this != &other) {
        Close();
        _descriptor = std::exchange(other._descriptor, -1);
        _isWritable = other._isWritable;
    }
    return *this;
}

void File::Close() {
    if (_descriptor >= 0) {
        ::close(_descriptor);
        _descriptor = -1;
    }
}

File File::Open(const std::string& path) {
    const int both =
        Uninterrupted([&] { return ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW); });
    if (both >= 0) {
        return {both, true};
    }
    return {Uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW); }),
            false};
}

File File::OpenForReading(const std::string& path) {
    return {Uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }),
            false};
}

File File::Create(const std::string& path) {
    return {Uninterrupted(
                [&] { return ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644); }),
            true};
}

bool File::Read(std::uint64_t offset, void* data, std::size_t bytes) const {
    auto* p = static_cast<std::uint8_t*>(data);
    while (bytes > 0) {
        const ssize_t count = Uninterrupted(
            [&] { return ::pread(_descriptor, p, bytes, static_cast<off_t>(offset)); });
        if (count <= 0) {
            return false;
        }
        p += count;
        offset += static_cast<std::uint64_t>(count);
        bytes -= static_cast<std::size_t>(count);
    }
    return true;
}

bool File::Write(std::uint64_t offset, const void* data, std::size_t bytes) const {
    const auto* p = static_cast<const std::uint8_t*>(data);
    while (bytes > 0) {
        const ssize_t count = Uninterrupted(
            [&] { return ::pwrite(_descriptor, p, bytes, static_cast<off_t>(offset)); });
        if (count <= 0) {
            if (count == 0) {
                errno = ENOSPC;
            }
            return false;
        }
        p += count;
        offset += static_cast<std::uint64_t>(count);
        bytes -= static_cast<std::size_t>(count);
    }
    return true;
}

bool File::Resize(std::uint64_t bytes) const {
    return Uninterrupted([&] { return ::ftruncate(_descriptor, static_cast<off_t>(bytes)); }) == 0;
}

std::uint64_t File::Size() const {
    struct stat status {};
    return ::fstat(_descriptor, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

bool File::IsUnlinked() const {
    struct stat status {};
    return ::fstat(_descriptor, &status) != 0 || status.st_nlink == 0;
}

void File::Touch() const {
    ::futimens(_descriptor, nullptr);
}

LockResult File::TryLock(std::uint64_t first, std::uint64_t count, bool isExclusive) const {
    if (SetLock(_descriptor, isExclusive ? F_WRLCK : F_RDLCK, first, count)) {
        return LockResult::Acquired;
    }
    return errno == EAGAIN || errno == EACCES ? LockResult::Busy : LockResult::Unsupported;
}

void File::Unlock(std::uint64_t first, std::uint64_t count) const {
    SetLock(_descriptor, F_UNLCK, first, count);
}

const std::uint8_t* File::Map(std::size_t bytes) const {
    void* address = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, _descriptor, 0);
    return address == MAP_FAILED ? nullptr : static_cast<const std::uint8_t*>(address);
}

} // namespace hds
