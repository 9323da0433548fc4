// SPDX-License-Identifier: Apache-2.0
// The AOVs a render can write, in one table: name, channels, kind, clear value and meaning. The
// command line, Hydra's AOV descriptors, the film's buffers and the image writer all read it.
// Explained in docs/film.md.
#pragma once

#include "hdStream/film/imageLayer.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// How a pixel's samples become its value.
enum class AovFilter {
    Weighted, ///< mean of the samples, weighted by the pixel filter
    First,    ///< of the ray through the pixel's centre: averages of depths and ids mean nothing
    Counter,  ///< the film's own bookkeeping of the pixel
    Matte,    ///< shares of the samples, by what they met first (film/cryptomatte.h)
};

/// One row of the table.
struct AovInfo {
    std::string name;                  ///< as in --aovs and HdAovTokens
    std::vector<std::string> channels; ///< channel names in an EXR; their number is the width
    bool isInteger = false;            ///< one int32 a pixel instead of floats
    bool isColor = false;              ///< linear working-space colour: display transforms apply
    AovFilter filter = AovFilter::Weighted;
    float clearValue = 0.0f;  ///< every channel of a pixel that hit nothing
    std::int32_t clearId = 0; ///< of an integer AOV: a pixel that hit nothing
    std::string description;  ///< meaning, space and unit
    std::string lightPaths;   ///< the light that it shows: an expression (film/lightPaths.h)

    std::uint32_t NumChannels() const { return static_cast<std::uint32_t>(channels.size()); }
};

/// All AOVs, in the order they are listed to users. Thread-safe.
const std::vector<AovInfo>& AovTable();

/// The row of that name, or of the layer of a Cryptomatte; null when there is none. Primvars, light
/// path expressions and groups of lights have none.
const AovInfo* FindAov(const std::string& name);

/// Whether there is such an AOV, primvars, layers of Cryptomattes, light path expressions, whether
/// or not they can be read, and groups of lights included.
bool HasAov(const std::string& name);

/// The names of the layers that a Cryptomatte's name stands for; any other name as it is.
std::vector<std::string> LayersOf(const std::string& name);

/// AOVs of this prefix show a primvar of the first hit (three floats; 0 where there is none).
constexpr const char* kPrimvarAovPrefix = "primvars:";
/// The AOV whose samples are traced apart.
constexpr const char* kOcclusionAov = "ambientOcclusion";
/// AOVs of this prefix show the light of an expression (film/lightPaths.h).
constexpr const char* kLightPathPrefix = "lpe:";
/// AOVs of this prefix show the light of the lights of a group.
constexpr const char* kLightGroupPrefix = "lightGroup:";
/// AOVs of this prefix show the variance of an AOV that is the light of an expression.
constexpr const char* kVariancePrefix = "variance:";

/// Whether a film keeps sums or counts for that AOV beside those of colour.
bool IsSummed(const std::string& name);

/// Throws an error (Usage) that names the AOV, and of a light path expression the column, for a
/// list of AOVs that no render can have.
void CheckAovs(const std::vector<std::string>& names);

/// Where a render keeps one of its AOVs.
struct AovSlot {
    std::shared_ptr<const AovInfo> info;
    std::uint32_t offset = 0; ///< first channel, in floats (ints for integer AOVs) inside a pixel
    /// Of AovInfo::lightPaths: its number in AovLayout::lightPaths.
    std::uint32_t lightPath = 0;
};

/// Layout of a render's resolved AOVs: one buffer of floats and one of int32s, each with all
/// values of a pixel next to each other, pixels in rows from top to bottom.
struct AovLayout {
    std::vector<AovSlot> slots; ///< in the order asked for
    std::uint32_t floatsPerPixel = 0;
    std::uint32_t intsPerPixel = 0;
    bool hasMattes = false; ///< some AOV is a layer of a Cryptomatte, which lies in neither buffer
    /// Names of the primvars that are AOVs; they lie one after another from primvarOffset on.
    std::vector<std::string> primvars;
    std::uint32_t primvarOffset = 0;
    std::vector<std::string> lightPaths; ///< expressions that AOVs show, each once
    bool hasCatchers = false;            ///< sums of what catchers show are kept; the scene says it
    bool hasOcclusion = false;           ///< ambient occlusion is an AOV

    /// What sums are kept beside colour: expressions, then what catchers get with and without
    /// others, then ambient occlusion.
    std::vector<std::string> SumNames() const;

    /// The slot of that AOV; null when it was not asked for.
    const AovSlot* Find(const std::string& name) const;
};

/// Lays the AOVs out in the order given. The name of a Cryptomatte stands for kMatteLayers layers.
/// \throws Error (Usage) that names the AOV, for an unknown or repeated name or an empty list.
AovLayout MakeAovLayout(const std::vector<std::string>& names);

/// A layer of that size with every pixel at the AOV's clear value.
ImageLayer MakeClearLayer(const AovInfo& info, std::uint32_t width, std::uint32_t height);

/// How a layer shows pixels of which nothing is known.
enum class PreviewFill {
    Squares, ///< as the known pixel above and to the left of them
    Clear,   ///< at the AOV's clear value
};

/// A layer of width x height of which only those pixels are known whose coordinates are multiples
/// of `stride`: `known` has them, row by row.
ImageLayer EnlargePreview(const AovInfo& info, const ImageLayer& known, std::uint32_t width,
                          std::uint32_t height, std::uint32_t stride, PreviewFill fill);

/// Splits resolved buffers (read back from the device) into layers, in the order of the layout.
/// Cryptomattes are left clear.
/// \param floats [height][width][floatsPerPixel]; may be null when floatsPerPixel is 0
/// \param ints [height][width][intsPerPixel]; may be null when intsPerPixel is 0
std::vector<ImageLayer> MakeLayers(const AovLayout& layout, std::uint32_t width,
                                   std::uint32_t height, const float* floats,
                                   const std::int32_t* ints);

} // namespace hds
