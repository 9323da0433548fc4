// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/cameraAttributes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <variant>

namespace hds {

namespace {

constexpr int kMaxBlades = 100;
constexpr float kLeastFieldOfView = 0.01F;
constexpr float kMostFieldOfView = 360.0F;
/// The tangent of a quarter of it is finite.
constexpr float kMostStereographic = 350.0F;
constexpr float kLeastRatio = 0.01F;
constexpr float kMostRatio = 100.0F;
/// Arnold's, where a fisheye does not say.
constexpr float kArnoldFieldOfView = 90.0F;

std::optional<float> NumberOf(const ParameterValue& value) {
    std::optional<float> number;
    if (const auto* real = std::get_if<double>(&value)) {
        number = static_cast<float>(*real);
    } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        number = static_cast<float>(*integer);
    }
    return number && std::isfinite(*number) ? number : std::nullopt;
}

/// What a setter is told.
struct Context {
    const std::string& name;
    const ParameterValue& value;
    CameraLens& lens;
    std::vector<std::string>& problems;

    void Complain(const std::string& text) const { problems.push_back(name + " " + text); }

    /// The value, moved into a range.
    std::optional<float> Number(float least, float most) const {
        const std::optional<float> number = NumberOf(value);
        if (!number) {
            Complain("is no number; ignored");
            return std::nullopt;
        }
        const float inRange = std::clamp(*number, least, most);
        if (inRange != *number) {
            Complain("is out of its range; the nearest value in it counts");
        }
        return inRange;
    }
    void Set(float CameraLens::*member, float least, float most) const {
        lens.*member = Number(least, most).value_or(lens.*member);
    }
};

void SetProjection(const Context& context) {
    const auto* text = std::get_if<std::string>(&context.value);
    const auto names = NamesOf(CameraProjection());
    const auto row = std::find_if(names.begin(), names.end(),
                                  [&](const auto& one) { return text && *text == one.text; });
    if (row != names.end()) {
        context.lens.projection = row->value;
        return;
    }
    std::string all;
    for (const auto& one : names) {
        all += (all.empty() ? "" : ", ") + std::string(one.text);
    }
    context.Complain("'" + (text ? *text : std::string()) + "' is none of " + all + "; ignored");
}

void SetArnoldCamera(const Context& context) {
    const auto* type = std::get_if<std::string>(&context.value);
    if (!type) {
        return; // lights have an attribute of this name that is a number
    }
    if (*type == "fisheye_camera") {
        context.lens.projection = CameraProjection::FisheyeEquidistant;
        context.lens.fieldOfView = kArnoldFieldOfView;
    } else if (*type == "spherical_camera") {
        context.lens.projection = CameraProjection::Latlong;
    } else if (*type != "persp_camera" && *type != "ortho_camera") {
        context.Complain("'" + *type + "' is not supported; UsdGeomCamera's projection counts");
    }
}

void SetFieldOfView(const Context& context) {
    context.Set(&CameraLens::fieldOfView, kLeastFieldOfView, kMostFieldOfView);
}

/// An interval of degrees.
std::optional<std::array<float, 2>> Degrees(const Context& context, float most) {
    const auto* pair = std::get_if<std::vector<float>>(&context.value);
    const bool isUsable = pair && pair->size() == 2 && std::isfinite((*pair)[0]) &&
                          std::isfinite((*pair)[1]) && (*pair)[0] < (*pair)[1] &&
                          (*pair)[0] >= -most && (*pair)[1] <= most;
    if (!isUsable) {
        context.Complain("is no interval of degrees; ignored");
        return std::nullopt;
    }
    return std::array<float, 2>{(*pair)[0], (*pair)[1]};
}

void SetLongitudes(const Context& context) {
    context.lens.longitudes = Degrees(context, 360.0F).value_or(context.lens.longitudes);
}

void SetLatitudes(const Context& context) {
    context.lens.latitudes = Degrees(context, 90.0F).value_or(context.lens.latitudes);
}

void SetBlades(const Context& context) {
    const std::optional<float> blades = context.Number(0.0F, float(kMaxBlades));
    context.lens.apertureBlades =
        blades ? static_cast<std::int32_t>(*blades) : context.lens.apertureBlades;
}

void SetRotation(const Context& context) {
    context.Set(&CameraLens::apertureRotation, -1e6F, 1e6F);
}

void SetRoundness(const Context& context) {
    context.Set(&CameraLens::apertureRoundness, 0.0F, 1.0F);
}

void SetRatio(const Context& context) {
    context.Set(&CameraLens::apertureRatio, kLeastRatio, kMostRatio);
}

void SetVignetting(const Context& context) {
    context.Set(&CameraLens::vignetting, 0.0F, 1.0F);
}

void RefuseRatio(const Context& context) {
    if (NumberOf(context.value) != 1.0F) {
        context.Complain("is not read; hdstream:camera:apertureRatio is");
    }
}

struct Attribute {
    const char* name;
    void (*set)(const Context& context);
};

constexpr Attribute kAttributes[] = {
    {"ri:apertureNSides", SetBlades},
    {"ri:apertureAngle", SetRotation},
    {"ri:apertureRoundness", SetRoundness},
    {"ri:dofaspect", RefuseRatio},
    {"primvars:arnold:camera", SetArnoldCamera},
    {"primvars:arnold:fov", SetFieldOfView},
    {"primvars:arnold:aperture_blades", SetBlades},
    {"primvars:arnold:aperture_rotation", SetRotation},
    {"primvars:arnold:aperture_blade_curvature", SetRoundness},
    {"primvars:arnold:aperture_aspect_ratio", RefuseRatio},
    {"hdstream:camera:projection", SetProjection},
    {"hdstream:camera:fieldOfView", SetFieldOfView},
    {"hdstream:camera:longitudes", SetLongitudes},
    {"hdstream:camera:latitudes", SetLatitudes},
    {"hdstream:camera:apertureBlades", SetBlades},
    {"hdstream:camera:apertureRotation", SetRotation},
    {"hdstream:camera:apertureRoundness", SetRoundness},
    {"hdstream:camera:apertureRatio", SetRatio},
    {"hdstream:camera:vignetting", SetVignetting},
};

constexpr const char* kExposureTime = "exposure:time";
constexpr const char* kExposureIso = "exposure:iso";
constexpr const char* kExposureFStop = "exposure:fStop";
constexpr const char* kExposureResponsivity = "exposure:responsivity";

} // namespace

std::vector<std::string> CameraAttributeNames() {
    std::vector<std::string> names;
    std::transform(std::begin(kAttributes), std::end(kAttributes), std::back_inserter(names),
                   [](const Attribute& row) { return row.name; });
    return names;
}

std::vector<std::string> ExposureAttributeNames() {
    return {kExposureTime, kExposureIso, kExposureFStop, kExposureResponsivity};
}

std::vector<std::string> SetCameraAttributes(const CameraAttributes& attributes,
                                             CameraPrim* camera) {
    std::vector<std::string> problems;
    for (const Attribute& row : kAttributes) {
        const auto found = attributes.find(row.name);
        if (found != attributes.end()) {
            row.set({found->first, found->second, camera->lens, problems});
        }
    }
    CameraLens& lens = camera->lens;
    if (lens.projection == CameraProjection::FisheyeStereographic &&
        lens.fieldOfView > kMostStereographic) {
        lens.fieldOfView = kMostStereographic;
        problems.emplace_back("a stereographic fisheye sees 350 degrees at most");
    }
    return problems;
}

float LinearExposureScale(float exposure, const CameraAttributes& attributes) {
    const auto get = [&](const char* name, float fallback) {
        const auto found = attributes.find(name);
        return found == attributes.end() ? fallback : NumberOf(found->second).value_or(fallback);
    };
    const float fStop = get(kExposureFStop, 1.0F);
    return (get(kExposureTime, 1.0F) * get(kExposureIso, 100.0F) * std::pow(2.0F, exposure) *
            get(kExposureResponsivity, 1.0F)) /
           (100.0F * fStop * fStop);
}

} // namespace hds
