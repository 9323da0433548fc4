// SPDX-License-Identifier: Apache-2.0
// The façade of the core: the only header a front end includes.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/base/error.h"
#include "hdStream/base/version.h"
#include "hdStream/device/device.h"
#include "hdStream/device/kernelSource.h"
#include "hdStream/film/aovSources.h"
#include "hdStream/film/compare.h"
#include "hdStream/film/denoiser.h"
#include "hdStream/film/filmSums.h"
#include "hdStream/film/imageWriter.h"
#include "hdStream/geometry/carriedNormals.h"
#include "hdStream/geometry/implicitMesh.h"
#include "hdStream/geometry/limitCage.h"
#include "hdStream/geometry/splatSource.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/persist/packageFile.h"
#include "hdStream/scene/cameraAttributes.h"
#include "hdStream/scene/rayVisibility.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/session/settings.h"
#include "hdStream/shading/shaderNetwork.h"
#include "hdStream/shading/shaderNodes.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// An OpenCL device as `hdstream devices` lists it.
using DeviceInfo = DeviceProperties;

/// All OpenCL devices of the machine. Never throws: no device gives an empty list.
std::vector<DeviceInfo> ListDevices();

/// Pages of the persistent cache that belong to a stage (persist/stagePages.h).
struct CachedStage {
    std::string file; ///< of the root layer
    std::uint64_t pages = 0;
    std::uint64_t bytes = 0;
};

/// The persistent cache as `hdstream cache` shows it.
struct CacheState {
    std::string directory;
    std::uint64_t bytes = 0;         ///< of all files
    std::vector<CachedStage> stages; ///< by name; what several share is counted for each
    std::uint64_t otherPages = 0;    ///< of no stage that is known
    std::uint64_t otherBytes = 0;
};

/// What Session::Prepare has left in the persistent cache.
struct PreparedAmount {
    std::uint64_t chunks = 0;
    std::uint64_t chunksBuilt = 0; ///< the others were there
    std::uint64_t chunkBytes = 0;  ///< of the pages of all chunks
    std::uint64_t textures = 0;
    std::uint64_t texturesBuilt = 0; ///< of which nothing was there
};

/// \param directory as Settings::cacheDirectory.
CacheState InspectCache(const std::string& directory);
/// Deletes all entries; returns their bytes.
std::uint64_t ClearCache(const std::string& directory);

/// Compiles the general kernels of a device (docs/device.md) into the persistent cache, as far as
/// they are not there; nothing where its driver compiles fast. Blocks, for seconds.
/// \param device, directory as Settings::device and Settings::cacheDirectory.
/// \return warnings. \throws Error when there is no such device or a kernel does not build.
std::vector<std::string> PrepareKernels(const std::string& device, const std::string& directory);

/// A scene, its device and its film. Externally synchronised: one thread at a time; RenderThread
/// owns one for front ends that edit while it renders.
class Session {
public:
    using WarningSink = std::function<void(const std::string& line)>;

    /// Does not touch a device yet: describing, dumping and inspecting a scene needs none. Sets
    /// what PoCL reads of the environment: make the first one while no other thread reads that.
    explicit Session(WarningSink onWarning = {});
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Ends what has threads that may still warn, and waits for them; only the destructor may be
    /// called afterwards.
    void EndThreads();

    // --- Scene edits: each replaces the prim of that path, or removes it. -----------------------
    // Cheap whatever the prim: what is expensive to prepare is shared through pointers
    // (GeometryPrim).
    void SetGeometry(const std::string& path, GeometryPrim prim);
    /// What geometry that is there is linked to: front ends may meet lights after it. \throws
    /// Error.
    void SetCategories(const std::string& path, std::set<std::string> categories);
    void SetVolume(const std::string& path, VolumePrim prim);
    void SetInstancer(const std::string& path, InstancerPrim prim);
    void SetLight(const std::string& path, LightPrim prim);
    void SetMaterial(const std::string& path, std::shared_ptr<const MaterialNetwork> network);
    void SetCamera(const std::string& path, CameraPrim prim);
    void Remove(const std::string& path);
    void Clear();
    /// Surfaces are diced for the camera of the next render. Until then they keep the rates of the
    /// scene's first camera: moving it changes no geometry.
    void Redice();
    const SceneDescription& Scene() const;

    /// A warning of the front end joins the core's own.
    void Warn(const std::string& subject, const std::string& text);
    std::vector<std::string> Warnings() const;

    /// The scene as canonical text (docs/architecture.md). Needs no device.
    std::string Dump() const;

    /// Counts and bytes of the scene as JSON text (`hdstream info`). Needs no device.
    std::string Info() const;

    // --- Rendering -------------------------------------------------------------------------------
    /// Makes what a first render with such settings will need whatever the scene: the device, the
    /// kernels that a render of an earlier process asked for last. Blocks, but for the kernels:
    /// they are made on a thread of their own, and Render waits for them when the scene is
    /// committed. What fails is left to Render, which tells of it.
    void Warm(const Settings& settings);

    /// The file of the scene's stage: what renders use of the persistent cache is noted under this
    /// name (`hdstream cache`). Empty: nothing is noted.
    void SetStageFile(const std::string& file);

    /// Makes all pages that renders of these settings may use, as far as the persistent cache does
    /// not have them: of geometry and of textures, whatever the camera sees. Needs no device.
    /// Blocks. Stops as Render does. \throws Error as Render, and when the cache does not take all.
    RenderResult Prepare(const Settings& settings, const ProgressCallback& onProgress,
                         PreparedAmount* amount);

    /// Renders with the settings from the first sample on. Blocks. Stops early when `onProgress`
    /// returns false; that is asked while the scene is prepared too. `watch` may stop it sooner.
    /// What did not change since the last call is kept: planned geometry, images, light tables,
    /// device memory, kernels. \throws Error when there is no device, memory runs out, or a setting
    /// is wrong. \param start the film begins with these sums of other renders of the same scene
    /// and settings, and the samples that follow are rendered; the bits are those of one render. A
    /// film without pixels begins a range of samples (docs/film.md). Not with --noise.
    RenderResult Render(const Settings& settings, const ProgressCallback& onProgress = {},
                        const std::vector<FilmSums>& start = {}, const RenderWatch& watch = {});

    /// The sums of the film as rendered so far: what another render, on any machine with the same
    /// device model, can begin with. \throws Error before the first Render.
    FilmSums Film() const;

    /// The film as rendered so far, one layer an AOV of the settings. May be called inside
    /// onProgress. \param withFirstHits false: the AOVs of the first hit are left at their clear
    /// values unless they are there already (finding them takes a ray a pixel).
    /// \throws Error before the first Render.
    std::vector<ImageLayer> Layers(bool withFirstHits = true) const;

    /// The deep picture as rendered so far, where the settings ask for one. May be called inside
    /// onProgress. \throws Error before the first Render, and where none was asked for.
    DeepImage Deep() const;

    /// True when Layers and Statistics have something to say: a render has begun, and the scene of
    /// the last one was not cancelled while it was prepared.
    bool HasImage() const;

    /// Forgets what was read from image files, so that the next Render reads them again.
    void FlushTextures();

    /// Statistics of the last render as JSON text (docs/statistics.md).
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
