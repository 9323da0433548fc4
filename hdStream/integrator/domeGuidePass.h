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

/// Traces a path through each pixel of a picture with these options. \return false when it was
/// cancelled.
using TracePicture = std::function<bool(const RenderOptions& options)>;

/// Learns the guide and gives it to the domes in `buffers`; a few paths decide whether many are
/// traced. What the last guide was is forgotten. The result depends on the scene and the options
/// of the whole picture: crops and tiles have one guide. Kernels have to be bound again. \param
/// camera relative to the scene centre. \return false when it was cancelled.
bool LearnDomeGuide(const RenderOptions& options, const std::array<float, 3>& camera,
                    WaveTracer* tracer, SceneBuffers* buffers, const TracePicture& trace);

/// 0, 1, ... count - 1.
std::vector<std::uint32_t> NumbersUpTo(std::uint32_t count);

} // namespace hds
