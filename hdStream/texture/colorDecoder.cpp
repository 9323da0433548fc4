// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorDecoder.h"

#include "hdStream/texture/colorConfig.h"
#include "hdStream/texture/colorConversion.h"
#include "hdStream/texture/oneLine.h"
#include "hdStream/texture/srgb.h"

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

std::string AutoColorSpace(const OIIO::ImageSpec& spec) {
    // OpenImageIO sets oiio:ColorSpace for files that say nothing too, so it proves nothing; a
    // gamma and Exif's colour space are there only when the file has them.
    const float gamma = spec.get_float_attribute("oiio:Gamma", 0.0f);
    if (gamma > 0.0f) {
        return gamma < 1.5f ? "raw" : "sRGB";
    }
    constexpr int kExifSrgb = 1;
    if (spec.get_int_attribute("Exif:ColorSpace", 0) == kExifSrgb) {
        return "sRGB";
    }
    const bool isEightBit = spec.format == OIIO::TypeUInt8;
    return isEightBit && (spec.nchannels == 3 || spec.nchannels == 4) ? "sRGB" : "raw";
}

ColorDecoder::ColorDecoder(const std::string& colorSpace, const OIIO::ImageSpec& spec,
                           std::string* warning) {
    const ColorConversionName name = SplitConversion(colorSpace);
    std::string space = name.from;
    const bool isColor = space == kAutoColor;
    if (isColor) {
        space = "auto";
    }
    if (!space.empty() && space != "auto" && space != "raw" && space != "sRGB") {
        try {
            if (TryNamed(space, name.to)) {
                return;
            }
            *warning = "colour space '" + space + "' is unknown; auto is used";
        } catch (const std::exception& failure) {
            *warning = "colour space '" + space + "' cannot be used (" + OneLine(failure.what()) +
                       "); auto is used";
        }
        space = "auto";
    }
    if (space.empty() || space == "auto") {
        space = AutoColorSpace(spec);
    }
    if (!name.to.empty() && (space == "sRGB" || isColor)) {
        try {
            _processor =
                MakeColorProcessor(space == "sRGB" ? "srgb_texture" : "lin_rec709", name.to);
            return;
        } catch (const std::exception& failure) {
            *warning = "colour space '" + name.to + "' cannot be used (" + OneLine(failure.what()) +
                       "); it is left as it is";
        }
    }
    _isSrgb = space == "sRGB";
}

/// Decodes by a processor between named spaces; false: the first is unknown. Data are raw.
bool ColorDecoder::TryNamed(const std::string& space, const std::string& workingSpace) {
    OCIO::ConstConfigRcPtr config = ColorConfig();
    OCIO::ConstColorSpaceRcPtr known = config->getColorSpace(space.c_str());
    if (!known && !workingSpace.empty()) {
        known = BuiltInColorConfig()->getColorSpace(space.c_str());
    }
    if (known && !known->isData()) {
        _processor = workingSpace.empty()
                         ? config->getProcessor(known->getName(), OCIO::ROLE_SCENE_LINEAR)
                               ->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS)
                         : MakeColorProcessor(known->getName(), workingSpace);
    }
    return known != nullptr;
}

void ColorDecoder::DecodeRgb(float* rgb, std::size_t numPixels) const {
    if (_processor) {
        OCIO::PackedImageDesc pixels(rgb, static_cast<long>(numPixels), 1, 3);
        _processor->apply(pixels);
    } else if (_isSrgb) {
        for (std::size_t i = 0; i < 3 * numPixels; ++i) {
            rgb[i] = static_cast<float>(LinearFromSrgb(rgb[i]));
        }
    }
}

} // namespace hds
