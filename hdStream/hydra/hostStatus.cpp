// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/hostStatus.h"

#include <pxr/base/js/json.h>
#include <pxr/base/js/value.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Held while a delegate is asked, so that none goes meanwhile.
std::mutex registryMutex;

std::map<std::string, HdStreamRenderParam*>& Registry() {
    static std::map<std::string, HdStreamRenderParam*> registry;
    return registry;
}

std::string TextOf(HdStreamRenderParam& param) {
    const std::shared_ptr<const hds::RenderStatus> status = param.Thread().Status();
    const bool isDone = param.Thread().IsConverged();
    const hds::RenderStatus none;
    const hds::RenderStatus& shown = status ? *status : none;
    JsArray warnings;
    for (std::string& line : param.PrintedWarnings()) {
        warnings.emplace_back(std::move(line));
    }
    JsObject object;
    object["isDone"] = JsValue(isDone);
    object["error"] = JsValue(shown.error);
    object["samplesDone"] = JsValue(std::uint64_t{shown.progress.samplesDone});
    object["samplesTotal"] = JsValue(std::uint64_t{shown.progress.samplesTotal});
    object["fraction"] = JsValue(shown.isFinal ? 1.0 : shown.progress.fraction);
    object["secondsElapsed"] = JsValue(shown.progress.secondsElapsed);
    object["warnings"] = JsValue(std::move(warnings));
    std::string text = JsWriteToString(JsValue(std::move(object)));
    // The statistics are JSON text already: put in before the last brace.
    text.resize(text.rfind('}'));
    return text + ",\"statistics\":" + (shown.statistics.empty() ? "null" : shown.statistics) + "}";
}

} // namespace

void HdStreamHostStatus::SetName(const std::string& name) {
    const std::lock_guard<std::mutex> lock(registryMutex);
    const auto found = Registry().find(_name);
    if (found != Registry().end() && found->second == _param) {
        Registry().erase(found);
    }
    _name = name;
    if (!_name.empty()) {
        Registry()[_name] = _param;
    }
}

PXR_NAMESPACE_CLOSE_SCOPE

std::size_t hdStreamStatus(const char* name, char* text, std::size_t capacity) {
    PXR_NAMESPACE_USING_DIRECTIVE
    const std::lock_guard<std::mutex> lock(registryMutex);
    const auto found = Registry().find(name);
    if (found == Registry().end()) {
        return 0;
    }
    const std::string status = TextOf(*found->second);
    if (status.size() < capacity) {
        std::memcpy(text, status.c_str(), status.size() + 1);
    }
    return status.size() + 1;
}
