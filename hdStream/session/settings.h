// SPDX-License-Identifier: Apache-2.0
// The settings of a render and the one table that describes them: the command line, the render
// settings prim, Hydra's descriptors and docs/settings.md all come from it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace hds {

/// All settings; each member has a row in SettingTable().
struct Settings {
    std::string camera;              ///< prim path; must be in the scene
    std::uint32_t imageWidth = 960;  ///< pixels of the image (the data window)
    std::uint32_t imageHeight = 540; ///< pixels of the image (the data window)
    double pixelAspectRatio = 1.0;   ///< width / height of a pixel
    /// What the camera's aperture is fitted to: left, top, right, bottom in pixels, y down; all 0:
    /// the image. Larger than the image for a crop, smaller for an overscan.
    std::array<double, 4> displayWindow{};
    /// The image's upper left pixel, in the same coordinates. Samples are keyed by their pixel's
    /// distance from the display window's corner, so a crop has the bits of the full image.
    std::array<std::int32_t, 2> dataWindowMin{};
    /// How an aperture of another aspect ratio is fitted to the display window: expandAperture,
    /// cropAperture, adjustApertureWidth, adjustApertureHeight, adjustPixelAspectRatio.
    std::string conformPolicy = "expandAperture";
    std::vector<std::string> aovs{"color"};
    std::vector<std::string> purposes{"default", "render"}; ///< drawn
    std::string cullStyle = "nothing"; ///< of meshes that have none: see CullStyle
    bool cameraMoves = false;          ///< dice for a camera that may turn anywhere
    bool domeVisible = true;           ///< domes are seen by camera rays
    std::uint32_t samples = 64;        ///< per pixel
    std::uint32_t maxDepth = 8;        ///< bounces after the first hit
    std::uint32_t seed = 0;
    double timeLimit = 0.0; ///< seconds; 0: none
    double noise = 0.0;     ///< relative error per pixel at which it stops; 0: never
    std::string pixelFilter = "blackmanHarris"; ///< or "box"
    double pixelFilterWidth = 3.0;              ///< pixels, full width (box: 1 is the pixel itself)
    bool russianRoulette = true;
    std::string motionBlur = "on"; ///< where the camera has an open shutter; or "off"
    bool denoise = false;          ///< the picture, by Open Image Denoise
    double mipBias = 0.0;          ///< mips that texture look-ups are moved by; positive: coarser
    std::string subdivision = "adaptive"; ///< adaptive, complexity (refineLevel everywhere) or cage
    std::uint32_t refineLevel = 0;        ///< for subdivision "complexity"
    std::uint32_t waveSize = 0; ///< paths in flight, at least 16; 0: the device's own default
    std::string device;         ///< part of its name; empty: the first GPU, else the first CPU
    std::string cacheDirectory; ///< empty: HDSTREAM_CACHE_DIR or the platform's
    bool noCache = false;
    std::string traversal = "auto";     ///< auto, wide (8-wide vectors), lane (one lane a ray)
    std::uint64_t chunkBytes = 1 << 20; ///< upper bound of a chunk's pages
    std::string residency = "auto";     ///< auto, resident, stream, mapped
    /// Pool for geometry that streams: bytes with suffix K, M or G, or a percentage of all that
    /// could be streamed ("30%"); empty: a quarter of the device's memory.
    std::string geometryMemory;
    std::string textureMemory;              ///< likewise for textures
    std::string geometryEviction = "clock"; ///< or "flush"
    std::string request = "last";           ///< chunk a ray asks for after its walk, or "first"
    /// Times that a point is shaded before coarser mips are taken for texels that are not there
    /// yet; 0: until all are.
    std::uint32_t shadeIterations = 0;
    bool plainTextures = false;   ///< textures whole and uncompressed, to compare with
    std::uint64_t hostMemory = 0; ///< bytes of prepared pages kept; 0: a quarter of the machine's
    std::string prepare = "lazy"; ///< pages when rays ask for them, or "eager": all at first

    bool operator==(const Settings& other) const;
    bool operator!=(const Settings& other) const { return !(*this == other); }
};

} // namespace hds
