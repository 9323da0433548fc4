// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/thinWall.h"

#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/surfaceFrame.h"

namespace hds {

bool IsThinWall(NetworkEvaluator& network, const MaterialNode& node, const char* input) {
    const ShaderValue value = network.EvaluateOr(node, input, {}, 1);
    if (!IsConstant(value)) {
        WarnOf(network, node, input, "varies, which is not supported, and counts as false");
        return false;
    }
    return ConstantOf(value)[0] != 0.0F;
}

void FrostThinWall(LayeredMaterial* material) {
    const ShaderValue& transmission = material->values[HDS_INPUT_TRANSMISSION];
    if (!transmission || IsAll(transmission, 0.0F)) {
        return;
    }
    const ShaderValue& roughness = material->values[HDS_INPUT_ROUGHNESS];
    const bool isClear = IsConstant(roughness) && ConstantOf(roughness)[0] <= HDS_CLEAR_ROUGHNESS;
    material->flags |= isClear ? 0U : HDS_MATERIAL_FROSTED;
}

} // namespace hds
