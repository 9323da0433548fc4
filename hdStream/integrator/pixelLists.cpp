// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pixelLists.h"

namespace hds {

void PixelLists::Begin(const SampleSchedule& schedule) {
    if (_all.number != schedule.NumberOfAll()) {
        _all = {};
    }
    if (_preview.number != schedule.NumberOf(PixelList::Preview)) {
        _preview = {};
    }
    _others = {}; // of one render each
}

const Buffer& PixelLists::Get(const SampleSchedule& schedule, PixelList list) {
    const std::uint64_t number = schedule.NumberOf(list);
    const bool isAll = number == schedule.NumberOfAll();
    Kept* kept = list == PixelList::Preview ? &_preview : isAll ? &_all : &_others;
    return Keep(number, schedule.Pixels(list), kept);
}

const Buffer& PixelLists::All(const SampleSchedule& schedule) {
    return Keep(schedule.NumberOfAll(), schedule.AllPixels(), &_all);
}

const Buffer& PixelLists::Keep(std::uint64_t number, const std::vector<std::uint32_t>& pixels,
                               Kept* kept) {
    if (kept->number != number) {
        *kept = {}; // frees first
        kept->buffer = UploadVector(_device, "pixels", pixels);
        kept->number = number;
    }
    return kept->buffer;
}

} // namespace hds
