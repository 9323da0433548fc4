// SPDX-License-Identifier: Apache-2.0
// What Hydra knows of prims around the frame, as the core's samples (docs/motionBlur.md).
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/gf/rotation.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/timeSampleArray.h>
#include <pxr/pxr.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// The transform of a prim, or of an instancer, while the shutter is open; empty when it does not
/// change.
std::vector<hds::TransformSample>
HdStreamSampleTransform(HdSceneDelegate* delegate, const SdfPath& id, const hds::Shutter& shutter);
std::vector<hds::TransformSample> HdStreamSampleInstancerTransform(HdSceneDelegate* delegate,
                                                                   const SdfPath& id,
                                                                   const hds::Shutter& shutter);

/// A value while the shutter is open: when it opens, when it closes, and where there are samples in
/// between.
struct HdStreamMovingValue {
    std::vector<double> times; ///< empty: it does not change
    HdTimeSampleArray<VtValue, 4> samples;
    bool fits = true; ///< false: arrays of different lengths

    bool Moves() const { return !times.empty(); }
    VtValue At(double time) const { return samples.Resample(static_cast<float>(time)); }
};

HdStreamMovingValue HdStreamSamplePrimvar(HdSceneDelegate* delegate, const SdfPath& id,
                                          const TfToken& name, const hds::Shutter& shutter);

/// Points by their velocities and accelerations at the frame. OpenUSD's scene index does so for
/// points of several samples only. What velocities take from somewhere finite to nowhere finite
/// stands still. \param[out] isFinite false: there is such; else it is left as it is.
HdStreamMovingValue HdStreamMoveByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                             const VtValue& points, const hds::Shutter& shutter,
                                             bool* isFinite);

/// How far instances turn by their angular velocities, from the frame on.
struct HdStreamTurn {
    std::vector<double> times; ///< empty: they do not
    VtVec3fArray degreesPerSecond;
    double timeCodesPerSecond = 24.0;

    VtArray<GfRotation> At(double time) const; ///< empty where they do not turn
};
HdStreamTurn HdStreamTurnByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                      std::size_t count, const hds::Shutter& shutter);

/// Points, authored or computed; empty when they do not move. \param name of the primvar.
/// \param[out] fit false: they change in number, and are taken to be at rest. \param[out] isFinite
/// false: velocities are not, and points that have these stand still.
std::vector<hds::PointSample> HdStreamSamplePoints(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const TfToken& name, const hds::Shutter& shutter,
                                                   bool* fit, bool* isFinite);

/// The primvars "widths" and "normals"; empty when they do not change.
std::vector<hds::FloatSample> HdStreamSampleWidths(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const hds::Shutter& shutter);
std::vector<hds::PointSample> HdStreamSampleNormals(HdSceneDelegate* delegate, const SdfPath& id,
                                                    const hds::Shutter& shutter);

/// The shapes of Gaussian splats; what does not change has no samples.
hds::SplatSamples HdStreamSampleShapes(HdSceneDelegate* delegate, const SdfPath& id,
                                       const hds::GeometryDescription& splats,
                                       const hds::Shutter& shutter);

bool HdStreamEqual(const std::vector<hds::PointSample>& a, const std::vector<hds::PointSample>& b);
bool HdStreamEqual(const std::vector<hds::FloatSample>& a, const std::vector<hds::FloatSample>& b);
bool HdStreamEqual(const std::vector<hds::TransformSample>& a,
                   const std::vector<hds::TransformSample>& b);

PXR_NAMESPACE_CLOSE_SCOPE
