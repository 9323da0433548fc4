// SPDX-License-Identifier: Apache-2.0
// UsdLux lights as light descriptions: values as they are, UsdLux's fallbacks, nothing folded in.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/pxr.h>

#include <memory>
#include <optional>
#include <set>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// A parameter of a light under Hydra's name, else under the attribute's, which begins with
/// "inputs:": some scene delegates (Blender's) know a few parameters by the latter alone. Empty:
/// there is none. All reading of light parameters goes through here.
VtValue HdStreamGetLightParameter(HdSceneDelegate* delegate, const SdfPath& id,
                                  const TfToken& name);

/// The parameter, a bool, by which a render pass hides a light from the camera.
extern const TfToken kHdStreamLightSeenByCamera;

/// The core's type of a light prim; none for types it does not render. "simpleLight" is the
/// application's camera light, which has the values of a distant light.
std::optional<hds::LightType> HdStreamFindLightType(const TfToken& typeId);

/// The description of a light. Thread-safe during Sync.
hds::LightDescription HdStreamReadLight(HdSceneDelegate* delegate, const SdfPath& id,
                                        const TfToken& typeId, hds::LightType type);

/// Whether the scene switches the colour temperature of a light on or off, and leaves the
/// temperature itself at UsdLux's fallback. False where the delegate does not tell what the scene
/// says.
bool HdStreamLeavesTemperatureOut(HdSceneDelegate* delegate, const SdfPath& id);

/// What of a light changes while the shutter is open; empty when the scene does not tell of a
/// change. \param light of the frame. Thread-safe during Sync.
std::vector<hds::LightSample> HdStreamSampleLight(HdSceneDelegate* delegate, const SdfPath& id,
                                                  const hds::LightDescription& light,
                                                  const hds::Shutter& shutter);

/// The categories that a light is linked to.
hds::LinkCategories HdStreamReadLinks(HdSceneDelegate* delegate, const SdfPath& id);

/// What makes a mesh a light; null: it is none.
std::shared_ptr<const hds::MeshLight> HdStreamReadMeshLight(HdSceneDelegate* delegate,
                                                            const SdfPath& id);

/// Says of a prim without faces that it is no light, where the scene says that it is.
void HdStreamWarnOfNoLight(HdSceneDelegate* delegate, const SdfPath& id,
                           const std::string& scenePath, HdStreamRenderParam* param);

/// The prims that filter a light.
SdfPathVector HdStreamFiltersOf(HdSceneDelegate* delegate, const SdfPath& id);

/// The same with their kinds and inputs. \param[out] problems of those that cannot be read
std::vector<hds::LightFilter> HdStreamReadFilters(HdSceneDelegate* delegate, const SdfPath& id,
                                                  std::vector<std::string>* problems);

/// Names of features of a light that the core does not have yet.
std::set<std::string> HdStreamUnsupportedLightFeatures(HdSceneDelegate* delegate,
                                                       const SdfPath& id);

/// Whether a mesh light is linked to a part of the scene alone and Hydra does not say to which
/// (OpenUSD 24.11 does not), as far as it lets that be seen.
bool HdStreamHidesLinks(HdSceneDelegate* delegate, const SdfPath& id);

PXR_NAMESPACE_CLOSE_SCOPE
