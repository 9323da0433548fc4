// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/framing.h"

#include <cmath>

PXR_NAMESPACE_OPEN_SCOPE

CameraUtilFraming HdStreamFramingOf(const HdRenderPassState& state) {
    if (state.GetFraming().IsValid()) {
        return state.GetFraming();
    }
    const GfVec4f& viewport = state.GetViewport();
    return CameraUtilFraming(
        GfRect2i(GfVec2i(0), static_cast<int>(viewport[2]), static_cast<int>(viewport[3])));
}

void HdStreamApplyFraming(const CameraUtilFraming& framing, const GfVec2i& bufferSize,
                          hds::Settings* settings) {
    const GfRect2i& data = framing.dataWindow;
    const GfRange2f& display = framing.displayWindow;
    settings->imageWidth = static_cast<std::uint32_t>(data.GetWidth());
    settings->imageHeight = static_cast<std::uint32_t>(data.GetHeight());
    settings->pixelAspectRatio = static_cast<double>(framing.pixelAspectRatio);
    // Pixels are counted from the display window's corner, so that a crop whose host counts from
    // its own corner has the bits of the whole image.
    const int left = static_cast<int>(std::floor(display.GetMin()[0]));
    const int top = static_cast<int>(std::floor(display.GetMin()[1]));
    settings->dataWindowMin = {data.GetMinX() - left, data.GetMinY() - top};
    settings->uncroppedWindow = {};
    const GfRect2i whole = data.GetUnion(GfRect2i(GfVec2i(0), bufferSize[0], bufferSize[1]));
    if (whole != data) {
        settings->uncroppedWindow = {double(whole.GetMinX()) - left, double(whole.GetMinY()) - top,
                                     double(whole.GetMaxX()) + 1.0 - left,
                                     double(whole.GetMaxY()) + 1.0 - top};
    }
    const bool isWholeImage =
        data.GetMinX() == 0 && data.GetMinY() == 0 &&
        display == GfRange2f(GfVec2f(0.0F), GfVec2f(static_cast<float>(data.GetWidth()),
                                                    static_cast<float>(data.GetHeight())));
    if (isWholeImage) {
        settings->displayWindow = {};
        return;
    }
    settings->displayWindow = {static_cast<double>(display.GetMin()[0]) - left,
                               static_cast<double>(display.GetMin()[1]) - top,
                               static_cast<double>(display.GetMax()[0]) - left,
                               static_cast<double>(display.GetMax()[1]) - top};
}

std::string HdStreamConformPolicy(CameraUtilConformWindowPolicy policy) {
    switch (policy) {
    case CameraUtilMatchVertically:
        return "adjustApertureWidth";
    case CameraUtilMatchHorizontally:
        return "adjustApertureHeight";
    case CameraUtilCrop:
        return "cropAperture";
    case CameraUtilDontConform:
        return "adjustPixelAspectRatio";
    case CameraUtilFit:
        break;
    }
    return "expandAperture";
}

PXR_NAMESPACE_CLOSE_SCOPE
