// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/drawnPaths.h"

#include <gtest/gtest.h>

namespace hds {

TEST(DrawnPaths, PrimsLieAtAndBelowPaths) {
    for (const char* prim : {"/a/b", "/a/b/c", "/a/b{/x/y}", "/a/b{2}"}) {
        EXPECT_TRUE(IsAtOrBelow(prim, "/a/b")) << prim;
        EXPECT_TRUE(IsAtOrBelow(prim, "/a")) << prim;
        EXPECT_TRUE(IsAtOrBelow(prim, "/")) << prim;
    }
    for (const char* prim : {"/a/bc", "/a", "/", "/b", "", "/x/a/b"}) {
        EXPECT_FALSE(IsAtOrBelow(prim, "/a/b")) << prim;
    }
}

TEST(DrawnPaths, HiddenWinsAndNoneDrawnMeansAll) {
    EXPECT_TRUE(IsDrawnPath("/a", {}, {}));
    EXPECT_TRUE(IsDrawnPath("/a/b", {"/c", "/a"}, {}));
    EXPECT_FALSE(IsDrawnPath("/d", {"/c", "/a"}, {}));
    EXPECT_FALSE(IsDrawnPath("/a/b", {"/a"}, {"/a/b"}));
    EXPECT_TRUE(IsDrawnPath("/a/c", {"/a"}, {"/a/b"}));
    EXPECT_FALSE(IsDrawnPath("/a", {}, {"/"}));
}

} // namespace hds
