// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryMotion.h"

#include "hdStream/geometry/meshContent.h"
#include "hdStream/geometry/splatSource.h"
#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// How far a value may be from where it should be, as a part of the way of the one that goes
/// furthest.
constexpr float kTolerance = 1.0F / 256.0F;

/// How values go from one to another.
enum class Way {
    Straight,
    Turn, ///< quaternions, on the shorter arc; where keys have them straight, and of unit length
};

/// Quaternions straight between keys stay within 0.016 a^3 of an arc of a radians, which is half of
/// what they turn by: within the tolerance to here.
constexpr double kMostArc = 0.49;

SharedSpan<float> StraightBetween(const SharedSpan<float>& from, const SharedSpan<float>& to,
                                  float part) {
    std::vector<float> values(from.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = from[i] + part * (to[i] - from[i]);
    }
    return values;
}

/// Calls `function` with each quaternion.
template <typename Function>
void ForEachTurn(std::size_t numValues, const Function& function) {
    for (std::size_t i = 0; i + 4 <= numValues; i += 4) {
        function(i);
    }
}

glm::dvec4 TurnAt(const SharedSpan<float>& turns, std::size_t i) {
    return {turns[i], turns[i + 1], turns[i + 2], turns[i + 3]};
}

/// What has no length stays.
SharedSpan<float> UnitTurns(const SharedSpan<float>& turns) {
    std::vector<float> values(turns.begin(), turns.end());
    ForEachTurn(values.size(), [&](std::size_t i) {
        const glm::dvec4 turn = TurnAt(turns, i);
        const double length = glm::length(turn);
        for (int k = 0; length > 0.0 && k < 4; ++k) {
            values[i + k] = static_cast<float>(turn[k] / length);
        }
    });
    return values;
}

/// Those of opposite sign that are on the side of the ones before.
SharedSpan<float> TurnsBeside(const SharedSpan<float>& turns, const SharedSpan<float>& before) {
    std::vector<float> values(turns.begin(), turns.end());
    ForEachTurn(values.size(), [&](std::size_t i) {
        const bool isBehind = glm::dot(TurnAt(turns, i), TurnAt(before, i)) < 0.0;
        for (int k = 0; isBehind && k < 4; ++k) {
            values[i + k] = -values[i + k];
        }
    });
    return values;
}

/// Between time samples on one side, as OpenUSD has it (GfSlerp): whatever their lengths are.
SharedSpan<float> TurnsBetween(const SharedSpan<float>& from, const SharedSpan<float>& to,
                               float part) {
    constexpr double kNear = 1e-5; // they are taken for equal
    std::vector<float> values(from.size());
    ForEachTurn(values.size(), [&](std::size_t i) {
        const glm::dvec4 begin = TurnAt(from, i);
        const glm::dvec4 end = TurnAt(to, i);
        const double cosine = glm::dot(begin, end);
        double ofBegin = 1.0 - part;
        double ofEnd = part;
        if (1.0 - cosine > kNear) {
            const double arc = std::acos(cosine);
            ofBegin = std::sin((1.0 - part) * arc) / std::sin(arc);
            ofEnd = std::sin(part * arc) / std::sin(arc);
        }
        for (int k = 0; k < 4; ++k) {
            values[i + k] = static_cast<float>(ofBegin * begin[k] + ofEnd * end[k]);
        }
    });
    return values;
}

/// The half of what the one turns by that turns most.
double LongestArc(const SharedSpan<float>& from, const SharedSpan<float>& to) {
    double longest = 0.0;
    ForEachTurn(from.size(), [&](std::size_t i) {
        const glm::dvec4 begin = TurnAt(from, i);
        const glm::dvec4 end = TurnAt(to, i);
        const double cosine = glm::dot(begin, end) / (glm::length(begin) * glm::length(end));
        longest = cosine < 1.0 ? std::max(longest, std::acos(cosine)) : longest;
    });
    return longest;
}

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
    ValueCurve(const std::vector<FloatSample>& samples, std::size_t size, Way way = Way::Straight)
        : _way(way) {
        for (const FloatSample& sample : samples) {
            Add(sample.time, sample.values);
        }
        Check(way == Way::Straight || size % 4 == 0 ? size : 0);
        for (std::size_t i = 1; way == Way::Turn && i < _samples.size(); ++i) {
            _samples[i].values = TurnsBeside(_samples[i].values, _samples[i - 1].values);
        }
    }

    bool IsEmpty() const { return _samples.empty(); }

    SharedSpan<float> At(double time) const {
        const SharedSpan<float> values = Between(time);
        return _way == Way::Turn ? UnitTurns(values) : values;
    }
    /// As kernels have it between keys.
    SharedSpan<float> BetweenKeys(const SharedSpan<float>& from, const SharedSpan<float>& to,
                                  float part) const {
        const SharedSpan<float> values = StraightBetween(from, to, part);
        return _way == Way::Turn ? UnitTurns(values) : values;
    }

    /// The fewest equal steps in which nothing turns by too much.
    double LeastSegments(const Shutter& shutter) const {
        double least = 1.0;
        for (std::size_t i = 1; _way == Way::Turn && i < _samples.size(); ++i) {
            const Sample& from = _samples[i - 1];
            const Sample& to = _samples[i];
            if (to.time <= shutter.open || from.time >= shutter.close) {
                continue;
            }
            const double steps = (shutter.close - shutter.open) / (to.time - from.time);
            least = std::max(least, steps * LongestArc(from.values, to.values) / kMostArc);
        }
        return least;
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

    SharedSpan<float> Between(double time) const {
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
        return _way == Way::Turn ? TurnsBetween(before.values, after->values, part)
                                 : StraightBetween(before.values, after->values, part);
    }

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
        if (!fit || _samples.size() < 2 || size == 0) {
            _samples.clear();
        }
    }

    Way _way = Way::Straight;
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
        const SharedSpan<float> between = curve.BetweenKeys(keys[segment], keys[segment + 1], part);
        for (std::size_t i = 0; i < exact.size(); ++i) {
            way = std::max(
                {way, std::fabs(exact[i] - keys[0][i]), std::fabs(keys.back()[i] - keys[0][i])});
            error = std::max(error, std::fabs(between[i] - exact[i]));
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

/// Something of geometry that may change.
struct MovingValues {
    ValueCurve curve;
    SharedSpan<float> ShutterKey::*member;
    const char* primvar; ///< null: the points
};

std::vector<MovingValues> ThatChange(const GeometryDescription& geometry, const Shutter& shutter) {
    std::vector<MovingValues> changing;
    const auto add = [&](ValueCurve curve, SharedSpan<float> ShutterKey::*member,
                         const char* primvar) {
        if (Changes(curve, shutter)) {
            changing.push_back({std::move(curve), member, primvar});
        }
    };
    add({geometry.samples, geometry.points.size()}, &ShutterKey::points, nullptr);
    add({geometry.widthSamples, NumValues(geometry, "widths")}, &ShutterKey::widths, "widths");
    add({geometry.normalSamples, NumValues(geometry, "normals")}, &ShutterKey::normals, "normals");
    if (geometry.splatSamples.IsApart()) {
        const SplatSamples& shapes = *geometry.splatSamples;
        add({shapes.orientations, NumValues(geometry, kSplatOrientations), Way::Turn},
            &ShutterKey::orientations, kSplatOrientations);
        add({shapes.scales, NumValues(geometry, kSplatScales)}, &ShutterKey::scales, kSplatScales);
        add({shapes.opacities, NumValues(geometry, kSplatOpacities)}, &ShutterKey::opacities,
            kSplatOpacities);
    }
    return changing;
}

std::size_t ChooseSegments(const std::vector<MovingValues>& changing, const Shutter& shutter) {
    constexpr std::size_t kMost = HDS_MAX_DEFORMATION_SEGMENTS;
    std::size_t numSegments = 1;
    for (const MovingValues& values : changing) {
        const double least = std::ceil(values.curve.LeastSegments(shutter));
        numSegments = std::max(numSegments, static_cast<std::size_t>(std::min(least, 1.0 * kMost)));
    }
    while (numSegments < kMost &&
           !std::all_of(changing.begin(), changing.end(), [&](const MovingValues& values) {
               return AreClose(values.curve, shutter, numSegments);
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
    return shutter.IsOpen() && !ThatChange(geometry, shutter).empty();
}

std::shared_ptr<const GeometryDescription> AtShutter(const GeometryDescription& geometry,
                                                     const Shutter& shutter) {
    const std::vector<MovingValues> changing = ThatChange(geometry, shutter);
    const std::size_t numSegments = ChooseSegments(changing, shutter);
    auto result = std::make_shared<GeometryDescription>(geometry);
    result->samples.clear();
    result->widthSamples.clear();
    result->normalSamples.clear();
    result->splatSamples = {};
    result->keys.assign(numSegments, {});
    for (ShutterKey& key : result->keys) {
        key.points = geometry.points;
    }
    for (const MovingValues& one : changing) {
        const std::vector<SharedSpan<float>> values = ValuesAt(one.curve, shutter, numSegments);
        if (one.primvar == nullptr) {
            result->points = values[0];
        } else {
            SetPrimvar(one.primvar, values[0], result.get());
        }
        for (std::size_t i = 0; i < numSegments; ++i) {
            result->keys[i].*one.member = values[i + 1];
        }
    }
    DropBadPoints(result.get());
    return result;
}

} // namespace hds
