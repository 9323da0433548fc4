// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/cameraFrame.h"

#include "hdStream/scene/motion.h"
#include "hdStream/scene/transforms.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hds {

namespace {

/// The film back after conforming, and the display window it fills.
struct Film {
    double width = 0.0;
    double height = 0.0;
    double left = 0.0; ///< display window, pixels, y down
    double top = 0.0;
    double windowWidth = 0.0;
    double windowHeight = 0.0;
};

Film ConformFilm(const RenderOptions& options, const LensSample& lens) {
    const auto& window = options.displayWindow;
    Film film;
    film.width = static_cast<double>(lens.horizontalAperture);
    film.height = static_cast<double>(lens.verticalAperture);
    film.left = window[0];
    film.top = window[1];
    film.windowWidth = window[2] - window[0];
    film.windowHeight = window[3] - window[1];
    const double imageAspect = options.pixelAspectRatio * film.windowWidth / film.windowHeight;
    const bool isImageWider = film.width / film.height < imageAspect;
    bool adjustsWidth = isImageWider;
    switch (options.conformPolicy) {
    case ConformPolicy::ExpandAperture:
        break;
    case ConformPolicy::CropAperture:
        adjustsWidth = !isImageWider;
        break;
    case ConformPolicy::AdjustApertureWidth:
        adjustsWidth = true;
        break;
    case ConformPolicy::AdjustApertureHeight:
        adjustsWidth = false;
        break;
    case ConformPolicy::AdjustPixelAspectRatio:
        return film;
    }
    if (adjustsWidth) {
        film.width = film.height * imageAspect;
    } else {
        film.height = film.width / imageAspect;
    }
    return film;
}

/// Planes of camera space as planes of world space relative to the scene centre. A plane is a row
/// vector: it is carried by the inverse of the transform that carries points.
void SetClipPlanes(const CameraPrim& camera, const glm::dmat4& worldFromCamera,
                   shared::HdsFrameParams* params) {
    const bool isMoving = (params->flags & HDS_FRAME_CAMERA_MOVES) != 0; // then they stay there
    const glm::dmat4 cameraFromWorld = isMoving ? glm::dmat4(1.0) : glm::inverse(worldFromCamera);
    for (const glm::dvec4& plane : camera.clippingPlanes) {
        if (params->numClipPlanes == HDS_MAX_CLIP_PLANES) {
            break; // CheckCamera has warned
        }
        const glm::dvec4 world = plane * cameraFromWorld;
        for (int i = 0; i < 4; ++i) {
            params->clipPlanes[params->numClipPlanes][i] = static_cast<float>(world[i]);
        }
        ++params->numClipPlanes;
    }
}

/// The camera's poses while the shutter is open.
void SetMotion(const RenderOptions& options, const glm::dvec3& centre,
               shared::HdsFrameParams* params) {
    const Shutter& shutter = options.shutter;
    if (shutter.IsOpen()) {
        const double time = -shutter.open / (shutter.close - shutter.open);
        params->frameTime = static_cast<float>(std::clamp(time, 0.0, 1.0));
    }
    if (!MovesOver(options.camera, shutter)) {
        return;
    }
    const std::vector<glm::dmat4> keys = MakeCameraKeys(options.camera, shutter);
    params->flags |= HDS_FRAME_CAMERA_MOVES;
    params->cameraSegments = static_cast<std::uint32_t>(keys.size() - 1);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const AffineRows rows = RowsFromMatrix(glm::translate(glm::dmat4(1.0), -centre) * keys[i]);
        std::copy(rows.begin(), rows.end(), params->cameraKeys[i]);
    }
}

constexpr double kPi = 3.14159265358979323846;

double Radians(float degrees) {
    return static_cast<double>(degrees) * (kPi / 180.0);
}

/// The display window in film coordinates: left, top, and the way from there to the right and to
/// the bottom.
std::array<double, 4> ProjectedWindow(const RenderOptions& options, const LensSample& lens) {
    const CameraLens& view = options.camera.lens;
    if (view.projection == CameraProjection::Latlong) {
        return {Radians(view.longitudes[0]), Radians(view.latitudes[1]),
                Radians(view.longitudes[1] - view.longitudes[0]),
                Radians(view.latitudes[0] - view.latitudes[1])};
    }
    if (view.projection != CameraProjection::Film) {
        // The field of view is a circle that touches the two longer sides.
        const auto& window = options.displayWindow;
        const double width = options.pixelAspectRatio * (window[2] - window[0]);
        const double height = window[3] - window[1];
        const double shorter = std::min(width, height);
        return {-width / shorter, height / shorter, 2.0 * width / shorter, -2.0 * height / shorter};
    }
    const FilmWindow film = ConformedFilmWindow(options, lens);
    return {film.left, film.top, film.width, -film.height};
}

/// Film coordinates of raster (0, 0), and the steps of a pixel.
std::array<double, 4> MakeFilm(const RenderOptions& options, const LensSample& lens) {
    const std::array<double, 4> edges = ProjectedWindow(options, lens);
    const auto& window = options.displayWindow;
    std::array<double, 4> film{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double step = edges[axis + 2] / (window[axis + 2] - window[axis]);
        film[axis] = edges[axis] - window[axis] * step;
        film[axis + 2] = step;
    }
    return film;
}

/// What of the frame depends on the lens, which may change while the shutter is open.
shared::HdsLensKey MakeLensKey(const RenderOptions& options, const LensSample& lens) {
    const std::array<double, 4> film = MakeFilm(options, lens);
    shared::HdsLensKey key{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        key.filmOrigin[axis] = static_cast<float>(film[axis]);
        key.filmStep[axis] = static_cast<float>(film[axis + 2]);
    }
    const bool hasLens = lens.fStop > 0.0F && lens.focusDistance > 0.0F;
    key.lensRadius = hasLens ? static_cast<float>(0.5 * static_cast<double>(lens.focalLength) /
                                                  static_cast<double>(lens.fStop))
                             : 0.0F;
    key.focusDistance = lens.focusDistance;
    return key;
}

/// Sets the members of the frame that a lens key has too.
void SetLensKey(const shared::HdsLensKey& key, shared::HdsFrameParams* params) {
    std::copy_n(key.filmOrigin, 2, params->filmOrigin);
    std::copy_n(key.filmStep, 2, params->filmStep);
    params->lensRadius = key.lensRadius;
    params->focusDistance = key.focusDistance;
}

/// What HDS_FEATURE_CAMERA_LENS reads.
void SetLens(const RenderOptions& options, shared::HdsFrameParams* params) {
    const CameraPrim& camera = options.camera;
    const CameraLens& lens = camera.lens;
    params->projection = static_cast<std::uint32_t>(lens.projection);
    const double half = 0.5 * Radians(lens.fieldOfView);
    params->fieldScale = static_cast<float>(
        lens.projection == CameraProjection::FisheyeEquisolid       ? std::sin(0.5 * half)
        : lens.projection == CameraProjection::FisheyeStereographic ? std::tan(0.5 * half)
                                                                    : half);
    params->fieldRest = static_cast<float>(std::pow(std::cos(0.5 * half), 2.0));
    const std::array<double, 4> film = MakeFilm(options, LensOfFrame(camera));
    for (std::size_t i = 0; i < 4; ++i) {
        params->filmRest[i] =
            static_cast<float>(film[i] - static_cast<double>(static_cast<float>(film[i])));
    }
    params->apertureBlades = static_cast<std::uint32_t>(HasBlades(lens) ? lens.apertureBlades : 0);
    params->apertureRotation =
        static_cast<float>(std::remainder(Radians(lens.apertureRotation), 2.0 * kPi));
    params->apertureRoundness = lens.apertureRoundness;
    params->apertureWidth = 1.0F / lens.apertureRatio;
    params->vignetting = lens.vignetting;
    const Shutter& shutter = options.shutter;
    if (LensChangesOver(camera, shutter)) {
        params->lensSegments = HDS_MAX_MOTION_SEGMENTS;
        for (std::uint32_t i = 0; i <= params->lensSegments; ++i) {
            const double part = double(i) / double(params->lensSegments);
            const double time = shutter.open + part * (shutter.close - shutter.open);
            params->lensKeys[i] = MakeLensKey(options, LensAt(camera, time));
        }
    }
}

/// The largest extent of the lens to each side, at any time. On a film it lies in the plane z = 0;
/// else it turns with the ray.
glm::dvec3 LensExtent(const shared::HdsFrameParams& params) {
    float radius = params.lensRadius;
    for (std::uint32_t i = 0; params.lensSegments > 0 && i <= params.lensSegments; ++i) {
        radius = std::max(radius, params.lensKeys[i].lensRadius);
    }
    const float width = radius * params.apertureWidth;
    return params.projection == HDS_PROJECTION_FILM ? glm::dvec3(width, radius, 0.0)
                                                    : glm::dvec3(std::max(width, radius));
}

/// A border of the data window in film coordinates, beyond what filters reach; of a lens that
/// changes the one that lies furthest out.
/// \param isFar whether the border is that of the greatest raster coordinate.
double FilmBorder(const shared::HdsFrameParams& params, int axis, bool isFar) {
    constexpr float kFilterMargin = 8.0F; // pixels
    const auto size = static_cast<float>(axis == 0 ? params.imageWidth : params.imageHeight);
    const float raster = static_cast<float>(params.dataWindowMin[axis]) +
                         (isFar ? size + kFilterMargin : -kFilterMargin);
    float border = raster * params.filmStep[axis] + params.filmOrigin[axis];
    const bool isGreatest = isFar == (params.filmStep[axis] > 0.0F);
    for (std::uint32_t i = 0; params.lensSegments > 0 && i <= params.lensSegments; ++i) {
        const shared::HdsLensKey& key = params.lensKeys[i];
        const float other = raster * key.filmStep[axis] + key.filmOrigin[axis];
        border = isGreatest ? std::max(border, other) : std::min(border, other);
    }
    return static_cast<double>(border);
}

} // namespace

FilmWindow ConformedFilmWindow(const RenderOptions& options, const LensSample& lens) {
    const Film film = ConformFilm(options, lens);
    const double scale =
        options.camera.orthographic ? 1.0 : 1.0 / static_cast<double>(lens.focalLength);
    const double left =
        (static_cast<double>(lens.horizontalApertureOffset) - 0.5 * film.width) * scale;
    const double top =
        (static_cast<double>(lens.verticalApertureOffset) + 0.5 * film.height) * scale;
    return {left, top, film.width * scale, film.height * scale};
}

static_assert(static_cast<std::uint32_t>(CameraProjection::Film) == HDS_PROJECTION_FILM);
static_assert(static_cast<std::uint32_t>(CameraProjection::FisheyeEquidistant) ==
              HDS_PROJECTION_EQUIDISTANT);
static_assert(static_cast<std::uint32_t>(CameraProjection::FisheyeEquisolid) ==
              HDS_PROJECTION_EQUISOLID);
static_assert(static_cast<std::uint32_t>(CameraProjection::FisheyeStereographic) ==
              HDS_PROJECTION_STEREOGRAPHIC);
static_assert(static_cast<std::uint32_t>(CameraProjection::Latlong) == HDS_PROJECTION_LATLONG);

bool NeedsLensKernels(const CameraPrim& camera, const Shutter& shutter) {
    const CameraLens& lens = camera.lens;
    const bool hasAperture = HasBlades(lens) || lens.apertureRatio != 1.0F;
    return lens.projection != CameraProjection::Film || lens.vignetting != 0.0F || hasAperture ||
           LensChangesOver(camera, shutter);
}

shared::HdsFrameParams MakeFrameParams(const RenderOptions& options, const glm::dvec3& centre,
                                       std::uint32_t numLights) {
    const CameraPrim& camera = options.camera;
    shared::HdsFrameParams params{};
    const glm::dmat4 worldFromCamera =
        glm::translate(glm::dmat4(1.0), -centre) * camera.worldFromCamera;
    const AffineRows rows = RowsFromMatrix(worldFromCamera);
    std::copy(rows.begin(), rows.end(), params.worldFromCamera);

    SetLensKey(MakeLensKey(options, LensOfFrame(camera)), &params);
    params.nearClip = camera.nearClip;
    params.farClip = camera.farClip;
    params.exposureScale = camera.exposureScale;
    const bool isOnFilm = camera.lens.projection == CameraProjection::Film;
    params.flags = (camera.orthographic && isOnFilm ? HDS_FRAME_ORTHOGRAPHIC : 0U) |
                   (options.russianRoulette ? HDS_FRAME_ROULETTE : 0U) |
                   (options.glassShadows ? HDS_FRAME_GLASS_SHADOWS : 0U) |
                   (options.learns ? HDS_FRAME_LEARNS : 0U) | (options.deep ? HDS_FRAME_DEEP : 0U);
    params.imageWidth = options.imageWidth;
    params.imageHeight = options.imageHeight;
    params.seed = options.seed;
    params.maxDepth = options.maxDepth;
    const auto bound = [](double clamp) {
        return clamp > 0.0 ? static_cast<float>(clamp) : std::numeric_limits<float>::infinity();
    };
    params.clampDirect = bound(options.clampDirect);
    params.clampIndirect = bound(options.clampIndirect);
    params.filterGlossy = static_cast<float>(options.filterGlossy);
    params.maxDiffuseDepth = options.maxDiffuseDepth;
    params.maxGlossyDepth = options.maxGlossyDepth;
    params.maxTransmissionDepth = options.maxTransmissionDepth;
    params.numLights = numLights;
    params.dataWindowMin[0] = options.dataWindowMin[0];
    params.dataWindowMin[1] = options.dataWindowMin[1];
    SetMotion(options, centre, &params);
    SetLens(options, &params);
    SetClipPlanes(camera, worldFromCamera, &params);
    return params;
}

float MediaProbeLength(const shared::HdsFrameParams& params, const MediaBounds& box, bool moves) {
    if (box.min.x > box.max.x) {
        return 0.0F;
    }
    const bool isOrthographic = (params.flags & HDS_FRAME_ORTHOGRAPHIC) != 0;
    const bool cameraMoves = (params.flags & HDS_FRAME_CAMERA_MOVES) != 0;
    const std::uint32_t numPoses = cameraMoves ? params.cameraSegments + 1 : 1;
    const glm::dvec3 middle = 0.5 * (box.min + box.max);
    const glm::dvec3 lens = LensExtent(params);
    MediaBounds camera;
    double furthest = 0.0;
    for (std::uint32_t pose = 0; pose < numPoses; ++pose) {
        const float* rows = cameraMoves ? params.cameraKeys[pose] : params.worldFromCamera;
        for (int corner = 0; corner < 8; ++corner) {
            glm::dvec3 at((corner & 1) != 0 ? lens.x : -lens.x,
                          (corner & 2) != 0 ? lens.y : -lens.y,
                          (corner & 4) != 0 ? lens.z : -lens.z);
            for (int i = 0; i < 2 && isOrthographic; ++i) {
                at[i] += FilmBorder(params, i, (corner >> i & 1) != 0);
            }
            glm::dvec3 world;
            for (int i = 0; i < 3; ++i) {
                const float* row = rows + 4 * i;
                world[i] =
                    glm::dot(glm::dvec3(row[0], row[1], row[2]), at) + static_cast<double>(row[3]);
            }
            camera.min = glm::min(camera.min, world);
            camera.max = glm::max(camera.max, world);
            furthest = std::max(furthest, glm::length(world - middle));
        }
    }
    const bool isApart = glm::any(glm::greaterThan(camera.min, box.max)) ||
                         glm::any(glm::lessThan(camera.max, box.min));
    if (isApart && !moves && !cameraMoves) {
        return 0.0F;
    }
    // Beyond the far side of the box, whatever the direction.
    return static_cast<float>(1.01 * (furthest + 0.5 * glm::length(box.max - box.min)));
}

} // namespace hds
