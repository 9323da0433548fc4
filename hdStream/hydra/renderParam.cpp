// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderParam.h"

#include "hdStream/hydra/scenePaths.h"
#include "hdStream/session/warningDigest.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/getenv.h>

#include <algorithm>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// More lines than this help nobody; all of them are in the statistics.
constexpr unsigned int kMaxWarningsPrinted = 100;

} // namespace

HdStreamRenderParam::HdStreamRenderParam()
    : _thread([this](const std::string& line) { _warnings.push(line); }) {}

HdStreamRenderParam::~HdStreamRenderParam() {
    PrintWarnings();
}

void HdStreamRenderParam::Push(hds::RenderThread::Edit edit) {
    _edits.push(std::move(edit));
}

void HdStreamRenderParam::Commit() {
    std::vector<hds::RenderThread::Edit> edits;
    hds::RenderThread::Edit edit;
    while (_edits.try_pop(edit)) {
        edits.push_back(std::move(edit));
    }
    if (!edits.empty()) {
        _thread.Post(std::move(edits));
    }
}

void HdStreamRenderParam::Warn(const SdfPath& prim, const std::string& text) {
    Push([path = prim.GetString(), text](hds::Session& session) { session.Warn(path, text); });
}

void HdStreamRenderParam::PrintWarnings() {
    static const bool isVerbose = TfGetenvBool("HDSTREAM_VERBOSE", false);
    std::vector<std::string> lines;
    for (std::string line; _warnings.try_pop(line);) {
        lines.push_back(std::move(line));
    }
    if (!isVerbose) {
        lines = hds::DigestWarnings(std::move(lines));
    }
    for (const std::string& line : lines) {
        ++_numWarningsPrinted;
        if (isVerbose || _numWarningsPrinted <= kMaxWarningsPrinted) {
            PrintWarning(line);
        } else if (_numWarningsPrinted == kMaxWarningsPrinted + 1) {
            PrintWarning("Stream: more warnings are in the render statistics only");
        }
    }
}

void HdStreamRenderParam::PrintWarning(const std::string& line) {
    {
        const std::lock_guard<std::mutex> lock(_printedMutex);
        if (std::find(_printedWarnings.begin(), _printedWarnings.end(), line) ==
            _printedWarnings.end()) {
            _printedWarnings.push_back(line);
        }
    }
    TF_WARN("%s", line.c_str());
}

std::vector<std::string> HdStreamRenderParam::PrintedWarnings() const {
    const std::lock_guard<std::mutex> lock(_printedMutex);
    return _printedWarnings;
}

std::string HdStreamRenderParam::ReservePath(const std::string& wanted, const SdfPath& id) {
    if (_idByScenePath.insert({wanted, id})) {
        return wanted;
    }
    std::string path = wanted + "{" + id.GetString() + "}";
    _idByScenePath.insert({path, id});
    return path;
}

void HdStreamRenderParam::ReleasePath(const std::string& path) {
    _idByScenePath.erase(path);
}

std::string HdStreamRenderParam::MaterialPath(HdSceneDelegate* delegate, const SdfPath& id) {
    if (id.IsEmpty()) {
        return {};
    }
    decltype(_materialPathById)::const_accessor known;
    if (_materialPathById.find(known, id.GetString())) {
        return known->second;
    }
    const std::string wanted = HdStreamMaterialScenePath(delegate, id);
    decltype(_materialPathById)::accessor added;
    if (_materialPathById.insert(added, id.GetString())) {
        added->second = ReservePath(wanted, id);
    }
    return added->second;
}

void HdStreamRenderParam::SetShutter(const SdfPath& camera, const hds::Shutter& shutter) {
    const std::lock_guard<std::mutex> lock(_shutterMutex);
    if (shutter.IsOpen()) {
        _shutters[camera] = shutter;
    } else {
        _shutters.erase(camera);
    }
}

hds::Shutter HdStreamRenderParam::Shutter() const {
    const std::lock_guard<std::mutex> lock(_shutterMutex);
    hds::Shutter all;
    for (const auto& [path, shutter] : _shutters) {
        const bool isFirst = !all.IsOpen();
        all.open = isFirst ? shutter.open : std::min(all.open, shutter.open);
        all.close = isFirst ? shutter.close : std::max(all.close, shutter.close);
    }
    return all;
}

void HdStreamRenderParam::SetSceneSettings(const SdfPath& owner, const VtDictionary& settings) {
    if (_sceneSettingsOwner == owner && _sceneSettings == settings) {
        return;
    }
    _sceneSettingsOwner = owner;
    _sceneSettings = settings;
    ++_sceneSettingsVersion;
}

void HdStreamRenderParam::ClearSceneSettings(const SdfPath& owner) {
    if (_sceneSettingsOwner == owner) {
        SetSceneSettings(SdfPath(), VtDictionary());
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
