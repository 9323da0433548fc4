// SPDX-License-Identifier: Apache-2.0
// The scene as canonical text: both front ends must give the same text for the same stage.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <string>

namespace hds {

/// One line a fact, prims in the order of their paths, numbers with nine digits (float) or 17
/// (double). What nobody sees is left out: what is invisible or below something invisible, and
/// materials that no visible prim is bound to or that have no surface; front ends hear of these at
/// different times. Arrays of more than 24 numbers are given as count, range and hash. Texture
/// files are named as authored, so that the text does not depend on where a stage lies. Needs no
/// device.
std::string DumpScene(const SceneDescription& scene);

} // namespace hds
