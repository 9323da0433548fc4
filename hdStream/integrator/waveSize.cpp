// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveSize.h"

#include "kernels/shared/frame.h"

#include <algorithm>

namespace hds {

namespace {

/// Paths in flight when the user does not say. Measured: docs/performance.md, "Wave size".
constexpr std::uint32_t kWaveSizeCpu = 32U << 10U;
constexpr std::uint32_t kWaveSizeGpu = 1U << 20U;
/// While geometry streams path state takes the memory that the pool does not, so that both together
/// are no more than resident geometry. A page that is transferred serves all that waits of a wave;
/// on CPUs more than so many paths only leave the caches (docs/streaming.md). Where someone looks
/// at previews, edits wait for a wave, and the least is taken.
constexpr std::uint32_t kMinWaveSizeStreamingCpu = 1U << 15U;
constexpr std::uint32_t kMaxWaveSizeStreamingCpu = 1U << 17U;
constexpr std::uint32_t kMinWaveSizeStreamingGpu = 1U << 17U;
constexpr std::uint32_t kMaxWaveSizeStreamingGpu = 1U << 20U;

} // namespace

std::uint32_t ChooseWaveSize(const RenderOptions& options, const DeviceProperties& properties,
                             std::uint64_t spareSlots) {
    const std::uint64_t pixels = std::uint64_t{options.imageWidth} * options.imageHeight;
    const std::uint64_t tile = TileSize(properties);
    std::uint64_t size = options.waveSize;
    if (size == 0) {
        size = properties.isCpu ? kWaveSizeCpu : kWaveSizeGpu;
        if (spareSlots > 0) {
            const std::uint64_t least =
                properties.isCpu ? kMinWaveSizeStreamingCpu : kMinWaveSizeStreamingGpu;
            const std::uint64_t most =
                properties.isCpu ? kMaxWaveSizeStreamingCpu : kMaxWaveSizeStreamingGpu;
            size = options.showsPreviews ? least : std::clamp(spareSlots, least, most);
            size -= size % std::min(size, tile); // no rest that is launched alone
        }
        size = std::min(size, std::max<std::uint64_t>(pixels * options.samples, HDS_SAMPLE_BLOCK));
    }
    return static_cast<std::uint32_t>(std::max<std::uint64_t>(size, HDS_SAMPLE_BLOCK));
}

std::uint32_t TileSize(const DeviceProperties& properties) {
    return properties.isCpu ? kWaveSizeCpu : kWaveSizeGpu;
}

} // namespace hds
