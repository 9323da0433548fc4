// SPDX-License-Identifier: Apache-2.0
// The frame that is rendered, for the nodes of a network that ask for it: `frame` and `time`. What
// they give is a constant of the network, which is another one at other frames.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <optional>

namespace hds {

/// The parameter of such nodes that is the frame. No file has it: front ends set it.
constexpr const char* kFrameInput = "frame";

/// Sets kFrameInput of all nodes that ask for the frame. \param frame nothing, or no finite float:
/// it is not known, and they have none. \return whether a node asks.
bool TellFrame(std::optional<double> frame, MaterialNetwork* network);

} // namespace hds
