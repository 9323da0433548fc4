// SPDX-License-Identifier: Apache-2.0
// Networks of displacement and of volumes on the host: their steps evaluated with the functions
// that kernels have, and bounded by interval arithmetic.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/scene/valueRange.h"
#include "hdStream/shading/displacementNetwork.h"

#include <array>

namespace hds {

using NetworkValue = std::array<float, 4>;

/// All components of a network's result. Images are looked up bilinearly at their finest, or their
/// fallbacks where they are missing. May be no number.
NetworkValue ValueOf(const DisplacementNetwork& network, const AmountPoint& point);

/// Between which values these are in a box; infinite where it cannot be told.
ValueRange RangeOf(const DisplacementNetwork& network, const AmountBox& box);

bool ReadsPosition(const DisplacementNetwork& network);

} // namespace hds
