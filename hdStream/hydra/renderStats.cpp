// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderStats.h"

#include <pxr/base/js/converter.h>
#include <pxr/base/js/json.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/tokens.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

std::string AnnotationOf(const hds::FilmImage& image) {
    if (!image.error.empty()) {
        return image.error;
    }
    if (image.isFinal) {
        return "done";
    }
    const hds::Progress& progress = image.progress;
    return progress.previewStride == 0
               ? std::string("preparing the scene")
               : TfStringPrintf("sample %u of %u", progress.samplesDone, progress.samplesTotal);
}

} // namespace

VtDictionary HdStreamRenderStats(const hds::FilmImage* image) {
    VtDictionary stats;
    if (!image) {
        return stats;
    }
    if (!image->statistics.empty()) {
        const VtValue parsed =
            JsConvertToContainerType<VtValue, VtDictionary>(JsParseString(image->statistics));
        stats = parsed.GetWithDefault(VtDictionary());
    }
    const hds::Progress& progress = image->progress;
    stats["percentDone"] = image->isFinal ? 100.0 : 100.0 * progress.fraction;
    stats[HdPerfTokens->numCompletedSamples.GetString()] = static_cast<int>(progress.samplesDone);
    stats["totalClockTime"] = progress.secondsElapsed;
    stats["renderProgressAnnotation"] = AnnotationOf(*image);
    return stats;
}

PXR_NAMESPACE_CLOSE_SCOPE
