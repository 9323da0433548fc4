// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/geometryVariants.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

bool HdStreamGeometryVariants::Update(
    const std::shared_ptr<const hds::GeometryDescription>& geometry,
    HdStreamInstanceGroups groups) {
    std::vector<Variant> before = std::move(_variants);
    const bool isSameGeometry = geometry == _geometry;
    _geometry = geometry;
    _variants.clear();
    for (HdStreamInstanceGroup& group : groups.groups) {
        Variant variant{std::move(group.primvars), geometry, std::move(group.instances)};
        if (geometry && !variant.primvars.empty()) {
            const auto known = std::find_if(before.begin(), before.end(), [&](const Variant& old) {
                return isSameGeometry && HdStreamEqual(old.primvars, variant.primvars);
            });
            if (known != before.end()) {
                variant.geometry = known->geometry;
            } else {
                auto split = std::make_shared<hds::GeometryDescription>(*geometry);
                split->primvars.insert(split->primvars.end(), variant.primvars.begin(),
                                       variant.primvars.end());
                variant.geometry = std::move(split);
            }
        }
        _variants.push_back(std::move(variant));
    }
    return !std::equal(_variants.begin(), _variants.end(), before.begin(), before.end(),
                       [](const Variant& a, const Variant& b) {
                           return a.geometry == b.geometry &&
                                  HdStreamEqual(a.instances, b.instances);
                       });
}

void HdStreamGeometryVariants::Push(HdStreamRenderParam* param, const SdfPath& id,
                                    const std::string& scenePath, const hds::GeometryPrim& prim,
                                    bool isDrawable) {
    const std::size_t numDrawn = isDrawable ? _variants.size() : 0;
    for (std::size_t i = 0; i < numDrawn; ++i) {
        if (i > _paths.size()) {
            _paths.push_back(param->ReservePath(scenePath + "{" + std::to_string(i) + "}", id));
        }
        hds::GeometryPrim split = prim;
        split.geometry = _variants[i].geometry;
        split.placement.instances = _variants[i].instances;
        param->Push([path = PathOf(i, scenePath), split](hds::Session& session) mutable {
            session.SetGeometry(path, std::move(split));
        });
    }
    RemoveFrom(param, numDrawn, scenePath);
    _numInScene = numDrawn;
}

void HdStreamGeometryVariants::RemoveFrom(HdStreamRenderParam* param, std::size_t first,
                                          const std::string& scenePath) {
    for (std::size_t i = first; i < _numInScene; ++i) {
        param->Push([path = PathOf(i, scenePath)](hds::Session& session) { session.Remove(path); });
    }
}

void HdStreamGeometryVariants::Finalize(HdStreamRenderParam* param, const std::string& scenePath) {
    RemoveFrom(param, 0, scenePath);
    _numInScene = 0;
    for (const std::string& path : _paths) {
        param->ReleasePath(path);
    }
    _paths.clear();
    _variants.clear();
    _geometry.reset();
}

PXR_NAMESPACE_CLOSE_SCOPE
