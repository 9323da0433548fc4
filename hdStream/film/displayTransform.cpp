// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/displayTransform.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/colorConfig.h"
#include "hdStream/texture/oneLine.h"
#include "hdStream/texture/srgb.h"

#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

struct DisplayTransform::Processor {
    std::vector<OCIO::ConstCPUProcessorRcPtr> steps; ///< one after another
};

namespace {

/// The default view of the default display, from a space that the configuration knows.
OCIO::ConstCPUProcessorRcPtr MakeView(const OCIO::ConstConfigRcPtr& config, const char* from) {
    const std::string display = config->getDefaultDisplay();
    const std::string view = config->getDefaultView(display.c_str());
    return config->getProcessor(from, display.c_str(), view.c_str(), OCIO::TRANSFORM_DIR_FORWARD)
        ->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS);
}

/// What leads from a working space to the display.
std::vector<OCIO::ConstCPUProcessorRcPtr> MakeSteps(bool isSrgb, const std::string& workingSpace) {
    if (isSrgb) {
        return {MakeColorProcessor(workingSpace, "lin_rec709")};
    }
    const OCIO::ConstConfigRcPtr config = ColorConfig();
    if (workingSpace.empty() || !config->getColorSpace(workingSpace.c_str())) {
        std::vector<OCIO::ConstCPUProcessorRcPtr> steps;
        if (!workingSpace.empty()) { // of the built-in configuration
            steps.push_back(MakeColorProcessor(workingSpace, OCIO::ROLE_SCENE_LINEAR));
        }
        steps.push_back(MakeView(config, OCIO::ROLE_SCENE_LINEAR));
        return steps;
    }
    return {MakeView(config, workingSpace.c_str())};
}

} // namespace

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

DisplayTransform::DisplayTransform(ColorCorrection mode, const std::string& workingSpace)
    : _mode(mode) {
    if (_mode == ColorCorrection::Automatic) {
        _mode = HasUserColorConfig() ? ColorCorrection::OpenColorIO : ColorCorrection::Srgb;
    }
    const bool isSrgb = _mode == ColorCorrection::Srgb && !workingSpace.empty();
    if (_mode != ColorCorrection::OpenColorIO && !isSrgb) {
        return;
    }
    try {
        _processor = std::make_unique<Processor>();
        _processor->steps = MakeSteps(isSrgb, workingSpace);
    } catch (const std::exception& failure) {
        throw Error("OCIO: the default display of the colour configuration cannot be used: " +
                    OneLine(failure.what()));
    }
}

DisplayTransform::~DisplayTransform() = default;

void DisplayTransform::Apply(float* rgb, std::size_t numPixels) const {
    if (_processor) {
        OCIO::PackedImageDesc pixels(rgb, static_cast<long>(numPixels), 1, 3);
        for (const OCIO::ConstCPUProcessorRcPtr& step : _processor->steps) {
            step->apply(pixels);
        }
    }
    if (_mode == ColorCorrection::Srgb) {
        for (std::size_t i = 0; i < 3 * numPixels; ++i) {
            rgb[i] = static_cast<float>(SrgbFromLinear(rgb[i]));
        }
    }
}

} // namespace hds
