// SPDX-License-Identifier: Apache-2.0
// Source of names, defaults and meanings: MaterialX 1.39, pbrlib.
#include "hdStream/shading/closureTree.h"

#include "hdStream/shading/closureReflectance.h"
#include "hdStream/shading/closureSlab.h"
#include "hdStream/shading/emissionForm.h"
#include "hdStream/shading/nodeWalk.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNodes.h"
#include "hdStream/shading/surfaceFrame.h"
#include "hdStream/shading/surfaceGraphs.h"
#include "hdStream/shading/thinWall.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>

namespace hds {

namespace {

/// More surfaces side by side than this are not kept: programs would become long.
constexpr std::size_t kMaxSlabs = 32;

/// Reads the closures that a surface is made of.
class ClosureReader {
public:
    explicit ClosureReader(NetworkEvaluator& network, bool isThin = false)
        : _network(network), _isThin(isThin) {}

    ClosureSlabs Bsdf(const MaterialNode& node, const std::string& input);
    /// What is emitted; empty: nothing.
    ShaderValue Edf(const MaterialNode& node, const std::string& input);

    // One function for each kind of closure.
    ClosureSlabs OrenNayar(const MaterialNode& node) {
        ClosureSlab slab = Diffuse(node, 0.18F);
        slab.layered.values[HDS_INPUT_DIFFUSE_ROUGHNESS] = Scalar(node, "roughness", 0.0F);
        return {slab};
    }
    ClosureSlabs Subsurface(const MaterialNode& node) {
        const ShaderValue radius = Color(node, "radius", 1.0F);
        if (_isThin || IsAll(radius, 0.0F)) {
            return {Diffuse(node, 0.18F)};
        }
        ClosureSlab slab = BlackSlab();
        LayeredMaterial& layered = slab.layered;
        layered.flags |= HDS_MATERIAL_MEDIUM;
        layered.values[HDS_INPUT_SUBSURFACE] =
            MakeMath(HDS_MATH_COMBINE,
                     {Scalar(node, "weight", 1.0F), Scalar(node, "anisotropy", 0.0F),
                      MakeScalar(0.0F), MakeScalar(0.0F)},
                     4);
        layered.values[HDS_INPUT_SUBSURFACE_COLOR] = Color(node, "color", 0.18F);
        layered.values[HDS_INPUT_SUBSURFACE_RADIUS] = radius;
        layered.values[HDS_INPUT_NORMAL] = EvaluateNormal(_network, node, "normal");
        return {slab};
    }
    ClosureSlabs Translucent(const MaterialNode& node) {
        ClosureSlab slab = Diffuse(node, 1.0F);
        slab.layered.values[HDS_INPUT_TRANSLUCENCY] = slab.layered.values[HDS_INPUT_DIFFUSE_COLOR];
        slab.layered.values[HDS_INPUT_DIFFUSE_COLOR] = MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, 3);
        return {slab};
    }
    ClosureSlabs Dielectric(const MaterialNode& node) {
        ClosureSlab slab = Rough(node);
        const ShaderValue weight = Scalar(node, "weight", 1.0F);
        const ShaderValue tint = Color(node, "tint", 1.0F);
        const std::string mode = _network.Text(node, "scatter_mode");
        LayeredMaterial& layered = slab.layered;
        layered.values[HDS_INPUT_IOR] = Scalar(node, "ior", 1.5F);
        layered.values[HDS_INPUT_SPECULAR_COLOR] = tint;
        SetFilm(node, &layered);
        if (mode.empty() || mode == "R") {
            layered.values[HDS_INPUT_SPECULAR_WEIGHT] = weight;
            return {slab};
        }
        SetTransmission(&layered);
        layered.values[HDS_INPUT_TRANSMISSION_COLOR] = tint;
        layered.values[HDS_INPUT_SPECULAR_WEIGHT] = MakeScalar(mode == "RT" ? 1.0F : 0.0F);
        slab.factor = weight;
        return {slab};
    }
    ClosureSlabs Conductor(const MaterialNode& node) {
        ClosureSlab slab = MetalSlab(node);
        const MaterialNode* source = _network.FindSource(node, "ior");
        if (source != nullptr && source->identifier == "ND_artistic_ior" &&
            source == _network.FindSource(node, "extinction")) {
            SetConductor(
                _network.EvaluateOr(*source, "reflectivity", {0.944F, 0.776F, 0.373F, 1.0F}, 3),
                _network.EvaluateOr(*source, "edge_color", {0.998F, 0.981F, 0.751F, 1.0F}, 3),
                &slab.layered);
            return {slab};
        }
        const ShaderValue index =
            _network.EvaluateOr(node, "ior", {0.183F, 0.421F, 1.373F, 1.0F}, 3);
        const ShaderValue extinction =
            _network.EvaluateOr(node, "extinction", {3.424F, 2.346F, 1.770F, 1.0F}, 3);
        const ShaderValue color = ConductorReflectance(index, extinction);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue root = MakeMath(HDS_MATH_SQRT, {color}, 3);
        const ShaderValue least = Divide(OneMinus(color, 3), Add(one, color, 3), 3);
        const ShaderValue most = Divide(Add(one, root, 3), OneMinus(root, 3), 3);
        const ShaderValue edge = Divide(Subtract(most, index, 3), Subtract(most, least, 3), 3);
        SetConductor(color, edge, &slab.layered);
        return {slab};
    }
    ClosureSlabs GeneralizedSchlick(const MaterialNode& node) {
        const std::string mode = _network.Text(node, "scatter_mode");
        const ShaderValue front = Color(node, "color0", 1.0F);
        const ShaderValue edge = Color(node, "color82", 1.0F);
        const bool isReflected = mode.empty() || mode == "R";
        const bool isSchlicks = IsAll(Color(node, "color90", 1.0F), 1.0F) &&
                                IsAll(Scalar(node, "exponent", 5.0F), 5.0F);
        if (isReflected && isSchlicks && !IsDielectricGrey(front)) {
            return Metal(node, front, edge);
        }
        ClosureSlab slab = Rough(node);
        LayeredMaterial& layered = slab.layered;
        const ShaderValue weight = Scalar(node, "weight", 1.0F);
        layered.values[HDS_INPUT_IOR] = IndexOfReflectance(front);
        layered.values[HDS_INPUT_SPECULAR_WEIGHT] = weight;
        SetFilm(node, &layered);
        if (!isReflected) {
            layered.values[HDS_INPUT_SPECULAR_WEIGHT] = MakeScalar(mode == "RT" ? 1.0F : 0.0F);
            SetTransmission(&layered);
            slab.factor = weight;
        }
        if (mode != "T" && !(isSchlicks && IsDielectricGrey(front) && IsAll(edge, 1.0F))) {
            layered.values[HDS_INPUT_SCHLICK_EXPONENT] =
                MakeMath(HDS_MATH_MAX, {Scalar(node, "exponent", 5.0F), MakeScalar(1e-4F)}, 1);
            layered.values[HDS_INPUT_SCHLICK_COLOR] = front;
            layered.values[HDS_INPUT_SCHLICK_GRAZING] = Color(node, "color90", 1.0F);
            layered.values[HDS_INPUT_SCHLICK_EDGE] = edge;
        }
        return {slab};
    }
    ClosureSlabs Sheen(const MaterialNode& node) {
        ClosureSlab slab = BlackSlab();
        LayeredMaterial& layered = slab.layered;
        layered.values[HDS_INPUT_SHEEN] = Scalar(node, "weight", 1.0F);
        layered.values[HDS_INPUT_SHEEN_COLOR] = Color(node, "color", 1.0F);
        layered.values[HDS_INPUT_SHEEN_ROUGHNESS] = Scalar(node, "roughness", 0.3F);
        layered.values[HDS_INPUT_NORMAL] = EvaluateNormal(_network, node, "normal");
        layered.flags |= _network.Text(node, "mode") == "zeltner" ? HDS_MATERIAL_FUZZ : 0U;
        return {slab};
    }
    ClosureSlabs ChiangHair(const MaterialNode& node) {
        ClosureSlab slab;
        slab.share = MakeScalar(1.0F);
        slab.factor = MakeScalar(1.0F);
        LayeredMaterial& layered = slab.layered;
        layered.flags |= HDS_MATERIAL_HAIR;
        layered.values[HDS_INPUT_HAIR] = MakeScalar(1.0F);
        layered.values[HDS_INPUT_HAIR_TINT_R] = Color(node, "tint_R", 1.0F);
        layered.values[HDS_INPUT_HAIR_TINT_TT] = Color(node, "tint_TT", 1.0F);
        layered.values[HDS_INPUT_HAIR_TINT_TRT] = Color(node, "tint_TRT", 1.0F);
        layered.values[HDS_INPUT_IOR] = Scalar(node, "ior", 1.55F);
        const std::array<ShaderValue, 3> roughness = {
            _network.EvaluateOr(node, "roughness_R", {0.1F, 0.1F}, 2),
            _network.EvaluateOr(node, "roughness_TT", {0.05F, 0.05F}, 2),
            _network.EvaluateOr(node, "roughness_TRT", {0.2F, 0.2F}, 2)};
        const auto channels = [&](std::uint32_t k) {
            return MakeMath(HDS_MATH_COMBINE,
                            {SelectChannel(roughness[0], k), SelectChannel(roughness[1], k),
                             SelectChannel(roughness[2], k), MakeScalar(0.0F)},
                            4);
        };
        layered.values[HDS_INPUT_HAIR_VARIANCE] = channels(0);
        layered.values[HDS_INPUT_HAIR_SCALE] = channels(1);
        layered.values[HDS_INPUT_HAIR_CUTICLE_ANGLE] = Scalar(node, "cuticle_angle", 0.5F);
        layered.values[HDS_INPUT_HAIR_ABSORPTION] =
            _network.EvaluateOr(node, "absorption_coefficient", {}, 3);
        layered.values[HDS_INPUT_NORMAL] = EvaluateNormal(_network, node, "normal");
        if (node.connections.count("curve_direction") == 0 ||
            !IsSurfaces(_network, node, "curve_direction")) {
            layered.values[HDS_INPUT_HAIR_DIRECTION] = _network.Evaluate(node, "curve_direction");
        }
        return {slab};
    }
    ClosureSlabs Layer(const MaterialNode& node) {
        return LayerSlabs(Bsdf(node, "top"), Bsdf(node, "base"));
    }
    ClosureSlabs LayerMedium(const MaterialNode& node);
    ClosureSlabs MixBsdf(const MaterialNode& node) {
        const ShaderValue share = Scalar(node, "mix", 0.0F);
        if (IsAll(share, 0.0F) || IsAll(share, 1.0F)) {
            return Bsdf(node, IsAll(share, 0.0F) ? "bg" : "fg");
        }
        return MixSlabs(Bsdf(node, "bg"), Bsdf(node, "fg"), share);
    }
    ClosureSlabs AddBsdf(const MaterialNode& node) {
        return AddSlabs(Bsdf(node, "in1"), Bsdf(node, "in2"));
    }
    ClosureSlabs MultiplyBsdf(const MaterialNode& node) {
        return MultiplySlabs(Bsdf(node, "in1"), Color(node, "in2", 1.0F));
    }

    ShaderValue UniformEdf(const MaterialNode& node) { return Color(node, "color", 1.0F); }
    ShaderValue MeasuredEdf(const MaterialNode& node) {
        _network.Warn(node.path + ": it emits alike in all directions");
        return UniformEdf(node);
    }
    ShaderValue ConicalEdf(const MaterialNode& node) {
        if (!IsSurfaces(_network, node, "normal")) {
            WarnOf(_network, node, "normal", kSurfacesFrame);
        }
        return Multiply(
            UniformEdf(node),
            ConicalEmission(Scalar(node, "inner_angle", 60.0F), Scalar(node, "outer_angle", 0.0F)),
            3);
    }
    ShaderValue SchlickEdf(const MaterialNode& node) {
        const ShaderValue base = Edf(node, "base");
        return base ? Multiply(base,
                               SchlickEmission(Color(node, "color0", 1.0F),
                                               Color(node, "color90", 1.0F),
                                               Scalar(node, "exponent", 5.0F)),
                               3)
                    : base;
    }
    ShaderValue MixEdf(const MaterialNode& node) {
        return Mix(OrBlack(Edf(node, "bg")), OrBlack(Edf(node, "fg")), Scalar(node, "mix", 0.0F),
                   3);
    }
    ShaderValue AddEdf(const MaterialNode& node) {
        return Add(OrBlack(Edf(node, "in1")), OrBlack(Edf(node, "in2")), 3);
    }
    ShaderValue MultiplyEdf(const MaterialNode& node) {
        return Multiply(OrBlack(Edf(node, "in1")), Color(node, "in2", 1.0F), 3);
    }

    ShaderValue Scalar(const MaterialNode& node, const char* input, float fallback) {
        return _network.EvaluateOr(node, input, {fallback, fallback, fallback, fallback}, 1);
    }
    ShaderValue Color(const MaterialNode& node, const char* input, float fallback) {
        return _network.EvaluateOr(node, input, {fallback, fallback, fallback, 1.0F}, 3);
    }
    static ShaderValue OrBlack(const ShaderValue& value) {
        return value ? value : MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, 3);
    }

private:
    void WarnOfUnknown(const MaterialNode* closure) {
        if (closure != nullptr) {
            _network.Warn("closure " + closure->identifier + " of " + closure->path +
                          " is not supported and is left out");
        }
    }

    ClosureSlab Diffuse(const MaterialNode& node, float fallback) {
        ClosureSlab slab = BlackSlab();
        slab.layered.values[HDS_INPUT_DIFFUSE_COLOR] =
            Multiply(Scalar(node, "weight", 1.0F), Color(node, "color", fallback), 3);
        slab.layered.values[HDS_INPUT_NORMAL] = EvaluateNormal(_network, node, "normal");
        return slab;
    }

    /// A black slab with the roughness of a node of microfacets, which gives GGX's alpha along x
    /// and y.
    ClosureSlab Rough(const MaterialNode& node) {
        ClosureSlab slab = BlackSlab();
        if (!IsAll(Scalar(node, "retroreflective", 0.0F), 0.0F)) {
            slab.layered.values[HDS_INPUT_RETRO] = Scalar(node, "retroreflective", 0.0F);
        }
        const ShaderValue alpha = _network.EvaluateOr(node, "roughness", {0.05F, 0.05F}, 2);
        const ShaderValue x = SelectChannel(alpha, 0);
        const ShaderValue y = SelectChannel(alpha, 1);
        const bool isRound = IsConstant(alpha) ? ConstantOf(alpha)[0] == ConstantOf(alpha)[1]
                                               : IsOfOneRoughness(node);
        const auto root = [](const ShaderValue& value) {
            return MakeMath(HDS_MATH_SQRT, {value}, 1);
        };
        if (isRound) {
            slab.layered.values[HDS_INPUT_ROUGHNESS] = root(x);
        } else {
            const ShaderValue mean =
                MakeMath(HDS_MATH_MAX, {root(Multiply(x, y, 1)), MakeScalar(1e-6F)}, 1);
            slab.layered.values[HDS_INPUT_ROUGHNESS] = root(mean);
            slab.layered.values[HDS_INPUT_STRETCH] =
                MakeMath(HDS_MATH_COMBINE,
                         {Divide(x, mean, 1), Divide(y, mean, 1),
                          EvaluateTangent(_network, node, "tangent"), MakeScalar(0.0F)},
                         4);
        }
        slab.layered.values[HDS_INPUT_NORMAL] = EvaluateNormal(_network, node, "normal");
        return slab;
    }

    void SetTransmission(LayeredMaterial* layered) {
        layered->values[HDS_INPUT_TRANSMISSION] = MakeScalar(1.0F);
        if (_isThin) {
            FrostThinWall(layered);
        }
    }

    /// Whether the node that gives a roughness has no anisotropy.
    bool IsOfOneRoughness(const MaterialNode& node) {
        const MaterialNode* source = _network.FindSource(node, "roughness");
        return source != nullptr && source->identifier.find("_anisotropy") != std::string::npos &&
               IsAll(Scalar(*source, "anisotropy", 0.0F), 0.0F);
    }

    /// A metal without a colour.
    ClosureSlab MetalSlab(const MaterialNode& node) {
        ClosureSlab slab = Rough(node);
        slab.layered.values[HDS_INPUT_DIELECTRIC] = MakeScalar(0.0F);
        slab.layered.values[HDS_INPUT_METALLIC] = Scalar(node, "weight", 1.0F);
        SetFilm(node, &slab.layered);
        return slab;
    }

    ClosureSlabs Metal(const MaterialNode& node, const ShaderValue& front,
                       const ShaderValue& edge) {
        ClosureSlab slab = MetalSlab(node);
        slab.layered.values[HDS_INPUT_METAL_COLOR] = front;
        slab.layered.values[HDS_INPUT_EDGE_COLOR] = edge;
        return {slab};
    }

    void SetFilm(const MaterialNode& node, LayeredMaterial* layered) {
        const ShaderValue thickness = Scalar(node, "thinfilm_thickness", 0.0F);
        if (!IsAll(thickness, 0.0F)) {
            layered->values[HDS_INPUT_FILM] = MakeMath(
                HDS_MATH_COMBINE,
                {MakeScalar(1.0F), thickness, Scalar(node, "thinfilm_ior", 1.5F), MakeScalar(0.0F)},
                4);
        }
    }

    NetworkEvaluator& _network;
    bool _isThin;        ///< of a thin wall
    bool _isCut = false; ///< there is a warning of too many closures
    NodeWalk<ClosureSlabs> _bsdfs;
    NodeWalk<ShaderValue> _edfs;
};

struct BsdfType {
    std::string_view id;
    ClosureSlabs (ClosureReader::*read)(const MaterialNode& node);
};

constexpr BsdfType kBsdfs[] = {
    {"ND_oren_nayar_diffuse_bsdf", &ClosureReader::OrenNayar},
    {"ND_burley_diffuse_bsdf", &ClosureReader::OrenNayar},
    {"ND_subsurface_bsdf", &ClosureReader::Subsurface},
    {"ND_translucent_bsdf", &ClosureReader::Translucent},
    {"ND_dielectric_bsdf", &ClosureReader::Dielectric},
    {"ND_conductor_bsdf", &ClosureReader::Conductor},
    {"ND_generalized_schlick_bsdf", &ClosureReader::GeneralizedSchlick},
    {"ND_sheen_bsdf", &ClosureReader::Sheen},
    {"ND_chiang_hair_bsdf", &ClosureReader::ChiangHair},
    {"ND_layer_bsdf", &ClosureReader::Layer},
    {"ND_layer_vdf", &ClosureReader::LayerMedium},
    {"ND_mix_bsdf", &ClosureReader::MixBsdf},
    {"ND_add_bsdf", &ClosureReader::AddBsdf},
    {"ND_multiply_bsdfC", &ClosureReader::MultiplyBsdf},
    {"ND_multiply_bsdfF", &ClosureReader::MultiplyBsdf},
};

struct EdfType {
    std::string_view id;
    ShaderValue (ClosureReader::*read)(const MaterialNode& node);
};

constexpr EdfType kEdfs[] = {
    {"ND_uniform_edf", &ClosureReader::UniformEdf},
    {"ND_conical_edf", &ClosureReader::ConicalEdf},
    {"ND_measured_edf", &ClosureReader::MeasuredEdf},
    {"ND_generalized_schlick_edf", &ClosureReader::SchlickEdf},
    {"ND_mix_edf", &ClosureReader::MixEdf},
    {"ND_add_edf", &ClosureReader::AddEdf},
    {"ND_multiply_edfC", &ClosureReader::MultiplyEdf},
    {"ND_multiply_edfF", &ClosureReader::MultiplyEdf},
};

constexpr std::string_view kSurface = "ND_surface";
constexpr std::string_view kMixSurface = "ND_mix_surfaceshader";
constexpr std::string_view kAbsorption = "ND_absorption_vdf";
constexpr std::string_view kAnisotropic = "ND_anisotropic_vdf";

template <typename Type, std::size_t kCount>
const Type* FindType(const Type (&types)[kCount], const MaterialNode* node) {
    const auto* found = std::find_if(std::begin(types), std::end(types), [&](const Type& one) {
        return node != nullptr && one.id == node->identifier;
    });
    return found == std::end(types) ? nullptr : found;
}

/// The first of a node's slabs. \param[in,out] isTold whether there is a warning
ClosureSlabs AtMost(std::size_t count, ClosureSlabs slabs, const MaterialNode& node,
                    NetworkEvaluator& network, bool* isTold) {
    if (slabs.size() > count) {
        if (!std::exchange(*isTold, true)) {
            network.Warn(node.path + ": only the first " + std::to_string(count) + " of its " +
                         std::to_string(slabs.size()) + " closures are drawn");
        }
        slabs.resize(count);
    }
    return slabs;
}

ClosureSlabs ClosureReader::Bsdf(const MaterialNode& node, const std::string& input) {
    const MaterialNode* source = _network.FindSource(node, input);
    const BsdfType* type = FindType(kBsdfs, source);
    if (source == nullptr || type == nullptr) {
        WarnOfUnknown(source);
        return {};
    }
    const auto slabs = _bsdfs.Visit(*source, [&] {
        return AtMost(kMaxSlabs, (this->*type->read)(*source), *source, _network, &_isCut);
    });
    if (!slabs) {
        _network.Warn(_bsdfs.EndText(node));
    }
    return slabs.value_or(ClosureSlabs());
}

ShaderValue ClosureReader::Edf(const MaterialNode& node, const std::string& input) {
    const MaterialNode* source = _network.FindSource(node, input);
    const EdfType* type = FindType(kEdfs, source);
    if (source == nullptr || type == nullptr) {
        WarnOfUnknown(source);
        return {};
    }
    const auto value = _edfs.Visit(*source, [&] { return (this->*type->read)(*source); });
    if (!value) {
        _network.Warn(_edfs.EndText(node));
    }
    return value.value_or(ShaderValue());
}

ClosureSlabs ClosureReader::LayerMedium(const MaterialNode& node) {
    ClosureSlabs slabs = Bsdf(node, "top");
    const MaterialNode* medium = _network.FindSource(node, "base");
    if (medium == nullptr) {
        return slabs;
    }
    if (medium->identifier != kAbsorption && medium->identifier != kAnisotropic) {
        WarnOfUnknown(medium);
        return slabs;
    }
    const ShaderValue absorption = _network.EvaluateOr(*medium, "absorption", {}, 3);
    const ShaderValue scattering = medium->identifier == kAnisotropic && !_isThin
                                       ? _network.EvaluateOr(*medium, "scattering", {}, 3)
                                       : MakeScalar(0.0F);
    for (ClosureSlab& slab : slabs) {
        LayeredMaterial& layered = slab.layered;
        if (!layered.values[HDS_INPUT_TRANSMISSION]) {
            continue;
        }
        layered.values[HDS_INPUT_ABSORPTION] = absorption;
        if (!IsAll(scattering, 0.0F)) {
            layered.flags |= HDS_MATERIAL_MEDIUM;
            layered.values[HDS_INPUT_SCATTERING] = scattering;
            layered.values[HDS_INPUT_SUBSURFACE] =
                MakeMath(HDS_MATH_COMBINE,
                         {MakeScalar(0.0F), MakeScalar(0.0F), Scalar(*medium, "anisotropy", 0.0F),
                          MakeScalar(0.0F)},
                         4);
        }
    }
    return slabs;
}

/// A surface and what shows it.
struct WholeSurface {
    ClosureSlabs slabs;
    ShaderValue opacity;
    ShaderValue emission;
    std::uint32_t flags = 0;
};

WholeSurface ReadClosures(NetworkEvaluator& network, const MaterialNode& node) {
    const bool isThinWall = IsThinWall(network, node, "thin_walled");
    ClosureReader reader(network, isThinWall);
    WholeSurface surface;
    surface.slabs = reader.Bsdf(node, "bsdf");
    surface.emission = reader.Edf(node, "edf");
    surface.opacity = reader.Scalar(node, "opacity", 1.0F);
    surface.flags |= isThinWall ? HDS_MATERIAL_THIN_WALLED : 0U;
    return surface;
}

/// One of the other models.
WholeSurface ReadModel(NetworkEvaluator& network, const MaterialNode& node) {
    WholeSurface surface;
    ClosureSlab slab{EvaluateLayered(network, node), MakeScalar(1.0F), MakeScalar(1.0F)};
    surface.opacity = std::exchange(slab.layered.values[HDS_INPUT_OPACITY], {});
    surface.emission = std::exchange(slab.layered.values[HDS_INPUT_EMISSIVE_COLOR], {});
    surface.opacity = surface.opacity ? surface.opacity : MakeScalar(1.0F);
    surface.slabs = {slab};
    return surface;
}

using SurfaceWalk = NodeWalk<WholeSurface>;

WholeSurface ReadSurface(NetworkEvaluator& network, const MaterialNode* node, SurfaceWalk& walk);

WholeSurface ReadMix(NetworkEvaluator& network, const MaterialNode& node, SurfaceWalk& walk) {
    ClosureReader reader(network);
    const ShaderValue share = reader.Scalar(node, "mix", 0.0F);
    WholeSurface back = ReadSurface(network, network.FindSource(node, "bg"), walk);
    WholeSurface front = ReadSurface(network, network.FindSource(node, "fg"), walk);
    WholeSurface both;
    both.flags = back.flags | front.flags;
    both.opacity = Mix(back.opacity, front.opacity, share, 1);
    // Opacity weighs both what is reflected and what is emitted.
    const bool areOpaque = IsAll(back.opacity, 1.0F) && IsAll(front.opacity, 1.0F);
    const ShaderValue part =
        areOpaque ? share
                  : Divide(Multiply(share, front.opacity, 1),
                           MakeMath(HDS_MATH_MAX, {both.opacity, MakeScalar(1e-6F)}, 1), 1);
    if (back.emission || front.emission) {
        both.emission = Mix(ClosureReader::OrBlack(back.emission),
                            ClosureReader::OrBlack(front.emission), part, 3);
    }
    bool isTold = false;
    both.slabs = AtMost(kMaxSlabs, MixSlabs(std::move(back.slabs), std::move(front.slabs), part),
                        node, network, &isTold);
    return both;
}

WholeSurface ReadSurface(NetworkEvaluator& network, const MaterialNode* node, SurfaceWalk& walk) {
    WholeSurface nothing;
    nothing.opacity = MakeScalar(1.0F);
    if (node == nullptr) {
        return nothing;
    }
    const auto surface = walk.Visit(*node, [&] {
        if (node->identifier == kMixSurface) {
            return ReadMix(network, *node, walk);
        }
        if (node->identifier == kSurface) {
            return ReadClosures(network, *node);
        }
        if (IsLayered(node->identifier)) {
            return ReadModel(network, *node);
        }
        network.Warn("surface shader " + node->identifier + " of " + node->path +
                     " cannot be mixed; black is used");
        return nothing;
    });
    if (!surface) {
        network.Warn(walk.EndText(*node));
    }
    return surface.value_or(nothing);
}

} // namespace

bool IsClosureSurface(const std::string& identifier) {
    return identifier == kSurface || identifier == kMixSurface;
}

LayeredMaterial EvaluateClosureSurface(NetworkEvaluator& network, const MaterialNode& node) {
    SurfaceWalk walk;
    WholeSurface surface = ReadSurface(network, &node, walk);
    LayeredMaterial layered = ChooseSlab(std::move(surface.slabs));
    layered.flags |= surface.flags;
    layered.values[HDS_INPUT_OPACITY] = surface.opacity;
    if (surface.emission) {
        layered.values[HDS_INPUT_EMISSIVE_COLOR] = surface.emission;
    }
    FinishLayered(&layered);
    return layered;
}

std::vector<std::string> ClosureIds() {
    std::vector<std::string> ids{std::string(kAbsorption), std::string(kAnisotropic)};
    std::transform(std::begin(kBsdfs), std::end(kBsdfs), std::back_inserter(ids),
                   [](const BsdfType& one) { return std::string(one.id); });
    std::transform(std::begin(kEdfs), std::end(kEdfs), std::back_inserter(ids),
                   [](const EdfType& one) { return std::string(one.id); });
    const std::vector<std::string> graphs = ClosureGraphIds();
    ids.insert(ids.end(), graphs.begin(), graphs.end());
    std::sort(ids.begin(), ids.end());
    return ids;
}

} // namespace hds
