// SPDX-License-Identifier: Apache-2.0
// What Hydra knows of prims around the frame, as the core's samples (docs/motionBlur.md).
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/gf/rotation.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/sceneDelegate.h>
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

/// A primvar when the shutter opens and when it closes; empty when it does not change.
std::vector<VtValue> HdStreamSamplePrimvar(HdSceneDelegate* delegate, const SdfPath& id,
                                           const TfToken& name, const hds::Shutter& shutter);

/// Points at the same times, from their velocities and accelerations at the frame; empty where
/// there are none. OpenUSD's scene index does so for points of several samples only.
std::vector<VtValue> HdStreamMoveByVelocities(HdSceneDelegate* delegate, const SdfPath& id,
                                              const VtValue& points, const hds::Shutter& shutter);

/// How far instances have turned since the frame at the same times, by their angular velocities;
/// empty where there are none.
std::vector<VtArray<GfRotation>> HdStreamTurnByVelocities(HdSceneDelegate* delegate,
                                                          const SdfPath& id, std::size_t count,
                                                          const hds::Shutter& shutter);

/// Points, authored or computed, at the same times; empty when they do not move.
std::vector<hds::PointSample> HdStreamSamplePoints(HdSceneDelegate* delegate, const SdfPath& id,
                                                   const hds::Shutter& shutter);

bool HdStreamEqual(const std::vector<hds::PointSample>& a, const std::vector<hds::PointSample>& b);
bool HdStreamEqual(const std::vector<hds::TransformSample>& a,
                   const std::vector<hds::TransformSample>& b);

PXR_NAMESPACE_CLOSE_SCOPE
