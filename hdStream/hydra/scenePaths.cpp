// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/instancedBySchema.h>
#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/primOriginSchema.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneIndex.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Where scene indices say a prim comes from; relative inside a USD prototype, or empty.
SdfPath OriginOf(const HdSceneIndexPrim& prim) {
    const HdPrimOriginSchema schema = HdPrimOriginSchema::GetFromParent(prim.dataSource);
    return schema ? schema.GetOriginPath(HdPrimOriginSchemaTokens->scenePath) : SdfPath();
}

SdfPath FirstInstanceOf(const HdSceneIndexBaseRefPtr& scene, const SdfPath& instancer,
                        const SdfPath& prototype);

/// The prim's USD path through the first instance of each level; empty when it is not known.
SdfPath FullOrigin(const HdSceneIndexBaseRefPtr& scene, const SdfPath& path) {
    const HdSceneIndexPrim prim = scene->GetPrim(path);
    const SdfPath origin = OriginOf(prim);
    if (origin.IsEmpty() || origin.IsAbsolutePath()) {
        return origin;
    }
    const HdInstancedBySchema instancedBy = HdInstancedBySchema::GetFromParent(prim.dataSource);
    const HdPathArrayDataSourceHandle paths = instancedBy ? instancedBy.GetPaths() : nullptr;
    const VtArray<SdfPath> instancers = paths ? paths->GetTypedValue(0.0F) : VtArray<SdfPath>();
    if (instancers.empty()) {
        return {};
    }
    const SdfPath instance = FirstInstanceOf(scene, instancers.front(), path);
    return instance.IsEmpty() ? SdfPath() : origin.MakeAbsolutePath(instance);
}

/// The USD path of the first native instance that draws a prototype; empty for point instancers.
SdfPath FirstInstanceOf(const HdSceneIndexBaseRefPtr& scene, const SdfPath& instancer,
                        const SdfPath& prototype) {
    HdInstancerTopologySchema topology =
        HdInstancerTopologySchema::GetFromParent(scene->GetPrim(instancer).dataSource);
    const HdPathArrayDataSourceHandle source =
        topology ? topology.GetInstanceLocations() : nullptr;
    const VtArray<SdfPath> locations = source ? source->GetTypedValue(0.0F) : VtArray<SdfPath>();
    if (locations.empty()) {
        return {};
    }
    std::size_t first = 0;
    if (!prototype.IsEmpty()) {
        const VtArray<int> indices = topology.ComputeInstanceIndicesForProto(prototype);
        if (!indices.empty() && indices[0] >= 0 &&
            static_cast<std::size_t>(indices[0]) < locations.size()) {
            first = static_cast<std::size_t>(indices[0]);
        }
    }
    return FullOrigin(scene, locations[first]);
}

/// How the Python front end names what a point instancer places.
std::string BelowInstancer(const std::string& usdPath, const std::string& instancerPath) {
    if (usdPath.compare(0, instancerPath.size() + 1, instancerPath + "/") == 0) {
        return usdPath;
    }
    return instancerPath + "{" + usdPath + "}";
}

} // namespace

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
                              const SdfPath& instancerId, const std::string& instancerPath) {
    if (instancerId.IsEmpty()) {
        return id.GetString();
    }
    SdfPath path;
    if (HdSceneDelegate* legacy = HdStreamFindLegacyDelegate(delegate, id)) {
        HdInstancerContext context;
        path = legacy->GetScenePrimPath(id, 0, &context);
    } else {
        path = FullOrigin(delegate->GetRenderIndex().GetTerminalSceneIndex(), id);
    }
    return path.IsEmpty() || path == id ? id.GetString()
                                        : BelowInstancer(path.GetString(), instancerPath);
}

std::string HdStreamInstancerScenePath(HdSceneDelegate* delegate, const SdfPath& id,
                                       const SdfPath& parentId, const std::string& parentPath) {
    if (HdStreamFindLegacyDelegate(delegate, id)) {
        return id.GetString(); // UsdImaging takes the first instance's path.
    }
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    SdfPath path = FirstInstanceOf(scene, id, SdfPath());
    if (path.IsEmpty()) {
        path = FullOrigin(scene, id);
    }
    if (path.IsEmpty()) {
        return id.GetString();
    }
    return parentId.IsEmpty() ? path.GetString() : BelowInstancer(path.GetString(), parentPath);
}

PXR_NAMESPACE_CLOSE_SCOPE
