// SPDX-License-Identifier: Apache-2.0
// An open image: OpenImageIO's reader for a file or a byte range, chosen by the content's first
// bytes, and its pixels in bands of rows so that memory stays bounded.
// Included by the readers of texture and by film's comparison; pulls OpenImageIO's header in.
#pragma once

#include "hdStream/texture/imageReader.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// An image open for reading: first subimage, finest level, first slice. One thread at a time.
/// Alpha is delivered as the file has it (PNG: not premultiplied).
class ImageFile {
public:
    static constexpr std::uint64_t kBandBytes = 1u << 20; ///< enough to keep decoders busy

    /// Rows [y, y + numRows) from the top, pixels interleaved.
    using BandCallback =
        std::function<void(std::uint32_t y, std::uint32_t numRows, const void* pixels)>;

    /// Opens an image; null with `error` (one line that names the file) when it cannot be read.
    static std::unique_ptr<ImageFile> Open(const ImageSource& source, std::string* error);
    /// The same of an image whose pixels nobody will read: reads no more than the header of a
    /// progressive JPEG file, which Open decodes.
    static std::unique_ptr<ImageFile> OpenHeader(const ImageSource& source, std::string* error);
    ~ImageFile();
    ImageFile(const ImageFile&) = delete;
    ImageFile& operator=(const ImageFile&) = delete;

    const OIIO::ImageSpec& Spec() const { return _spec; }
    std::uint32_t Width() const { return static_cast<std::uint32_t>(_spec.width); }
    std::uint32_t Height() const { return static_cast<std::uint32_t>(_spec.height); }
    std::string FormatName() const { return _input->format_name(); }
    /// How messages name the image.
    const std::string& Name() const { return _name; }

    /// Reads all rows of channels [channelBegin, channelEnd) in order, converted to `type`
    /// (integers to floats: divided by their maximum); OIIO::TypeUnknown leaves each channel as it
    /// is stored, packed.
    /// \param bandBytes memory of a band; at least one row of tiles or 64 rows are read at once
    /// \return an error, one line that names the file; empty when all rows were delivered
    std::string ReadBands(const OIIO::TypeDesc& type, int channelBegin, int channelEnd,
                          const BandCallback& onBand, std::uint64_t bandBytes = kBandBytes);

private:
    ImageFile() = default;
    static std::unique_ptr<ImageFile> OpenPart(const ImageSource& source, bool isHeaderOnly,
                                               std::string* error);
    /// \param isInMemory the file is _bytes, and its name does not count
    /// \param canHaveProfile an ICC profile: OpenImageIO decodes it, one at a time
    std::string OpenWith(const std::string& format, std::string file, bool isInMemory,
                         bool canHaveProfile);
    std::string Error(const std::string& reason) const { return _name + ": " + reason; }

    std::string _name;          ///< for messages
    std::vector<char> _bytes;   ///< the byte range or the header, when there is one
    std::string _temporaryFile; ///< its copy for readers that want a file; else empty
    std::unique_ptr<OIIO::Filesystem::IOMemReader> _proxy; ///< over _bytes
    std::unique_ptr<OIIO::ImageInput> _input;              ///< destroyed before the proxy
    OIIO::ImageSpec _spec;
};

/// What an open image is.
ImageInfo DescribeImage(const ImageFile& file);

/// Which channels of a file are colour and alpha.
struct ColorChannels {
    int red = 0;
    int green = 0;
    int blue = 0;   ///< -1: none (two-channel data); red == green == blue: gray
    int alpha = -1; ///< -1: none

    int Begin() const;
    int End() const;
};

/// Finds colour by channel names (R, G, B, A, Y; upper or lower case), else by order.
ColorChannels FindColorChannels(const OIIO::ImageSpec& spec);

} // namespace hds
