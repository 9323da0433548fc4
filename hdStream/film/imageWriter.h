// SPDX-License-Identifier: Apache-2.0
// Writing finished layers to image files: every AOV to an EXR, the colour to other formats.
// Files appear whole or not at all (atomicFile.h). Bytes are a function of layers and options only.
// Explained in docs/film.md.
#pragma once

#include "hdStream/film/deepImage.h"
#include "hdStream/film/displayTransform.h"
#include "hdStream/film/imageLayer.h"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// What a file says about the render, where its format can.
struct ImageMetadata {
    std::string software = "hdStream";                   ///< name and version of the program
    std::uint32_t samples = 0;                           ///< per pixel; 0: not said
    std::string camera;                                  ///< prim path; empty: not said
    double pixelAspectRatio = 1.0;                       ///< width / height of a pixel
    std::optional<std::array<double, 16>> worldToCamera; ///< rows of GfMatrix4d (row vectors)
    std::optional<std::array<double, 16>> worldToNdc; ///< rows of GfMatrix4d, with the projection
    std::map<std::string, std::string> texts;         ///< further named texts
    /// Where the image lies in a larger or smaller one, whose upper left pixel is (0, 0); sizes of
    /// 0: it is the whole.
    std::array<std::int32_t, 2> dataWindowMin{};
    std::array<std::uint32_t, 2> displayWindowSize{};
    /// Frames a second, as a fraction; 0: not said.
    std::array<std::uint32_t, 2> framesPerSecond{};
    /// Number of the frame, for a SMPTE time code; with framesPerSecond of 30 at most.
    std::optional<std::uint32_t> frameNumber;
    /// What colours are in; empty: the configuration's scene_linear role.
    std::string workingSpace = {};
    /// Width and height of the tiles that an EXR consists of; 0: of scan lines.
    std::array<std::uint32_t, 2> tileSize{};
};

/// Options of WriteImage.
struct ImageWriteOptions {
    ColorCorrection colorCorrection = ColorCorrection::Automatic; ///< .png and .jpg only
    ImageMetadata metadata;
    /// AOVs of layers that the file has under other names, by these.
    std::map<std::string, std::string> aovs = {};
};

/// Fails early, before hours of rendering: checks that the extension is known, that the format can
/// hold what it would keep of the AOVs, where they are known, and that the folder takes new files.
/// \throws Error that names the file: Usage for an unknown extension or AOVs that are none for it,
///         else Failure
void CheckImageFile(const std::string& file, const std::vector<std::string>& aovs = {});

/// Writes layers of one size.
///  .exr        all layers, linear float, ids as 32-bit unsigned integers (-1 is 4294967295):
///  colour
///              as R, G, B, A (premultiplied), every other layer as NAME.CHANNEL; halves where
///              ImageLayer::isHalf; data and display window of the metadata, and its tiles
///  .png        the AOV "color" (else the first layer) display-referred, 8 bits, not premultiplied
///  .jpg .jpeg  that layer display-referred, 8 bits, over black
///  .tif .tiff  that layer in linear float, premultiplied
///  .hdr        that layer in linear float, without alpha
/// Ids, those of Cryptomattes too, are for .exr alone, layers of two channels for .exr and .tif.
/// \return names of the layers that the format has no room for
/// \throws Error that names the file and the reason; nothing is left behind and an existing file is
///         kept
std::vector<std::string> WriteImage(const std::string& file, const std::vector<ImageLayer>& layers,
                                    const ImageWriteOptions& options = {});

/// Writes a deep picture to an .exr: scan lines with R, G, B, A, Z and ZBack; by pixel the samples
/// from front to back. Of the metadata all but the tiles; compression `none`, `rle` or, whatever
/// else it says, `zips`. \param isHalf R, G, B and A are halves.
/// \throws Error as WriteImage; Usage for a file of another format
void WriteDeepImage(const std::string& file, const DeepImage& image, bool isHalf,
                    const ImageMetadata& metadata);

} // namespace hds
