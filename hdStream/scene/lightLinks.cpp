// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/lightLinks.h"

#include "hdStream/scene/placements.h"
#include "kernels/shared/geometry.h"

#include <algorithm>

namespace hds {

namespace {

constexpr std::size_t kMaxSets = std::size_t{1} << (32U - HDS_INSTANCE_LINK_SHIFT);

} // namespace

LightLinks::LightLinks(const SceneDescription& scene) : _scene(scene) {
    for (const auto& [path, prim] : scene.lights) {
        AddLight(prim.light, prim.links);
    }
    for (const auto& [path, prim] : scene.geometry) {
        if (prim.light) {
            AddLight(prim.light->light, prim.light->links);
        }
    }
    _numberBySet[{}] = 0;
}

void LightLinks::AddLight(const LightDescription& light, const LinkCategories& links) {
    for (const std::string& category : {links.lightLink, links.shadowLink}) {
        if (!category.empty()) {
            _indexByCategory.emplace(category, std::uint32_t(_indexByCategory.size()));
        }
    }
    if (!links.shadowLink.empty()) {
        _shadowCategories.insert(_indexByCategory.at(links.shadowLink));
    }
    _isFading = _isFading || IsFading(light.shadow);
}

bool LightLinks::IsLinkedByInstance(const Placement& placement) const {
    std::string path = AreUsed() ? placement.instancerPath : std::string();
    for (std::size_t level = 0; !path.empty() && level <= _scene.instancers.size(); ++level) {
        const auto found = _scene.instancers.find(path);
        if (found == _scene.instancers.end()) {
            break;
        }
        const auto& categories = found->second.instanceCategories;
        if (std::any_of(categories.begin(), categories.end(),
                        [](const std::set<std::string>& some) { return !some.empty(); })) {
            return true;
        }
        path = found->second.placement.instancerPath;
    }
    return false;
}

LightLinks::Indices LightLinks::IndicesOf(const std::set<std::string>& categories,
                                          const std::set<std::string>& ofInstances) const {
    Indices indices;
    for (const std::set<std::string>* names : {&categories, &ofInstances}) {
        for (const std::string& name : *names) {
            const auto found = _indexByCategory.find(name);
            if (found != _indexByCategory.end()) {
                indices.insert(found->second);
            }
        }
    }
    return indices;
}

std::optional<std::uint32_t> LightLinks::NumberOf(const Indices& indices) {
    const auto found = _numberBySet.find(indices);
    if (found != _numberBySet.end()) {
        return found->second;
    }
    if (_numberBySet.size() >= kMaxSets) {
        _isFull = true;
        return {};
    }
    return _numberBySet.emplace(indices, std::uint32_t(_numberBySet.size())).first->second;
}

std::uint32_t LightLinks::FlagsOf(const std::set<std::string>& categories,
                                  const std::set<std::string>& ofInstances) {
    _hasUnshadowing = _hasUnshadowing || _isFading;
    if (!AreUsed()) {
        return _isFading ? HDS_INSTANCE_CUTOUT : 0U;
    }
    const Indices indices = IndicesOf(categories, ofInstances);
    const bool tracesAll =
        !_isFading && std::includes(indices.begin(), indices.end(), _shadowCategories.begin(),
                                    _shadowCategories.end());
    const std::optional<std::uint32_t> number = NumberOf(indices);
    if (!number) {
        return _isFading ? HDS_INSTANCE_CUTOUT : 0U;
    }
    _hasUnshadowing = _hasUnshadowing || !tracesAll;
    return (*number << HDS_INSTANCE_LINK_SHIFT) | (tracesAll ? 0U : HDS_INSTANCE_CUTOUT);
}

std::uint32_t LightLinks::SetOf(const std::set<std::string>& categories,
                                const std::set<std::string>& ofInstances) {
    return AreUsed() ? NumberOf(IndicesOf(categories, ofInstances)).value_or(0U) : 0U;
}

void LightLinks::NumberVolumes() {
    if (!AreUsed()) {
        return;
    }
    for (const auto& [path, prim] : _scene.volumes) {
        for (const Placed& place : PlacementsOf(_scene, prim.placement, Shutter())) {
            SetOf(prim.categories, place.categories);
        }
    }
}

std::uint32_t LightLinks::IndexOf(const std::string& category) const {
    return category.empty() ? HDS_NONE : _indexByCategory.at(category);
}

LinkTable LightLinks::Table() const {
    LinkTable table;
    table.numSets = std::uint32_t(_numberBySet.size());
    table.categories.assign(_indexByCategory.size(), std::vector<bool>(table.numSets));
    for (const auto& [indices, number] : _numberBySet) {
        for (const std::uint32_t index : indices) {
            table.categories[index][number] = true;
        }
    }
    return table;
}

void LightLinks::WarnOfOverflow(Warnings& warnings) const {
    if (_isFull) {
        warnings.Add("", "more than " + std::to_string(kMaxSets) +
                             " combinations of light and shadow links: the rest is not linked");
    }
}

} // namespace hds
