// SPDX-License-Identifier: Apache-2.0
// Whatever a scene takes, pages and sources together stay within what is left, or within a quarter.
#include "hdStream/session/hostShares.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

TEST(HostShares, TheSceneComesFirst) {
    constexpr std::uint64_t kHost = 4096;
    for (const std::uint64_t scene : {0U, 1U, 1000U, 3072U}) {
        const HostShares shares = ShareHostMemory(kHost, scene);
        EXPECT_EQ(scene + shares.pages + shares.sources, kHost);
        EXPECT_EQ(shares.sources, (kHost - scene) / 4);
    }
}

TEST(HostShares, AQuarterIsAlwaysSharedOut) {
    for (const std::uint64_t scene : {3073ULL, 4096ULL, 1ULL << 60U}) {
        const HostShares shares = ShareHostMemory(4096, scene);
        EXPECT_EQ(shares.pages + shares.sources, 1024U);
        EXPECT_EQ(shares.sources, 256U);
    }
    EXPECT_EQ(ShareHostMemory(0, 5).pages, 0U);
}

} // namespace
} // namespace hds
