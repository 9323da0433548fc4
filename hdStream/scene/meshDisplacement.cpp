// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshDisplacement.h"

#include "hdStream/scene/networkAmount.h"
#include "hdStream/scene/textureAmount.h"

#include <algorithm>

namespace hds {

Displacement MakeDisplacement(const std::vector<DisplacementInput>& inputs) {
    Displacement displacement;
    for (const DisplacementInput& input : inputs) {
        if (input.network) {
            displacement.push_back(MakeNetworkAmount(*input.network));
        } else if (input.lookup && input.lookup->image) {
            displacement.push_back(MakeTextureAmount(input.primvar, *input.lookup));
        } else if (input.lookup) {
            displacement.push_back(MakeConstantAmount(static_cast<double>(input.constant)));
        } else if (!input.primvar.empty()) {
            displacement.push_back(
                MakePrimvarAmount(input.primvar, static_cast<double>(input.constant)));
        } else if (input.constant != 0.0F) {
            displacement.push_back(MakeConstantAmount(static_cast<double>(input.constant)));
        } else {
            displacement.push_back(nullptr);
        }
    }
    const bool isNone = std::all_of(displacement.begin(), displacement.end(),
                                    [](const auto& amount) { return amount == nullptr; });
    return isNone ? Displacement() : displacement;
}

} // namespace hds
