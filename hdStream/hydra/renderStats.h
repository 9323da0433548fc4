// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStream/session/renderThread.h"

#include <pxr/base/vt/dictionary.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// The statistics of an image (the keys of docs/statistics.md) with those that Hydra's hosts look
/// for: percentDone, numCompletedSamples, totalClockTime (seconds), renderProgressAnnotation.
/// \param image may be null: nothing is rendered yet
VtDictionary HdStreamRenderStats(const hds::FilmImage* image);

PXR_NAMESPACE_CLOSE_SCOPE
