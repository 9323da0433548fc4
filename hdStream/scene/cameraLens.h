// SPDX-License-Identifier: Apache-2.0
// What UsdGeomCamera has no attributes for: other projections than those on a flat film, and the
// shape of the aperture. Explained in docs/cameras.md.
#pragma once

#include "hdStream/base/enumTable.h"
#include "hdStream/base/fields.h"

#include <array>
#include <cstdint>

namespace hds {

/// How directions become points of the image.
enum class CameraProjection {
    Film,                 ///< on a flat film: perspective or orthographic
    FisheyeEquidistant,   ///< distance from the middle ~ angle from the axis
    FisheyeEquisolid,     ///< ~ sine of half the angle: areas are kept
    FisheyeStereographic, ///< ~ tangent of half the angle: shapes are kept
    Latlong,              ///< longitude across, latitude upwards
};

constexpr EnumTable<CameraProjection, 5> NamesOf(CameraProjection /*type*/) {
    return {
        {{CameraProjection::Film, "Film", "film"},
         {CameraProjection::FisheyeEquidistant, "FisheyeEquidistant", "fisheyeEquidistant"},
         {CameraProjection::FisheyeEquisolid, "FisheyeEquisolid", "fisheyeEquisolid"},
         {CameraProjection::FisheyeStereographic, "FisheyeStereographic", "fisheyeStereographic"},
         {CameraProjection::Latlong, "Latlong", "latlong"}}};
}

struct CameraLens {
    CameraProjection projection = CameraProjection::Film;
    float fieldOfView = 180.0F; ///< fisheye: degrees across the image's shorter side
    std::array<float, 2> longitudes{-180.0F, 180.0F}; ///< latlong: degrees, left and right border
    std::array<float, 2> latitudes{-90.0F, 90.0F};    ///< degrees, lower and upper border
    std::int32_t apertureBlades = 0;                  ///< corners of the aperture; below 3: round
    float apertureRotation = 0.0F;                    ///< degrees, from the camera's x to its y
    float apertureRoundness = 0.0F;                   ///< 0: straight blades, 1: a disk
    float apertureRatio = 1.0F; ///< height over width of the aperture: 2 is anamorphic
    float vignetting = 0.0F;    ///< how much the fourth power of the cosine counts, 0 to 1

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(CameraLens, projection), HDS_FIELD(CameraLens, fieldOfView),
                         HDS_FIELD(CameraLens, longitudes), HDS_FIELD(CameraLens, latitudes),
                         HDS_FIELD(CameraLens, apertureBlades),
                         HDS_FIELD(CameraLens, apertureRotation),
                         HDS_FIELD(CameraLens, apertureRoundness),
                         HDS_FIELD(CameraLens, apertureRatio), HDS_FIELD(CameraLens, vignetting));
    }
};

/// Whether the aperture has corners.
inline bool HasBlades(const CameraLens& lens) {
    return lens.apertureBlades >= 3 && lens.apertureRoundness < 1.0F;
}

/// The lens and the film at a time, in frames from the frame; values as CameraPrim's.
struct LensSample {
    double time = 0.0;
    float focalLength = 5.0F;
    float fStop = 0.0F;
    float focusDistance = 0.0F;
    float horizontalAperture = 2.0955F;
    float verticalAperture = 1.52908F;
    float horizontalApertureOffset = 0.0F;
    float verticalApertureOffset = 0.0F;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LensSample, time), HDS_FIELD(LensSample, focalLength),
                         HDS_FIELD(LensSample, fStop), HDS_FIELD(LensSample, focusDistance),
                         HDS_FIELD(LensSample, horizontalAperture),
                         HDS_FIELD(LensSample, verticalAperture),
                         HDS_FIELD(LensSample, horizontalApertureOffset),
                         HDS_FIELD(LensSample, verticalApertureOffset));
    }
};

} // namespace hds
