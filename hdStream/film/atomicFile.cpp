// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/atomicFile.h"

#include "hdStream/base/error.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>

namespace fs = std::filesystem;

namespace hds {

namespace {

/// A short name that no other process uses; hidden on Unix.
std::string TemporaryName() {
    static std::atomic<std::uint64_t> counter{0};
    std::random_device random;
    return ".hdstream-" + std::to_string(random()) + "-" + std::to_string(counter.fetch_add(1)) +
           ".tmp";
}

} // namespace

AtomicFile::AtomicFile(const std::string& target) : _target(target) {
    std::error_code code;
    fs::path path = fs::canonical(target, code);
    if (code) {
        path = target; // it does not exist yet
    }
    const fs::file_status status = fs::status(path, code);
    if (fs::exists(status)) {
        if (fs::is_directory(status)) {
            Fail(EISDIR);
        }
        if (!fs::is_regular_file(status)) {
            throw Error("cannot write '" + _target + "': it is not a regular file");
        }
        // Renaming would replace a write-protected file: ask for the permission a plain write
        // needs.
        std::FILE* existing = std::fopen(path.string().c_str(), "r+b");
        if (!existing) {
            Fail(errno);
        }
        std::fclose(existing);
    }
    _finalPath = path.string();
    _temporaryPath = (path.parent_path() / TemporaryName()).string();
    _file = std::fopen(_temporaryPath.c_str(), "wbx");
    if (!_file) {
        Fail(errno);
    }
}

AtomicFile::~AtomicFile() {
    if (_file) {
        std::fclose(_file);
    }
    if (!_temporaryPath.empty()) {
        std::error_code ignored;
        fs::remove(_temporaryPath, ignored);
    }
}

std::size_t AtomicFile::Write(const void* data, std::size_t bytes) {
    if (_failure || bytes == 0) {
        return 0;
    }
    errno = 0;
    const std::size_t written = std::fwrite(data, 1, bytes, _file);
    if (written != bytes) {
        _failure = errno ? errno : EIO;
    }
    return written;
}

bool AtomicFile::Seek(std::int64_t position) {
    if (_failure) {
        return false;
    }
    errno = 0;
#ifdef _WIN32
    const int result = _fseeki64(_file, position, SEEK_SET);
#else
    const int result = fseeko(_file, static_cast<off_t>(position), SEEK_SET);
#endif
    if (result != 0) {
        _failure = errno ? errno : EIO;
    }
    return result == 0;
}

std::int64_t AtomicFile::Tell() const {
#ifdef _WIN32
    return _ftelli64(_file);
#else
    return static_cast<std::int64_t>(ftello(_file));
#endif
}

void AtomicFile::ThrowIfFailed() const {
    if (_failure) {
        Fail(_failure);
    }
}

void AtomicFile::Commit() {
    errno = 0;
    // A full disk may show only when the buffers are flushed.
    if (std::fclose(_file) != 0 && !_failure) {
        _failure = errno ? errno : EIO;
    }
    _file = nullptr;
    ThrowIfFailed();
    std::error_code code;
    fs::rename(_temporaryPath, _finalPath, code);
    if (code) {
        throw Error("cannot write '" + _target + "': " + code.message());
    }
    _temporaryPath.clear();
}

void AtomicFile::Fail(int reason) const {
    throw Error("cannot write '" + _target + "': " + std::strerror(reason));
}

} // namespace hds
