// SPDX-License-Identifier: Apache-2.0
// How many paths are in flight. It changes speed and memory, never bits.
// Explained in docs/wavefront.md and docs/streaming.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/integrator/renderOptions.h"

#include <cstdint>

namespace hds {

/// The wave size of the options, or one that suits the device; at least a block of samples, at most
/// all samples of the image. \param affordable while geometry streams: paths whose state fits what
/// resident geometry would take beyond the pool; 0: geometry is resident.
std::uint32_t ChooseWaveSize(const RenderOptions& options, const DeviceProperties& properties,
                             std::uint64_t affordable);

/// What path state may take while geometry streams, so that all together takes no more than
/// resident geometry with its wave would. \param residentBytes of that wave's state. \param
/// otherBytes of tables that are there besides.
std::uint64_t StreamedPathBytes(std::uint64_t totalBytes, std::uint64_t poolBytes,
                                std::uint64_t residentBytes, std::uint64_t otherBytes);

/// What path state may take while geometry streams, so that all that is beside the pool stays
/// small: with the tables of geometry as much as the state of the default wave, or an eighth of the
/// pool. \param stateBytes of that wave. \param tableBytes of geometry.
std::uint64_t StreamedStateBytes(std::uint64_t poolBytes, std::uint64_t stateBytes,
                                 std::uint64_t tableBytes);

/// How many paths a wave traces in so many slots while geometry streams. Where pages leave, several
/// for each: paths that begin late take the slots of those that have ended, so that the last few
/// paths of a wave, which wait for pages by themselves, are seldom.
/// \param evicts the pool has no room for all pages.
std::uint32_t StreamedWavePaths(const RenderOptions& options, std::uint32_t numSlots, bool evicts);
/// The same by slot, where the image has enough paths.
std::uint32_t StreamedPathsPerSlot(const RenderOptions& options, bool evicts);

/// The least paths that a wave may be cut to, so that it ends in time (SampleSchedule::WavePixels):
/// all of `waveSize` where the user has chosen it, and on GPUs, which trace a wave in no time.
std::uint32_t LeastWaveSize(const RenderOptions& options, const DeviceProperties& properties,
                            std::uint32_t waveSize);

/// What suits the device when geometry is resident and memory does not matter.
std::uint32_t ResidentWaveSize(const DeviceProperties& properties);

/// Paths of a wave that are traced together while nothing waits: as many as suit the device's
/// caches.
std::uint32_t TileSize(const DeviceProperties& properties);

} // namespace hds
