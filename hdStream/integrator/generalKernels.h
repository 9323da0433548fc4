// SPDX-License-Identifier: Apache-2.0
// Kernels that fit most scenes. A scene has the same bits with them as with kernels of its own, and
// takes longer; but they can be there before the scene is known, and nothing has to be compiled.
// Explained in docs/device.md.
#pragma once

#include "hdStream/integrator/kernelFeatures.h"

#include <vector>

namespace hds {

/// Whether kernels with the features `general` render what `features` asks for.
bool Covers(const KernelFeatures& general, const KernelFeatures& features);

/// The general sets that cover `features`, the fastest first; they have its form of traversal and
/// its programs. None: the scene needs kernels of its own.
std::vector<KernelFeatures> GeneralFeatures(const KernelFeatures& features);

/// All sets whose programs are worth having before any scene is known.
std::vector<KernelFeatures> AllGeneralFeatures();

/// Whether renders pay for kernels of their own: general ones have cost as much as compiling takes,
/// or will have. \param seconds that renders with these features have taken, or will take.
bool PayForOwnKernels(double seconds);

/// A render that ends sooner than they can come does not wait for them.
bool EndsBeforeOwnKernels(double secondsLeft);

} // namespace hds
