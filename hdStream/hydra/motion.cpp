// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/motion.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/floatValues.h"
#include "hdStream/hydra/sceneIndexPlugins.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/imaging/hd/timeSampleArray.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/xformSchema.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Samples that need no memory of their own.
constexpr unsigned int kUsualSamples = 4;
/// What accelerations or angular velocities move is sampled at so many equal steps.
constexpr int kNumSteps = 16;
/// Most samples of points that a computation makes.
constexpr std::size_t kMostComputed = 32;

/// Where transforms may be asked for at any time they are, at so many equal steps: they may turn by
/// half a circle in each.
constexpr int kNumTransformSteps = 8;

using MatrixSamples = HdTimeSampleArray<GfMatrix4d, kUsualSamples>;

double TimeCodesPerSecond(HdSceneDelegate* delegate) {
    return HdStreamTimeCodesPerSecond(delegate->GetRenderIndex().GetTerminalSceneIndex());
}

/// motion:blurScale of a prim: at a time of the shutter it is as at so many times that. Delegates
/// tell of it where it is authored.
double BlurScaleOf(HdSceneDelegate* delegate, const SdfPath& id) {
    const float scale = delegate->Get(id, HdTokens->blurScale).GetWithDefault(1.0F);
    return std::isfinite(scale) && scale >= 0.0F ? static_cast<double>(scale) : 1.0;
}

/// The shutter's interval for one prim, and its samples as the core takes them.
struct PrimShutter {
    double scale = 1.0;
    hds::Shutter interval; ///< to be sampled

    PrimShutter(HdSceneDelegate* delegate, const SdfPath& id, const hds::Shutter& shutter)
        : scale(shutter.IsOpen() ? BlurScaleOf(delegate, id) : 1.0), interval{scale * shutter.open,
                                                                              scale *
                                                                                  shutter.close} {}

    template <typename Sample>
    std::vector<Sample> Told(std::vector<Sample> samples) const {
        for (Sample& sample : samples) {
            sample.time /= scale;
        }
        return samples;
    }
};

/// Commit cuts out what lies in the interval.
std::vector<hds::TransformSample> SamplesFrom(const MatrixSamples& matrices) {
    std::vector<hds::TransformSample> samples;
    bool moves = false;
    for (std::size_t i = 0; i < matrices.count; ++i) {
        moves = moves || matrices.values[i] != matrices.values[0];
        samples.push_back(
            {static_cast<double>(matrices.times[i]), HdStreamToGlm(matrices.values[i])});
    }
    return moves ? samples : std::vector<hds::TransformSample>();
}

/// A transform at equal steps of the interval, as `hdstream record` has it, where a scene index
/// tells of a change. Nothing where prims come from scene delegates, which tell their samples
/// alone.
std::optional<std::vector<hds::TransformSample>>
SampleSource(HdSceneDelegate* delegate, const SdfPath& id, const hds::Shutter& interval) {
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    if (!scene || HdStreamFindLegacyDelegate(delegate, id)) {
        return std::nullopt;
    }
    const HdXformSchema schema = HdXformSchema::GetFromParent(scene->GetPrim(id).dataSource);
    const HdMatrixDataSourceHandle source = schema ? schema.GetMatrix() : nullptr;
    std::vector<HdSampledDataSource::Time> times;
    if (!source ||
        !source->GetContributingSampleTimesForInterval(
            static_cast<float>(interval.open), static_cast<float>(interval.close), &times)) {
        return std::nullopt;
    }
    MatrixSamples matrices;
    matrices.Resize(kNumTransformSteps + 1);
    std::vector<double> exact;
    for (int i = 0; i <= kNumTransformSteps; ++i) {
        const double time =
            interval.open + double(i) / kNumTransformSteps * (interval.close - interval.open);
        exact.push_back(time);
        matrices.times[std::size_t(i)] = static_cast<float>(time);
        matrices.values[std::size_t(i)] = source->GetTypedValue(static_cast<float>(time));
    }
    std::vector<hds::TransformSample> samples = SamplesFrom(matrices);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i].time = exact[i];
    }
    return samples;
}

/// At what times the samples say something of the shutter's interval.
void FindTimes(const hds::Shutter& shutter, HdStreamMovingValue* value) {
    const HdTimeSampleArray<VtValue, kUsualSamples>& samples = value->samples;
    if (samples.count < 2) {
        return;
    }
    for (std::size_t i = 1; i < samples.count; ++i) {
        if (samples.values[i].GetArraySize() != samples.values[0].GetArraySize()) {
            value->fits = false; // nothing to interpolate between
            return;
        }
    }
    std::vector<double> times{shutter.open};
    for (std::size_t i = 0; i < samples.count; ++i) {
        const auto time = static_cast<double>(samples.times[i]);
        if (time > times.back() && time < shutter.close &&
            samples.times[i] < static_cast<float>(shutter.close)) {
            times.push_back(time);
        }
    }
    times.push_back(shutter.close);
    const VtValue open = value->At(shutter.open);
    if (std::any_of(times.begin() + 1, times.end(),
                    [&](double time) { return value->At(time) != open; })) {
        value->times = std::move(times);
    }
}

/// The shutter's ends and, of what goes along a curve, equal steps between them.
std::vector<double> StepsOver(const hds::Shutter& shutter, bool isCurved) {
    std::vector<double> times{shutter.open};
    for (int i = 1; isCurved && i < kNumSteps; ++i) {
        times.push_back(i * ((shutter.close - shutter.open) / kNumSteps) + shutter.open);
    }
    times.push_back(shutter.close);
    return times;
}

/// Samples as rows of floats.
template <typename Sample>
std::vector<Sample> RowsOf(const HdStreamMovingValue& value, std::uint32_t numComponents) {
    std::vector<Sample> samples;
    for (const double time : value.times) {
        const std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(value.At(time));
        if (!rows || rows->numComponents != numComponents) {
            return {};
        }
        samples.push_back({time, rows->values});
    }
    return samples;
}

bool IsFinite(const GfVec3f& at) {
    return std::isfinite(at[0]) && std::isfinite(at[1]) && std::isfinite(at[2]);
}

} // namespace

std::vector<hds::TransformSample>
HdStreamSampleTransform(HdSceneDelegate* delegate, const SdfPath& id, const hds::Shutter& shutter) {
    const PrimShutter own(delegate, id, shutter);
    if (!own.interval.IsOpen()) {
        return {};
    }
    if (auto samples = SampleSource(delegate, id, own.interval)) {
        return own.Told(std::move(*samples));
    }
    MatrixSamples matrices;
    delegate->SampleTransform(id, static_cast<float>(own.interval.open),
                              static_cast<float>(own.interval.close), &matrices);
    return own.Told(SamplesFrom(matrices));
}

std::vector<hds::TransformSample> HdStreamSampleInstancerTransform(HdSceneDelegate* delegate,
                                                                   const SdfPath& id,
                                                                   const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    if (auto samples = SampleSource(delegate, id, shutter)) {
        return std::move(*samples);
    }
    MatrixSamples matrices;
    delegate->SampleInstancerTransform(id, static_cast<float>(shutter.open),
                                       static_cast<float>(shutter.close), &matrices);
    return SamplesFrom(matrices);
}

HdStreamMovingValue HdStreamSamplePrimvar(HdSceneDelegate* delegate, const SdfPath& id,
                                          const TfToken& name, const hds::Shutter& shutter) {
    HdStreamMovingValue value;
    if (shutter.IsOpen()) {
        delegate->SamplePrimvar(id, name, static_cast<float>(shutter.open),
                                static_cast<float>(shutter.close), &value.samples);
        FindTimes(shutter, &value);
    }
    return value;
}

// The arithmetic of both is UsdGeom's, so that both front ends give the same bits.
HdStreamMovingValue HdStreamMoveByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                             const VtValue& points, const hds::Shutter& shutter,
                                             bool* isFinite) {
    const VtValue velocities = delegate->Get(id, HdTokens->velocities);
    if (!shutter.IsOpen() || !points.IsHolding<VtVec3fArray>() ||
        !velocities.IsHolding<VtVec3fArray>()) {
        return {};
    }
    const auto& from = points.UncheckedGet<VtVec3fArray>();
    const auto& perSecond = velocities.UncheckedGet<VtVec3fArray>();
    if (from.size() != perSecond.size()) {
        return {};
    }
    const auto changes = delegate->Get(id, HdTokens->accelerations).GetWithDefault(VtVec3fArray());
    const double timeCodesPerSecond = TimeCodesPerSecond(delegate);
    HdStreamMovingValue value;
    for (const double time : StepsOver(shutter, changes.size() == from.size())) {
        const double seconds = time / timeCodesPerSecond;
        VtVec3fArray moved = from;
        for (std::size_t i = 0; i < moved.size(); ++i) {
            GfVec3f velocity = perSecond[i];
            if (changes.size() == from.size()) {
                velocity += seconds * changes[i] * 0.5;
            }
            const GfVec3f at = moved[i] + seconds * velocity;
            if (IsFinite(at) || !IsFinite(from[i])) {
                moved[i] = at;
            } else {
                *isFinite = false;
            }
        }
        const std::size_t last = value.samples.count;
        value.samples.Resize(static_cast<unsigned int>(last + 1));
        value.samples.times[last] = static_cast<float>(time);
        value.samples.values[last] = VtValue(std::move(moved));
    }
    FindTimes(shutter, &value);
    return value;
}

VtArray<GfRotation> HdStreamTurn::At(double time) const {
    const double seconds = time / timeCodesPerSecond;
    VtArray<GfRotation> turns;
    for (const GfVec3f& velocity : degreesPerSecond) {
        turns.push_back(GfRotation(velocity, seconds * velocity.GetLength()));
    }
    return turns;
}

HdStreamTurn HdStreamTurnByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                      std::size_t count, const hds::Shutter& shutter) {
    auto degreesPerSecond =
        delegate->Get(id, HdTokens->angularVelocities).GetWithDefault(VtVec3fArray());
    const bool turn = std::any_of(degreesPerSecond.cbegin(), degreesPerSecond.cend(),
                                  [](const GfVec3f& velocity) { return velocity != GfVec3f(0); });
    if (!shutter.IsOpen() || !turn || degreesPerSecond.size() != count) {
        return {};
    }
    return {StepsOver(shutter, true), std::move(degreesPerSecond), TimeCodesPerSecond(delegate)};
}

std::vector<hds::PointSample> HdStreamSamplePoints(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const TfToken& name, const hds::Shutter& shutter,
                                                   bool* fit, bool* isFinite) {
    *fit = true;
    *isFinite = true;
    const PrimShutter own(delegate, id, shutter);
    const hds::Shutter& interval = own.interval;
    if (!interval.IsOpen()) {
        return {};
    }
    HdExtComputationPrimvarDescriptorVector computed;
    for (const HdExtComputationPrimvarDescriptor& descriptor :
         delegate->GetExtComputationPrimvarDescriptors(id, HdInterpolationVertex)) {
        if (descriptor.name == name) {
            computed.push_back(descriptor);
        }
    }
    HdStreamMovingValue points;
    if (computed.empty()) {
        points = HdStreamSamplePrimvar(delegate, id, name, interval);
        *fit = points.fits;
        if (!points.Moves()) {
            points =
                HdStreamMoveByVelocities(delegate, id, delegate->Get(id, name), interval, isFinite);
            *fit = *fit || points.Moves();
        }
    } else {
        HdExtComputationUtils::SampledValueStore<kUsualSamples> values;
        HdExtComputationUtils::SampleComputedPrimvarValues(
            computed, delegate, static_cast<float>(interval.open),
            static_cast<float>(interval.close), kMostComputed, &values);
        points.samples = values[name];
        FindTimes(interval, &points);
    }
    return own.Told(RowsOf<hds::PointSample>(points, 3));
}

std::vector<hds::FloatSample> HdStreamSampleWidths(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const hds::Shutter& shutter) {
    const PrimShutter own(delegate, id, shutter);
    return own.Told(RowsOf<hds::FloatSample>(
        HdStreamSamplePrimvar(delegate, id, HdTokens->widths, own.interval), 1));
}

std::vector<hds::PointSample> HdStreamSampleNormals(HdSceneDelegate* delegate, const SdfPath& id,
                                                    const hds::Shutter& shutter) {
    const PrimShutter own(delegate, id, shutter);
    return own.Told(RowsOf<hds::PointSample>(
        HdStreamSamplePrimvar(delegate, id, HdTokens->normals, own.interval), 3));
}

hds::SplatSamples HdStreamSampleShapes(HdSceneDelegate* delegate, const SdfPath& id,
                                       const hds::GeometryDescription& splats,
                                       const hds::Shutter& shutter) {
    const PrimShutter own(delegate, id, shutter);
    const auto sample = [&](const char* name, std::uint32_t numComponents) {
        const bool isThere = std::any_of(splats.primvars.begin(), splats.primvars.end(),
                                         [&](const auto& one) { return one.name == name; });
        return isThere && own.interval.IsOpen()
                   ? own.Told(RowsOf<hds::FloatSample>(
                         HdStreamSamplePrimvar(delegate, id, TfToken(name), own.interval),
                         numComponents))
                   : std::vector<hds::FloatSample>();
    };
    return {sample(hds::kSplatOrientations, 4), sample(hds::kSplatScales, 3),
            sample(hds::kSplatOpacities, 1)};
}

bool HdStreamEqual(const std::vector<hds::FloatSample>& a, const std::vector<hds::FloatSample>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const hds::FloatSample& left, const hds::FloatSample& right) {
                          return left.time == right.time &&
                                 HdStreamEqual(left.values, right.values);
                      });
}

bool HdStreamEqual(const std::vector<hds::PointSample>& a, const std::vector<hds::PointSample>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const hds::PointSample& left, const hds::PointSample& right) {
                          return left.time == right.time &&
                                 HdStreamEqual(left.points, right.points);
                      });
}

bool HdStreamEqual(const std::vector<hds::TransformSample>& a,
                   const std::vector<hds::TransformSample>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const hds::TransformSample& left, const hds::TransformSample& right) {
                          return left.time == right.time && left.matrix == right.matrix;
                      });
}

PXR_NAMESPACE_CLOSE_SCOPE
