// SPDX-License-Identifier: Apache-2.0
// Sets of kernels: those used last stay, up to a number; what leaves is saved and comes back.
#include "hdStream/integrator/kernelSets.h"
#include "hdStream/scene/commit.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/temporaryFolder.h"

namespace hds::test {
namespace {

class KernelSetsTest : public DeviceFixture {};

TEST_F(KernelSetsTest, ThoseUsedLastStay) {
    Warnings warnings;
    const SceneDescription description;
    CommitCache cache(warnings);
    const auto scene = CommitScene(description, {}, &cache, warnings);
    const TemporaryFolder folder;
    Store store({folder.Path()}, &warnings);
    SceneBuffers buffers(device, &store);
    ASSERT_TRUE(buffers.Update(*scene, {}));

    KernelFeatures one;
    KernelFeatures two;
    two.groups = true;
    KernelFeatures three;
    three.groups = true;
    three.simd8 = true;
    KernelSets sets(device, &store, 2);
    const auto secondsOf = [&](const KernelFeatures& features) {
        double seconds = 0.0;
        EXPECT_EQ(sets.Get(features, buffers, 1, &seconds).Features(), features);
        return seconds;
    };
    EXPECT_GT(secondsOf(one), 0.0);
    EXPECT_GT(secondsOf(two), 0.0);
    EXPECT_EQ(secondsOf(one), 0.0);
    EXPECT_EQ(sets.AreInStore(two), !device->Properties().hasSlowBinaries) << "saved later";
    EXPECT_GT(secondsOf(three), 0.0);
    EXPECT_TRUE(sets.Has(one));
    EXPECT_FALSE(sets.Has(two)) << "used longest ago";
    EXPECT_TRUE(sets.Has(three));
    EXPECT_TRUE(sets.AreInStore(two)) << "nothing is compiled twice";
    EXPECT_GT(secondsOf(two), 0.0);
    EXPECT_FALSE(sets.Has(one));
}

/// What a process asked for is made by the next one before it knows of a scene, and nothing else.
TEST_F(KernelSetsTest, WarmMakesWhatWasRemembered) {
    Warnings warnings;
    const TemporaryFolder folder;
    Store store({folder.Path()}, &warnings);
    KernelFeatures first;
    first.groups = true;
    KernelFeatures last;
    last.simd8 = true;
    {
        KernelSets sets(device, &store);
        sets.Warm();
        sets.EndWarm();
        EXPECT_FALSE(sets.Has(first)) << "nothing is remembered";
        for (const KernelFeatures& features : {first, last}) {
            StageKernels(device, &store, features).SaveBinaries(&store);
            sets.Remember(features);
        }
    }
    KernelSets sets(device, &store);
    sets.Warm();
    sets.EndWarm();
    EXPECT_TRUE(sets.Has(last));
    EXPECT_FALSE(sets.Has(first));
    store.Clear();
    KernelSets(device, &store).Remember(last); // its kernels are in the store no more
    KernelSets cold(device, &store);
    cold.Warm();
    cold.EndWarm();
    EXPECT_FALSE(cold.Has(last)) << "it compiles nothing";
}

} // namespace
} // namespace hds::test
