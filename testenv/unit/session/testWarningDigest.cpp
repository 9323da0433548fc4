// SPDX-License-Identifier: Apache-2.0
// Many warnings become one line a kind, with the first three names.
#include "hdStream/session/warningDigest.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hds {
namespace {

using Lines = std::vector<std::string>;

TEST(WarningDigest, OneLineAKindWithThreeNames) {
    Lines lines;
    for (int i = 0; i < 40; ++i) {
        lines.push_back("/Looks/m" + std::to_string(10 + i) + ": no tangents");
    }
    lines.insert(lines.begin(), "/B: no points");
    lines.push_back("/A: no points");
    lines.push_back("/Alone: nothing like it");
    EXPECT_EQ(DigestWarnings(lines),
              (Lines{"/A and /B: no points", "/Alone: nothing like it",
                     "/Looks/m10, /Looks/m11, /Looks/m12 and 37 more: no tangents"}));
    EXPECT_EQ(DigestWarnings({"/C: x", "/A: x", "/B: x"}), Lines{"/A, /B and /C: x"});
    EXPECT_EQ(DigestWarnings({}), Lines{});
}

TEST(WarningDigest, NumbersAndPrimsMakeNoKindAndOtherWordsDo) {
    EXPECT_EQ(DigestWarnings({"/A: 2 faces dropped", "/B: 31 faces dropped", "/C: 1 face dropped"}),
              (Lines{"/A and /B: 2 faces dropped (or alike)", "/C: 1 face dropped"}));
    EXPECT_EQ(DigestWarnings({"/A: node /A/x is unknown", "/A: node /A/y is unknown"}),
              Lines{"/A: node /A/x is unknown (or alike)"}); // one prim, named once
    EXPECT_EQ(DigestWarnings({"/A: cannot read a1.png", "/B: cannot read a2.png"}).size(), 2U);
}

TEST(WarningDigest, WhatNamesNoPrimStaysAsItIs) {
    const Lines lines{"/A: 1 face", "USD: cannot open 1", "USD: cannot open 2", "no lights: a dome",
                      "some/file.png: is empty"};
    EXPECT_EQ(DigestWarnings(lines), lines);
    EXPECT_EQ(
        DigestWarnings({"/a path with blanks/a.usd: 1 bad", "/a path with blanks/a.usd: 2 bad"})
            .size(),
        2U);
}

} // namespace
} // namespace hds
