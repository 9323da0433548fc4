// SPDX-License-Identifier: Apache-2.0
// What kernels for a scene and a render have to be able to, and whether rays walk the flat
// hierarchy. Explained in docs/wavefront.md and docs/accel.md.
#pragma once

#include "hdStream/integrator/flatGeometry.h"
#include "hdStream/integrator/kernelFeatures.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/sceneBuffers.h"
#include "hdStream/scene/commit.h"

namespace hds {

/// \param isStreaming pages of geometry may be missing; false while they are: what kernels will be
/// able to once geometry is resident.
KernelFeatures SceneFeatures(const CommittedScene& scene, const RenderOptions& options,
                             const ResidencyOptions& residency, const SceneBuffers& buffers,
                             const DeviceProperties& properties, bool isStreaming);

/// How rays are traced.
TraversalForm FormOf(const KernelFeatures& features);

/// Whether rays may walk a flat hierarchy where geometry is resident. Hosts that edit do not wait
/// for one.
bool MayBeFlat(const CommittedScene& scene, const RenderOptions& options,
               const ResidencyOptions& residency);

FlatLimits LimitsOfFlat(const CommittedScene& scene, const RenderOptions& options,
                        const ResidencyOptions& residency, const SceneBuffers& buffers,
                        const DeviceProperties& properties);

/// Whether "auto" had better have all geometry before the first ray: what rays save on the way
/// through a flat hierarchy pays for it, unless most of it is hidden. Numbers: docs/streaming.md.
bool RaysPayForAllPages(const CommittedScene& scene, const RenderOptions& options,
                        const ResidencyOptions& residency, const DeviceProperties& properties);

} // namespace hds
