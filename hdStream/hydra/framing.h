// SPDX-License-Identifier: Apache-2.0
// The framing of a render pass as settings: which pixels are rendered, and how the camera's
// aperture is fitted to them.
#pragma once

#include "hdStream/session/settings.h"

#include <pxr/base/gf/rect2i.h>
#include <pxr/base/gf/vec2i.h>
#include <pxr/imaging/cameraUtil/conformWindow.h>
#include <pxr/imaging/cameraUtil/framing.h>
#include <pxr/imaging/hd/renderPassState.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The framing of a pass; of applications that set a viewport only, that viewport.
CameraUtilFraming HdStreamFramingOf(const HdRenderPassState& state);

/// Sets image size, data window, display window and pixel aspect ratio; and, of a data window that
/// is only a part of what the pass's buffers cover, all of that: surfaces are diced alike in parts.
void HdStreamApplyFraming(const CameraUtilFraming& framing, const GfVec2i& bufferSize,
                          hds::Settings* settings);

/// The name of the core's conform policy that does what a window policy does.
std::string HdStreamConformPolicy(CameraUtilConformWindowPolicy policy);

PXR_NAMESPACE_CLOSE_SCOPE
