// SPDX-License-Identifier: Apache-2.0
// Plays a full disk without privileges: while it lives, files of this process end at a limit and
// writes beyond it fail (EFBIG).
#pragma once

#include <csignal>
#include <sys/resource.h>

namespace hds::test {

class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) {
        _oldHandler = std::signal(SIGXFSZ, SIG_IGN); // else the write would end the process
        getrlimit(RLIMIT_FSIZE, &_old);
        rlimit limited = _old;
        limited.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &limited);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &_old);
        std::signal(SIGXFSZ, _oldHandler);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    rlimit _old{};
    void (*_oldHandler)(int) = nullptr;
};

} // namespace hds::test
