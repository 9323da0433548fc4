// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/udimSets.h"

#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/ar/resolver.h>
#include <pxr/usd/sdf/assetPath.h>
#include <pxr/usd/sdf/layer.h>
#include <pxr/usd/sdf/layerUtils.h>
#include <pxr/usd/sdf/schema.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr const char* kToken = "<UDIM>";
constexpr int kFirstTile = 1001;
constexpr int kLastTile = 1100;

/// The sets that each loaded layer authors. Locked by whoever uses it.
class AuthoredSets {
public:
    /// Layers that author a set, in the order of their identifiers.
    std::vector<SdfLayerHandle> Find(const std::string& authored) {
        std::vector<SdfLayerHandle> found = FindKnown(authored);
        if (found.empty()) { // layers that came or were edited since
            Read();
            found = FindKnown(authored);
        }
        return found;
    }

private:
    std::vector<SdfLayerHandle> FindKnown(const std::string& authored) const {
        std::vector<SdfLayerHandle> found;
        for (const auto& [identifier, sets] : _setsOf) {
            if (sets.count(authored) != 0) {
                if (const SdfLayerHandle layer = SdfLayer::Find(identifier)) {
                    found.push_back(layer);
                }
            }
        }
        return found;
    }

    void Read() {
        _setsOf.clear();
        for (const SdfLayerHandle& layer : SdfLayer::GetLoadedLayers()) {
            if (!layer) {
                continue;
            }
            std::set<std::string> sets;
            layer->Traverse(SdfPath::AbsoluteRootPath(), [&](const SdfPath& path) {
                VtValue value;
                if (path.IsPropertyPath() && layer->HasField(path, SdfFieldKeys->Default, &value) &&
                    value.IsHolding<SdfAssetPath>() &&
                    HdStreamIsUdimSet(value.UncheckedGet<SdfAssetPath>().GetAssetPath())) {
                    sets.insert(value.UncheckedGet<SdfAssetPath>().GetAssetPath());
                }
            });
            if (!sets.empty()) {
                _setsOf[layer->GetIdentifier()] = std::move(sets);
            }
        }
    }

    std::map<std::string, std::set<std::string>> _setsOf; ///< by the layer's identifier
};

/// The resolved path of the first tile that there is, with the token in the place of its number.
std::string ResolveFrom(const SdfLayerHandle& layer, const std::string& authored) {
    const std::size_t at = authored.find(kToken);
    const std::string after = authored.substr(at + std::string(kToken).size());
    for (int tile = kFirstTile; tile <= kLastTile; ++tile) {
        const std::string number = std::to_string(tile);
        const std::string anchored =
            SdfComputeAssetPathRelativeToLayer(layer, authored.substr(0, at) + number + after);
        std::string resolved = ArGetResolver().Resolve(anchored).GetPathString();
        const std::size_t place = resolved.rfind(number + after);
        if (!resolved.empty() && place != std::string::npos) {
            return resolved.replace(place, number.size(), kToken);
        }
    }
    return {};
}

} // namespace

bool HdStreamIsUdimSet(const std::string& path) {
    return path.find(kToken) != std::string::npos;
}

std::string HdStreamResolveUdimSet(const std::string& authored) {
    static std::mutex mutex;
    static AuthoredSets sets;
    const std::lock_guard<std::mutex> lock(mutex);
    for (const SdfLayerHandle& layer : sets.Find(authored)) {
        std::string resolved = ResolveFrom(layer, authored);
        if (!resolved.empty()) {
            return resolved;
        }
    }
    return {};
}

PXR_NAMESPACE_CLOSE_SCOPE
