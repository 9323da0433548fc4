// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveSize.h"

#include "kernels/shared/frame.h"

#include <algorithm>

namespace hds {

namespace {

/// Paths in flight when the user does not say. Measured: docs/performance.md, "Rays a second".
constexpr std::uint32_t kMaxWaveSize = 1U << 20U;
/// GPUs: a launch of a bounce that few paths reach takes as long as one of many, so waves are as
/// large as a part of memory allows (docs/device.md, "On a GPU").
constexpr std::uint32_t kMaxWaveSizeGpu = 1U << 24U;
constexpr std::uint64_t kStatePartOfGpu = 32;
constexpr std::uint64_t kPathBytes = 256; ///< about
/// CPUs, for each core. What a launch waits for its last core and for the next launch costs some
/// hundred paths, so waves are as large as memory (200 bytes a path) is cheap; tiles are what is
/// traced together while nothing waits, and the wave of interactive hosts.
constexpr std::uint32_t kPathsPerCore = 1U << 16U;
constexpr std::uint32_t kTilePathsPerCore = 1U << 14U;
constexpr std::uint32_t kMinTileSizeCpu = 1U << 15U;
/// Of a tile: waves that would take too long are cut to this part of it at most. Smaller ones cost
/// more than they save (docs/performance.md, "Rays a second").
constexpr std::uint32_t kLeastPart = 4;
/// While geometry streams and pages leave. More would save little, and cost memory, of which slots
/// make better use (docs/decisions/0007).
constexpr std::uint32_t kPathsPerSlot = 6;
/// While geometry streams: of the pool, what path state and tables may take together.
constexpr std::uint64_t kStatePartOfPool = 8;
/// GPUs, while geometry streams.
constexpr std::uint32_t kMinWaveSizeStreamingGpu = 1U << 17U;
/// The numbers of paths have to fit their state (kernels/integrator/pathState.clh).
constexpr std::uint64_t kMaxWavePaths = 1U << 26U;

std::uint32_t OfCores(const DeviceProperties& properties, std::uint32_t pathsPerCore) {
    return std::clamp<std::uint32_t>(std::min(properties.computeUnits, 1024U) * pathsPerCore,
                                     kMinTileSizeCpu, kMaxWaveSize);
}

/// \param affordable as of ChooseWaveSize.
std::uint64_t SizeForDevice(const RenderOptions& options, const DeviceProperties& properties,
                            std::uint64_t affordable) {
    const std::uint64_t least =
        properties.isCpu || affordable == 0 ? TileSize(properties) : kMinWaveSizeStreamingGpu;
    if (options.interactive) {
        return least;
    }
    const std::uint64_t most = ResidentWaveSize(properties);
    if (affordable == 0) {
        return most;
    }
    return std::clamp(affordable, least, most);
}

} // namespace

std::uint32_t ChooseWaveSize(const RenderOptions& options, const DeviceProperties& properties,
                             std::uint64_t affordable) {
    const std::uint64_t pixels = std::uint64_t{options.imageWidth} * options.imageHeight;
    std::uint64_t size = options.waveSize;
    if (size == 0) {
        size = std::min(SizeForDevice(options, properties, affordable),
                        std::max<std::uint64_t>(pixels * options.samples, HDS_SAMPLE_BLOCK));
    }
    return static_cast<std::uint32_t>(std::max<std::uint64_t>(size, HDS_SAMPLE_BLOCK));
}

std::uint64_t StreamedPathBytes(std::uint64_t totalBytes, std::uint64_t poolBytes,
                                std::uint64_t residentBytes, std::uint64_t otherBytes) {
    const std::uint64_t savedBytes = totalBytes - std::min(totalBytes, poolBytes);
    return savedBytes + residentBytes - std::min(residentBytes, otherBytes);
}

std::uint64_t StreamedStateBytes(std::uint64_t poolBytes, std::uint64_t stateBytes,
                                 std::uint64_t tableBytes) {
    const std::uint64_t together = std::max(stateBytes, poolBytes / kStatePartOfPool);
    return together - std::min(together, tableBytes);
}

std::uint32_t StreamedPathsPerSlot(const RenderOptions& options, bool evicts) {
    return options.interactive || !evicts ? 1 : kPathsPerSlot;
}

std::uint32_t StreamedWavePaths(const RenderOptions& options, std::uint32_t numSlots, bool evicts) {
    const std::uint64_t image =
        std::uint64_t{options.imageWidth} * options.imageHeight * options.samples;
    const std::uint64_t most = std::uint64_t{numSlots} * StreamedPathsPerSlot(options, evicts);
    return static_cast<std::uint32_t>(
        std::min(kMaxWavePaths, std::max<std::uint64_t>(numSlots, std::min(most, image))));
}

std::uint32_t ResidentWaveSize(const DeviceProperties& properties) {
    if (properties.isCpu) {
        return OfCores(properties, kPathsPerCore);
    }
    return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        properties.memoryBytes / kStatePartOfGpu / kPathBytes, kMaxWaveSize, kMaxWaveSizeGpu));
}

std::uint32_t LeastWaveSize(const RenderOptions& options, const DeviceProperties& properties,
                            std::uint32_t waveSize) {
    const bool isCut = options.waveSize == 0 && properties.isCpu;
    return isCut ? std::min(waveSize, TileSize(properties) / kLeastPart) : waveSize;
}

std::uint32_t TileSize(const DeviceProperties& properties) {
    return properties.isCpu ? OfCores(properties, kTilePathsPerCore) : kMaxWaveSize;
}

} // namespace hds
