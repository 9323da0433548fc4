// SPDX-License-Identifier: Apache-2.0
// Networks to records. Inputs and their defaults: kernels/shared/materialInputs.def; layered
// surfaces are read in layeredMaterial.cpp.
#include "hdStream/shading/materialCompiler.h"

#include "hdStream/geometry/displacement.h"
#include "hdStream/shading/arnoldNodes.h"
#include "hdStream/shading/arnoldPatterns.h"
#include "hdStream/shading/layeredMaterial.h"
#include "hdStream/shading/materialDisplacement.h"
#include "hdStream/shading/meshMedium.h"
#include "hdStream/shading/networkEvaluator.h"
#include "hdStream/shading/programWriter.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNetwork.h"
#include "hdStream/shading/shaderNodes.h"
#include "hdStream/shading/surfaceGraphs.h"
#include "hdStream/shading/valueResolver.h"
#include "kernels/shared/geometry.h"

#include <glm/common.hpp>

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

namespace hds {

namespace {

struct InputRow {
    const char* name;
    std::uint32_t numComponents;
    std::array<float, 4> fallback;
    bool isInRecord;
};

/// By HDS_INPUT_*.
constexpr InputRow kInputs[] = {
#define HDS_PREVIEW_INPUT(NAME, name, components, x, y, z, w) \
    {#name, components, {x, y, z, w}, true},
#define HDS_LAYERED_INPUT(NAME, name, components, x, y, z, w) \
    {#name, components, {x, y, z, w}, false},
#include "kernels/shared/materialInputs.def"
};

constexpr bool AreRecordInputsFirst() {
    for (std::uint32_t i = 0; i < HDS_NUM_LAYERED_INPUTS; ++i) {
        if (kInputs[i].isInRecord != (i < HDS_NUM_INPUTS)) {
            return false;
        }
    }
    return true;
}
static_assert(AreRecordInputsFirst());

void SetConstant(shared::HdsMaterial& material, std::uint32_t input,
                 const std::array<float, 4>& value) {
    material.constants[input] = {value[0], value[1], value[2], value[3]};
}

/// All constants at the specification's defaults, no slots, no program, no flags.
CompiledMaterial DefaultMaterial() {
    CompiledMaterial material;
    for (std::uint32_t i = 0; i < HDS_NUM_INPUTS; ++i) {
        SetConstant(material.constants, i, kInputs[i].fallback);
        material.constants.slots[i] = HDS_NONE;
    }
    material.constants.program = HDS_NONE;
    return material;
}

bool IsNormal(std::uint32_t input) {
    return input == HDS_INPUT_NORMAL || input == HDS_INPUT_COAT_NORMAL;
}

/// One component spreads over a colour, a scalar takes the first of many. Empty: a wrong type.
ShaderValue FitToInput(std::uint32_t input, ShaderValue value) {
    const InputRow& row = kInputs[input];
    if (row.numComponents == 1 || value.numComponents >= 3) {
        return value;
    }
    if (value.numComponents != 1 || IsNormal(input)) {
        return {};
    }
    if (IsConstant(value)) {
        const float x = ConstantOf(value)[0];
        return MakeConstant({x, x, x, 1.0F}, 3);
    }
    value.channel = value.channel == HDS_CHANNEL_ALL ? 0 : value.channel;
    return value;
}

/// Puts a value into an input: a constant, or what is resolved for each prim.
void SetInput(CompiledMaterial& material, std::uint32_t input, const ShaderValue& value,
              const MaterialNode& node, const std::string& materialPath, Warnings& warnings) {
    const ShaderValue fitted = FitToInput(input, value);
    if (!fitted) {
        warnings.Add(materialPath, std::string("input ") + kInputs[input].name + " of " +
                                       node.path + " has a wrong type");
    } else if (IsConstant(fitted) && kInputs[input].isInRecord) {
        SetConstant(material.constants, input, ConstantOf(fitted));
    } else if (!IsConstant(fitted) || ConstantOf(fitted) != kInputs[input].fallback) {
        material.values[input] = fitted;
    }
}

/// Puts a layered surface into a material of defaults.
void SetLayered(CompiledMaterial& material, const LayeredMaterial& layered,
                const MaterialNode& node, const std::string& materialPath, Warnings& warnings) {
    material.constants.flags |= layered.flags | DispersionFlags(layered);
    material.constants.lobes = layered.lobes;
    for (std::uint32_t i = 0; i < HDS_NUM_LAYERED_INPUTS; ++i) {
        if (layered.values[i]) {
            const ShaderValue value = kInputs[i].numComponents == 1 && !kInputs[i].isInRecord
                                          ? Spread(layered.values[i])
                                          : layered.values[i];
            SetInput(material, i, value, node, materialPath, warnings);
        }
    }
}

/// The node of the surface terminal when it is a known surface, else null with a warning.
const MaterialNode* FindSurface(const MaterialNetwork& network, const std::string& materialPath,
                                Warnings& warnings) {
    const MaterialNode* node = FindTerminalShader(network, "surface");
    if (node == nullptr) {
        warnings.Add(materialPath, "material has no surface shader; displayColor is used");
        return nullptr;
    }
    if (!IsSurfaceShader(node->identifier) || IsArnoldPattern(node->identifier)) {
        const std::string what = node->identifier.empty() ? node->path + ", which has no shader id,"
                                                          : node->identifier + " of " + node->path;
        warnings.Add(materialPath,
                     "surface shader " + what + " is not supported; displayColor is used");
        return nullptr;
    }
    return node;
}

/// The first look-up or primvar that an emission is made of.
/// \param searched functions that hold none: they are shared, and there may be exponentially many
/// ways to one
EmissionInput FindEmission(const ShaderValue& value, const std::vector<MaterialTexture>& textures,
                           std::set<const ShaderExpression*>* searched) {
    constexpr std::array<float, 3> kLuminance = {0.2126F, 0.7152F, 0.0722F};
    EmissionInput emission;
    if (!value || IsConstant(value)) {
        return emission;
    }
    const ShaderExpression& expression = *value.expression;
    const std::vector<ShaderValue>& operands = expression.operands;
    if (expression.kind == ShaderExpression::Kind::Primvar) {
        emission.primvar = expression.primvar;
        return emission;
    }
    const std::optional<DisplacementInput> lookup = LookupDisplacement(value, textures);
    if (lookup) {
        emission.primvar = lookup->primvar;
        emission.lookup = lookup->lookup;
        const bool isColor = value.channel == HDS_CHANNEL_ALL;
        for (std::uint32_t i = 0; i < (isColor ? 3 : 1); ++i) {
            const std::uint32_t channel = isColor ? i : value.channel;
            const float weight = isColor ? kLuminance[i] : 1.0F;
            emission.factors[channel] = weight * ConstantOf(operands[2])[channel];
            emission.bias += weight * ConstantOf(operands[3])[channel];
        }
        return emission;
    }
    if (expression.kind == ShaderExpression::Kind::Math && searched->insert(&expression).second) {
        for (const ShaderValue& operand : operands) {
            emission = FindEmission(operand, textures, searched);
            if (!emission.primvar.empty()) {
                break;
            }
        }
    }
    return emission;
}

void SetEmission(CompiledMaterial* material) {
    std::set<const ShaderExpression*> searched;
    material->emission =
        FindEmission(material->values[HDS_INPUT_EMISSIVE_COLOR], material->textures, &searched);
}

/// Whether an input is no constant.
bool Varies(const shared::HdsMaterial& m, std::uint32_t input) {
    return m.slots[input] != HDS_NONE || (m.programInputs >> input & 1U) != 0;
}

/// Whether a thin wall lets light through, straight on, at some point at least.
bool IsThinGlass(const shared::HdsMaterial& m) {
    return (m.flags & HDS_MATERIAL_THIN_WALLED) != 0 && (m.lobes & HDS_LOBE_TRANSMISSION) != 0 &&
           ((m.flags & HDS_MATERIAL_FROSTED) == 0 || Varies(m, HDS_INPUT_ROUGHNESS) ||
            m.constants[HDS_INPUT_ROUGHNESS].x <= HDS_CLEAR_ROUGHNESS);
}

/// Flags that follow from constants, slots and what the program sets.
std::uint32_t DerivedFlags(const shared::HdsMaterial& m) {
    std::uint32_t flags = 0;
    if (Varies(m, HDS_INPUT_OPACITY) || m.constants[HDS_INPUT_OPACITY].x < 1.0F || IsThinGlass(m)) {
        flags |= HDS_MATERIAL_CUTOUT;
    }
    if (!Varies(m, HDS_INPUT_OPACITY_THRESHOLD) && !IsThinGlass(m) &&
        m.constants[HDS_INPUT_OPACITY_THRESHOLD].x > 0.0F) {
        flags |= HDS_MATERIAL_MASK;
    }
    const shared::float4& emission = m.constants[HDS_INPUT_EMISSIVE_COLOR];
    if (Varies(m, HDS_INPUT_EMISSIVE_COLOR) || emission.x > 0.0F || emission.y > 0.0F ||
        emission.z > 0.0F) {
        flags |= HDS_MATERIAL_EMISSIVE;
    }
    const shared::float4& normal = m.constants[HDS_INPUT_NORMAL];
    if (Varies(m, HDS_INPUT_NORMAL) || normal.x != 0.0F || normal.y != 0.0F) {
        flags |= HDS_MATERIAL_NORMAL;
    }
    return flags;
}

/// Finds slots of a prim's attributes, then of its instances'; those that are too short warn.
class SlotFinder {
public:
    SlotFinder(const std::vector<AttributeName>& attributes,
               const std::vector<AttributeName>& ofInstances, const std::string& primPath,
               Warnings& warnings)
        : _attributes(attributes), _ofInstances(ofInstances), _primPath(primPath),
          _warnings(warnings) {}

    std::uint32_t operator()(const std::string& primvar, std::uint32_t numComponents) const {
        const std::uint32_t slot = FindIn(_attributes, HDS_SLOT_USER, primvar, numComponents);
        return slot != HDS_NONE ? slot
                                : FindIn(_ofInstances, HDS_SLOT_INSTANCE, primvar, numComponents);
    }

private:
    /// \param first slot of the list. \return HDS_NONE where there is none, or it is too short.
    std::uint32_t FindIn(const std::vector<AttributeName>& list, std::uint32_t first,
                         const std::string& primvar, std::uint32_t numComponents) const {
        const auto found = std::find_if(list.begin(), list.end(), [&](const AttributeName& one) {
            return one.name == primvar;
        });
        if (found == list.end()) {
            return HDS_NONE;
        }
        if (found->numComponents < numComponents) {
            _warnings.Add(_primPath,
                          "primvar " + primvar + " has " + std::to_string(found->numComponents) +
                              " components; its material needs " + std::to_string(numComponents));
            return HDS_NONE;
        }
        return first + static_cast<std::uint32_t>(found - list.begin());
    }

    const std::vector<AttributeName>& _attributes;
    const std::vector<AttributeName>& _ofInstances;
    const std::string& _primPath;
    Warnings& _warnings;
};

ShaderValue MakePrimvar(const char* name, const std::array<float, 4>& fallback,
                        std::uint32_t numComponents) {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Primvar;
    expression->primvar = name;
    expression->operands = {MakeConstant(fallback, numComponents)};
    return {std::move(expression), HDS_CHANNEL_ALL, numComponents};
}

/// Puts a resolved value where it belongs; `program` collects what is neither constant nor slot.
void PlaceValue(std::uint32_t input, const ShaderValue& value, const SlotCallback& findSlot,
                shared::HdsMaterial& record, std::vector<ProgramInput>& program) {
    const bool isInRecord = input < HDS_NUM_INPUTS;
    if (IsConstant(value) && isInRecord) {
        std::array<float, 4> constant = ConstantOf(value);
        if (kInputs[input].numComponents == 3 && value.numComponents == 1) {
            constant = {constant[0], constant[0], constant[0], 1.0F};
        }
        SetConstant(record, input, constant);
        return;
    }
    const ShaderExpression& expression = *value.expression;
    if (expression.kind == ShaderExpression::Kind::Primvar && value.channel == HDS_CHANNEL_ALL &&
        isInRecord) {
        record.slots[input] = findSlot(expression.primvar, kInputs[input].numComponents);
        if (IsConstant(expression.operands[0])) {
            SetConstant(record, input, ConstantOf(expression.operands[0]));
        }
        return;
    }
    program.push_back({input, value});
    record.programInputs |= isInRecord ? 1U << input : 0U;
    if (IsNormal(input) && HasFrame(value)) {
        record.flags |= HDS_MATERIAL_TANGENTS;
    }
}

} // namespace

namespace {

/// Of the coordinates that tangents belong to; HDS_NONE: there are none.
std::uint32_t FindTangents(const SlotFinder& findOwn) {
    std::uint32_t slot = HDS_NONE;
    for (const char* const name : kTangentPrimvars) {
        slot = slot == HDS_NONE ? findOwn(name, 2) : slot;
    }
    return slot;
}

/// Empty for prims that do not keep what it needs, and where the amount is the same everywhere.
ProgramRelief ResolveRelief(const MaterialRelief& relief, ValueResolver& resolver,
                            const SlotFinder& findOwn) {
    ProgramRelief result;
    result.movedSlot = findOwn(kMovedBy, 3);
    if (!relief.value || result.movedSlot == HDS_NONE) {
        return result;
    }
    const ShaderValue value =
        resolver.Resolve(relief.value, relief.space == HDS_DISPLACES_ALONG ? 1 : 3);
    if (IsConstant(value)) {
        return result;
    }
    result.value = value;
    result.space = relief.space;
    result.normalSlot = findOwn(kRestNormals, 3);
    result.coordinateSlot =
        relief.space == HDS_DISPLACES_TANGENT ? FindTangents(findOwn) : HDS_NONE;
    return result;
}

} // namespace

bool IsSurfaceShader(const std::string& identifier) {
    return identifier == "UsdPreviewSurface" ||
           identifier.compare(0, 20, "ND_UsdPreviewSurface") == 0 || IsLayered(identifier) ||
           HasSurfaceGraph(identifier) || IsArnoldSurface(identifier);
}

CompiledMaterial DisplayColorMaterial() {
    CompiledMaterial material = DefaultMaterial();
    SetConstant(material.constants, HDS_INPUT_DIFFUSE_COLOR, {0.5F, 0.5F, 0.5F, 1.0F});
    material.constants.flags = HDS_MATERIAL_LAMBERT;
    material.values[HDS_INPUT_DIFFUSE_COLOR] =
        MakePrimvar("displayColor", {0.5F, 0.5F, 0.5F, 1.0F}, 3);
    material.values[HDS_INPUT_OPACITY] = MakePrimvar("displayOpacity", {1.0F, 0.0F, 0.0F, 1.0F}, 1);
    return material;
}

CompiledMaterial BlackMaterial() {
    CompiledMaterial material = DefaultMaterial();
    SetConstant(material.constants, HDS_INPUT_DIFFUSE_COLOR, {0.0F, 0.0F, 0.0F, 1.0F});
    material.constants.flags = HDS_MATERIAL_LAMBERT;
    return material;
}

CompiledMaterial SplatMaterial(const char* harmonics) {
    CompiledMaterial material = BlackMaterial();
    material.constants.flags |= HDS_MATERIAL_SPLAT | HDS_MATERIAL_CUTOUT | HDS_MATERIAL_EMISSIVE;
    material.values[HDS_INPUT_EMISSIVE_COLOR] = MakePrimvar(harmonics, {0.0F, 0.0F, 0.0F, 1.0F}, 3);
    return material;
}

/// Lets all pass.
CompiledMaterial BoundaryMaterial() {
    CompiledMaterial material = BlackMaterial();
    SetConstant(material.constants, HDS_INPUT_OPACITY, {0.0F, 0.0F, 0.0F, 1.0F});
    return material;
}

shared::HdsMeshMedium InteriorOf(const CompiledMaterial& material, const std::string& primPath,
                                 Warnings& warnings) {
    const auto valueOf = [&](std::uint32_t input) {
        const ShaderValue& value = material.values[input];
        if (value && !IsConstant(value)) {
            warnings.Add(primPath, std::string("the ") + kInputs[input].name +
                                       " inside of it varies: where media have priorities it does "
                                       "not");
        }
        std::array<float, 4> constant = kInputs[input].fallback;
        if (input < HDS_NUM_INPUTS) {
            const shared::float4& own = material.constants.constants[input];
            constant = {own.x, own.y, own.z, own.w};
        }
        return value && IsConstant(value) ? ConstantOf(value) : constant;
    };
    const auto colorOf = [&](std::uint32_t input) {
        const std::array<float, 4> value = valueOf(input);
        return glm::max(glm::vec3(value[0], value[1], value[2]), glm::vec3(0.0F));
    };
    shared::HdsMeshMedium medium =
        MakeMeshMedium(colorOf(HDS_INPUT_ABSORPTION), colorOf(HDS_INPUT_SCATTERING),
                       valueOf(HDS_INPUT_SUBSURFACE)[2], glm::vec3(0.0F));
    medium.ior = std::clamp(valueOf(HDS_INPUT_IOR)[0], 0.1F, 10.0F);
    return medium;
}

bool HasConstantEmission(const shared::HdsMaterial& material) {
    return !Varies(material, HDS_INPUT_EMISSIVE_COLOR) &&
           (material.flags & HDS_MATERIAL_CUTOUT) == 0;
}

namespace {

/// Whether a displacement of MaterialX stands beside the surface.
bool HasOwnDisplacement(const MaterialNetwork& network) {
    const MaterialNode* node = FindTerminalShader(network, "displacement");
    return node != nullptr && node->identifier.rfind("ND_displacement", 0) == 0;
}

/// Of the terminal "surface".
CompiledMaterial CompileSurface(const MaterialNetwork& network, const std::string& materialPath,
                                const ImageQueries& images, Warnings& warnings) {
    NetworkEvaluator evaluator(network, materialPath, images, warnings);
    const MaterialNode* surface = FindSurface(network, materialPath, warnings);
    if (surface == nullptr) {
        return DisplayColorMaterial();
    }
    CompiledMaterial material = DefaultMaterial();
    if (const ShaderValue priority = evaluator.Evaluate(*surface, "dielectric_priority")) {
        if (IsConstant(priority)) {
            material.dielectricPriority = ConstantOf(priority)[0];
        }
    }
    if (IsLayered(surface->identifier)) {
        SetLayered(material, EvaluateLayered(evaluator, *surface), *surface, materialPath,
                   warnings);
        material.textures = evaluator.Textures();
        SetEmission(&material);
        SetMaterialXDisplacement(evaluator, network, materialPath, warnings, &material);
        return material;
    }
    evaluator.WarnOfWidth(*surface, "displacement", 1);
    for (std::uint32_t i = 0; i < HDS_NUM_INPUTS; ++i) {
        evaluator.WarnOfWidth(*surface, kInputs[i].name, kInputs[i].numComponents);
        if (const ShaderValue value = evaluator.Evaluate(*surface, kInputs[i].name)) {
            SetInput(material, i, value, *surface, materialPath, warnings);
        }
    }
    const ShaderValue workflow = evaluator.Evaluate(*surface, "useSpecularWorkflow");
    if (IsConstant(workflow) && ConstantOf(workflow)[0] != 0.0F) {
        material.constants.flags |= HDS_MATERIAL_SPECULAR_WORKFLOW;
    }
    const std::string mode = evaluator.Text(*surface, "opacityMode");
    const ShaderValue number = // in MaterialX's definition
        mode.empty() ? evaluator.Evaluate(*surface, "opacityMode") : ShaderValue();
    if (mode == "presence" || (IsConstant(number) && ConstantOf(number)[0] == 1.0F)) {
        material.constants.flags |= HDS_MATERIAL_PRESENCE;
    } else if (!mode.empty() && mode != "transparent") {
        warnings.Add(materialPath, "opacityMode is " + mode + "; transparent is used");
    }
    material.textures = evaluator.Textures(); // without what only displaces
    SetEmission(&material);
    if (HasOwnDisplacement(network)) {
        SetMaterialXDisplacement(evaluator, network, materialPath, warnings, &material);
    } else {
        SetDisplacement(evaluator.Evaluate(*surface, "displacement"), evaluator.Textures(),
                        materialPath, warnings, &material);
    }
    return material;
}

} // namespace

CompiledMaterial CompileMaterial(const MaterialNetwork& authored, const std::string& materialPath,
                                 const ImageQueries& images, Warnings& warnings) {
    const MaterialNetwork network = ExpandGraphs(
        JoinShaders(TranslateArnold(authored, materialPath, warnings), materialPath, warnings));
    const auto medium = ReadMeshMedium(network, materialPath, warnings);
    const bool isBoundary =
        network.terminals.count("volume") > 0 && network.terminals.count("surface") == 0;
    CompiledMaterial material =
        isBoundary ? BoundaryMaterial() : CompileSurface(network, materialPath, images, warnings);
    material.meshMedium = medium;
    return material;
}

ResolvedMaterial ResolveMaterial(const CompiledMaterial& material,
                                 const std::vector<std::uint32_t>& textures,
                                 const std::vector<AttributeName>& attributes,
                                 const std::vector<AttributeName>& ofInstances,
                                 const std::string& primPath, Warnings& warnings) {
    ResolvedMaterial result;
    result.record = material.constants;
    const SlotCallback findSlot = SlotFinder(attributes, ofInstances, primPath, warnings);
    ValueResolver resolver(findSlot);
    std::vector<ProgramInput> inputs;
    for (std::uint32_t i = 0; i < HDS_NUM_LAYERED_INPUTS; ++i) {
        if (material.values[i]) {
            const ShaderValue value =
                resolver.Resolve(material.values[i], kInputs[i].numComponents);
            PlaceValue(i, value, findSlot, result.record, inputs);
        }
    }
    const std::vector<AttributeName> none;
    const SlotFinder findOwn(attributes, none, primPath, warnings);
    ProgramRelief relief = ResolveRelief(material.relief, resolver, findOwn);
    if (!inputs.empty() || relief.value) {
        std::uint32_t tangentSlot = HDS_NONE;
        const bool needsFrame =
            std::any_of(inputs.begin(), inputs.end(), [](const ProgramInput& one) {
                return IsNormal(one.input) && (HasSlope(one.value) || !HasFrame(one.value));
            });
        constexpr std::uint32_t kTurned = HDS_LOBE_ANISOTROPY | HDS_LOBE_COAT_FRAME;
        if (needsFrame || (result.record.lobes & kTurned) != 0 ||
            (result.record.flags & HDS_MATERIAL_HAIR) != 0) {
            // Coordinates that are the same all over a prim have no tangents.
            tangentSlot = FindTangents(findOwn);
            result.record.flags |= tangentSlot == HDS_NONE ? 0U : HDS_MATERIAL_TANGENTS;
        }
        result.program = WriteProgram(inputs, textures, findSlot, tangentSlot, relief);
        if (result.program.empty() && relief.value) {
            warnings.Add(primPath, "its displacement is too deep for the shader machine; shading "
                                   "adds nothing to what its triangles have of it");
            result.program = inputs.empty() ? std::vector<std::uint32_t>()
                                            : WriteProgram(inputs, textures, findSlot, tangentSlot);
        }
        result.record.flags |= NeedsFilteredTexels(result.program) ? HDS_MATERIAL_COMPUTES : 0U;
        result.record.lobes |= HasInside(result.program) ? HDS_LOBE_COVERED : 0U;
        if (result.program.empty() && !inputs.empty()) {
            warnings.Add(primPath, "its material is too deep for the shader machine; the inputs "
                                   "that it computes keep their defaults");
            result.record.programInputs = 0;
        }
    }
    result.record.flags |= DerivedFlags(result.record);
    return result;
}

} // namespace hds
