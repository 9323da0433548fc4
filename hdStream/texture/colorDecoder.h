// SPDX-License-Identifier: Apache-2.0
// From a file's numbers to linear light in the working space: raw, sRGB, auto as UsdUVTexture
// defines them, or a named space of the OpenColorIO configuration.
// Explained in docs/texturing.md.
#pragma once

#include <OpenColorIO/OpenColorIO.h>
#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <string>

namespace hds {

/// What "auto" means for an image: "sRGB" or "raw". Authored metadata decides where the file has
/// any (a gamma, or Exif's colour space), else 8 bits with 3 or 4 channels is sRGB (UsdUVTexture,
/// sourceColorSpace).
std::string AutoColorSpace(const OIIO::ImageSpec& spec);

/// Decodes colours of one image. Immutable after construction, thread-safe.
class ColorDecoder {
public:
    /// \param colorSpace of the file, or a conversion to another than the scene_linear role
    ///        (colorConversion.h)
    /// \param warning one line (without the file's name) when the space is unknown or unusable and
    ///        the image is decoded as "auto" instead; else left alone
    ColorDecoder(const std::string& colorSpace, const OIIO::ImageSpec& spec, std::string* warning);

    /// Whether each channel is decoded for itself, by the sRGB curve or not at all.
    bool IsPerChannel() const { return !_processor; }

    /// Whether the values are sRGB codes; else, if per channel, they are linear or data.
    bool IsSrgb() const { return _isSrgb; }

    /// Decodes RGB triples in place; any space.
    void DecodeRgb(float* rgb, std::size_t numPixels) const;

private:
    bool TryNamed(const std::string& space, const std::string& workingSpace);

    bool _isSrgb = false;
    OCIO_NAMESPACE::ConstCPUProcessorRcPtr _processor; ///< null: raw or sRGB
};

} // namespace hds
