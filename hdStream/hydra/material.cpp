// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/material.h"

#include "hdStream/hydra/materialContexts.h"
#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/base/tf/error.h>
#include <pxr/base/tf/errorMark.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// What a scene delegate has for a material. OpenUSD 25.02 cannot convert the configuration of
/// MaterialX that comes with networks of scene delegates, a dictionary within a dictionary, and
/// posts an error for each. Nothing here reads it: these errors are taken back, and all others are
/// left.
VtValue ResourceOf(HdSceneDelegate* delegate, const SdfPath& id) {
    TfErrorMark errors;
    VtValue network = delegate->GetMaterialResource(id);
    const bool areKnown = std::all_of(errors.begin(), errors.end(), [](const TfError& error) {
        return error.GetCommentary() == "Unsupported type VtDictionary";
    });
    if (areKnown) {
        errors.Clear();
    }
    return network;
}

/// A material's network in the first of this thread's contexts that it has.
hds::MaterialNetwork NetworkOf(HdSceneDelegate* delegate, const SdfPath& id,
                               const SdfPath& scenePath) {
    const VtValue resource = ResourceOf(delegate, id);
    return resource.IsHolding<HdMaterialNetworkMap>()
               ? HdStreamMaterialNetworkFrom(scenePath, id,
                                             resource.UncheckedGet<HdMaterialNetworkMap>())
               : hds::MaterialNetwork();
}

const hds::MaterialNode* FindNode(const hds::MaterialNetwork& network, const std::string& path) {
    const auto found =
        std::find_if(network.nodes.begin(), network.nodes.end(),
                     [&](const hds::MaterialNode& node) { return node.path == path; });
    return found == network.nodes.end() ? nullptr : &*found;
}

bool HasDrawnSurface(const hds::MaterialNetwork& network) {
    const hds::MaterialNode* surface = hds::FindTerminalShader(network, "surface");
    return surface != nullptr && hds::IsSurfaceShader(surface->identifier);
}

/// Adds what a terminal hangs on, in the place of the network's own.
void TakeTerminal(const std::string& name, const hds::MaterialNetwork& from,
                  hds::MaterialNetwork* network) {
    const hds::MaterialNode::Connection& terminal = from.terminals.at(name);
    network->terminals[name] = terminal;
    std::vector<std::string> pending{terminal.upstreamPath};
    while (!pending.empty()) {
        const hds::MaterialNode* node = FindNode(from, pending.back());
        pending.pop_back();
        if (node == nullptr || FindNode(*network, node->path) != nullptr) {
            continue;
        }
        network->nodes.push_back(*node);
        for (const auto& [input, connection] : node->connections) {
            pending.push_back(connection.upstreamPath);
        }
    }
}

/// The first of the networks that has a terminal; null: none has.
const hds::MaterialNetwork* FindTerminal(const std::string& name,
                                         const std::vector<hds::MaterialNetwork>& networks) {
    const auto found =
        std::find_if(networks.begin(), networks.end(), [&](const hds::MaterialNetwork& one) {
            return one.terminals.count(name) != 0;
        });
    return found == networks.end() ? nullptr : &*found;
}

/// A material's network. The surface is that of the best context in which it is drawn, else of the
/// best that has one; what displaces, or fills, is that of the best context that has it. As on the
/// command line, so that both front ends draw the same; but contexts after that of the surface are
/// not asked for.
hds::MaterialNetwork BestNetwork(HdSceneDelegate* delegate, const SdfPath& id,
                                 const SdfPath& scenePath, HdStreamRenderParam* param) {
    std::vector<hds::MaterialNetwork> passed{NetworkOf(delegate, id, scenePath)};
    const bool isVolume =
        passed[0].terminals.count("surface") == 0 && passed[0].terminals.count("volume") != 0;
    if (HasDrawnSurface(passed[0]) || isVolume) {
        return std::move(passed[0]);
    }
    hds::MaterialNetwork result = passed[0];
    const std::size_t numContexts = HdStreamMaterialContexts().size();
    for (std::size_t numSkipped = 1; numSkipped < numContexts; ++numSkipped) {
        const HdStreamLaterMaterialContexts later(numSkipped);
        passed.push_back(NetworkOf(delegate, id, scenePath));
        if (HasDrawnSurface(passed.back())) {
            result = passed.back();
            break;
        }
    }
    // Where UsdImaging has dropped a surface that OpenUSD does not know there is no terminal: it
    // has told the id, and here the material looks like one that has no surface there.
    const hds::MaterialNetwork* best = FindTerminal("surface", passed);
    const hds::MaterialNode* surface = hds::FindTerminalShader(result, "surface");
    if (best != nullptr && !HasDrawnSurface(*best) && HasDrawnSurface(result)) {
        const hds::MaterialNode* other = hds::FindTerminalShader(*best, "surface");
        const bool hasId = other != nullptr && !other->identifier.empty();
        param->Warn(scenePath, "surface shader " + (hasId ? other->identifier : "without an id") +
                                   " is not supported; " + surface->identifier + " is used");
    }
    for (const char* name : {"surface", "displacement", "volume"}) {
        const bool isSurface = name == std::string("surface");
        const hds::MaterialNetwork* from = FindTerminal(name, passed);
        if (from != nullptr && !(isSurface && result.terminals.count(name) != 0)) {
            TakeTerminal(name, *from, &result);
        }
    }
    return result;
}

} // namespace

HdStreamMaterial::HdStreamMaterial(const SdfPath& id, HdStreamMaterialFrames* frames)
    : HdMaterial(id), _frames(*frames) {}

HdDirtyBits HdStreamMaterial::GetInitialDirtyBitsMask() const {
    return AllDirty;
}

void HdStreamMaterial::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                            HdDirtyBits* dirtyBits) {
    if (*dirtyBits & AllDirty) {
        auto* param = static_cast<HdStreamRenderParam*>(renderParam);
        if (_scenePath.empty()) {
            _scenePath = param->MaterialPath(delegate, GetId());
        }
        auto network = std::make_shared<hds::MaterialNetwork>(
            BestNetwork(delegate, GetId(), SdfPath(_scenePath), param));
        HdStreamFixMaterial(param->Exporter(), network.get());
        _frames.Tell(_scenePath, delegate->GetRenderIndex().GetTerminalSceneIndex(), network.get());
        param->Push([path = _scenePath, network](hds::Session& session) {
            session.SetMaterial(path, network);
        });
    }
    *dirtyBits = Clean;
}

void HdStreamMaterial::Finalize(HdRenderParam* renderParam) {
    if (!_scenePath.empty()) {
        _frames.Remove(_scenePath);
        static_cast<HdStreamRenderParam*>(renderParam)
            ->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
