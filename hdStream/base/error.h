// SPDX-License-Identifier: Apache-2.0
// Errors of the environment (device, disk, memory, options) and broken invariants of our own code.
// Scene content never throws: it warns (base/log.h) and is replaced by a defined fallback.
#pragma once

#include <stdexcept>
#include <string>

namespace hds {

/// What failed, as the front end's exit code distinguishes it (docs/command-line.md).
enum class ErrorKind {
    Usage,   ///< a wrong option or argument: exit code 2
    Failure, ///< rendering, device, disk or memory failed: exit code 1
};

/// An error of the environment. The message is one line that names the file, option, prim or
/// device.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message, ErrorKind kind = ErrorKind::Failure)
        : std::runtime_error(message), _kind(kind) {}
    ErrorKind kind() const { return _kind; }

private:
    ErrorKind _kind;
};

/// Prints the broken invariant and aborts. Used through HDS_VERIFY only.
[[noreturn]] void FailVerify(const char* condition, const char* file, int line,
                             const std::string& message);

} // namespace hds

/// Checks an invariant of our own code, in every build type; the message prints its operands.
#define HDS_VERIFY(condition, message)                                    \
    do {                                                                  \
        if (!(condition)) {                                               \
            ::hds::FailVerify(#condition, __FILE__, __LINE__, (message)); \
        }                                                                 \
    } while (false)
