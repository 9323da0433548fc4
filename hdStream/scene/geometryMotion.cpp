// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryMotion.h"

#include "hdStream/geometry/meshContent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hds {

namespace {

bool HasUsableSamples(const GeometryDescription& geometry) {
    return geometry.samples.size() >= 2 &&
           std::all_of(geometry.samples.begin(), geometry.samples.end(),
                       [&](const PointSample& sample) {
                           return sample.points.size() == geometry.points.size();
                       });
}

/// Linear between the samples; before the first and after the last one they hold.
SharedSpan<float> PointsAt(const GeometryDescription& geometry, double time) {
    const auto after =
        std::find_if(geometry.samples.begin(), geometry.samples.end(),
                     [time](const PointSample& sample) { return sample.time >= time; });
    if (after == geometry.samples.end()) {
        return geometry.samples.back().points;
    }
    if (after == geometry.samples.begin() || after->time == time) {
        return after->points;
    }
    const PointSample& before = *std::prev(after);
    const auto part = static_cast<float>((time - before.time) / (after->time - before.time));
    std::vector<float> points(before.points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = before.points[i] + part * (after->points[i] - before.points[i]);
    }
    return points;
}

} // namespace

bool Deforms(const GeometryDescription& geometry, const Shutter& shutter) {
    if (!shutter.IsOpen() || !HasUsableSamples(geometry)) {
        return false;
    }
    const SharedSpan<float> open = PointsAt(geometry, shutter.open);
    const SharedSpan<float> close = PointsAt(geometry, shutter.close);
    return open.data() != close.data() && !std::equal(open.begin(), open.end(), close.begin());
}

std::shared_ptr<const GeometryDescription> AtShutter(const GeometryDescription& geometry,
                                                     const Shutter& shutter) {
    auto result = std::make_shared<GeometryDescription>(geometry);
    result->samples.clear();
    result->points = PointsAt(geometry, shutter.open);
    result->closePoints = PointsAt(geometry, shutter.close);
    // What cannot be drawn at one end is not drawn at all.
    const auto isBad = [](float value) { return !(std::fabs(value) <= kMaxCoordinate); };
    if (std::any_of(result->points.begin(), result->points.end(), isBad) ||
        std::any_of(result->closePoints.begin(), result->closePoints.end(), isBad)) {
        std::vector<float> open(result->points.begin(), result->points.end());
        std::vector<float> close(result->closePoints.begin(), result->closePoints.end());
        for (std::size_t i = 0; i < open.size(); ++i) {
            if (isBad(open[i]) || isBad(close[i])) {
                open[i] = close[i] = std::numeric_limits<float>::quiet_NaN();
            }
        }
        result->points = std::move(open);
        result->closePoints = std::move(close);
    }
    return result;
}

} // namespace hds
