// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/hostFrame.h"

#include "hdStream/shading/patternRegistry.h"

#include <cmath>

namespace hds {

namespace {

bool AsksForFrame(const MaterialNode& node) {
    const PatternType* type = FindPatternType(node.identifier);
    return type != nullptr && (type->name == "frame" || type->name == "time");
}

} // namespace

bool TellFrame(std::optional<double> frame, MaterialNetwork* network) {
    // OpenUSD's earliest time is no float, and its default time no number.
    const bool isKnown = frame && std::isfinite(static_cast<float>(*frame));
    bool asks = false;
    for (MaterialNode& node : network->nodes) {
        if (!AsksForFrame(node)) {
            continue;
        }
        asks = true;
        node.parameters.erase(kFrameInput);
        if (isKnown) {
            node.parameters[kFrameInput] = *frame;
        }
    }
    return asks;
}

} // namespace hds
