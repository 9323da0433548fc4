// SPDX-License-Identifier: Apache-2.0
// A stopwatch.
#pragma once

#include <chrono>

namespace hds {

/// Runs from its construction on.
class Timer {
public:
    double Seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - _start).count();
    }

private:
    std::chrono::steady_clock::time_point _start = std::chrono::steady_clock::now();
};

} // namespace hds
