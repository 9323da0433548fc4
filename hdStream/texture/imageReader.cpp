// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/imageReader.h"

#include "hdStream/texture/colorDecoder.h"
#include "hdStream/texture/imageFile.h"

#include <memory>

namespace hds {

ImageInfo DescribeImage(const ImageFile& file) {
    const OIIO::ImageSpec& spec = file.Spec();
    ImageInfo info;
    info.width = file.Width();
    info.height = file.Height();
    info.channels = static_cast<std::uint32_t>(spec.nchannels);
    info.fileFormat = file.FormatName();
    info.channelType = spec.format.c_str();
    info.autoColorSpace = AutoColorSpace(spec);
    info.hasAlpha = FindColorChannels(spec).alpha >= 0;
    // "black,periodic": s, then t; one mode is for both.
    const std::string wraps = spec.get_string_attribute("wrapmodes");
    const std::size_t comma = wraps.find(',');
    info.wrapS = wraps.substr(0, comma);
    info.wrapT = comma == std::string::npos ? wraps : wraps.substr(comma + 1);
    // What UsdUVTexture's text asks for comes first.
    info.wrapS = spec.get_string_attribute("wrapS", info.wrapS);
    info.wrapT = spec.get_string_attribute("wrapT", info.wrapT);
    info.bytesDecoded = std::uint64_t{info.width} * info.height * spec.pixel_bytes(true);
    return info;
}

ImageInfo ProbeImage(const ImageSource& source) {
    ImageInfo info;
    const std::unique_ptr<ImageFile> file = ImageFile::OpenHeader(source, &info.error);
    return file ? DescribeImage(*file) : info;
}

} // namespace hds
