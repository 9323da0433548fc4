// SPDX-License-Identifier: Apache-2.0
// How many paths are in flight by default: by cores, image, hosts and memory.
#include "hdStream/integrator/waveSize.h"

#include <gtest/gtest.h>

namespace hds::test {
namespace {

DeviceProperties Cpu(std::uint32_t cores) {
    DeviceProperties properties;
    properties.isCpu = true;
    properties.computeUnits = cores;
    return properties;
}

RenderOptions Options() {
    RenderOptions options;
    options.imageWidth = 4096;
    options.imageHeight = 4096;
    options.samples = 16;
    return options;
}

TEST(WaveSize, GrowWithCoresWithinBounds) {
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(2), 0), 131072);
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(8), 0), 524288);
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(1000000000), 0), 1U << 20U);
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(0), 0), 32768);
    EXPECT_EQ(TileSize(Cpu(1)), 32768);
    EXPECT_EQ(TileSize(Cpu(8)), 131072);
}

TEST(WaveSize, WhileGeometryStreamsOfCpusIsWhatMemoryAllows) {
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(2), 1), 32768U);
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(2), 101000), 101000U);
    EXPECT_EQ(ChooseWaveSize(Options(), Cpu(2), 1U << 30U), ResidentWaveSize(Cpu(2)));
}

TEST(WaveSize, TakesLessWhereTheTablesOfGeometryTakeMuch) {
    constexpr std::uint64_t kMiB = 1U << 20U;
    EXPECT_EQ(StreamedStateBytes(512 * kMiB, 70 * kMiB, kMiB), 69 * kMiB);
    EXPECT_EQ(StreamedStateBytes(512 * kMiB, 60 * kMiB, kMiB), 63 * kMiB)
        << "an eighth of the pool";
    EXPECT_EQ(StreamedStateBytes(512 * kMiB, 70 * kMiB, 100 * kMiB), 0U) << "a tile, then";
    EXPECT_EQ(StreamedStateBytes(16 * kMiB, 70 * kMiB, 0), 70 * kMiB) << "as without tables";
}

TEST(WaveSize, SlotsAreUsedSeveralTimesWherePagesLeave) {
    RenderOptions options = Options();
    EXPECT_EQ(StreamedPathsPerSlot(options, true), 6U);
    EXPECT_EQ(StreamedWavePaths(options, 1000, true), 6000U);
    EXPECT_EQ(StreamedWavePaths(options, 1000, false), 1000U);
    EXPECT_EQ(StreamedWavePaths(options, 1U << 24U, true), 1U << 26U) << "their numbers end here";
    options.imageWidth = 10;
    options.imageHeight = 10;
    EXPECT_EQ(StreamedWavePaths(options, 1000, true), 1600U) << "no more than the image has";
    EXPECT_EQ(StreamedWavePaths(options, 5000, true), 5000U);
    options.interactive = true;
    EXPECT_EQ(StreamedWavePaths(options, 1000, true), 1000U);
}

TEST(WaveSize, OfInteractiveHostsAreTiles) {
    RenderOptions options = Options();
    options.interactive = true;
    EXPECT_EQ(ChooseWaveSize(options, Cpu(2), 0), TileSize(Cpu(2)));
    EXPECT_EQ(ChooseWaveSize(options, Cpu(2), 1), TileSize(Cpu(2)));
}

TEST(WaveSize, AreAsSetOrNoLargerThanTheImage) {
    RenderOptions options = Options();
    options.imageWidth = 10;
    options.imageHeight = 10;
    EXPECT_EQ(ChooseWaveSize(options, Cpu(2), 0), 1600);
    options.waveSize = 5000;
    EXPECT_EQ(ChooseWaveSize(options, Cpu(2), 0), 5000);
}

TEST(WaveSize, TakeWhatThePoolSavesOnGpus) {
    DeviceProperties gpu;
    gpu.memoryBytes = std::uint64_t{4} << 30U;
    EXPECT_EQ(ChooseWaveSize(Options(), gpu, 0), 1U << 20U);
    EXPECT_EQ(ChooseWaveSize(Options(), gpu, 1), 1U << 17U);
    EXPECT_EQ(ChooseWaveSize(Options(), gpu, 300000), 300000);
}

TEST(WaveSize, GrowWithTheMemoryOfGpusWithinBounds) {
    DeviceProperties gpu;
    EXPECT_EQ(ResidentWaveSize(gpu), 1U << 20U) << "the driver does not say";
    gpu.memoryBytes = std::uint64_t{16} << 30U;
    EXPECT_EQ(ResidentWaveSize(gpu), 2097152U);
    EXPECT_LE(ResidentWaveSize(gpu) * std::uint64_t{256}, gpu.memoryBytes / 32);
    gpu.memoryBytes = std::uint64_t{140} << 30U;
    EXPECT_EQ(ResidentWaveSize(gpu), 1U << 24U);
    EXPECT_EQ(ChooseWaveSize(Options(), gpu, 0), 1U << 24U);
    RenderOptions options = Options();
    options.interactive = true;
    EXPECT_EQ(ChooseWaveSize(options, gpu, 0), 1U << 20U) << "an edit waits for it";
}

} // namespace
} // namespace hds::test
