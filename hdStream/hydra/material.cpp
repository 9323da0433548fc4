// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/material.h"

#include "hdStream/hydra/materialContexts.h"
#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/base/tf/error.h>
#include <pxr/base/tf/errorMark.h>
#include <pxr/base/tf/stringUtils.h>
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

/// The surface shader, behind ND_surfacematerial or not; null: there is none.
const hds::MaterialNode* FindSurface(const hds::MaterialNetwork& network) {
    const auto terminal = network.terminals.find("surface");
    const hds::MaterialNode* node = terminal == network.terminals.end()
                                        ? nullptr
                                        : FindNode(network, terminal->second.upstreamPath);
    if (node != nullptr && TfStringStartsWith(node->identifier, "ND_surfacematerial")) {
        const auto shader = node->connections.find("surfaceshader");
        node = shader == node->connections.end() ? nullptr
                                                 : FindNode(network, shader->second.upstreamPath);
    }
    return node;
}

bool HasDrawnSurface(const hds::MaterialNetwork& network) {
    const hds::MaterialNode* surface = FindSurface(network);
    return surface != nullptr && hds::IsSurfaceShader(surface->identifier);
}

/// Adds what a terminal hangs on. What displaces, or fills, stays that of the best context that has
/// such a terminal.
void TakeTerminal(const std::string& name, const hds::MaterialNetwork& from,
                  hds::MaterialNetwork* network) {
    const auto terminal = from.terminals.find(name);
    if (terminal == from.terminals.end()) {
        return;
    }
    network->terminals[name] = terminal->second;
    std::vector<std::string> pending{terminal->second.upstreamPath};
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

/// A material's network: that of the best context whose surface is drawn, else of the best. As the
/// command line's, so that both front ends draw the same.
hds::MaterialNetwork BestNetwork(HdSceneDelegate* delegate, const SdfPath& id,
                                 const SdfPath& scenePath, HdStreamRenderParam* param) {
    hds::MaterialNetwork best = NetworkOf(delegate, id, scenePath);
    const bool isVolume =
        best.terminals.count("surface") == 0 && best.terminals.count("volume") != 0;
    if (HasDrawnSurface(best) || isVolume) {
        return best;
    }
    const std::size_t numContexts = HdStreamMaterialContexts().size();
    for (std::size_t numSkipped = 1; numSkipped < numContexts; ++numSkipped) {
        const HdStreamLaterMaterialContexts later(numSkipped);
        hds::MaterialNetwork other = NetworkOf(delegate, id, scenePath);
        if (HasDrawnSurface(other)) {
            // UsdImaging may have dropped a surface that OpenUSD does not know, and told its id.
            const hds::MaterialNode* surface = FindSurface(best);
            const std::string what = surface == nullptr            ? "that OpenUSD does not know"
                                     : surface->identifier.empty() ? "without an id"
                                                                   : surface->identifier;
            param->Warn(scenePath, "surface shader " + what + " is not supported; " +
                                       FindSurface(other)->identifier + " is used");
            TakeTerminal("displacement", best, &other);
            TakeTerminal("volume", best, &other);
            return other;
        }
    }
    return best;
}

} // namespace

HdStreamMaterial::HdStreamMaterial(const SdfPath& id) : HdMaterial(id) {}

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
        param->Push([path = _scenePath, network](hds::Session& session) {
            session.SetMaterial(path, network);
        });
    }
    *dirtyBits = Clean;
}

void HdStreamMaterial::Finalize(HdRenderParam* renderParam) {
    if (!_scenePath.empty()) {
        static_cast<HdStreamRenderParam*>(renderParam)
            ->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
