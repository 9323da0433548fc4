// SPDX-License-Identifier: Apache-2.0
// What the active render pass of a scene does to a prim: the collections of a UsdRenderPass, asked
// by USD paths. hdStream/python/hdstream/translate/passCollections.py has the same rules.
#pragma once

#include <pxr/imaging/hd/collectionExpressionEvaluator.h>
#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>
#include <pxr/usd/sdf/pathExpression.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// What a pass does to a prim that it does not prune. As it is: nothing.
struct HdStreamPassFlags {
    bool isRendered = true;
    bool isSeenByCamera = true;
    bool isMatte = false;

    /// Of a prim that `outer` places.
    HdStreamPassFlags Within(const HdStreamPassFlags& outer) const;
    bool operator==(const HdStreamPassFlags& other) const;
    bool operator!=(const HdStreamPassFlags& other) const { return !(*this == other); }
};

/// What a pass does to a native instance as a whole.
struct HdStreamPassOfInstance {
    HdStreamPassFlags flags;
    bool isPruned = false;
};

/// The collections of a scene index's active render pass, as they were when this was made. What the
/// scene holds may change; Forget() then. Thread-safe.
class HdStreamPassMembership {
public:
    explicit HdStreamPassMembership(const HdSceneIndexBaseRefPtr& scene);

    /// Of the pass; empty: there is none.
    const SdfPath& Path() const { return _path; }
    /// False: the pass changes nothing.
    bool IsActive() const { return _rendered || _seen || _matte || _pruned; }
    bool IsSame(const HdStreamPassMembership& other) const;

    /// With all that is above the prim.
    bool IsPruned(const SdfPath& path) const;
    /// Of a gprim or light. Below native instances: what is the same in all of them.
    HdStreamPassFlags FlagsOf(const SdfPath& path) const;
    /// Of an instancer's native instances, in its order; empty where nothing is done to any, and
    /// for point instancers, whose prototypes have their flags.
    std::vector<HdStreamPassOfInstance> FlagsOfInstances(const SdfPath& instancer) const;
    void Forget();

private:
    /// A collection that is neither empty nor everything.
    struct Members {
        SdfPathExpression expression;
        HdCollectionExpressionEvaluator evaluator;
        bool Hold(const SdfPath& path) const { return bool(evaluator.Match(path)); }
    };
    /// What holds for all that an instancer places.
    struct OfInstancer {
        HdStreamPassFlags flags;
        bool asksPaths = true; ///< paths of prims further in say more
    };

    std::unique_ptr<Members> Read(const HdContainerDataSourceHandle& pass, const char* name,
                                  bool isAllUsual) const;
    HdStreamPassFlags Own(const SdfPath& usdPath) const;
    /// What is the same at all these paths.
    HdStreamPassFlags Common(const SdfPathVector& usdPaths) const;
    bool IsInPrunedTree(SdfPath usdPath) const;
    bool IsBelow(const SdfPath& path, const SdfPath& instancer) const;
    OfInstancer OfInstancerAt(const SdfPath& instancer) const;
    HdStreamPassFlags FindFlagsOf(const SdfPath& path) const;
    SdfPathVector LeavesBelow(const SdfPath& instancer, const HdSceneIndexPrim& prim) const;
    std::vector<HdStreamPassOfInstance> FindFlagsOfInstances(const SdfPath& instancer) const;

    HdSceneIndexBaseRefPtr _scene;
    SdfPath _path;
    std::unique_ptr<Members> _rendered; ///< null: all
    std::unique_ptr<Members> _seen;     ///< null: all
    std::unique_ptr<Members> _matte;    ///< null: none
    std::unique_ptr<Members> _pruned;   ///< null: none
    mutable std::mutex _mutex;
    mutable std::map<SdfPath, HdStreamPassFlags> _flags;
    mutable std::map<SdfPath, std::vector<HdStreamPassOfInstance>> _flagsOfInstances;
};

/// Whether a pass shows or hides prims of a type: gprims and lights.
bool HdStreamIsInPasses(const TfToken& primType);

PXR_NAMESPACE_CLOSE_SCOPE
