// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshDisplacement.h"

#include "hdStream/geometry/primvars.h"
#include "hdStream/scene/networkAmount.h"
#include "hdStream/scene/textureAmount.h"

#include <algorithm>
#include <cmath>

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

double DisplacementReachOf(const GeometryDescription& mesh,
                           const std::vector<DisplacementInput>& inputs) {
    const Displacement displacement = MakeDisplacement(inputs);
    if (displacement.empty()) {
        return 0.0;
    }
    TopologySize size;
    size.numPoints = mesh.points.size() / 3;
    size.numFaces = mesh.faceVertexCounts.size();
    for (const std::int32_t count : mesh.faceVertexCounts.Held()) {
        size.numCorners += std::size_t(std::max(count, 0));
    }
    Warnings unheard; // the source tells of them
    std::vector<GeometryAttribute> attributes;
    for (const Primvar& primvar : mesh.primvars) {
        if (auto attribute = ValidatePrimvar(primvar, size, {}, unheard)) {
            attributes.push_back(std::move(*attribute));
        }
    }
    const AmountRange range =
        RangeOf(BindAmounts(displacement, attributes), attributes, mesh, true);
    return std::max(std::fabs(range.low), std::fabs(range.high));
}

} // namespace hds
