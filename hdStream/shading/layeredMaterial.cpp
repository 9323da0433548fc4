// SPDX-License-Identifier: Apache-2.0
// Sources of names, defaults and formulas: Georgiev et al. 2019, "Autodesk Standard Surface";
// Andersson et al. 2024, "OpenPBR Surface" 1.1; Khronos glTF 2.0; their MaterialX 1.39 definitions.
#include "hdStream/shading/layeredMaterial.h"

#include "hdStream/base/error.h"
#include "hdStream/shading/closureTree.h"
#include "hdStream/shading/emissionForm.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNodes.h"
#include "hdStream/shading/surfaceFrame.h"
#include "hdStream/shading/surfaceInputs.h"
#include "hdStream/shading/thinWall.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// The inputs of a model.
class InputTable {
public:
    template <std::size_t kCount>
    explicit constexpr InputTable(const SurfaceInput (&inputs)[kCount])
        : _begin(inputs), _end(inputs + kCount) {}
    const SurfaceInput* begin() const { return _begin; }
    const SurfaceInput* end() const { return _end; }

private:
    const SurfaceInput* _begin;
    const SurfaceInput* _end;
};

/// Reads one surface shader.
class ModelReader {
public:
    ModelReader(NetworkEvaluator& network, const MaterialNode& node, const InputTable& inputs)
        : _network(network), _node(node), _inputs(inputs) {}

    LayeredMaterial StandardSurface() {
        const ShaderValue base = Read("base");
        const ShaderValue coat = Read("coat");
        const ShaderValue gamma =
            Add(MakeScalar(1.0F), Multiply(coat, Read("coat_affect_color"), 1), 1);
        const ShaderValue color = Multiply(base, Power(Read("base_color"), gamma, 3), 3);
        const ShaderValue subsurface = Power(Read("subsurface_color"), gamma, 3);
        const ShaderValue specular = Read("specular");
        const ShaderValue specularColor = Read("specular_color");
        const ShaderValue metalness = Read("metalness");
        SetThinWalled("thin_walled");
        SetDiffuse(color, subsurface, Read("subsurface"), MakeScalar(1.0F));
        SetSubsurface(color, subsurface, Read("subsurface"),
                      Multiply(Read("subsurface_radius"), Read("subsurface_scale"), 3),
                      "subsurface_anisotropy");
        Set(HDS_INPUT_DIFFUSE_ROUGHNESS, Read("diffuse_roughness"));
        Set(HDS_INPUT_DIELECTRIC, OneMinus(metalness, 1));
        Set(HDS_INPUT_METALLIC, metalness);
        SetConductor(Multiply(base, Read("base_color"), 3), Multiply(specular, specularColor, 3),
                     &_result);
        Set(HDS_INPUT_SPECULAR_WEIGHT, specular);
        Set(HDS_INPUT_SPECULAR_COLOR, specularColor);
        Set(HDS_INPUT_IOR, Read("specular_IOR"));
        const ShaderValue affect =
            Multiply(Read("coat_affect_roughness"), Multiply(coat, Read("coat_roughness"), 1), 1);
        Set(HDS_INPUT_ROUGHNESS, Mix(Read("specular_roughness"), MakeScalar(1.0F), affect, 1));
        SetStandardStretch(HDS_INPUT_STRETCH, "specular_anisotropy", "specular_rotation");
        SetTransmission("transmission", "transmission_color", "transmission_depth");
        Set(HDS_INPUT_SHEEN, Read("sheen"));
        Set(HDS_INPUT_SHEEN_COLOR, Read("sheen_color"));
        Set(HDS_INPUT_SHEEN_ROUGHNESS, Read("sheen_roughness"));
        Set(HDS_INPUT_CLEARCOAT, coat);
        Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, Read("coat_roughness"));
        Set(HDS_INPUT_COAT_IOR, Read("coat_IOR"));
        const ShaderValue tint = Mix(MakeScalar(1.0F), Read("coat_color"), coat, 3);
        Set(HDS_INPUT_COAT_TINT, tint);
        Set(HDS_INPUT_EMISSIVE_COLOR,
            CoatedEmission(Multiply(Read("emission"), Read("emission_color"), 3), coat,
                           Read("coat_IOR"), Read("coat_color")));
        SetFilm(MakeScalar(1.0F), Read("thin_film_thickness"), Read("thin_film_IOR"));
        SetOpacity(Read("opacity"));
        SetNormal("normal");
        Ignore("transmission_extra_roughness", {"transmission"});
        const float abbe = Uniform("transmission_dispersion", {"transmission"});
        SetDispersion(abbe > 0.0F ? 1.0F / abbe : 0.0F);
        SetCoatNormal("coat_normal", {"coat"});
        if (AreShown({"coat", "coat_anisotropy"})) {
            SetStandardStretch(HDS_INPUT_COAT_STRETCH, "coat_anisotropy", "coat_rotation");
        }
        return Take();
    }

    LayeredMaterial OpenPbr() {
        const ShaderValue color = Multiply(Read("base_weight"), Read("base_color"), 3);
        const ShaderValue coat = Read("coat_weight");
        const ShaderValue coatIor = Read("coat_ior");
        const ShaderValue coatRoughness = Read("coat_roughness");
        const ShaderValue metalness = Read("base_metalness");
        const ShaderValue specular = Read("specular_weight");
        const ShaderValue specularColor = Read("specular_color");
        const ShaderValue subsurface = Read("subsurface_weight");
        _result.flags |= HDS_MATERIAL_FUZZ;
        SetThinWalled("geometry_thin_walled");
        SetDiffuse(color, Read("subsurface_color"), subsurface, MakeScalar(0.5F));
        SetSubsurface(color, Read("subsurface_color"), subsurface,
                      Multiply(Read("subsurface_radius"), Read("subsurface_radius_scale"), 3),
                      "subsurface_scatter_anisotropy");
        Set(HDS_INPUT_DIFFUSE_ROUGHNESS, Read("base_diffuse_roughness"));
        Set(HDS_INPUT_DIELECTRIC, OneMinus(metalness, 1));
        Set(HDS_INPUT_METALLIC, Multiply(metalness, specular, 1));
        Set(HDS_INPUT_METAL_COLOR, color);
        Set(HDS_INPUT_EDGE_COLOR, specularColor);
        Set(HDS_INPUT_SPECULAR_COLOR, specularColor);
        Set(HDS_INPUT_IOR, OpenPbrIor(specular, coat, coatIor));
        const ShaderValue four = MakeScalar(4.0F);
        const ShaderValue roughness = Read("specular_roughness");
        const ShaderValue sum = Add(Multiply(MakeScalar(2.0F), Power(coatRoughness, four, 1), 1),
                                    Power(roughness, four, 1), 1);
        const ShaderValue rougher =
            Power(MakeMath(HDS_MATH_MIN, {sum, MakeScalar(1.0F)}, 1), MakeScalar(0.25F), 1);
        Set(HDS_INPUT_ROUGHNESS, Mix(roughness, rougher, coat, 1));
        SetOpenPbrStretch(HDS_INPUT_STRETCH, "specular_roughness_anisotropy", "geometry_tangent");
        SetTransmission("transmission_weight", "transmission_color", "transmission_depth");
        Set(HDS_INPUT_SHEEN, Read("fuzz_weight"));
        Set(HDS_INPUT_SHEEN_COLOR, Read("fuzz_color"));
        Set(HDS_INPUT_SHEEN_ROUGHNESS, Read("fuzz_roughness"));
        Set(HDS_INPUT_CLEARCOAT, coat);
        Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, coatRoughness);
        Set(HDS_INPUT_COAT_IOR, coatIor);
        const ShaderValue tint = Mix(MakeScalar(1.0F), Read("coat_color"), coat, 3);
        Set(HDS_INPUT_COAT_TINT,
            Multiply(tint, OpenPbrDarkening(subsurface, metalness, specular, coat, coatIor), 3));
        Set(HDS_INPUT_EMISSIVE_COLOR,
            CoatedEmission(Multiply(Read("emission_luminance"), Read("emission_color"), 3), coat,
                           coatIor, Read("coat_color")));
        const ShaderValue nanometres =
            Multiply(Read("thin_film_thickness"), MakeScalar(1000.0F), 1);
        SetFilm(Read("thin_film_weight"), nanometres, Read("thin_film_ior"));
        SetOpacity(Read("geometry_opacity"));
        SetNormal("geometry_normal");
        const float scale = Uniform("transmission_dispersion_scale", {"transmission_weight"});
        const float abbe = Uniform("transmission_dispersion_abbe_number",
                                   {"transmission_weight", "transmission_dispersion_scale"});
        SetDispersion(abbe > 0.0F ? scale / abbe : 0.0F);
        SetCoatNormal("geometry_coat_normal", {"coat_weight"});
        if (AreShown({"coat_weight", "coat_roughness_anisotropy"})) {
            SetOpenPbrStretch(HDS_INPUT_COAT_STRETCH, "coat_roughness_anisotropy",
                              "geometry_coat_tangent");
        }
        return Take();
    }

    LayeredMaterial Gltf() {
        const ShaderValue color = Read("base_color");
        const ShaderValue metallic = Read("metallic");
        const ShaderValue thickness = Read("thickness");
        if (IsAll(thickness, 0.0F)) {
            _result.flags |= HDS_MATERIAL_THIN_WALLED;
        }
        Set(HDS_INPUT_DIFFUSE_COLOR, color);
        Set(HDS_INPUT_DIELECTRIC, OneMinus(metallic, 1));
        Set(HDS_INPUT_METALLIC, metallic);
        Set(HDS_INPUT_METAL_COLOR, color);
        Set(HDS_INPUT_IOR, Read("ior"));
        SetGltfReflection();
        Set(HDS_INPUT_ROUGHNESS, Read("roughness"));
        Set(HDS_INPUT_TRANSMISSION, Read("transmission"));
        Set(HDS_INPUT_TRANSMISSION_COLOR, color);
        const ShaderValue distance = Read("attenuation_distance");
        SetAbsorption(Read("attenuation_color"), distance);
        SetGltfSheen();
        Set(HDS_INPUT_CLEARCOAT, Read("clearcoat"));
        Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, Read("clearcoat_roughness"));
        Set(HDS_INPUT_EMISSIVE_COLOR, Multiply(Read("emissive_strength"), Read("emissive"), 3));
        const ShaderValue mode = Read("alpha_mode");
        if (!IsAll(mode, 0.0F)) {
            SetOpacity(Read("alpha"));
        }
        if (IsAll(mode, 1.0F)) {
            Set(HDS_INPUT_OPACITY_THRESHOLD, Read("alpha_cutoff"));
        }
        SetNormal("normal");
        SetFilm(Read("iridescence"), Read("iridescence_thickness"), Read("iridescence_ior"));
        SetGltfStretch();
        constexpr float kGltfAbbe = 20.0F; // of dispersion 1
        SetDispersion(Uniform("dispersion", {"transmission"}) / kGltfAbbe);
        SetCoatNormal("clearcoat_normal", {"clearcoat"});
        return Take();
    }

    LayeredMaterial Unlit() {
        Set(HDS_INPUT_DIELECTRIC, MakeScalar(0.0F));
        Set(HDS_INPUT_DIFFUSE_COLOR, MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, 3));
        Set(HDS_INPUT_EMISSIVE_COLOR, Multiply(Read("emission"), Read("emission_color"), 3));
        SetOpacity(Read("opacity"));
        Ignore("transmission");
        return Take();
    }

private:
    /// An input as the model's table has it.
    ShaderValue Read(std::string_view name) {
        const auto* found = std::find_if(_inputs.begin(), _inputs.end(),
                                         [&](const SurfaceInput& one) { return one.name == name; });
        HDS_VERIFY(found != _inputs.end(), "an input that its model does not list");
        const std::array<float, 3>& c = found->fallback;
        const std::array<float, 4> fallback{c[0], c[1], c[2],
                                            found->numComponents == 1 ? c[0] : 1.0F};
        return _network.EvaluateOr(_node, std::string(name), fallback, found->numComponents);
    }
    void Set(std::uint32_t input, const ShaderValue& value) { _result.values[input] = value; }

    void SetThinWalled(const char* input) {
        _result.flags |= IsThinWall(_network, _node, input) ? HDS_MATERIAL_THIN_WALLED : 0U;
    }

    /// \param transmitted share of the subsurface that a thin wall lets through
    void SetDiffuse(const ShaderValue& color, const ShaderValue& subsurface,
                    const ShaderValue& weight, const ShaderValue& transmitted) {
        if ((_result.flags & HDS_MATERIAL_THIN_WALLED) == 0) {
            Set(HDS_INPUT_DIFFUSE_COLOR, Mix(color, subsurface, weight, 3));
            return;
        }
        const ShaderValue reflected = Multiply(OneMinus(transmitted, 1), subsurface, 3);
        Set(HDS_INPUT_DIFFUSE_COLOR, Mix(color, reflected, weight, 3));
        Set(HDS_INPUT_TRANSLUCENCY, Multiply(Multiply(transmitted, weight, 1), subsurface, 3));
    }

    /// Light that walks below the surface, where that is not a thin wall. A mean free path of 0 is
    /// diffuse reflection.
    void SetSubsurface(const ShaderValue& color, const ShaderValue& subsurface,
                       const ShaderValue& weight, const ShaderValue& radius,
                       const char* anisotropy) {
        if ((_result.flags & HDS_MATERIAL_THIN_WALLED) != 0 || IsAll(weight, 0.0F) ||
            IsAll(radius, 0.0F)) {
            return;
        }
        Set(HDS_INPUT_DIFFUSE_COLOR, Multiply(color, OneMinus(weight, 1), 3));
        Set(HDS_INPUT_SUBSURFACE_COLOR, subsurface);
        Set(HDS_INPUT_SUBSURFACE_RADIUS, radius);
        _subsurface = {weight, Read(anisotropy), MakeScalar(0.0F), MakeScalar(0.0F)};
        _result.flags |= HDS_MATERIAL_MEDIUM;
    }

    void SetStandardStretch(std::uint32_t input, const char* name, const char* rotation) {
        const ShaderValue anisotropy = Read(name);
        if (IsAll(anisotropy, 0.0F)) {
            return;
        }
        const ShaderValue limited = MakeMath(HDS_MATH_MIN, {anisotropy, MakeScalar(0.98F)}, 1);
        const ShaderValue aspect = MakeMath(HDS_MATH_SQRT, {OneMinus(limited, 1)}, 1);
        SetStretch(input, Divide(MakeScalar(1.0F), aspect, 1), aspect,
                   Add(TurnsOf("tangent"), Read(rotation), 1));
    }

    void SetOpenPbrStretch(std::uint32_t input, const char* name, const char* tangent) {
        const ShaderValue anisotropy = Read(name);
        if (IsAll(anisotropy, 0.0F)) {
            return;
        }
        const ShaderValue left = OneMinus(anisotropy, 1);
        const ShaderValue along = MakeMath(
            HDS_MATH_SQRT,
            {Divide(MakeScalar(2.0F), Add(Multiply(left, left, 1), MakeScalar(1.0F), 1), 1)}, 1);
        SetStretch(input, along, Multiply(left, along, 1), TurnsOf(tangent));
    }

    /// The square of the strength brings GGX's alpha along x to 1.
    void SetGltfStretch() {
        const ShaderValue strength = Read("anisotropy_strength");
        if (IsAll(strength, 0.0F)) {
            return;
        }
        const ShaderValue roughness = Read("roughness");
        const ShaderValue alpha =
            MakeMath(HDS_MATH_MAX, {Multiply(roughness, roughness, 1), MakeScalar(1e-6F)}, 1);
        const ShaderValue along = Mix(alpha, MakeScalar(1.0F), Multiply(strength, strength, 1), 1);
        const ShaderValue turns =
            Multiply(Read("anisotropy_rotation"), MakeScalar(kTurnsOfRadian), 1);
        SetStretch(HDS_INPUT_STRETCH, Divide(along, alpha, 1), MakeScalar(1.0F),
                   Add(TurnsOf("tangent"), turns, 1));
    }

    /// Over all but the coat; its strongest channel is its weight.
    void SetGltfSheen() {
        const ShaderValue color = Read("sheen_color");
        if (IsAll(color, 0.0F)) {
            return;
        }
        ShaderValue strongest = SelectChannel(color, 0);
        for (std::uint32_t k = 1; k < 3; ++k) {
            strongest = MakeMath(HDS_MATH_MAX, {strongest, SelectChannel(color, k)}, 1);
        }
        const ShaderValue divisor = MakeMath(HDS_MATH_MAX, {strongest, MakeScalar(1e-6F)}, 1);
        const ShaderValue roughness = Read("sheen_roughness");
        Set(HDS_INPUT_SHEEN, strongest);
        Set(HDS_INPUT_SHEEN_COLOR, Divide(color, divisor, 3));
        Set(HDS_INPUT_SHEEN_ROUGHNESS, Multiply(roughness, roughness, 1));
        _result.flags |= HDS_MATERIAL_SHEEN_OVER;
    }

    /// The colour tints what is reflected at normal incidence and not at grazing angles, and a film
    /// lies on what the weight has scaled: both need Schlick's term, where others do without.
    void SetGltfReflection() {
        const ShaderValue weight = Read("specular");
        const ShaderValue color = Read("specular_color");
        Set(HDS_INPUT_SPECULAR_COLOR, MakeConstant({1.0F, 1.0F, 1.0F, 1.0F}, 3));
        const bool hasFilm =
            !IsAll(Read("iridescence"), 0.0F) && !IsAll(Read("iridescence_thickness"), 0.0F);
        if (IsAll(weight, 0.0F) || (IsAll(color, 1.0F) && (!hasFilm || IsAll(weight, 1.0F)))) {
            Set(HDS_INPUT_SPECULAR_WEIGHT, weight);
            return;
        }
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue ior = Read("ior");
        const ShaderValue root = Divide(Subtract(ior, one, 1), Add(ior, one, 1), 1);
        const ShaderValue tinted = Multiply(color, Multiply(root, root, 1), 3);
        Set(HDS_INPUT_SPECULAR_WEIGHT, one);
        Set(HDS_INPUT_SCHLICK_EXPONENT, MakeScalar(5.0F));
        Set(HDS_INPUT_SCHLICK_COLOR, Multiply(MakeMath(HDS_MATH_MIN, {tinted, one}, 3), weight, 3));
        Set(HDS_INPUT_SCHLICK_GRAZING, weight);
    }

    ShaderValue TurnsOf(const char* tangent) { return EvaluateTangent(_network, _node, tangent); }

    void SetStretch(std::uint32_t input, const ShaderValue& along, const ShaderValue& across,
                    const ShaderValue& turns) {
        Set(input, MakeMath(HDS_MATH_COMBINE, {along, across, turns, MakeScalar(0.0F)}, 4));
    }

    /// \param thickness in nanometres
    void SetFilm(const ShaderValue& weight, const ShaderValue& thickness,
                 const ShaderValue& index) {
        if (!IsAll(weight, 0.0F) && !IsAll(thickness, 0.0F)) {
            Set(HDS_INPUT_FILM,
                MakeMath(HDS_MATH_COMBINE, {weight, thickness, index, MakeScalar(0.0F)}, 4));
        }
    }

    void SetTransmission(const char* weight, const char* color, const char* depth) {
        const ShaderValue tint = Read(color);
        const ShaderValue distance = Read(depth);
        Set(HDS_INPUT_TRANSMISSION, Read(weight));
        if (IsAll(distance, 0.0F)) {
            Set(HDS_INPUT_TRANSMISSION_COLOR, tint);
        } else {
            SetAbsorption(tint, distance);
            SetScattering(Divide(Read("transmission_scatter"), distance, 3));
        }
    }

    /// What scatters is a part of the extinction that SetAbsorption has set; where it is more, the
    /// extinction is raised for all colours alike, until no absorption is below 0.
    void SetScattering(const ShaderValue& scattering) {
        if ((_result.flags & HDS_MATERIAL_THIN_WALLED) != 0 || IsAll(scattering, 0.0F) ||
            !_result.values[HDS_INPUT_TRANSMISSION] ||
            IsAll(_result.values[HDS_INPUT_TRANSMISSION], 0.0F)) {
            return;
        }
        const ShaderValue left = Subtract(_result.values[HDS_INPUT_ABSORPTION], scattering, 3);
        ShaderValue missing = MakeScalar(0.0F);
        for (std::uint32_t k = 0; k < 3; ++k) {
            missing = MakeMath(HDS_MATH_MIN, {missing, SelectChannel(left, k)}, 1);
        }
        Set(HDS_INPUT_ABSORPTION, Subtract(left, missing, 3));
        Set(HDS_INPUT_SCATTERING, scattering);
        _subsurface[2] = Read("transmission_scatter_anisotropy");
        _result.flags |= HDS_MATERIAL_MEDIUM;
    }

    /// What is left after a distance is `color`. Colours of 0 are taken as 0.001.
    void SetAbsorption(const ShaderValue& color, const ShaderValue& distance) {
        if (IsAll(distance, 0.0F)) {
            return;
        }
        const ShaderValue visible = MakeMath(HDS_MATH_MAX, {color, MakeScalar(1e-3F)}, 3);
        const ShaderValue depth =
            Subtract(MakeScalar(0.0F), MakeMath(HDS_MATH_LN, {visible}, 3), 3);
        Set(HDS_INPUT_ABSORPTION, Divide(depth, distance, 3));
    }

    /// The index as the weight and the coat change it (OpenPBR 1.1, sections 3.2 and 3.7).
    ShaderValue OpenPbrIor(const ShaderValue& weight, const ShaderValue& coat,
                           const ShaderValue& coatIor) {
        const ShaderValue ior = Read("specular_ior");
        const ShaderValue below =
            MakeMath(HDS_MATH_MAX, {Divide(ior, coatIor, 1), Divide(coatIor, ior, 1)}, 1);
        const ShaderValue eta = Mix(ior, below, coat, 1);
        if (IsAll(weight, 1.0F)) {
            return eta;
        }
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue root = Divide(Subtract(eta, one, 1), Add(eta, one, 1), 1);
        const ShaderValue scaled = MakeMath(
            HDS_MATH_MIN, {Multiply(weight, Multiply(root, root, 1), 1), MakeScalar(0.99999F)}, 1);
        const ShaderValue epsilon =
            Multiply(MakeMath(HDS_MATH_SIGN, {root}, 1), MakeMath(HDS_MATH_SQRT, {scaled}, 1), 1);
        return Divide(Add(one, epsilon, 1), OneMinus(epsilon, 1), 1);
    }

    /// What light that bounces between coat and base loses (OpenPBR 1.1, section 3.7, node graph).
    ShaderValue OpenPbrDarkening(const ShaderValue& subsurface, const ShaderValue& metalness,
                                 const ShaderValue& specular, const ShaderValue& coat,
                                 const ShaderValue& coatIor) {
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue root = Divide(Subtract(coatIor, one, 1), Add(coatIor, one, 1), 1);
        const ShaderValue inside = OneMinus(
            Divide(OneMinus(Multiply(root, root, 1), 1), Multiply(coatIor, coatIor, 1), 1), 1);
        const ShaderValue color = Read("base_color");
        const ShaderValue dielectric = Mix(color, Read("subsurface_color"), subsurface, 3);
        const ShaderValue base = Mix(dielectric, Multiply(color, specular, 3), metalness, 3);
        const ShaderValue left =
            Divide(OneMinus(inside, 1), OneMinus(Multiply(base, inside, 3), 3), 3);
        return Mix(one, left, Multiply(coat, Read("coat_darkening"), 1), 3);
    }

    /// A colour counts by its luminance.
    void SetOpacity(const ShaderValue& opacity) {
        if (opacity.numComponents == 1 || (IsConstant(opacity) && IsGrey(opacity))) {
            Set(HDS_INPUT_OPACITY, SelectFirst(opacity));
            return;
        }
        const ShaderValue weights = MakeConstant({0.2722287F, 0.6740818F, 0.0536895F, 0.0F}, 3);
        Set(HDS_INPUT_OPACITY, MakeMath(HDS_MATH_DOT, {opacity, weights}, 1));
    }
    static bool IsGrey(const ShaderValue& value) {
        const std::array<float, 4>& c = ConstantOf(value);
        return c[0] == c[1] && c[1] == c[2];
    }
    static ShaderValue SelectFirst(const ShaderValue& value) {
        return value.numComponents == 1 ? value : SelectChannel(value, 0);
    }

    using Names = std::initializer_list<const char*>;

    /// \pre SetNormal.
    void SetCoatNormal(const char* input, Names shownBy) {
        if (AreShown(shownBy)) {
            SetOwnNormal(EvaluateNormal(_network, _node, input), &_result);
        }
    }
    void SetNormal(const char* input) {
        if (ShaderValue normal = EvaluateNormal(_network, _node, input)) {
            Set(HDS_INPUT_NORMAL, normal);
        }
    }

    /// The value of an input that is the same all over a surface; 0 of one that is not shown, and
    /// of one that varies, with a warning.
    float Uniform(const char* input, Names shownBy) {
        if (!AreShown(shownBy)) {
            return 0.0F;
        }
        const ShaderValue value = Read(input);
        if (!IsConstant(value)) {
            Warn(input, "varies, which is not supported, and is left out");
            return 0.0F;
        }
        return ConstantOf(value)[0];
    }
    void SetDispersion(float dispersion) {
        if ((_result.flags & HDS_MATERIAL_THIN_WALLED) == 0) {
            _result.dispersion = dispersion > 0.0F ? dispersion : 0.0F;
        }
    }

    /// Warns where the input and all that it shows by are not 0.
    void Ignore(const char* input, Names shownBy = {}) {
        if (AreShown(shownBy) && !IsAll(Read(input), 0.0F)) {
            Warn(input, "is not supported and is left out");
        }
    }
    bool AreShown(Names inputs) {
        return std::none_of(inputs.begin(), inputs.end(),
                            [&](const char* input) { return IsAll(Read(input), 0.0F); });
    }
    void Warn(const std::string& input, const std::string& what) {
        WarnOf(_network, _node, input, what);
    }

    LayeredMaterial Take() {
        if ((_result.flags & HDS_MATERIAL_MEDIUM) != 0) {
            Set(HDS_INPUT_SUBSURFACE,
                MakeMath(HDS_MATH_COMBINE,
                         {_subsurface[0], _subsurface[1], _subsurface[2], _subsurface[3]}, 4));
        }
        if ((_result.flags & HDS_MATERIAL_THIN_WALLED) != 0) {
            FrostThinWall(&_result);
        }
        FinishLayered(&_result);
        return std::move(_result);
    }

    NetworkEvaluator& _network;
    const MaterialNode& _node;
    const InputTable& _inputs;
    LayeredMaterial _result;
    /// The components of HDS_INPUT_SUBSURFACE.
    std::array<ShaderValue, 4> _subsurface{MakeScalar(0.0F), MakeScalar(0.0F), MakeScalar(0.0F),
                                           MakeScalar(0.0F)};
};

struct Model {
    std::string_view name; ///< begins its id: versions follow
    LayeredMaterial (ModelReader::*read)();
    InputTable inputs;
};

constexpr Model kModels[] = {
    {"ND_standard_surface_surfaceshader", &ModelReader::StandardSurface,
     InputTable(kStandardSurfaceInputs)},
    {"ND_open_pbr_surface_surfaceshader", &ModelReader::OpenPbr, InputTable(kOpenPbrInputs)},
    {"ND_gltf_pbr_surfaceshader", &ModelReader::Gltf, InputTable(kGltfInputs)},
    {"ND_surface_unlit", &ModelReader::Unlit, InputTable(kUnlitInputs)}};

/// Null: none of them.
const Model* FindModel(std::string_view identifier) {
    const auto* found = std::find_if(std::begin(kModels), std::end(kModels), [&](const Model& one) {
        return identifier.substr(0, one.name.size()) == one.name;
    });
    return found == std::end(kModels) ? nullptr : found;
}

} // namespace

bool IsLayered(const std::string& identifier) {
    return FindModel(identifier) != nullptr || IsClosureSurface(identifier);
}

LayeredMaterial EvaluateLayered(NetworkEvaluator& network, const MaterialNode& node) {
    if (IsClosureSurface(node.identifier)) {
        return EvaluateClosureSurface(network, node);
    }
    const Model& model = *FindModel(node.identifier);
    for (const SurfaceInput& input : model.inputs) {
        network.WarnOfWidth(node, std::string(input.name), input.numComponents);
    }
    ModelReader reader(network, node, model.inputs);
    return (reader.*model.read)();
}

std::vector<SurfaceInput> SurfaceInputs(const std::string& identifier) {
    const Model* model = FindModel(identifier);
    return model == nullptr ? std::vector<SurfaceInput>()
                            : std::vector<SurfaceInput>(model->inputs.begin(), model->inputs.end());
}

} // namespace hds
