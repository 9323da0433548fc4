// SPDX-License-Identifier: Apache-2.0
// The façade of the core: the only header a front end includes.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/base/error.h"
#include "hdStream/device/device.h"
#include "hdStream/film/compare.h"
#include "hdStream/film/imageWriter.h"
#include "hdStream/geometry/implicitMesh.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/session/settings.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// An OpenCL device as `hdstream devices` lists it.
using DeviceInfo = DeviceProperties;

/// All OpenCL devices of the machine. Never throws: no device gives an empty list.
std::vector<DeviceInfo> ListDevices();

/// The persistent cache as `hdstream cache` shows it.
struct CacheState {
    std::string directory;
    std::uint64_t bytes = 0;
};

/// \param directory as Settings::cacheDirectory.
CacheState InspectCache(const std::string& directory);
/// Deletes all entries; returns their bytes.
std::uint64_t ClearCache(const std::string& directory);

/// A scene, its device and its film. Externally synchronised: one thread at a time.
class Session {
public:
    using WarningSink = std::function<void(const std::string& line)>;

    /// Does not touch a device yet: describing, dumping and inspecting a scene needs none.
    explicit Session(WarningSink onWarning = {});
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // --- Scene edits: each replaces the prim of that path, or removes it. -----------------------
    void SetMesh(const std::string& path, MeshPrim prim);
    void SetInstancer(const std::string& path, InstancerPrim prim);
    void SetLight(const std::string& path, LightPrim prim);
    void SetMaterial(const std::string& path, MaterialNetwork network);
    void SetCamera(const std::string& path, CameraPrim prim);
    void SetStage(double metersPerUnit, const std::string& upAxis);
    void Remove(const std::string& path);
    void Clear();
    const SceneDescription& Scene() const;

    /// A warning of the front end joins the core's own.
    void Warn(const std::string& subject, const std::string& text);
    std::vector<std::string> Warnings() const;

    /// The scene as canonical text (docs/architecture.md). Needs no device.
    std::string Dump() const;

    /// Counts and bytes of the scene as JSON text (`hdstream info`). Needs no device.
    std::string Info() const;

    // --- Rendering -------------------------------------------------------------------------------
    /// Renders from scratch with the settings. Blocks. Stops early when `onProgress` returns false.
    /// \throws Error when there is no device, memory runs out, or a setting is wrong.
    RenderResult Render(const Settings& settings, const ProgressCallback& onProgress = {});

    /// The film as rendered so far, one layer an AOV of the settings.
    /// \throws Error before the first Render.
    std::vector<ImageLayer> Layers() const;

    /// Statistics of the last render as JSON text (DESIGN.md section 9).
    /// \throws Error before the first Render.
    std::string Statistics() const;

    /// Seconds the front end spent, for the statistics ("load", "translate") and the process start
    /// (seconds before now) from which firstPixel counts.
    void SetFrontEndTimes(double loadSeconds, double translateSeconds, double sinceStartSeconds);

private:
    struct Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace hds
