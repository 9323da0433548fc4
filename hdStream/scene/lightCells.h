// SPDX-License-Identifier: Apache-2.0
// Lights whose size or emission changes while the shutter is open, cut into parts of it.
// Explained in docs/lights.md, section "Moving lights".
#pragma once

#include "hdStream/scene/motion.h"
#include "hdStream/shading/emissiveMesh.h"

#include <vector>

namespace hds {

constexpr std::size_t kMostLightCells = 128;

/// The light in the middle of each of equal parts of the interval, a power of two of them: so many
/// that it changes little from one to the next. Empty: it is the same at all times, and as for the
/// frame. \param keys of MakeLightKeys, whose motion the cells lack; empty: they have all of it.
/// \param isRigid what that said. \param most of them, a power of two
std::vector<LightCell> MakeLightCells(const LightPrim& prim, const Shutter& shutter,
                                      const MovingTransform& worldFromLight,
                                      const std::vector<LightKey>& keys, bool isRigid,
                                      std::size_t most = kMostLightCells);

/// A light that is as large as any of the cells, and emits as the brightest does.
LightDescription MostOf(const LightDescription& light, const std::vector<LightCell>& cells);

} // namespace hds
