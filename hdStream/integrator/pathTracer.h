// SPDX-License-Identifier: Apache-2.0
// The iterative wavefront: fills a film with path-traced samples, wave by wave.
// One kernel a stage: generate, intersect, shade, shadow, resolve (kernels/integrator/*.cl).
// Explained in docs/wavefront.md.
#pragma once

#include "hdStream/device/program.h"
#include "hdStream/film/filmSums.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/renderStatistics.h"
#include "hdStream/integrator/sceneBuffers.h"
#include "hdStream/scene/commit.h"
#include "hdStream/scene/placeTables.h"

#include <memory>
#include <vector>

namespace hds {

/// Renders committed scenes, one after another, on one device: what they share (pages, tables,
/// kernels, path state) stays there. Externally synchronised.
class PathTracer {
public:
    /// \param store of kernel binaries; may be null.
    PathTracer(std::shared_ptr<Device> device, Store* store);
    ~PathTracer();

    /// Begins to make the kernels that a render of an earlier process asked for last, if they need
    /// not be compiled, and keeps what renders ask for from here on. Begin waits for them.
    void WarmKernels();

    /// Whether SetScene asks for all pages of a scene, or for the sizes of all: they are better
    /// prepared before.
    bool NeedsAllPages(const CommittedScene& scene, const ResidencyOptions& residency) const;

    /// Uploads a scene, which must live until the next call. \return false when a new path tracer
    /// is needed for it (SceneBuffers::Update). \throws Error when it does not fit the device.
    bool SetScene(const CommittedScene& scene, const ResidencyOptions& residency);

    /// Uploads what is mended of the scene of the last SetScene. \return false as SetScene.
    bool TakePlaces(const PlaceChanges& changes);

    /// Readies a film, path state and kernels for a render of the scene. \param start the film has
    /// these sums (CheckFilmSums), and the samples that follow are rendered; empty: all are.
    /// \throws Error when memory runs out or a kernel does not build.
    void Begin(RenderOptions options, const std::vector<FilmSums>& start = {});

    /// Renders all samples that the film lacks. Blocks; once after each Begin.
    RenderResult Render(const ProgressCallback& onProgress, const RenderWatch& watch = {});

    /// The AOVs of the options as rendered so far, also inside onProgress. \param withFirstHits
    /// traces the rays that find first-hit AOVs if that has not been done since Begin.
    std::vector<ImageLayer> Layers(bool withFirstHits);

    /// The deep picture as rendered so far; without pixels where the options ask for none.
    DeepImage Deep() const;

    /// The sums of the film as rendered so far. Blocks.
    FilmSums Film() const;

    /// What pools have done counts from 0 again. Before the SetScene of a render.
    void BeginStatistics();
    const RenderStatistics& Statistics() const;
    const SceneBuffers& Buffers() const;

private:
    struct Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace hds
