// SPDX-License-Identifier: Apache-2.0
// What the integrator needs to know besides the scene.
#pragma once

#include "hdStream/base/workCount.h"
#include "hdStream/film/aov.h"
#include "hdStream/film/deepImage.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/stream/reportPool.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace hds {

/// Which form of the traversal kernel runs (docs/accel.md).
enum class TraversalForm {
    Auto,   ///< Flat where it is worth it, else Simd8 on CPU devices; Scalar on others
    Flat,   ///< as Simd8, and the flat hierarchy wherever geometry is resident and at rest
    Simd8,  ///< eight boxes a vector inside a work-item, level by level
    Scalar, ///< one work-item a ray
};

/// Which kernels a render runs (docs/device.md); equal bits.
enum class KernelChoice {
    Auto,    ///< general ones until those of its own are there, if it pays to have them
    Own,     ///< those that its own features need
    General, ///< general ones wherever they cover the scene
};

/// How an aperture of another aspect ratio is fitted to the display window (UsdRender's
/// aspectRatioConformPolicy).
enum class ConformPolicy {
    ExpandAperture,         ///< the aperture grows in the direction in which the image is longer
    CropAperture,           ///< it shrinks in the other
    AdjustApertureWidth,    ///< the aperture's height holds
    AdjustApertureHeight,   ///< its width holds
    AdjustPixelAspectRatio, ///< the aperture fills the display window, whatever shape pixels get
};

/// Options of a render; units and defaults as in session/settings.h.
struct RenderOptions {
    CameraPrim camera;
    Shutter shutter; ///< closed: no motion blur
    std::uint32_t imageWidth = 0;
    std::uint32_t imageHeight = 0;
    double pixelAspectRatio = 1.0;
    std::array<double, 4> displayWindow{}; ///< left, top, right, bottom
    std::array<std::int32_t, 2> dataWindowMin{};
    std::array<double, 4> uncroppedWindow{}; ///< of what the image is a crop of; all 0: of itself
    ConformPolicy conformPolicy = ConformPolicy::ExpandAperture;
    AovLayout aovs;
    std::optional<DeepLimits> deep; ///< of a deep picture, which is asked for
    std::uint32_t samples = 64;
    std::uint32_t maxDepth = 8;
    std::uint32_t maxDiffuseDepth = ~0U; ///< bounces of these lobes, of maxDepth
    std::uint32_t maxGlossyDepth = ~0U;
    std::uint32_t maxTransmissionDepth = ~0U;
    double clampDirect = 0.0; ///< 0: none, as of the next two
    double clampIndirect = 0.0;
    double filterGlossy = 0.0;
    float occlusionDistance = 0.0F; ///< of the AOV ambientOcclusion; may be infinite
    bool glassShadows = false;      ///< as CommitOptions::glassShadows
    bool smoothTerminator = false;  ///< rays leave triangles from the surface of their normals
    std::uint32_t seed = 0;
    double timeLimit = 0.0;
    double noise = 0.0;
    std::string pixelFilter;
    double pixelFilterWidth = 3.0;
    bool russianRoulette = true;
    double mipBias = 0.0; ///< mips that texture look-ups are moved by
    /// Launches after which coarser mips are taken for texels that are missing; 0: never.
    std::uint32_t shadeIterations = 0;
    std::uint32_t waveSize = 0;
    TraversalForm traversal = TraversalForm::Auto;
    KernelChoice kernels = KernelChoice::Auto;
    /// Someone looks at the film while it is rendered, and edits: the first sample goes from coarse
    /// to fine, and passes are short. The final picture is the same, but for the noise of domes
    /// that would have a guide (domeGuidePass.h).
    bool interactive = false;
    bool learns = false;      ///< paths are for a guide: holdouts are like other surfaces
    double passSeconds = 0.0; ///< that a pass is to take; 0: by who looks on

    /// Whether kernels have to know of bounds beside maxDepth.
    bool HasPathLimits() const {
        const std::uint32_t least =
            std::min({maxDiffuseDepth, maxGlossyDepth, maxTransmissionDepth});
        return least < maxDepth || clampDirect > 0.0 || clampIndirect > 0.0 || filterGlossy > 0.0;
    }
};

/// Seconds that a pass is to take once passes have grown, and that pictures are apart.
/// \param passSeconds as RenderOptions::passSeconds.
double PassSeconds(bool interactive, double passSeconds = 0.0);

/// Where geometry and textures live on the device (docs/streaming.md, docs/texturing.md). Textures
/// stream unless they are to be resident: what nobody sees is never opened.
enum class ResidencyMode {
    Auto,     ///< Resident when little, or once all of it is in a pool that holds it; else Stream
    Resident, ///< all of it, uploaded once
    Stream,   ///< what rays ask for, in a pool of the budget's size
    Mapped,   ///< read where the persistent cache has it (CPU devices)
};

/// How geometry and textures are kept on the device.
struct ResidencyOptions {
    ResidencyMode mode = ResidencyMode::Auto;
    /// Of the pool in bytes; 0: a share of the device's memory.
    std::uint64_t budgetBytes = 0;
    /// Of the pool as a share of all bytes that could be streamed, instead of budgetBytes; 0: none.
    double budgetShare = 0.0;
    Eviction eviction = Eviction::Lru;
    bool requestsFirst = false; ///< rays ask for the first missing chunk they meet, not the nearest
    std::uint32_t pageEntries = 0; ///< StreamingPool::SetHashEntries
    /// Of the pool for textures, as budgetBytes and budgetShare.
    std::uint64_t textureBudgetBytes = 0;
    double textureBudgetShare = 0.0;
    /// Of the part of it that only volumes have, likewise. Both 0: volumes share with textures.
    std::uint64_t volumeBudgetBytes = 0;
    double volumeBudgetShare = 0.0;
    bool preparesAll = false; ///< all geometry is prepared before the first ray

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(ResidencyOptions, mode), HDS_FIELD(ResidencyOptions, budgetBytes),
            HDS_FIELD(ResidencyOptions, budgetShare), HDS_FIELD(ResidencyOptions, eviction),
            HDS_FIELD(ResidencyOptions, requestsFirst), HDS_FIELD(ResidencyOptions, pageEntries),
            HDS_FIELD(ResidencyOptions, textureBudgetBytes),
            HDS_FIELD(ResidencyOptions, textureBudgetShare),
            HDS_FIELD(ResidencyOptions, volumeBudgetBytes),
            HDS_FIELD(ResidencyOptions, volumeBudgetShare),
            HDS_FIELD(ResidencyOptions, preparesAll));
    }
};

/// Progress while rendering.
struct Progress {
    std::uint32_t samplesDone = 0; ///< per pixel, of the pixels that are done least
    std::uint32_t samplesTotal = 0;
    double fraction = 0.0;       ///< of all work
    double secondsElapsed = 0.0; ///< since rendering began
    double secondsLeft = 0.0;    ///< estimate
    /// While the first sample goes from coarse to fine: pixels whose coordinates are multiples of
    /// this have it. 1: all pixels; 0: there is no picture yet.
    std::uint32_t previewStride = 0;
    /// While the scene is prepared (`fraction` is 0): prims whose geometry is planned, then, where
    /// all pages are made before the first ray, chunks whose pages are there.
    WorkCount prims;
    WorkCount chunks;
    WorkCount textures; ///< the same, of lines (Session::Prepare)
};

/// Return false to stop; what was rendered so far stays in the film.
using ProgressCallback = std::function<bool(const Progress&)>;

/// What else a front end wants while it renders.
struct RenderWatch {
    /// Asked between launches, many times a wave: true ends the render at once, without the samples
    /// of the present wave. May be empty.
    std::function<bool()> isCancelled;
    /// Layers is called in the progress callback: the AOVs of first hits come with the first
    /// picture. The error of a render that is stopped then is not estimated.
    bool takesPictures = false;
};

/// How a render ended.
enum class RenderResult { Complete, Stopped };

} // namespace hds
