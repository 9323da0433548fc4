// SPDX-License-Identifier: Apache-2.0
// Learns the guide of domes (shading/domeGuide): paths are traced before the first sample, and
// those of their rays that meet nothing are counted by place and direction. Explained in
// docs/lights.md, "Guided domes".
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/sceneBuffers.h"
#include "hdStream/integrator/waveTracer.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace hds {

/// The pixels of a picture, in any order that is always the same.
std::vector<std::uint32_t> PixelsOf(const RenderOptions& picture);

/// Calls `trace` for waves of one sample of all pixels of a picture. \return false when one of them
/// was cancelled: the others are left out.
bool ForEachWave(const RenderOptions& picture, std::uint32_t maxPaths,
                 const std::function<bool(const shared::HdsWave&)>& trace);

/// Traces a path through each pixel of a picture with these options. \return false when it was
/// cancelled.
using TracePicture = std::function<bool(const RenderOptions& options)>;

/// Learns the guide and gives it to the domes in `buffers`, which have none, unless it is
/// cancelled; a few paths decide whether many are traced. The result depends on the scene and the
/// options of the whole picture: crops and tiles have one guide. Kernels have to be bound again.
/// \param camera relative to the scene centre.
void LearnDomeGuide(const RenderOptions& options, const std::array<float, 3>& camera,
                    WaveTracer* tracer, SceneBuffers* buffers, const TracePicture& trace);

} // namespace hds
