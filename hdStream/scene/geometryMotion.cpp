// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryMotion.h"

#include "hdStream/geometry/meshContent.h"
#include "kernels/shared/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hds {

namespace {

/// How far a value may be from where it should be, as a part of the way of the one that goes
/// furthest.
constexpr float kTolerance = 1.0F / 256.0F;

/// Values over time, linear between samples; before the first and after the last one they hold.
class ValueCurve {
public:
    /// \param samples of `size` values each, or it does not change.
    ValueCurve(const std::vector<PointSample>& samples, std::size_t size) {
        for (const PointSample& sample : samples) {
            Add(sample.time, sample.points);
        }
        Check(size);
    }
    ValueCurve(const std::vector<FloatSample>& samples, std::size_t size) {
        for (const FloatSample& sample : samples) {
            Add(sample.time, sample.values);
        }
        Check(size);
    }

    bool IsEmpty() const { return _samples.empty(); }

    SharedSpan<float> At(double time) const {
        const auto after =
            std::find_if(_samples.begin(), _samples.end(),
                         [time](const Sample& sample) { return sample.time >= time; });
        if (after == _samples.end()) {
            return _samples.back().values;
        }
        if (after == _samples.begin() || after->time == time) {
            return after->values;
        }
        const Sample& before = *std::prev(after);
        const auto part = static_cast<float>((time - before.time) / (after->time - before.time));
        std::vector<float> values(before.values.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = before.values[i] + part * (after->values[i] - before.values[i]);
        }
        return values;
    }

    /// Times of samples inside of the shutter's interval, which is 0 to 1.
    std::vector<double> TimesWithin(const Shutter& shutter) const {
        std::vector<double> times;
        for (const Sample& sample : _samples) {
            if (sample.time > shutter.open && sample.time < shutter.close) {
                times.push_back((sample.time - shutter.open) / (shutter.close - shutter.open));
            }
        }
        return times;
    }

private:
    struct Sample {
        double time;
        SharedSpan<float> values;
    };

    /// Times that are no number, or do not ascend, say nothing.
    void Add(double time, const SharedSpan<float>& values) {
        if (std::isfinite(time) && (_samples.empty() || time > _samples.back().time)) {
            _samples.push_back({time, values});
        }
    }

    void Check(std::size_t size) {
        const bool fit =
            std::all_of(_samples.begin(), _samples.end(),
                        [size](const Sample& sample) { return sample.values.size() == size; });
        if (!fit || _samples.size() < 2) {
            _samples.clear();
        }
    }

    std::vector<Sample> _samples; ///< empty: it does not change
};

bool AreSame(const SharedSpan<float>& a, const SharedSpan<float>& b) {
    return a.data() == b.data() || std::equal(a.begin(), a.end(), b.begin(), b.end());
}

/// Whether it changes while the shutter is open.
bool Changes(const ValueCurve& curve, const Shutter& shutter) {
    if (curve.IsEmpty()) {
        return false;
    }
    const SharedSpan<float> open = curve.At(shutter.open);
    std::vector<double> times = curve.TimesWithin(shutter);
    times.push_back(1.0);
    return std::any_of(times.begin(), times.end(), [&](double time) {
        return !AreSame(open, curve.At(shutter.open + time * (shutter.close - shutter.open)));
    });
}

/// The values at the ends of so many equal steps.
std::vector<SharedSpan<float>> ValuesAt(const ValueCurve& curve, const Shutter& shutter,
                                        std::size_t numSegments) {
    std::vector<SharedSpan<float>> values;
    for (std::size_t i = 0; i < numSegments; ++i) {
        const double part = static_cast<double>(i) / static_cast<double>(numSegments);
        values.push_back(curve.At(shutter.open + part * (shutter.close - shutter.open)));
    }
    values.push_back(curve.At(shutter.close));
    return values;
}

/// Whether keys are where the samples are. Both are linear in between, so it is enough to look at
/// the samples.
bool AreClose(const ValueCurve& curve, const Shutter& shutter, std::size_t numSegments) {
    const std::vector<double> times = curve.TimesWithin(shutter);
    const bool areAtKeys = std::all_of(times.begin(), times.end(), [&](double time) {
        const double scaled = time * static_cast<double>(numSegments);
        return std::fabs(scaled - std::round(scaled)) < 1e-5;
    });
    if (areAtKeys) {
        return true;
    }
    const std::vector<SharedSpan<float>> keys = ValuesAt(curve, shutter, numSegments);
    float way = 0.0F;
    float error = 0.0F;
    for (const double time : times) {
        const SharedSpan<float> exact =
            curve.At(shutter.open + time * (shutter.close - shutter.open));
        const double scaled = time * static_cast<double>(numSegments);
        const auto segment = static_cast<std::size_t>(scaled);
        const auto part = static_cast<float>(scaled - static_cast<double>(segment));
        const SharedSpan<float>& from = keys[segment];
        const SharedSpan<float>& to = keys[segment + 1];
        for (std::size_t i = 0; i < exact.size(); ++i) {
            way = std::max(
                {way, std::fabs(exact[i] - keys[0][i]), std::fabs(keys.back()[i] - keys[0][i])});
            error = std::max(error, std::fabs(from[i] + part * (to[i] - from[i]) - exact[i]));
        }
    }
    return error <= kTolerance * way;
}

std::size_t NumValues(const GeometryDescription& geometry, const char* name) {
    const auto found =
        std::find_if(geometry.primvars.begin(), geometry.primvars.end(),
                     [name](const Primvar& primvar) { return primvar.name == name; });
    return found == geometry.primvars.end() ? 0 : found->values.size();
}

void SetPrimvar(const char* name, const SharedSpan<float>& values, GeometryDescription* geometry) {
    for (Primvar& primvar : geometry->primvars) {
        if (primvar.name == name) {
            primvar.values = values;
        }
    }
}

/// Everything of geometry that may change.
struct Curves {
    ValueCurve points;
    ValueCurve widths;
    ValueCurve normals;

    explicit Curves(const GeometryDescription& geometry)
        : points(geometry.samples, geometry.points.size()),
          widths(geometry.widthSamples, NumValues(geometry, "widths")),
          normals(geometry.normalSamples, NumValues(geometry, "normals")) {}

    std::vector<const ValueCurve*> ThatChange(const Shutter& shutter) const {
        std::vector<const ValueCurve*> curves;
        for (const ValueCurve* curve : {&points, &widths, &normals}) {
            if (Changes(*curve, shutter)) {
                curves.push_back(curve);
            }
        }
        return curves;
    }
};

std::size_t ChooseSegments(const std::vector<const ValueCurve*>& curves, const Shutter& shutter) {
    std::size_t numSegments = 1;
    while (numSegments < HDS_MAX_DEFORMATION_SEGMENTS &&
           !std::all_of(curves.begin(), curves.end(), [&](const ValueCurve* curve) {
               return AreClose(*curve, shutter, numSegments);
           })) {
        ++numSegments;
    }
    return numSegments;
}

/// What cannot be drawn at one key is not drawn at all.
void DropBadPoints(GeometryDescription* geometry) {
    const auto isBad = [](float value) { return !(std::fabs(value) <= kMaxCoordinate); };
    std::vector<bool> bad;
    const auto mark = [&](const SharedSpan<float>& points) {
        if (std::any_of(points.begin(), points.end(), isBad)) {
            bad.resize(points.size());
            for (std::size_t i = 0; i < points.size(); ++i) {
                bad[i] = bad[i] || isBad(points[i]);
            }
        }
    };
    mark(geometry->points);
    for (const ShutterKey& key : geometry->keys) {
        mark(key.points);
    }
    if (bad.empty()) {
        return;
    }
    const auto drop = [&](SharedSpan<float>* points) {
        std::vector<float> values(points->begin(), points->end());
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = bad[i] ? std::numeric_limits<float>::quiet_NaN() : values[i];
        }
        *points = std::move(values);
    };
    drop(&geometry->points);
    for (ShutterKey& key : geometry->keys) {
        drop(&key.points);
    }
}

} // namespace

bool Deforms(const GeometryDescription& geometry, const Shutter& shutter) {
    return shutter.IsOpen() && !Curves(geometry).ThatChange(shutter).empty();
}

std::shared_ptr<const GeometryDescription> AtShutter(const GeometryDescription& geometry,
                                                     const Shutter& shutter) {
    const Curves curves(geometry);
    const std::vector<const ValueCurve*> changing = curves.ThatChange(shutter);
    const std::size_t numSegments = ChooseSegments(changing, shutter);
    auto result = std::make_shared<GeometryDescription>(geometry);
    result->samples.clear();
    result->widthSamples.clear();
    result->normalSamples.clear();
    result->keys.assign(numSegments, {});
    for (ShutterKey& key : result->keys) {
        key.points = geometry.points;
    }
    for (const ValueCurve* curve : changing) {
        const std::vector<SharedSpan<float>> values = ValuesAt(*curve, shutter, numSegments);
        const auto setLater = [&](SharedSpan<float> ShutterKey::*member) {
            for (std::size_t i = 0; i < numSegments; ++i) {
                result->keys[i].*member = values[i + 1];
            }
        };
        if (curve == &curves.points) {
            result->points = values[0];
            setLater(&ShutterKey::points);
            continue;
        }
        const bool isWidths = curve == &curves.widths;
        SetPrimvar(isWidths ? "widths" : "normals", values[0], result.get());
        setLater(isWidths ? &ShutterKey::widths : &ShutterKey::normals);
    }
    DropBadPoints(result.get());
    return result;
}

} // namespace hds
