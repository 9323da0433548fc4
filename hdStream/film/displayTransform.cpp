// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/displayTransform.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/colorConfig.h"
#include "hdStream/texture/oneLine.h"
#include "hdStream/texture/srgb.h"

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

struct DisplayTransform::Processor {
    OCIO::ConstCPUProcessorRcPtr cpu;
};

ColorCorrection ParseColorCorrection(const std::string& mode) {
    if (mode.empty()) {
        return ColorCorrection::Automatic;
    }
    if (mode == "disabled") {
        return ColorCorrection::Disabled;
    }
    if (mode == "sRGB") {
        return ColorCorrection::Srgb;
    }
    if (mode == "openColorIO") {
        return ColorCorrection::OpenColorIO;
    }
    throw Error("--colorCorrectionMode: '" + mode + "' is none of disabled, sRGB, openColorIO",
                ErrorKind::Usage);
}

DisplayTransform::DisplayTransform(ColorCorrection mode) : _mode(mode) {
    if (_mode == ColorCorrection::Automatic) {
        _mode = HasUserColorConfig() ? ColorCorrection::OpenColorIO : ColorCorrection::Srgb;
    }
    if (_mode != ColorCorrection::OpenColorIO) {
        return;
    }
    const OCIO::ConstConfigRcPtr config = ColorConfig();
    try {
        const std::string display = config->getDefaultDisplay();
        const std::string view = config->getDefaultView(display.c_str());
        _processor = std::make_unique<Processor>();
        _processor->cpu = config
                              ->getProcessor(OCIO::ROLE_SCENE_LINEAR, display.c_str(), view.c_str(),
                                             OCIO::TRANSFORM_DIR_FORWARD)
                              ->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS);
    } catch (const std::exception& failure) {
        throw Error("OCIO: the default display of the colour configuration cannot be used: " +
                    OneLine(failure.what()));
    }
}

DisplayTransform::~DisplayTransform() = default;

void DisplayTransform::Apply(float* rgb, std::size_t numPixels) const {
    if (_processor) {
        OCIO::PackedImageDesc pixels(rgb, static_cast<long>(numPixels), 1, 3);
        _processor->cpu->apply(pixels);
    } else if (_mode == ColorCorrection::Srgb) {
        for (std::size_t i = 0; i < 3 * numPixels; ++i) {
            rgb[i] = static_cast<float>(SrgbFromLinear(rgb[i]));
        }
    }
}

} // namespace hds
