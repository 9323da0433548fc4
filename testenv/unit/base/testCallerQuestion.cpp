// SPDX-License-Identifier: Apache-2.0
// Callbacks of hosts are asked on the thread that called, until they say yes; all threads are told.
#include "hdStream/base/callerQuestion.h"

#include <gtest/gtest.h>

#include <thread>

namespace hds {
namespace {

TEST(CallerQuestion, IsAskedByItsThreadUntilYes) {
    int numAsked = 0;
    const std::function<bool()> ask = [&numAsked] { return ++numAsked == 2; };
    CallerQuestion question(ask);
    EXPECT_FALSE(question.Ask());
    std::thread([&] { EXPECT_FALSE(question.Ask()); }).join();
    EXPECT_EQ(numAsked, 1);
    EXPECT_FALSE(question.IsYes());
    EXPECT_TRUE(question.Ask());
    std::thread([&] { EXPECT_TRUE(question.Ask() && question.IsYes()); }).join();
    EXPECT_TRUE(question.Ask());
    EXPECT_EQ(numAsked, 2);
}

TEST(CallerQuestion, NobodyToAskIsNo) {
    const std::function<bool()> nobody;
    CallerQuestion question(nobody);
    EXPECT_FALSE(question.Ask() || question.IsYes());
}

} // namespace
} // namespace hds
