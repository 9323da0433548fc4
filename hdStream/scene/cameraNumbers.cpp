// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/cameraNumbers.h"

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

constexpr float kFarFocus = 1e18F; ///< its square is a float

bool IsAperture(float length) {
    return std::isfinite(length) && length > 0.0F;
}

/// \return whether the focal length was 0.
bool MendFocus(float* focalLength, float* fStop, float* focusDistance) {
    *focusDistance = std::min(*focusDistance, kFarFocus);
    if (*focalLength != 0.0F) {
        return false;
    }
    *focalLength = 1.0F;
    *fStop = 0.0F;
    return true;
}

} // namespace

std::vector<std::string> MendCamera(CameraPrim* camera) {
    std::vector<std::string> problems;
    const CameraPrim usual;
    if (!IsAperture(camera->horizontalAperture) || !IsAperture(camera->verticalAperture)) {
        problems.emplace_back("aperture is not above 0; 20.955 x 15.2908 is used");
        camera->horizontalAperture = usual.horizontalAperture;
        camera->verticalAperture = usual.verticalAperture;
    }
    const auto mend = [&](float CameraPrim::*member, const char* name, const char* fallback) {
        if (!std::isfinite(camera->*member)) {
            problems.push_back(std::string(name) + " is not finite; " + fallback + " is used");
            camera->*member = usual.*member;
        }
    };
    mend(&CameraPrim::horizontalApertureOffset, "horizontalApertureOffset", "0");
    mend(&CameraPrim::verticalApertureOffset, "verticalApertureOffset", "0");
    mend(&CameraPrim::focalLength, "focalLength", "50");
    mend(&CameraPrim::exposureScale, "the factor of its exposure", "1");
    mend(&CameraPrim::fStop, "fStop", "0");
    if (camera->fStop < 0.0F) {
        problems.emplace_back("fStop is below 0; everything is in focus");
        camera->fStop = 0.0F;
    }
    if (std::isnan(camera->focusDistance)) {
        problems.emplace_back("focusDistance is not a number; everything is in focus");
        camera->focusDistance = 0.0F;
    }
    if (std::isnan(camera->nearClip) || std::isnan(camera->farClip)) {
        problems.emplace_back("clippingRange is not a number; (1, 1000000) is used");
        camera->nearClip = usual.nearClip;
        camera->farClip = usual.farClip;
    } else if (camera->nearClip >= camera->farClip) {
        problems.emplace_back("clippingRange is empty; the picture says nothing of the scene");
    }
    bool isZero = MendFocus(&camera->focalLength, &camera->fStop, &camera->focusDistance);
    for (LensSample& sample : camera->lensSamples) {
        if (!std::isfinite(sample.focalLength)) {
            sample.focalLength = camera->focalLength;
        }
        sample.fStop = sample.fStop > 0.0F && std::isfinite(sample.fStop) ? sample.fStop : 0.0F;
        if (std::isnan(sample.focusDistance)) {
            sample.focusDistance = camera->focusDistance;
        }
        if (!IsAperture(sample.horizontalAperture) || !IsAperture(sample.verticalAperture)) {
            sample.horizontalAperture = camera->horizontalAperture;
            sample.verticalAperture = camera->verticalAperture;
        }
        if (!std::isfinite(sample.horizontalApertureOffset)) {
            sample.horizontalApertureOffset = camera->horizontalApertureOffset;
        }
        if (!std::isfinite(sample.verticalApertureOffset)) {
            sample.verticalApertureOffset = camera->verticalApertureOffset;
        }
        isZero = MendFocus(&sample.focalLength, &sample.fStop, &sample.focusDistance) || isZero;
    }
    if (isZero && !camera->orthographic && camera->lens.projection == CameraProjection::Film) {
        problems.emplace_back("focalLength is 0; drawn with OpenUSD's frustum of it, that of one "
                              "scene unit, and everything in focus");
    }
    return problems;
}

} // namespace hds
