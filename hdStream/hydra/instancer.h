// SPDX-License-Identifier: Apache-2.0
// Instancers, one level each: the hierarchy of Hydra is kept, nothing is multiplied out.
#pragma once

#include "hdStream/hydra/instancePrimvars.h"
#include "hdStream/session/session.h"

#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/pxr.h>

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// An instancer of Hydra on its way into the core. Synced by the prims it places, under the lock
/// that Hydra has for each instancer.
class HdStreamInstancer final : public HdInstancer {
public:
    HdStreamInstancer(HdSceneDelegate* delegate, const SdfPath& id);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;

    /// The instancer's path in the core's scene; found once. Thread-safe.
    const std::string& ScenePath(HdStreamRenderParam* param);

    /// Sets the instancer's path of a prim's placement. Returns true when that changed it.
    static bool UpdatePathOf(HdRenderIndex& index, const SdfPath& instancerId,
                             HdStreamRenderParam* param, hds::Placement* placement);

    /// Reads which instances of its instancer place a prim.
    static void ReadInstances(HdSceneDelegate* delegate, const SdfPath& instancerId,
                              const SdfPath& prototypeId, hds::Placement* placement);

    /// What an instancer and those above it know of their instances. Thread-safe; all of them must
    /// have been synced, as by _SyncInstancerAndParents.
    static HdStreamInstanceLevels Levels(HdRenderIndex& index, const SdfPath& instancerId);

    /// True for a prim that is drawn at least once: not instanced, or by some instance.
    static bool IsPlaced(const hds::Placement& placement) {
        return placement.instancerPath.empty() || !placement.instances.empty();
    }

private:
    void SyncPrimvars(HdSceneDelegate* delegate, HdDirtyBits bits);
    /// Reads the instances' transforms while the shutter is open. \return false: velocities take,
    /// or turn, some of them nowhere finite, and these stand still.
    bool SyncMotion(HdSceneDelegate* delegate, const hds::Shutter& shutter);
    /// Lets others see the primvars and the placement as they are now.
    void ShareLevel(HdStreamRenderParam* param);

    std::once_flag _hasScenePath;
    std::string _scenePath;
    std::map<TfToken, VtValue> _values;  ///< transforms and their parts, per instance
    std::vector<hds::Primvar> _primvars; ///< the others, whatever their number of values
    hds::InstancerPrim _prim;
    bool _isInScene = false;
    mutable std::mutex _levelMutex;
    std::shared_ptr<const HdStreamInstanceLevel> _level;
};

PXR_NAMESPACE_CLOSE_SCOPE
