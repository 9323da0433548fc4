// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/lightShaping.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadians = kPi / 180.0;

bool IsFlat(LightType type) {
    return type == LightType::Rect || type == LightType::Disk;
}

/// A frame in world space: the axis, which is -Z (of flat lights the normal of the side that
/// emits), then what is left of X, and Y.
glm::dmat3 FrameOf(const LightDescription& light, const glm::dmat4& worldFromLight) {
    const glm::dmat3 m(worldFromLight);
    glm::dvec3 axis = -m[2];
    if (IsFlat(light.type)) {
        const glm::dvec3 normal = glm::cross(m[0], m[1]);
        axis = glm::dot(normal, m[2]) < 0.0 ? normal : -normal;
    }
    axis = glm::normalize(axis);
    const glm::dvec3 side = glm::normalize(m[0] - glm::dot(m[0], axis) * axis);
    const glm::dvec3 up = glm::cross(side, axis);
    return {axis, side, glm::dot(up, m[1]) < 0.0 ? -up : up};
}

void Write(const glm::dvec3& v, float* out) {
    for (int i = 0; i < 3; ++i) {
        out[i] = float(v[i]);
    }
}

/// Degrees, finite.
double ConeAngleOf(const LightShaping& shaping) {
    return std::clamp(shaping.coneAngle, 0.0F, std::numeric_limits<float>::max());
}

/// The part of a cone over which it dims. No number: none.
double SoftnessOf(const LightShaping& shaping) {
    return shaping.coneSoftness > 0.0F ? std::min(double(shaping.coneSoftness), 1.0) : 0.0;
}

/// What the luminance of focus reaches at most: at the axis it is white.
double FocusPeak(const LightShaping& shaping) {
    const auto& tint = shaping.focusTint;
    const double luminance = 0.2126 * LightFactor(tint[0]) + 0.7152 * LightFactor(tint[1]) +
                             0.0722 * LightFactor(tint[2]);
    return shaping.focus > 0.0F ? std::max(1.0, luminance) : 1.0;
}

void AppendProfile(const IesProfile& profile, bool isNormalized, shared::HdsLightShaping* record,
                   std::vector<float>* data) {
    const double mean = isNormalized ? profile.MeanIntensity() : 1.0;
    record->profileBase = std::uint32_t(data->size());
    record->numPolar = std::uint32_t(profile.polars.size());
    record->numAzimuths = std::uint32_t(profile.azimuths.size());
    data->insert(data->end(), profile.polars.begin(), profile.polars.end());
    data->insert(data->end(), profile.azimuths.begin(), profile.azimuths.end());
    record->profilePeak = 0.0F;
    for (const float candela : profile.candela) {
        data->push_back(mean > 0.0 ? float(candela / mean) : 0.0F);
        record->profilePeak = std::max(record->profilePeak, data->back());
    }
}

} // namespace

bool IsUnshaped(const LightDescription& light) {
    const LightShaping& shaping = light.shaping;
    // A flat light shines within 90 degrees of its axis anyway.
    const double whole = IsFlat(light.type) ? 90.0 : 180.0;
    return light.type == LightType::Dome ||
           (!(shaping.focus > 0.0F) && shaping.iesFile.authoredPath.empty() &&
            (1.0 - SoftnessOf(shaping)) * ConeAngleOf(shaping) >= whole);
}

shared::HdsLightShaping AppendShaping(const LightDescription& light,
                                      const glm::dmat4& worldFromLight, const IesProfile* profile,
                                      std::vector<float>* data) {
    const LightShaping& shaping = light.shaping;
    shared::HdsLightShaping record{};
    const glm::dmat3 frame = FrameOf(light, worldFromLight);
    Write(frame[0], record.axis);
    Write(frame[1], record.side);
    Write(frame[2], record.up);
    const double cutoff = ConeAngleOf(shaping) * kRadians;
    record.cutoff = float(cutoff);
    record.smoothStart = float(cutoff * (1.0 - SoftnessOf(shaping)));
    record.focus = LightFactor(shaping.focus);
    std::transform(shaping.focusTint.begin(), shaping.focusTint.end(), record.focusTint,
                   LightFactor);
    record.angleScale = std::isfinite(shaping.iesAngleScale) ? shaping.iesAngleScale : 0.0F;
    record.profileBase = HDS_NONE;
    record.profilePeak = 1.0F;
    if (profile != nullptr) {
        AppendProfile(*profile, shaping.iesNormalize, &record, data);
    }
    record.peak = float(record.profilePeak * FocusPeak(shaping));
    const std::size_t at = data->size();
    data->resize(at + sizeof(record) / sizeof(float));
    std::memcpy(data->data() + at, &record, sizeof(record));
    return record;
}

} // namespace hds
