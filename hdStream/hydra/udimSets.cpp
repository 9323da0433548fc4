// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/udimSets.h"

#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/ar/resolver.h>
#include <pxr/usd/sdf/assetPath.h>
#include <pxr/usd/sdf/layerUtils.h>
#include <pxr/usd/sdf/schema.h>
#include <pxr/usd/sdf/types.h>

#include <algorithm>
#include <iterator>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr const char* kToken = "<UDIM>";
constexpr const char* kArnoldToken = "<udim>"; // which Arnold knows as well
constexpr int kFirstTile = 1001;
constexpr int kLastTile = 1100;

/// Where a path has the token; npos: nowhere.
std::size_t FindToken(const std::string& path) {
    const std::size_t at = path.find(kToken);
    return at == std::string::npos ? path.find(kArnoldToken) : at;
}

/// The sets that a layer authors as values of attributes. Values of other types stay unread: arrays
/// are what makes files large.
std::set<std::string> SetsOf(const SdfLayerHandle& layer) {
    const TfToken assetType = SdfValueTypeNames->Asset.GetAsToken();
    std::set<std::string> sets;
    layer->Traverse(SdfPath::AbsoluteRootPath(), [&](const SdfPath& path) {
        VtValue type;
        VtValue value;
        if (path.IsPropertyPath() && layer->HasField(path, SdfFieldKeys->TypeName, &type) &&
            type == assetType && layer->HasField(path, SdfFieldKeys->Default, &value) &&
            value.IsHolding<SdfAssetPath>() &&
            HdStreamIsUdimSet(value.UncheckedGet<SdfAssetPath>().GetAssetPath())) {
            sets.insert(value.UncheckedGet<SdfAssetPath>().GetAssetPath());
        }
    });
    return sets;
}

/// The resolved path of the first tile that there is, with the token in the place of its number.
std::string ResolveFrom(const SdfLayerHandle& layer, const std::string& authored) {
    const std::size_t at = FindToken(authored);
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
    return FindToken(path) != std::string::npos;
}

std::string HdStreamResolveUdimSet(const std::string& authored) {
    static auto& sets = *new HdStreamUdimSets; // notices may come as long as the process lives
    return sets.Resolve(authored);
}

HdStreamUdimSets::HdStreamUdimSets()
    : _key(TfNotice::Register(TfCreateWeakPtr(this), &HdStreamUdimSets::_OnEdit)) {}

HdStreamUdimSets::~HdStreamUdimSets() {
    TfNotice::Revoke(_key);
}

std::string HdStreamUdimSets::Resolve(const std::string& authored) {
    for (const SdfLayerHandle& layer : _Find(authored)) { // resolvers may wait for whoever edits
        std::string resolved = ResolveFrom(layer, authored);
        if (!resolved.empty()) {
            return resolved;
        }
    }
    return {};
}

std::size_t HdStreamUdimSets::NumRead() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _numRead;
}

void HdStreamUdimSets::_OnEdit(const SdfNotice::LayersDidChange& notice) {
    const std::lock_guard<std::mutex> lock(_mutex);
    for (const SdfLayerHandle& layer : notice.GetLayers()) {
        _setsOf.erase(layer);
    }
}

/// In the order of the layers' identifiers.
std::vector<SdfLayerHandle> HdStreamUdimSets::_Find(const std::string& authored) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _Read(); // what came or was edited since
    return _FindKnown(authored);
}

/// \pre the mutex is held, as in what follows.
std::vector<SdfLayerHandle> HdStreamUdimSets::_FindKnown(const std::string& authored) const {
    std::vector<SdfLayerHandle> found;
    for (const auto& [layer, sets] : _setsOf) {
        if (layer && sets.count(authored) != 0) {
            found.push_back(layer);
        }
    }
    std::sort(found.begin(), found.end(), [](const SdfLayerHandle& a, const SdfLayerHandle& b) {
        return a->GetIdentifier() < b->GetIdentifier();
    });
    return found;
}

void HdStreamUdimSets::_Read() {
    for (auto known = _setsOf.begin(); known != _setsOf.end();) {
        known = known->first ? std::next(known) : _setsOf.erase(known);
    }
    for (const SdfLayerHandle& layer : SdfLayer::GetLoadedLayers()) {
        if (layer && _setsOf.count(layer) == 0) {
            _setsOf[layer] = SetsOf(layer);
            ++_numRead;
        }
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
