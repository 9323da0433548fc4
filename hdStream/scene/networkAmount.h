// SPDX-License-Identifier: Apache-2.0
// Displacement by a network: its steps evaluated on the host for geometry, with the functions that
// kernels have, and bounded by interval arithmetic.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/shading/displacementNetwork.h"

#include <memory>

namespace hds {

/// Images are looked up bilinearly at their finest, or their fallbacks where they are missing.
/// Values that are not finite are 0.
std::shared_ptr<const DisplacementAmount> MakeNetworkAmount(DisplacementNetwork network);

} // namespace hds
