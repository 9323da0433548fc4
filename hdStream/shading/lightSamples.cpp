// SPDX-License-Identifier: Apache-2.0
// Lights between samples of their inputs.
#include "hdStream/shading/lightDescription.h"

#include <algorithm>
#include <iterator>
#include <type_traits>

namespace hds {

namespace {

/// Calls visit(member of a sample, member of a description) for each that changes.
template <typename Visit>
void ForEachInput(Visit visit) {
    using S = LightSample;
    using L = LightDescription;
    visit(&S::intensity, &L::intensity);
    visit(&S::exposure, &L::exposure);
    visit(&S::color, &L::color);
    visit(&S::colorTemperature, &L::colorTemperature);
    visit(&S::angle, &L::angle);
    visit(&S::radius, &L::radius);
    visit(&S::width, &L::width);
    visit(&S::height, &L::height);
    visit(&S::length, &L::length);
}

float Mix(float from, float to, float part) {
    return from + part * (to - from);
}

std::array<float, 3> Mix(const std::array<float, 3>& from, const std::array<float, 3>& to,
                         float part) {
    return {Mix(from[0], to[0], part), Mix(from[1], to[1], part), Mix(from[2], to[2], part)};
}

} // namespace

LightSample SampleOf(const LightDescription& light) {
    LightSample sample;
    ForEachInput([&](auto ofSample, auto ofLight) { sample.*ofSample = light.*ofLight; });
    return sample;
}

LightDescription LightAt(const LightDescription& light, const std::vector<LightSample>& samples,
                         double time) {
    const auto after =
        std::find_if(samples.begin(), samples.end(),
                     [time](const LightSample& sample) { return sample.time >= time; });
    const LightSample& to = after == samples.end() ? samples.back() : *after;
    const bool isBetween = after != samples.begin() && after != samples.end();
    const LightSample& from = isBetween ? *std::prev(after) : to;
    const auto part =
        isBetween ? static_cast<float>((time - from.time) / (to.time - from.time)) : 1.0F;
    LightDescription result = light;
    ForEachInput([&](auto ofSample, auto ofLight) {
        result.*ofLight = Mix(from.*ofSample, to.*ofSample, part);
    });
    return result;
}

} // namespace hds
