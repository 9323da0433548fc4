// SPDX-License-Identifier: Apache-2.0
// Which scenes general kernels cover, and when renders pay for kernels of their own.
#include "hdStream/integrator/generalKernels.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hds::test {
namespace {

TEST(GeneralKernels, CoverTheirOwnFormAlone) {
    const std::vector<KernelFeatures> all = AllGeneralFeatures();
    ASSERT_EQ(all.size(), 6U) << "two sets for each of three forms";
    for (const KernelFeatures& set : all) {
        EXPECT_EQ(set, set.WithNeeds());
        EXPECT_TRUE(Covers(set, set));
        KernelFeatures form;
        form.simd8 = set.simd8;
        form.flat = set.flat;
        form.streaming = set.streaming;
        form.firstHits = set.firstHits;
        EXPECT_TRUE(Covers(set, form));
        const std::vector<KernelFeatures> sets = GeneralFeatures(form);
        EXPECT_NE(std::find(sets.begin(), sets.end(), set), sets.end());
        KernelFeatures otherForm = form;
        otherForm.streaming = !otherForm.streaming;
        for (const KernelFeatures& other : GeneralFeatures(otherForm)) {
            EXPECT_FALSE(other == set);
        }
    }
}

/// Each feature alone: whoever gets a general set has the feature in it.
TEST(GeneralKernels, HaveWhatASceneAsksFor) {
    std::size_t numCovered = 0;
    std::size_t numNot = 0;
    const auto expectCovered = [&](const KernelFeatures& features, const char* name) {
        const std::vector<KernelFeatures> sets = GeneralFeatures(features.WithNeeds());
        ++(sets.empty() ? numNot : numCovered);
        for (const KernelFeatures& set : sets) {
            EXPECT_TRUE(Covers(set, features)) << name;
            EXPECT_EQ(set, set.WithNeeds()) << name;
        }
    };
    const KernelFeatures none;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    {                                                         \
        KernelFeatures features = none;                       \
        features.member = on;                                 \
        expectCovered(features, #member);                     \
    }
#define HDS_VARIANT(member, macro, needs, doc) \
    HDS_FEATURE(bool, member, macro, false, true, needs, doc)
#include "kernels/shared/features.def"
    EXPECT_GT(numCovered, 12U);
    EXPECT_GT(numNot, 12U);
}

TEST(GeneralKernels, LayeredSurfacesTakeTheSlowerSet) {
    KernelFeatures features;
    features.simd8 = true;
    EXPECT_EQ(GeneralFeatures(features).size(), 2U);
    EXPECT_EQ(GeneralFeatures(features).front().lobes, 0U);
    features.lobes = HDS_LOBE_BASE | HDS_LOBE_COAT;
    ASSERT_EQ(GeneralFeatures(features).size(), 1U);
    EXPECT_TRUE(GeneralFeatures(features).front().media);
    EXPECT_EQ(GeneralFeatures(features).front().lobes & HDS_LOBE_COAT_FRAME, 0U) << "other bits";
    features.lobes |= HDS_LOBE_COAT_FRAME; // a coat over bumps, as of car paint
    EXPECT_EQ(GeneralFeatures(features).size(), 1U);
    // Shading for eight paths does not know films, nor Schlick's terms; others are rare.
    for (const std::uint32_t lobe :
         {HDS_LOBE_FILM, HDS_LOBE_SCHLICK, HDS_LOBE_RETRO, HDS_LOBE_COVERED}) {
        features.lobes = HDS_LOBE_BASE | HDS_LOBE_COAT | lobe;
        EXPECT_TRUE(GeneralFeatures(features).empty());
    }
}

/// Textures that are resident have fewer arguments than those that stream; where there are none,
/// kernels that know streaming ones fit.
TEST(GeneralKernels, HaveTheFormOfTextures) {
    KernelFeatures features;
    EXPECT_TRUE(GeneralFeatures(features).front().textureStreaming);
    features.textures = true;
    EXPECT_FALSE(GeneralFeatures(features).front().textureStreaming);
    features.textureStreaming = true;
    EXPECT_TRUE(GeneralFeatures(features).front().textureStreaming);
}

TEST(GeneralKernels, OwnOnesPayInLongRenders) {
    EXPECT_FALSE(PayForOwnKernels(0.0));
    EXPECT_FALSE(PayForOwnKernels(5.0));
    EXPECT_TRUE(PayForOwnKernels(600.0));
    EXPECT_TRUE(EndsBeforeOwnKernels(1.0));
    EXPECT_FALSE(EndsBeforeOwnKernels(60.0));
}

} // namespace
} // namespace hds::test
