// SPDX-License-Identifier: Apache-2.0
// Sizes and percentages as users write them.
#include "hdStream/session/memorySize.h"

#include "hdStream/base/error.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace hds {
namespace {

std::string ErrorOf(const std::string& text) {
    try {
        ParseMemorySize(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage);
        return error.what();
    }
    return "none";
}

TEST(MemorySize, SuffixesArePowersOf1024) {
    EXPECT_EQ(ParseBytes("1"), 1U);
    EXPECT_EQ(ParseBytes("4096"), 4096U);
    EXPECT_EQ(ParseBytes("4K"), 4096U);
    EXPECT_EQ(ParseBytes("512m"), 536870912U);
    EXPECT_EQ(ParseBytes("1.5G"), 1610612736U);
    EXPECT_EQ(ParseBytes("2T"), std::uint64_t{1} << 41U);
    EXPECT_EQ(ParseBytes("1e3M"), 1048576000U);
    EXPECT_EQ(ParseBytes("1.9"), 1U);
}

TEST(MemorySize, IsBytesOrAShare) {
    EXPECT_EQ(ParseMemorySize("2G").bytes, std::uint64_t{2} << 30U);
    EXPECT_EQ(ParseMemorySize("2G").share, 0.0);
    EXPECT_EQ(ParseMemorySize("30%").bytes, 0U);
    EXPECT_EQ(ParseMemorySize("30%").share, 0.3);
    EXPECT_EQ(ParseMemorySize("100%").share, 1.0);
}

TEST(MemorySize, SaysWhatIsExpected) {
    for (const char* text : {"", "K", "12Q", "12KB", "1 G", "G2", "nan", "inf", "0x10", "1,5G",
                             "1e30", "99999999T", "1e999"}) {
        const std::string expected =
            "'" + std::string(text) + "' is not a size such as 512M, 2G or 30%";
        EXPECT_EQ(ErrorOf(text), expected);
    }
    for (const char* text : {"0", "0G", "-1", "-2M", "0.5"}) {
        EXPECT_EQ(ErrorOf(text), "'" + std::string(text) + "' is not a size above 0");
    }
    for (const char* text : {"%", "0%", "-5%", "101%", "nan%", "5K%", "5 %"}) {
        EXPECT_EQ(ErrorOf(text), "'" + std::string(text) + "' is not a percentage in 0..100");
    }
}

} // namespace
} // namespace hds
