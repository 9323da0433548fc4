// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/picturePacing.h"

#include <algorithm>

namespace hds {

namespace {

/// Making pictures takes at most one part in so many of the time.
constexpr double kMaxShare = 10.0;

} // namespace

void PicturePacing::Made(double begin, double end, std::uint32_t stride) {
    // What the first one takes says nothing of those to come: drivers compile what they launch
    // first, and buffers are made.
    const bool isFirst = stride != _stride;
    _next = end + std::max(_interval, isFirst ? 0.0 : kMaxShare * (end - begin));
    _stride = stride;
}

} // namespace hds
