// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/motion.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/floatValues.h"
#include "hdStream/hydra/sceneIndexPlugins.h"

#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/timeSampleArray.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Samples that need no memory of their own.
constexpr unsigned int kUsualSamples = 4;

using MatrixSamples = HdTimeSampleArray<GfMatrix4d, kUsualSamples>;

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

/// Points at the interval's ends from their velocities at the frame: OpenUSD's scene index moves
/// points of one sample to the frame, but tells of no samples around it.
std::vector<VtValue> MovedByVelocities(const VtValue& points, const VtValue& velocities,
                                       const hds::Shutter& shutter) {
    if (!points.IsHolding<VtVec3fArray>() || !velocities.IsHolding<VtVec3fArray>()) {
        return {};
    }
    const auto& from = points.UncheckedGet<VtVec3fArray>();
    const auto& perSecond = velocities.UncheckedGet<VtVec3fArray>();
    if (from.size() != perSecond.size()) {
        return {};
    }
    std::vector<VtValue> ends;
    for (const double time : {shutter.open, shutter.close}) {
        const float seconds = static_cast<float>(time) / kHdStreamTimeCodesPerSecond;
        VtVec3fArray moved(from.size());
        for (std::size_t i = 0; i < moved.size(); ++i) {
            moved[i] = from[i] + seconds * perSecond[i];
        }
        ends.emplace_back(std::move(moved));
    }
    return ends;
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
            ends = MovedByVelocities(delegate->Get(id, HdTokens->points),
                                     delegate->Get(id, HdTokens->velocities), shutter);
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
