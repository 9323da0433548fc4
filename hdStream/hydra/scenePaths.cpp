// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/scenePaths.h"

#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/instancedBySchema.h>
#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/primOriginSchema.h>
#include <pxr/imaging/hd/renderIndex.h>

#include <algorithm>
#include <numeric>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Instances that are asked for their paths in search of a name.
constexpr std::size_t kMaxInstancesAsked = 4096;

/// Where scene indices say a prim comes from; relative inside a USD prototype, or empty.
SdfPath OriginOf(const HdSceneIndexPrim& prim) {
    const HdPrimOriginSchema schema = HdPrimOriginSchema::GetFromParent(prim.dataSource);
    return schema ? schema.GetOriginPath(HdPrimOriginSchemaTokens->scenePath) : SdfPath();
}

/// Where the first native instance of an instancer is; empty for point instancers.
SdfPath FirstLocationOf(const HdSceneIndexBaseRefPtr& scene, const SdfPath& instancer) {
    const VtArray<SdfPath> locations =
        HdStreamInstanceLocations(scene->GetPrim(instancer).dataSource);
    return locations.empty() ? SdfPath() : locations.front();
}

/// The origin of something inside the prim `path`, made absolute through the first instance of each
/// level; empty when it is not known.
SdfPath ThroughInstances(const HdSceneIndexBaseRefPtr& scene, SdfPath path, SdfPath origin) {
    while (!origin.IsEmpty() && !origin.IsAbsolutePath()) {
        const SdfPath instancer = HdStreamInstancerOf(scene->GetPrim(path).dataSource);
        if (instancer.IsEmpty()) {
            return {};
        }
        const SdfPath location = FirstLocationOf(scene, instancer);
        if (!location.IsEmpty()) { // Point instancers add nothing to the path.
            const SdfPath above = OriginOf(scene->GetPrim(location));
            origin = above.IsEmpty() ? above : above.AppendPath(origin);
        }
        path = instancer;
    }
    return origin;
}

/// The prim's USD path through the first instance of each level; empty when it is not known.
SdfPath FullOrigin(const HdSceneIndexBaseRefPtr& scene, const SdfPath& path) {
    return ThroughInstances(scene, path, OriginOf(scene->GetPrim(path)));
}

/// The USD path of the first native instance of an instancer; empty for point instancers.
SdfPath FirstInstanceOf(const HdSceneIndexBaseRefPtr& scene, const SdfPath& instancer) {
    const SdfPath location = FirstLocationOf(scene, instancer);
    return location.IsEmpty()
               ? SdfPath()
               : ThroughInstances(scene, instancer, OriginOf(scene->GetPrim(location)));
}

/// How the Python front end names what a point instancer places.
std::string BelowInstancer(const std::string& usdPath, const std::string& instancerPath) {
    if (usdPath.compare(0, instancerPath.size() + 1, instancerPath + "/") == 0) {
        return usdPath;
    }
    return instancerPath + "{" + usdPath + "}";
}

/// Of the paths that a prim below native instances has, the one inside the instance that gave the
/// instancer its id; `first`, that of the first instance, where there is none among the first few
/// thousand.
SdfPath PathBelow(HdSceneDelegate* legacy, const SdfPath& id, const SdfPath& instancerId,
                  const SdfPath& first, std::size_t numInstances) {
    if (first.HasPrefix(instancerId)) {
        return first;
    }
    std::vector<int> indices(std::min(numInstances, kMaxInstancesAsked));
    std::iota(indices.begin(), indices.end(), 0);
    for (const SdfPath& path : legacy->GetScenePrimPaths(id, indices, nullptr)) {
        if (path.HasPrefix(instancerId)) {
            return path;
        }
    }
    return first;
}

} // namespace

SdfPath HdStreamInstancerOf(const HdContainerDataSourceHandle& prim) {
    const HdInstancedBySchema schema = HdInstancedBySchema::GetFromParent(prim);
    const HdPathArrayDataSourceHandle source = schema ? schema.GetPaths() : nullptr;
    const VtArray<SdfPath> paths = source ? source->GetTypedValue(0.0F) : VtArray<SdfPath>();
    return paths.empty() ? SdfPath() : paths.front();
}

VtArray<SdfPath> HdStreamInstanceLocations(const HdContainerDataSourceHandle& instancer) {
    HdInstancerTopologySchema topology = HdInstancerTopologySchema::GetFromParent(instancer);
    const HdPathArrayDataSourceHandle source = topology ? topology.GetInstanceLocations() : nullptr;
    return source ? source->GetTypedValue(0.0F) : VtArray<SdfPath>();
}

SdfPathVector HdStreamUsdPaths(const HdSceneIndexBaseRefPtr& scene, const SdfPath& path) {
    const HdSceneIndexPrim prim = scene->GetPrim(path);
    const SdfPath origin = OriginOf(prim);
    if (origin.IsEmpty()) {
        return {path};
    }
    if (origin.IsAbsolutePath()) {
        return {origin};
    }
    const SdfPath instancer = HdStreamInstancerOf(prim.dataSource);
    SdfPathVector paths = HdStreamUsdPathsOfInstances(scene, instancer);
    if (paths.empty()) {
        paths.push_back(FullOrigin(scene, path));
    } else {
        for (SdfPath& instance : paths) {
            instance = instance.IsEmpty() ? instance : instance.AppendPath(origin);
        }
    }
    return paths;
}

SdfPathVector HdStreamUsdPathsOfInstances(const HdSceneIndexBaseRefPtr& scene,
                                          const SdfPath& instancer) {
    SdfPathVector paths;
    for (const SdfPath& location :
         HdStreamInstanceLocations(scene->GetPrim(instancer).dataSource)) {
        const SdfPath origin = OriginOf(scene->GetPrim(location));
        paths.push_back(origin.IsEmpty() ? location : ThroughInstances(scene, instancer, origin));
    }
    return paths;
}

HdSceneDelegate* HdStreamFindLegacyDelegate(HdSceneDelegate* delegate, const SdfPath& id) {
    const HdRenderIndex& index = delegate->GetRenderIndex();
    if (!index.GetTerminalSceneIndex()) {
        return delegate; // Hydra runs without scene indices.
    }
    // The emulation's own delegate syncs every prim; the one that inserted it tells the origin.
    HdSceneDelegate* origin = index.GetSceneDelegateForRprim(id);
    return origin == delegate ? nullptr : origin;
}

std::string HdStreamScenePath(HdSceneDelegate* delegate, const SdfPath& id,
                              const SdfPath& instancerId, const hds::Placement& placement) {
    if (instancerId.IsEmpty() || placement.instances.empty()) {
        return id.GetString();
    }
    SdfPath path;
    if (HdSceneDelegate* legacy = HdStreamFindLegacyDelegate(delegate, id)) {
        HdInstancerContext context;
        path = legacy->GetScenePrimPath(id, 0, &context);
        if (context.empty() && !path.IsEmpty()) { // native instances only
            return PathBelow(legacy, id, instancerId, path, placement.instances.size()).GetString();
        }
    } else {
        path = FullOrigin(delegate->GetRenderIndex().GetTerminalSceneIndex(), id);
    }
    return path.IsEmpty() || path == id ? id.GetString()
                                        : BelowInstancer(path.GetString(), placement.instancerPath);
}

bool HdStreamReservePath(HdSceneDelegate* delegate, const SdfPath& id, const SdfPath& instancerId,
                         const hds::Placement& placement, HdStreamRenderParam* param,
                         std::string* path, bool* isProvisional) {
    const bool isTold = instancerId.IsEmpty() || !placement.instances.empty();
    if (!path->empty() && !(*isProvisional && isTold)) {
        return false;
    }
    const std::string before = *path;
    if (!before.empty()) {
        param->ReleasePath(before);
    }
    *path = param->ReservePath(HdStreamScenePath(delegate, id, instancerId, placement), id);
    *isProvisional = !isTold;
    return !before.empty() && *path != before;
}

std::string HdStreamInstancerScenePath(HdSceneDelegate* delegate, const SdfPath& id,
                                       const SdfPath& parentId, const std::string& parentPath) {
    if (HdStreamFindLegacyDelegate(delegate, id)) {
        return id.GetString(); // UsdImaging takes the first instance's path.
    }
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    SdfPath path = FirstInstanceOf(scene, id);
    if (path.IsEmpty()) {
        path = FullOrigin(scene, id);
    }
    if (path.IsEmpty()) {
        return id.GetString();
    }
    return parentId.IsEmpty() ? path.GetString() : BelowInstancer(path.GetString(), parentPath);
}

std::string HdStreamMaterialScenePath(HdSceneDelegate* delegate, const SdfPath& id) {
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    const SdfPath path = scene && !id.IsEmpty() ? FullOrigin(scene, id) : SdfPath();
    return path.IsEmpty() ? id.GetString() : path.GetString();
}

PXR_NAMESPACE_CLOSE_SCOPE
