// SPDX-License-Identifier: Apache-2.0
// What all prims and passes of a delegate share: the core's render thread and the way edits take to
// it. Prims are synced on many threads and only push; nobody waits for the render thread.
// Explained in docs/hydra.md.
#pragma once

#include "hdStream/hydra/exporterFixes.h"
#include "hdStream/hydra/volumeTable.h"
#include "hdStream/session/renderThread.h"

#include <pxr/base/vt/dictionary.h>
#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <tbb/concurrent_hash_map.h>
#include <tbb/concurrent_queue.h>

#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Owned by the delegate, outlives its prims. Thread-safe except where noted.
class HdStreamRenderParam final : public HdRenderParam {
public:
    HdStreamRenderParam();
    ~HdStreamRenderParam() override;

    hds::RenderThread& Thread() { return _thread; }
    HdStreamVolumeTable& Volumes() { return _volumes; }

    /// Queues an edit for the next Commit. Lock-free.
    void Push(hds::RenderThread::Edit edit);

    /// Hands all queued edits to the render thread as one version. Application's thread only.
    void Commit();

    /// A warning about scene content: printed once per text, and part of the statistics.
    void Warn(const SdfPath& prim, const std::string& text);

    /// Prints warnings that arrived since the last call, one line a kind (HDSTREAM_VERBOSE=1: all
    /// of them). Application's thread only: printing on the render thread could meet a diagnostic
    /// delegate that waits for a lock the application holds.
    void PrintWarnings();

    /// Prints a warning about what the application has set.
    void PrintWarning(const std::string& line);

    /// What was printed so far, each line once.
    std::vector<std::string> PrintedWarnings() const;

    /// Reserves a path of the scene for a prim of Hydra: `wanted`, or a path made unique with the
    /// prim's id when another prim has it.
    std::string ReservePath(const std::string& wanted, const SdfPath& id);
    void ReleasePath(const std::string& path);

    /// The scene path of a material, the same for the delegate's life, so that what binds it and
    /// the material itself agree whenever they ask. Empty for an empty id.
    std::string MaterialPath(HdSceneDelegate* delegate, const SdfPath& id);

    /// The refine level that Hydra gives its meshes; the same for all of them.
    void SetRefineLevel(int level) { _refineLevel.store(level, std::memory_order_relaxed); }
    int RefineLevel() const { return _refineLevel.load(std::memory_order_relaxed); }

    /// Whose mistakes are turned back in what is synced from now on. Application's thread only.
    void SetExporter(HdStreamExporter exporter) { _exporter = exporter; }
    HdStreamExporter Exporter() const { return _exporter; }

    /// What a camera's shutter is. Cameras are synced before what moves in front of them, which
    /// HdStreamShutterSceneIndex marks.
    void SetShutter(const SdfPath& camera, const hds::Shutter& shutter);
    /// While some camera's shutter is open: what moves then is sampled.
    hds::Shutter Shutter() const;

    // --- Settings of the scene's active render settings prim; application's thread only. ---
    /// \param owner the prim; settings of a prim that is not active are empty.
    void SetSceneSettings(const SdfPath& owner, const VtDictionary& settings);
    void ClearSceneSettings(const SdfPath& owner);
    const VtDictionary& SceneSettings() const { return _sceneSettings; }
    /// Changes with every change of the scene's settings.
    unsigned int SceneSettingsVersion() const { return _sceneSettingsVersion; }

private:
    HdStreamVolumeTable _volumes;
    tbb::concurrent_queue<hds::RenderThread::Edit> _edits;
    tbb::concurrent_queue<std::string> _warnings;
    tbb::concurrent_hash_map<std::string, SdfPath> _idByScenePath;
    tbb::concurrent_hash_map<std::string, std::string> _materialPathById;
    std::atomic<int> _refineLevel{0};
    HdStreamExporter _exporter = HdStreamExporter::None;
    mutable std::mutex _shutterMutex;
    std::map<SdfPath, hds::Shutter> _shutters; ///< of cameras that have one
    VtDictionary _sceneSettings;
    SdfPath _sceneSettingsOwner;
    unsigned int _sceneSettingsVersion = 0;
    unsigned int _numWarningsPrinted = 0; ///< of the scene
    mutable std::mutex _printedMutex;
    std::vector<std::string> _printedWarnings;
    hds::RenderThread _thread; ///< last: joined before what its edits and warnings use goes
};

PXR_NAMESPACE_CLOSE_SCOPE
