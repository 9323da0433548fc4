// SPDX-License-Identifier: Apache-2.0
// Lights whose size or emission changes while the shutter is open, cut into parts of it.
// Explained in docs/lights.md, section "Moving lights".
#pragma once

#include "hdStream/scene/motion.h"
#include "hdStream/shading/emissiveMesh.h"

#include <vector>

namespace hds {

/// The light in the middle of each of equal parts of the interval, a power of two and at most 128
/// of them: so many that it changes little from one to the next. Empty: it is the same at all
/// times, and as for the frame. \param keys of MakeLightKeys, whose motion the cells lack; empty:
/// they have all of it. \param isRigid what that said.
std::vector<LightCell> MakeLightCells(const LightPrim& prim, const Shutter& shutter,
                                      const MovingTransform& worldFromLight,
                                      const std::vector<LightKey>& keys, bool isRigid);

/// A light that is as large as any of the cells, and emits as the brightest does.
LightDescription MostOf(const LightDescription& light, const std::vector<LightCell>& cells);

} // namespace hds
