// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/motion.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/floatValues.h"
#include "hdStream/hydra/sceneIndexPlugins.h"

#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/imaging/hd/timeSampleArray.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Samples that need no memory of their own.
constexpr unsigned int kUsualSamples = 4;

using MatrixSamples = HdTimeSampleArray<GfMatrix4d, kUsualSamples>;

double TimeCodesPerSecond(HdSceneDelegate* delegate) {
    return HdStreamTimeCodesPerSecond(delegate->GetRenderIndex().GetTerminalSceneIndex());
}

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

/// The value when the shutter opens and when it closes; empty when it does not change.
template <typename Samples>
std::vector<VtValue> EndsOf(const Samples& samples, const hds::Shutter& shutter) {
    if (samples.count < 2) {
        return {};
    }
    const std::size_t size = samples.values[0].GetArraySize();
    for (std::size_t i = 1; i < samples.count; ++i) {
        if (samples.values[i].GetArraySize() != size) {
            return {}; // nothing to interpolate between
        }
    }
    std::vector<VtValue> ends{samples.Resample(static_cast<float>(shutter.open)),
                              samples.Resample(static_cast<float>(shutter.close))};
    return ends[0] == ends[1] ? std::vector<VtValue>() : ends;
}

} // namespace

std::vector<hds::TransformSample>
HdStreamSampleTransform(HdSceneDelegate* delegate, const SdfPath& id, const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    MatrixSamples matrices;
    delegate->SampleTransform(id, static_cast<float>(shutter.open),
                              static_cast<float>(shutter.close), &matrices);
    return SamplesFrom(matrices);
}

std::vector<hds::TransformSample> HdStreamSampleInstancerTransform(HdSceneDelegate* delegate,
                                                                   const SdfPath& id,
                                                                   const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    MatrixSamples matrices;
    delegate->SampleInstancerTransform(id, static_cast<float>(shutter.open),
                                       static_cast<float>(shutter.close), &matrices);
    return SamplesFrom(matrices);
}

std::vector<VtValue> HdStreamSamplePrimvar(HdSceneDelegate* delegate, const SdfPath& id,
                                           const TfToken& name, const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    HdTimeSampleArray<VtValue, kUsualSamples> samples;
    delegate->SamplePrimvar(id, name, static_cast<float>(shutter.open),
                            static_cast<float>(shutter.close), &samples);
    return EndsOf(samples, shutter);
}

// The arithmetic of both is UsdGeom's, so that both front ends give the same bits.
std::vector<VtValue> HdStreamMoveByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                              const VtValue& points, const hds::Shutter& shutter) {
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
    std::vector<VtValue> ends;
    for (const double time : {shutter.open, shutter.close}) {
        const double seconds = time / timeCodesPerSecond;
        VtVec3fArray moved = from;
        for (std::size_t i = 0; i < moved.size(); ++i) {
            GfVec3f velocity = perSecond[i];
            if (changes.size() == from.size()) {
                velocity += seconds * changes[i] * 0.5;
            }
            moved[i] += seconds * velocity;
        }
        ends.emplace_back(std::move(moved));
    }
    return ends[0] == ends[1] ? std::vector<VtValue>() : ends;
}

std::vector<VtArray<GfRotation>> HdStreamTurnByVelocities(HdSceneDelegate* delegate,
                                                          const SdfPath& id, std::size_t count,
                                                          const hds::Shutter& shutter) {
    const auto degreesPerSecond =
        delegate->Get(id, HdTokens->angularVelocities).GetWithDefault(VtVec3fArray());
    const bool turn = std::any_of(degreesPerSecond.cbegin(), degreesPerSecond.cend(),
                                  [](const GfVec3f& velocity) { return velocity != GfVec3f(0); });
    if (!shutter.IsOpen() || !turn || degreesPerSecond.size() != count) {
        return {};
    }
    const double timeCodesPerSecond = TimeCodesPerSecond(delegate);
    std::vector<VtArray<GfRotation>> ends;
    for (const double time : {shutter.open, shutter.close}) {
        const double seconds = time / timeCodesPerSecond;
        VtArray<GfRotation> turns;
        for (const GfVec3f& velocity : degreesPerSecond) {
            turns.push_back(GfRotation(velocity, seconds * velocity.GetLength()));
        }
        ends.push_back(std::move(turns));
    }
    return ends;
}

std::vector<hds::PointSample> HdStreamSamplePoints(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    HdExtComputationPrimvarDescriptorVector computed;
    for (const HdExtComputationPrimvarDescriptor& descriptor :
         delegate->GetExtComputationPrimvarDescriptors(id, HdInterpolationVertex)) {
        if (descriptor.name == HdTokens->points) {
            computed.push_back(descriptor);
        }
    }
    std::vector<VtValue> ends;
    if (computed.empty()) {
        ends = HdStreamSamplePrimvar(delegate, id, HdTokens->points, shutter);
        if (ends.empty()) {
            ends = HdStreamMoveByVelocities(delegate, id, delegate->Get(id, HdTokens->points),
                                            shutter);
        }
    } else {
        HdExtComputationUtils::SampledValueStore<kUsualSamples> values;
        HdExtComputationUtils::SampleComputedPrimvarValues(
            computed, delegate, static_cast<float>(shutter.open), static_cast<float>(shutter.close),
            kUsualSamples, &values);
        ends = EndsOf(values[HdTokens->points], shutter);
    }
    std::vector<hds::PointSample> samples;
    for (const VtValue& value : ends) {
        const std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(value);
        if (!rows || rows->numComponents != 3) {
            return {};
        }
        samples.push_back({samples.empty() ? shutter.open : shutter.close, rows->values});
    }
    return samples;
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
