// SPDX-License-Identifier: Apache-2.0
// Materials whose nodes ask for the frame. Hydra marks nothing when the frame alone changes, so
// they are looked through whenever the application has synced its scene.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/pxr.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Thread-safe.
class HdStreamMaterialFrames {
public:
    /// A material with the network of another frame.
    struct Edit {
        std::string scenePath;
        std::shared_ptr<const hds::MaterialNetwork> network;
    };

    /// Tells a material's network the frame of the scene, and notes it where it asks for one.
    /// \param scene may be null.
    void Tell(const std::string& scenePath, const HdSceneIndexBaseRefPtr& scene,
              hds::MaterialNetwork* network);
    void Remove(const std::string& scenePath);

    /// The materials that were told another frame than their scene is at now.
    std::vector<Edit> Update();

private:
    struct Asking {
        HdSceneIndexBasePtr scene;
        std::optional<double> frame;
        std::shared_ptr<const hds::MaterialNetwork> network;
    };

    std::mutex _mutex;
    std::map<std::string, Asking> _asking; ///< by scene path
};

PXR_NAMESPACE_CLOSE_SCOPE
