// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/error.h"

#include <cstdio>
#include <cstdlib>

namespace hds {

void FailVerify(const char* condition, const char* file, int line, const std::string& message) {
    std::fprintf(stderr, "hdStream: broken invariant %s at %s:%d: %s\n", condition, file, line,
                 message.c_str());
    std::abort();
}

} // namespace hds
