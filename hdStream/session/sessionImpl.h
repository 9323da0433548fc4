// SPDX-License-Identifier: Apache-2.0
// What a session has, and what it does for a render.
#pragma once

#include "hdStream/integrator/dicingCamera.h"
#include "hdStream/integrator/pathTracer.h"
#include "hdStream/persist/pageStore.h"
#include "hdStream/scene/primCommit.h"
#include "hdStream/scene/sceneSizes.h"
#include "hdStream/session/denoising.h"
#include "hdStream/session/editCounts.h"
#include "hdStream/session/session.h"
#include "hdStream/session/settingsCheck.h"
#include "hdStream/session/statistics.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// What the present commit was made of.
struct CommitKey {
    std::uint64_t sceneVersion = 0;
    CommitOptions options;
    ResidencyOptions residency;
};

struct Session::Impl {
    explicit Impl(WarningSink onWarning) : warnings(std::move(onWarning)), cache(warnings) {}

    void ReadyDevice(const Settings& settings);

    /// The cache's folder; it needs no device.
    void ReadyStore(const Settings& settings);

    /// What of a scene is kept in the folder of ReadyStore.
    void ReadyCaches(const Settings& settings);

    /// Processes that compile take a while to start: they do it now where no kernel at all is in
    /// the store.
    void ReadyCompilers();

    void Warm(const Settings& settings);

    void ReadyTracer();

    /// Everything in device memory.
    void Discard();

    /// After an error: what is in device memory is not known, and contexts that ran out of it may
    /// be of no use to this session or the next.
    void LoseDevice();

    /// Bounds what is kept besides the scene as it is now.
    void ShareHostMemory(const Settings& settings);

    /// Notes the scene's size. \return whether it is much larger than that noted before. Of many
    /// prims front ends and planning leave as much free memory behind as the scene takes; edits
    /// leave little.
    bool NoteGrowth();

    /// Whether a scene may have records that were hidden: the flat hierarchy would show them.
    static bool MaySeeMended(const Settings& settings);

    /// Mends the scene and its tables where edits since the last commit allow it. \return Done;
    /// Cancelled; Otherwise: it has to be committed.
    PrimCommit::Reshaped MendCommit(const Settings& settings, const CommitKey& key,
                                    const CancelCallback& isCancelled);

    /// \throws Error when there is no such camera.
    const CameraPrim& CameraOf(const Settings& settings) const;

    /// Tells who waits how far the scene is prepared. \return whether the render is cancelled.
    CancelCallback Reporting(const Settings& settings, const ProgressCallback& onProgress);

    /// Surfaces are diced for the camera of the picture, as in a fresh session; where the camera
    /// moves under someone's eyes, for the first one.
    void ReadyDicing(const Settings& settings, const RenderOptions& options);

    CommitOptions OptionsOfCommit(const Settings& settings, const RenderOptions& options) const;

    /// The scene in host memory. \return null when it was cancelled.
    std::unique_ptr<CommittedScene> MakeScene(const Settings& settings,
                                              const CommitOptions& commitOptions,
                                              const CancelCallback& isCancelled);

    /// The scene in device memory. \return false when it was cancelled.
    bool Commit(const Settings& settings, const RenderOptions& options,
                const CancelCallback& isCancelled);

    /// Without Open Image Denoise pictures stay as they are, with a warning.
    void ReadyDenoiser(const Settings& settings);

    /// What is counted is of the render that begins.
    void BeginStatistics();

    RenderResult Render(const Settings& settings, const CameraPrim& camera,
                        const ProgressCallback& onProgress, const std::vector<FilmSums>& film,
                        const RenderWatch& watch);

    /// As Session::Prepare.
    RenderResult Prepare(const Settings& settings, const CameraPrim& camera,
                         const ProgressCallback& onProgress, PreparedAmount* amount);

    /// Notes in the cache which of its pages the stage has used.
    void NotePages();

    hds::Warnings warnings;
    SceneDescription description;
    SceneSizes sizes; ///< of `description`
    std::unique_ptr<Store> store;
    std::shared_ptr<Device> device; ///< its compilers write to the store
    std::string deviceName;         ///< what `device` was asked for by
    std::string cacheDirectory;     ///< what `store` was made with
    bool noCache = false;
    bool hasCaches = false;               ///< `cache` is of that folder
    std::shared_ptr<PageStore> pageStore; ///< of `cache`; may be null
    std::string stageFile;                ///< names the stage; empty: nobody has said
    std::uint64_t notedPages = 0;         ///< of pageStore, as NotePages has noted them
    CommitCache cache;
    EditCounts edits{&cache};                 ///< of `description`
    std::optional<DicingCamera> dicingCamera; ///< ReadyDicing
    std::unique_ptr<CommittedScene> scene;
    std::optional<CommitKey> committed; ///< what `scene` and the tracer's device tables hold
    bool isMended = false;              ///< `scene` is, since its commit
    std::unique_ptr<PathTracer> tracer;
    bool hasFilm = false;   ///< the tracer has begun a render
    WorkCount chunksMade;   ///< before the first ray of the present one
    WorkCount texturesMade; ///< the same, of Prepare
    bool isOpaque = false;  ///< the background of the present render
    std::unique_ptr<Denoiser> denoiser;
    std::vector<std::string> denoisedAovs; ///< of the present render; empty: it is not denoised
    StatisticsInput statistics;
    std::uint64_t notedBytes = 0; ///< of the scene, as NoteGrowth has noted it
    double sinceStartSeconds = 0.0;
};

} // namespace hds
