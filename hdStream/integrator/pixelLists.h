// SPDX-License-Identifier: Apache-2.0
// The lists of pixels that waves take theirs from, on the device. Explained in docs/session.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/integrator/sampleSchedule.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace hds {

/// Keeps lists from one render to the next while they are the same: to write those of a whole image
/// may take longer than to trace the first picture after an edit. Externally synchronised.
class PixelLists {
public:
    explicit PixelLists(std::shared_ptr<Device> device) : _device(std::move(device)) {}

    /// Frees what a render of this schedule has no use for.
    void Begin(const SampleSchedule& schedule);

    /// SampleSchedule::Pixels. Its contents may be others after the next call.
    const Buffer& Get(const SampleSchedule& schedule, PixelList list);
    /// SampleSchedule::AllPixels.
    const Buffer& All(const SampleSchedule& schedule);

private:
    struct Kept {
        std::uint64_t number = 0; ///< SampleSchedule::NumberOf; 0: there is none
        Buffer buffer;
    };

    const Buffer& Keep(std::uint64_t number, const std::vector<std::uint32_t>& pixels, Kept* kept);

    std::shared_ptr<Device> _device;
    Kept _preview;
    Kept _all;
    Kept _others; ///< Late, or Active where pixels have been dropped
};

} // namespace hds
