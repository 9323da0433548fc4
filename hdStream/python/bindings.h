// SPDX-License-Identifier: Apache-2.0
// The parts of the module `hdstream._core`; each registers its types once, at import.
#pragma once

#include <nanobind/nanobind.h>

namespace hds::python {

/// Meshes, instancers, lights, cameras and the scene.
void BindScene(nanobind::module_& module);

/// Material networks and asset references.
void BindMaterials(nanobind::module_& module);

/// Finished layers, image files and their comparison.
void BindImages(nanobind::module_& module);

/// Session, settings, devices, the cache and errors.
void BindSession(nanobind::module_& module);

} // namespace hds::python
