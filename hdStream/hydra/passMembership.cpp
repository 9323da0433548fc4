// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/passMembership.h"

#include "hdStream/hydra/scenePaths.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/collectionsSchema.h>
#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/primOriginSchema.h>
#include <pxr/imaging/hd/sceneGlobalsSchema.h>
#include <pxr/imaging/hd/sceneIndexPrimView.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Stands for what is below an instance and has no name here.
const TfToken kAny("hdStreamAny");

bool IsEverything(const SdfPathExpression& expression) {
    static const SdfPathExpression allButProperties("~//*.*"); // what includeRoot becomes
    return expression == SdfPathExpression::Everything() || expression == allButProperties;
}

/// The path of a prim inside the prototype that it is a part of; empty where it says none.
SdfPath RelativeOrigin(const HdSceneIndexPrim& prim) {
    const HdPrimOriginSchema schema = HdPrimOriginSchema::GetFromParent(prim.dataSource);
    const SdfPath path =
        schema ? schema.GetOriginPath(HdPrimOriginSchemaTokens->scenePath) : SdfPath();
    return path.IsAbsolutePath() ? SdfPath() : path;
}

} // namespace

HdStreamPassFlags HdStreamPassFlags::Within(const HdStreamPassFlags& outer) const {
    return {isRendered && outer.isRendered, isSeenByCamera && outer.isSeenByCamera,
            isMatte || outer.isMatte};
}

bool HdStreamPassFlags::operator==(const HdStreamPassFlags& other) const {
    return isRendered == other.isRendered && isSeenByCamera == other.isSeenByCamera &&
           isMatte == other.isMatte;
}

bool HdStreamIsInPasses(const TfToken& primType) {
    static const TfTokenVector shapes{HdPrimTypeTokens->sphere,  HdPrimTypeTokens->cube,
                                      HdPrimTypeTokens->cone,    HdPrimTypeTokens->cylinder,
                                      HdPrimTypeTokens->capsule, HdPrimTypeTokens->plane};
    return HdPrimTypeIsGprim(primType) || HdPrimTypeIsLight(primType) ||
           std::find(shapes.begin(), shapes.end(), primType) != shapes.end();
}

HdStreamPassMembership::HdStreamPassMembership(const HdSceneIndexBaseRefPtr& scene)
    : _scene(scene) {
    const HdPathDataSourceHandle path =
        HdSceneGlobalsSchema::GetFromSceneIndex(scene).GetActiveRenderPassPrim();
    _path = path ? path->GetTypedValue(0.0F) : SdfPath();
    if (_path.IsEmpty()) {
        return;
    }
    const HdContainerDataSourceHandle pass = scene->GetPrim(_path).dataSource;
    _rendered = Read(pass, "renderVisibility", true);
    _seen = Read(pass, "cameraVisibility", true);
    _matte = Read(pass, "matte", false);
    _pruned = Read(pass, "prune", false);
}

std::unique_ptr<HdStreamPassMembership::Members>
HdStreamPassMembership::Read(const HdContainerDataSourceHandle& pass, const char* name,
                             bool isAllUsual) const {
    const HdPathExpressionDataSourceHandle source = HdCollectionsSchema::GetFromParent(pass)
                                                        .GetCollection(TfToken(name))
                                                        .GetMembershipExpression();
    if (!source) {
        return nullptr;
    }
    SdfPathExpression expression = source->GetTypedValue(0.0F);
    if (isAllUsual ? IsEverything(expression) : expression.IsEmpty()) {
        return nullptr;
    }
    HdCollectionExpressionEvaluator evaluator(_scene, expression);
    return std::make_unique<Members>(Members{std::move(expression), std::move(evaluator)});
}

bool HdStreamPassMembership::IsSame(const HdStreamPassMembership& other) const {
    const auto isEqual = [](const std::unique_ptr<Members>& a, const std::unique_ptr<Members>& b) {
        return a && b ? a->expression == b->expression : !a && !b;
    };
    return isEqual(_rendered, other._rendered) && isEqual(_seen, other._seen) &&
           isEqual(_matte, other._matte) && isEqual(_pruned, other._pruned);
}

HdStreamPassFlags HdStreamPassMembership::Own(const SdfPath& usdPath) const {
    return {!_rendered || _rendered->Hold(usdPath), !_seen || _seen->Hold(usdPath),
            _matte && _matte->Hold(usdPath)};
}

HdStreamPassFlags HdStreamPassMembership::Common(const SdfPathVector& usdPaths) const {
    HdStreamPassFlags common{false, false, true};
    for (const SdfPath& path : usdPaths) {
        const HdStreamPassFlags own = Own(path);
        common = {common.isRendered || own.isRendered, common.isSeenByCamera || own.isSeenByCamera,
                  common.isMatte && own.isMatte};
        if (common == HdStreamPassFlags()) {
            break;
        }
    }
    return common;
}

bool HdStreamPassMembership::IsInPrunedTree(SdfPath usdPath) const {
    for (; !usdPath.IsEmpty() && !usdPath.IsAbsoluteRootPath(); usdPath = usdPath.GetParentPath()) {
        if (_pruned->Hold(usdPath)) {
            return true;
        }
    }
    return false;
}

bool HdStreamPassMembership::IsPruned(const SdfPath& path) const {
    if (!_pruned || path.IsAbsoluteRootPath()) {
        return false;
    }
    if (IsInPrunedTree(path)) {
        return true;
    }
    const SdfPath instancer = HdStreamInstancerOf(_scene->GetPrim(path).dataSource);
    if (!instancer.IsEmpty() && IsPruned(instancer)) {
        return true;
    }
    const SdfPathVector usdPaths = HdStreamUsdPaths(_scene, path);
    return std::all_of(usdPaths.begin(), usdPaths.end(),
                       [this](const SdfPath& usdPath) { return IsInPrunedTree(usdPath); });
}

bool HdStreamPassMembership::IsBelow(const SdfPath& path, const SdfPath& instancer) const {
    return HdStreamUsdPaths(_scene, path)
        .front()
        .HasPrefix(HdStreamUsdPaths(_scene, instancer).front());
}

HdStreamPassMembership::OfInstancer
HdStreamPassMembership::OfInstancerAt(const SdfPath& instancer) const {
    const HdSceneIndexPrim prim = _scene->GetPrim(instancer);
    const SdfPath parent = HdStreamInstancerOf(prim.dataSource);
    const OfInstancer outer = parent.IsEmpty() ? OfInstancer() : OfInstancerAt(parent);
    if (!outer.asksPaths || !HdStreamInstanceLocations(prim.dataSource).empty()) {
        return outer; // native instances have flags of their own
    }
    const bool isForeign = !parent.IsEmpty() &&
                           HdStreamInstanceLocations(_scene->GetPrim(parent).dataSource).empty() &&
                           !IsBelow(instancer, parent);
    if (isForeign) {
        return {outer.flags, false};
    }
    return {Common(HdStreamUsdPaths(_scene, instancer)).Within(outer.flags), true};
}

HdStreamPassFlags HdStreamPassMembership::FlagsOf(const SdfPath& path) const {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto known = _flags.find(path);
    return known != _flags.end() ? known->second : _flags[path] = FindFlagsOf(path);
}

HdStreamPassFlags HdStreamPassMembership::FindFlagsOf(const SdfPath& path) const {
    const SdfPath instancer = HdStreamInstancerOf(_scene->GetPrim(path).dataSource);
    if (instancer.IsEmpty()) {
        return Common(HdStreamUsdPaths(_scene, path));
    }
    const OfInstancer outer = OfInstancerAt(instancer);
    const bool isNative = !HdStreamInstanceLocations(_scene->GetPrim(instancer).dataSource).empty();
    if (!outer.asksPaths || (!isNative && !IsBelow(path, instancer))) {
        return outer.flags;
    }
    return Common(HdStreamUsdPaths(_scene, path)).Within(outer.flags);
}

SdfPathVector HdStreamPassMembership::LeavesBelow(const SdfPath& instancer,
                                                  const HdSceneIndexPrim& prim) const {
    SdfPathVector leaves;
    const HdPathArrayDataSourceHandle source =
        HdInstancerTopologySchema::GetFromParent(prim.dataSource).GetPrototypes();
    const VtArray<SdfPath> prototypes = source ? source->GetTypedValue(0.0F) : VtArray<SdfPath>();
    for (const SdfPath& prototype : prototypes) {
        for (const SdfPath& path : HdSceneIndexPrimView(_scene, prototype)) {
            const HdSceneIndexPrim found = _scene->GetPrim(path);
            const bool isInstancer = found.primType == HdPrimTypeTokens->instancer;
            if ((isInstancer || HdStreamIsInPasses(found.primType)) &&
                HdStreamInstancerOf(found.dataSource) == instancer) {
                const SdfPath origin = RelativeOrigin(found);
                leaves.push_back(origin.IsEmpty() ? SdfPath(kAny)
                                 : isInstancer    ? origin.AppendChild(kAny)
                                                  : origin);
            }
        }
    }
    return leaves;
}

std::vector<HdStreamPassOfInstance>
HdStreamPassMembership::FlagsOfInstances(const SdfPath& instancer) const {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto known = _flagsOfInstances.find(instancer);
    return known != _flagsOfInstances.end()
               ? known->second
               : _flagsOfInstances[instancer] = FindFlagsOfInstances(instancer);
}

std::vector<HdStreamPassOfInstance>
HdStreamPassMembership::FindFlagsOfInstances(const SdfPath& instancer) const {
    const HdSceneIndexPrim prim = _scene->GetPrim(instancer);
    const SdfPathVector instances = HdStreamUsdPathsOfInstances(_scene, instancer);
    if (instances.empty()) {
        return {};
    }
    const bool asksPaths = OfInstancerAt(instancer).asksPaths;
    const SdfPathVector leaves = LeavesBelow(instancer, prim);
    std::vector<HdStreamPassOfInstance> result(instances.size());
    bool isAny = false;
    bool isPartly = false;
    std::vector<HdStreamPassFlags> common(leaves.size(), {false, false, true});
    std::vector<HdStreamPassFlags> all(instances.size() * leaves.size());
    for (std::size_t i = 0; i < instances.size(); ++i) {
        HdStreamPassFlags whole{false, false, true}; // what is done to each of its leaves
        for (std::size_t leaf = 0; asksPaths && leaf < leaves.size(); ++leaf) {
            const HdStreamPassFlags own = Own(instances[i].AppendPath(leaves[leaf]));
            all[i * leaves.size() + leaf] = own;
            for (HdStreamPassFlags* sum : {&whole, &common[leaf]}) {
                *sum = {sum->isRendered || own.isRendered,
                        sum->isSeenByCamera || own.isSeenByCamera, sum->isMatte && own.isMatte};
            }
        }
        if (asksPaths && !leaves.empty()) {
            result[i].flags = whole;
        }
        result[i].isPruned = _pruned && IsInPrunedTree(instances[i]);
        isAny |= result[i].isPruned || result[i].flags != HdStreamPassFlags();
    }
    for (std::size_t i = 0; asksPaths && i < all.size(); ++i) {
        isPartly |= common[i % leaves.size()].Within(result[i / leaves.size()].flags) != all[i];
    }
    if (isPartly) {
        TF_WARN("render pass %s: what it says of single prims inside some native instances of %s, "
                "and not of others, does not count",
                _path.GetText(), instancer.GetText());
    }
    return isAny ? result : std::vector<HdStreamPassOfInstance>();
}

void HdStreamPassMembership::Forget() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _flags.clear();
    _flagsOfInstances.clear();
}

PXR_NAMESPACE_CLOSE_SCOPE
