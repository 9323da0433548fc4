// SPDX-License-Identifier: Apache-2.0
// The hash tells contents, lengths and orders apart, and never changes between builds.
#include "hdStream/base/hash.h"

#include <gtest/gtest.h>

#include <set>

namespace hds {
namespace {

std::string HexOf(std::initializer_list<std::string_view> texts) {
    Hasher hasher;
    for (const std::string_view text : texts) {
        hasher.Append(text);
    }
    return hasher.Hex();
}

TEST(Hash, TellsSplitsAndOrdersApart) {
    const std::set<std::string> values{HexOf({"ab", "c"}), HexOf({"a", "bc"}), HexOf({"abc"}),
                                       HexOf({"c", "ab"}), HexOf({"", "abc"}), HexOf({})};
    EXPECT_EQ(values.size(), 6U);
    EXPECT_EQ(HexOf({"ab", "c"}), HexOf({"ab", "c"}));
}

TEST(Hash, EverySingleBitMatters) {
    std::set<std::string> values;
    for (int byte = 0; byte < 64; ++byte) {
        for (int bit = 0; bit < 8; ++bit) {
            unsigned char data[64] = {};
            data[byte] = static_cast<unsigned char>(1U << bit);
            Hasher hasher;
            hasher.Append(data, sizeof(data));
            values.insert(hasher.Hex());
        }
    }
    EXPECT_EQ(values.size(), 64U * 8U);
}

} // namespace
} // namespace hds
