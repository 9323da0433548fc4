// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStream/session/renderThread.h"

#include <pxr/base/vt/dictionary.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// The statistics of a render (the keys of docs/statistics.md) with those that Hydra's hosts look
/// for: percentDone, numCompletedSamples, totalClockTime (seconds), renderProgressAnnotation.
/// \param status may be null: nothing is rendered yet
VtDictionary HdStreamRenderStats(const hds::RenderStatus* status);

PXR_NAMESPACE_CLOSE_SCOPE
