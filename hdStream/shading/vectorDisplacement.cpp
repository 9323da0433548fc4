// SPDX-License-Identifier: Apache-2.0
// Source of names and meanings: MaterialX 1.39, pbrlib.
#include "hdStream/shading/vectorDisplacement.h"

#include "hdStream/shading/materialCompiler.h"
#include "hdStream/shading/shaderMath.h"

namespace hds {

std::optional<DisplacementNetwork>
MakeVectorDisplacement(NetworkEvaluator& evaluator, const MaterialNode& node, ShaderValue* value) {
    const ShaderValue scale = evaluator.EvaluateOr(node, "scale", {1.0F, 1.0F, 1.0F, 1.0F}, 1);
    const ShaderValue vector =
        Multiply(evaluator.EvaluateOr(node, "displacement", {}, 3), scale, 3);
    if (IsAll(vector, 0.0F)) {
        return std::nullopt;
    }
    *value = vector;
    std::string problem;
    std::optional<DisplacementNetwork> network =
        MakeDisplacementNetwork(vector, evaluator.Textures(), &problem);
    if (!network) {
        evaluator.Warn("displacement by a network with " + problem + " is ignored");
        return network;
    }
    network->isVector = true;
    const std::string space = evaluator.Text(node, "space");
    if (space != "object") {
        if (!space.empty() && space != "tangent") {
            evaluator.Warn("space \"" + space + "\" of " + node.path +
                           " is neither tangent nor object; tangent is used");
        }
        network->coordinates = static_cast<std::uint32_t>(network->primvars.size());
        network->primvars.push_back({{kTangentPrimvars.begin(), kTangentPrimvars.end()}, 2, {}});
    }
    return network;
}

} // namespace hds
