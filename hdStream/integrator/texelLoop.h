// SPDX-License-Identifier: Apache-2.0
// Shades items again that have missed texels, until none does. Explained in
// docs/texturing.md.
#pragma once

#include "hdStream/integrator/renderStatistics.h"
#include "hdStream/integrator/stageKernels.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

namespace hds {

/// Runs after each launch that evaluates materials. Externally synchronised.
class TexelLoop {
public:
    /// Launches the kernel again over items [0, count) of `queue`.
    using Relaunch = std::function<void(const Buffer& queue, std::uint32_t count)>;

    TexelLoop(std::shared_ptr<Device> device, SceneBuffers* buffers, RenderStatistics* statistics);

    /// \param maxItems most items of a launch. \param iterations after so many launches of an item
    /// coarser mips are taken for texels that are still missing; 0: never.
    void Ready(StageKernels* kernels, std::uint32_t maxItems, std::uint32_t iterations);

    /// Of the launches to come: asked while texels are loaded. Empty: they are not cancelled.
    /// What is given up until the next call stays given up.
    void Watch(LineProvider::IsCancelled isCancelled) {
        _isCancelled = std::move(isCancelled);
        _isGivenUp = false;
    }

    /// After a launch of `numItems`: as long as some wait for texels, loads those and launches them
    /// again. Does nothing when textures do not stream. Blocks. Where it is cancelled, those that
    /// still wait are given up, and with them the wave that they are of.
    void Finish(std::uint32_t numItems, const Relaunch& relaunch);

    /// Seconds of preparing, reading and loading so far.
    double Seconds() const;

private:
    std::shared_ptr<Device> _device;
    SceneBuffers* _buffers;
    RenderStatistics* _statistics;
    StageKernels* _kernels = nullptr;
    std::uint32_t _iterations = 0;
    LineProvider::IsCancelled _isCancelled;
    bool _isGivenUp = false; ///< some that have waited were
    Buffer _queue;
};

} // namespace hds
