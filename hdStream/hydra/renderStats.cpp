// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderStats.h"

#include <pxr/base/js/converter.h>
#include <pxr/base/js/json.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/tokens.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

std::string AnnotationOf(const hds::RenderStatus& status) {
    if (!status.error.empty()) {
        return status.error;
    }
    if (status.isFinal) {
        return "done";
    }
    const hds::Progress& progress = status.progress;
    return progress.fraction == 0.0
               ? std::string("preparing the scene")
               : TfStringPrintf("sample %u of %u", progress.samplesDone, progress.samplesTotal);
}

} // namespace

VtDictionary HdStreamRenderStats(const hds::RenderStatus* status) {
    VtDictionary stats;
    if (!status) {
        return stats;
    }
    if (!status->statistics.empty()) {
        const VtValue parsed =
            JsConvertToContainerType<VtValue, VtDictionary>(JsParseString(status->statistics));
        stats = parsed.GetWithDefault(VtDictionary());
    }
    const hds::Progress& progress = status->progress;
    stats["percentDone"] = status->isFinal ? 100.0 : 100.0 * progress.fraction;
    stats[HdPerfTokens->numCompletedSamples.GetString()] = static_cast<int>(progress.samplesDone);
    stats["totalClockTime"] = progress.secondsElapsed;
    stats["renderProgressAnnotation"] = AnnotationOf(*status);
    return stats;
}

PXR_NAMESPACE_CLOSE_SCOPE
