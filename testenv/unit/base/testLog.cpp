// SPDX-License-Identifier: Apache-2.0
// A warning comes once, whatever the number of threads that raise it, and lists are sorted.
#include "hdStream/base/log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

namespace hds {
namespace {

TEST(Warnings, EachLineOnceFromAnyThread) {
    int numCalls = 0; // the sink runs under the lock
    Warnings warnings([&](const std::string&) { ++numCalls; });
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            for (int k = 0; k < 100; ++k) {
                warnings.Add("/prim" + std::to_string(k % 10), "text");
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(numCalls, 10);
    const std::vector<std::string> lines = warnings.Lines();
    ASSERT_EQ(lines.size(), 10U);
    EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end()));
    EXPECT_EQ(lines.front(), "/prim0: text");
}

} // namespace
} // namespace hds
