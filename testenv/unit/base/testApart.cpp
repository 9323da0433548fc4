// SPDX-License-Identifier: Apache-2.0
// A value that lies apart behaves as the value itself, and takes a pointer where it is the default.
#include "hdStream/base/apart.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hds {
namespace {

using Text = Apart<std::string>;

TEST(Apart, ADefaultTakesAPointer) {
    EXPECT_EQ(sizeof(Apart<std::vector<std::string>>), sizeof(void*));
    EXPECT_FALSE(Text().IsApart());
    EXPECT_FALSE(Text(std::string()).IsApart());
    EXPECT_TRUE(Text(std::string("a")).IsApart());
    EXPECT_EQ(*Text(), "");
    EXPECT_EQ(Text()->size(), 0U);
}

TEST(Apart, CopiesHaveValuesOfTheirOwn) {
    Text first(std::string("first"));
    Text copy = first;
    copy.Edit() += "!";
    EXPECT_EQ(*first, "first");
    EXPECT_EQ(*copy, "first!");
    first = copy;
    copy.Edit() = "other";
    EXPECT_EQ(*first, "first!");
    Text moved = std::move(copy);
    EXPECT_EQ(*moved, "other");
    first = std::move(moved);
    EXPECT_EQ(*first, "other");
    first = Text();
    EXPECT_FALSE(first.IsApart());
}

TEST(Apart, AssignsItself) {
    Text text(std::string("text"));
    const Text& same = text;
    text = same;
    EXPECT_EQ(*text, "text");
}

TEST(Apart, ComparesValuesWhereverTheyLie) {
    Text edited;
    edited.Edit() = "";
    EXPECT_TRUE(edited.IsApart());
    EXPECT_TRUE(edited == Text());
    edited.Edit() = "a";
    EXPECT_TRUE(edited != Text());
    EXPECT_TRUE(edited == Text(std::string("a")));
}

} // namespace
} // namespace hds
