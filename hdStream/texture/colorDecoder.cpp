// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorDecoder.h"

#include "hdStream/texture/colorConfig.h"
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
    std::string space = colorSpace;
    if (!space.empty() && space != "auto" && space != "raw" && space != "sRGB") {
        try {
            const OCIO::ConstConfigRcPtr config = ColorConfig();
            const OCIO::ConstColorSpaceRcPtr known = config->getColorSpace(space.c_str());
            if (known && known->isData()) {
                space = "raw";
            } else if (known) {
                _processor = config->getProcessor(known->getName(), OCIO::ROLE_SCENE_LINEAR)
                                 ->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS);
                return;
            } else {
                *warning = "colour space '" + space + "' is unknown; auto is used";
                space = "auto";
            }
        } catch (const std::exception& failure) {
            *warning = "colour space '" + space + "' cannot be used (" + OneLine(failure.what()) +
                       "); auto is used";
            space = "auto";
        }
    }
    if (space.empty() || space == "auto") {
        space = AutoColorSpace(spec);
    }
    _isSrgb = space == "sRGB";
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
