// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/materialFrames.h"

#include "hdStream/session/hostFrame.h"

#include <pxr/imaging/hd/utils.h>

#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// As the scene's globals say; nothing: they do not.
std::optional<double> CurrentFrame(const HdSceneIndexBaseRefPtr& scene) {
    double frame = 0.0;
    return HdUtils::GetCurrentFrame(scene, &frame) ? std::optional<double>(frame) : std::nullopt;
}

} // namespace

void HdStreamMaterialFrames::Tell(const std::string& scenePath, const HdSceneIndexBaseRefPtr& scene,
                                  hds::MaterialNetwork* network) {
    const std::optional<double> frame = CurrentFrame(scene);
    const bool asks = hds::TellFrame(frame, network);
    const std::lock_guard<std::mutex> lock(_mutex);
    if (asks) {
        _asking[scenePath] = {scene, frame, std::make_shared<const hds::MaterialNetwork>(*network)};
    } else {
        _asking.erase(scenePath);
    }
}

void HdStreamMaterialFrames::Remove(const std::string& scenePath) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _asking.erase(scenePath);
}

std::vector<HdStreamMaterialFrames::Edit> HdStreamMaterialFrames::Update() {
    std::vector<Edit> edits;
    const std::lock_guard<std::mutex> lock(_mutex);
    for (auto& [scenePath, asking] : _asking) {
        const std::optional<double> frame = CurrentFrame(asking.scene);
        if (frame == asking.frame) {
            continue;
        }
        auto next = std::make_shared<hds::MaterialNetwork>(*asking.network);
        hds::TellFrame(frame, next.get());
        asking.frame = frame;
        asking.network = next;
        edits.push_back({scenePath, std::move(next)});
    }
    return edits;
}

PXR_NAMESPACE_CLOSE_SCOPE
