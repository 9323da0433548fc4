// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/materialPrimvars.h"

#include "hdStream/shading/programWriter.h"

namespace hds {

namespace {

using Visited = std::set<const ShaderExpression*>;

void AddPrimvars(const ShaderValue& value, Visited* visited, std::set<std::string>* names) {
    if (!value || !visited->insert(value.expression.get()).second) {
        return;
    }
    if (!value.expression->primvar.empty()) {
        names->insert(value.expression->primvar);
    }
    for (const ShaderValue& operand : value.expression->operands) {
        AddPrimvars(operand, visited, names);
    }
}

} // namespace

std::set<std::string> PrimvarsOf(const CompiledMaterial& material) {
    std::set<std::string> names;
    Visited visited;
    for (const ShaderValue& value : material.values) {
        AddPrimvars(value, &visited, &names);
    }
    const ShaderValue& normal = material.values[HDS_INPUT_NORMAL];
    if ((material.constants.lobes & (HDS_LOBE_ANISOTROPY | HDS_LOBE_COAT_FRAME)) != 0 ||
        (material.constants.flags & HDS_MATERIAL_HAIR) != 0 || (normal && HasSlope(normal))) {
        names.insert(kTangentPrimvars.begin(), kTangentPrimvars.end());
    }
    if (!material.displacement.primvar.empty()) {
        names.insert(material.displacement.primvar);
    }
    if (material.displacement.network) {
        for (const DisplacementPrimvar& primvar : material.displacement.network->primvars) {
            names.insert(primvar.names.begin(), primvar.names.end());
        }
    }
    return names;
}

} // namespace hds
