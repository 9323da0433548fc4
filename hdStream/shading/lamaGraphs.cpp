// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/lamaGraphs.h"

#include <iterator>

namespace hds {

namespace {

using namespace graphRows;

using Rows = std::vector<GraphNode>;
using Defaults = std::map<std::string, std::vector<float>>;

const std::vector<float>& White() {
    static const std::vector<float> kWhite = {1.0F, 1.0F, 1.0F};
    return kWhite;
}

Rows operator+(Rows rows, const Rows& more) {
    rows.insert(rows.end(), more.begin(), more.end());
    return rows;
}

/// GGX's alpha along x and y, "alpha", of the roughness along x and another along y.
Rows AlphaOf(const GraphSource& across) {
    return {
        {"both", "combine2_vector2", {{"in1", From("roughness")}, {"in2", across}}},
        {"squared", "power_vector2FA", {{"in1", Of("both")}, {"in2", Is({2.0F})}}},
        {"alpha", "max_vector2FA", {{"in1", Of("squared")}, {"in2", Is({0.000001F})}}},
    };
}

/// The same of an anisotropy, which brings the roughness across to 1 or, below 0, to 0.
Rows AnisotropicAlpha() {
    return Rows{
               {"smoothness", "subtract_float", {{"in1", Is({1.0F})}, {"in2", From("roughness")}}},
               {"room",
                "ifgreatereq_float",
                {{"value1", From("anisotropy")},
                 {"value2", Is({0.0F})},
                 {"in1", Of("smoothness")},
                 {"in2", From("roughness")}}},
               {"more", "multiply_float", {{"in1", From("anisotropy")}, {"in2", Of("room")}}},
               {"sum", "add_float", {{"in1", From("roughness")}, {"in2", Of("more")}}},
               {"across", "clamp_float", {{"in", Of("sum")}}},
           } +
           AlphaOf(Of("across"));
}

/// "tangent", the direction of an anisotropy, turned about the normal.
Rows Turned(const char* direction, const char* rotation) {
    return {
        {"axis", "normal_vector3", {{"space", Named("world")}}},
        {"degrees", "multiply_float", {{"in1", From(rotation)}, {"in2", Is({-360.0F})}}},
        {"tangent",
         "rotate3d_vector3",
         {{"in", From(direction)}, {"amount", Of("degrees")}, {"axis", Of("axis")}}},
    };
}

/// "interior", what absorbs and scatters in a body.
Rows Interior() {
    return {
        {"absorption",
         "divide_color3FA",
         {{"in1", From("absorptionColor")}, {"in2", From("absorptionRadius")}}},
        {"absorptionVector", "convert_color3_vector3", {{"in", Of("absorption")}}},
        {"scatteringVector", "convert_color3_vector3", {{"in", From("scatterColor")}}},
        {"interior",
         "anisotropic_vdf",
         {{"absorption", Of("absorptionVector")},
          {"scattering", Of("scatteringVector")},
          {"anisotropy", From("scatterAnisotropy")}}},
    };
}

const Defaults& InteriorDefaults() {
    static const Defaults kDefaults = {{"absorptionColor", White()},
                                       {"absorptionRadius", {1.0F}},
                                       {"scatterColor", {0.0F, 0.0F, 0.0F}},
                                       {"scatterAnisotropy", {0.0F}}};
    return kDefaults;
}

Defaults WithInterior(Defaults defaults) {
    defaults.insert(InteriorDefaults().begin(), InteriorDefaults().end());
    return defaults;
}

GraphNode OrenNayar(const char* name, float isCompensated) {
    return {name,
            "oren_nayar_diffuse_bsdf",
            {{"color", From("color")},
             {"roughness", Of("roughness")},
             {"normal", From("normal")},
             {"energy_compensation", Is({isCompensated})}}};
}

NodeGraph Diffuse() {
    return {
        "ND_lama_diffuse",
        {{"color", {0.18F, 0.18F, 0.18F}}, {"roughness", {0.0F}}, {"energyCompensation", {1.0F}}},
        {{"squared", "multiply_float", {{"in1", From("roughness")}, {"in2", From("roughness")}}},
         {"roughness", "multiply_float", {{"in1", Of("squared")}, {"in2", Is({0.5F})}}},
         OrenNayar("plain", 0.0F),
         OrenNayar("compensated", 1.0F),
         {"",
          "mix_bsdf",
          {{"bg", Of("plain")}, {"fg", Of("compensated")}, {"mix", From("energyCompensation")}}}}};
}

NodeGraph Translucent() {
    return {"ND_lama_translucent",
            {{"color", {0.18F, 0.18F, 0.18F}}},
            {{"", "translucent_bsdf", {{"color", From("color")}, {"normal", From("normal")}}}}};
}

NodeGraph Sheen() {
    return {
        "ND_lama_sheen",
        {{"color", White()}, {"roughness", {0.1F}}},
        {{"compressed", "multiply_float", {{"in1", From("roughness")}, {"in2", Is({0.9F})}}},
         {"remapped", "add_float", {{"in1", Of("compressed")}, {"in2", Is({0.1F})}}},
         {"squared", "power_float", {{"in1", Of("remapped")}, {"in2", Is({2.0F})}}},
         {"",
          "sheen_bsdf",
          {{"color", From("color")}, {"roughness", Of("squared")}, {"normal", From("normal")}}}}};
}

NodeGraph Subsurface() {
    return {
        "ND_lama_sss",
        {{"color", {0.18F, 0.18F, 0.18F}},
         {"sssRadius", {0.0F, 0.0F, 0.0F}},
         {"sssScale", {1.0F}},
         {"sssAnisotropy", {0.0F}},
         {"sssUnitLength", {0.00328F}}},
        {{"scaled", "multiply_color3FA", {{"in1", From("sssRadius")}, {"in2", From("sssScale")}}},
         {"radius", "multiply_color3FA", {{"in1", Of("scaled")}, {"in2", From("sssUnitLength")}}},
         {"",
          "subsurface_bsdf",
          {{"color", From("color")},
           {"radius", Of("radius")},
           {"anisotropy", From("sssAnisotropy")},
           {"normal", From("normal")}}}}};
}

GraphNode DielectricPart(const char* name, const char* tint, const char* mode) {
    return {name,
            "dielectric_bsdf",
            {{"tint", From(tint)},
             {"ior", Of("ior")},
             {"roughness", Of("alpha")},
             {"normal", From("normal")},
             {"tangent", Of("tangent")},
             {"scatter_mode", Named(mode)}}};
}

NodeGraph Dielectric() {
    return {
        "ND_lama_dielectric",
        WithInterior({{"reflectionTint", White()},
                      {"transmissionTint", White()},
                      {"fresnelMode", {0.0F}},
                      {"IOR", {1.5F}},
                      {"reflectivity", {0.04F}},
                      {"roughness", {0.1F}},
                      {"anisotropy", {0.0F}},
                      {"rotation", {0.0F}}}),
        AnisotropicAlpha() + Turned("direction", "rotation") + Interior() +
            Rows{{"reflectivity", "convert_float_color3", {{"in", From("reflectivity")}}},
                 {"artistic",
                  "artistic_ior",
                  {{"reflectivity", Of("reflectivity")}, {"edge_color", Is({0.0F, 0.0F, 0.0F})}}},
                 {"artisticIor",
                  "extract_color3",
                  {{"in", Of("artistic", "ior")}, {"index", Is({0.0F})}}},
                 {"ior",
                  "switch_float",
                  {{"in1", Of("artisticIor")},
                   {"in2", From("IOR")},
                   {"which", From("fresnelMode")}}},
                 DielectricPart("transmission", "transmissionTint", "T"),
                 {"body", "layer_vdf", {{"top", Of("transmission")}, {"base", Of("interior")}}},
                 DielectricPart("reflection", "reflectionTint", "R"),
                 {"", "layer_bsdf", {{"top", Of("reflection")}, {"base", Of("body")}}}}};
}

NodeGraph Conductor() {
    return {"ND_lama_conductor",
            {{"tint", White()},
             {"fresnelMode", {0.0F}},
             {"IOR", {0.180000007153F, 0.419999986887F, 1.37000000477F}},
             {"extinction", {3.42000007629F, 2.34999990463F, 1.76999998093F}},
             {"reflectivity", {0.9450F, 0.7772F, 0.3737F}},
             {"edgeColor", {0.7137F, 0.7373F, 0.4550F}},
             {"roughness", {0.1F}},
             {"anisotropy", {0.0F}},
             {"anisotropyRotation", {0.0F}}},
            AnisotropicAlpha() + Turned("anisotropyDirection", "anisotropyRotation") +
                Rows{{"artistic",
                      "artistic_ior",
                      {{"reflectivity", From("reflectivity")}, {"edge_color", From("edgeColor")}}},
                     {"iorColor", "convert_vector3_color3", {{"in", From("IOR")}}},
                     {"extinctionColor", "convert_vector3_color3", {{"in", From("extinction")}}},
                     {"ior",
                      "switch_color3",
                      {{"in1", Of("artistic", "ior")},
                       {"in2", Of("iorColor")},
                       {"which", From("fresnelMode")}}},
                     {"extinction",
                      "switch_color3",
                      {{"in1", Of("artistic", "extinction")},
                       {"in2", Of("extinctionColor")},
                       {"which", From("fresnelMode")}}},
                     {"metal",
                      "conductor_bsdf",
                      {{"ior", Of("ior")},
                       {"extinction", Of("extinction")},
                       {"roughness", Of("alpha")},
                       {"normal", From("normal")},
                       {"tangent", Of("tangent")}}},
                     {"", "multiply_bsdfC", {{"in1", Of("metal")}, {"in2", From("tint")}}}}};
}

GraphNode SchlickPart(const char* name, const char* mode) {
    return {name,
            "generalized_schlick_bsdf",
            {{"color0", Of("color0")},
             {"color90", From("reflectivity90")},
             {"exponent", Of("exponent")},
             {"roughness", Of("alpha")},
             {"normal", From("normal")},
             {"tangent", Of("tangent")},
             {"scatter_mode", Named(mode)}}};
}

NodeGraph GeneralizedSchlick() {
    return {
        "ND_lama_generalized_schlick",
        WithInterior({{"reflectionTint", White()},
                      {"transmissionTint", White()},
                      {"fresnelMode", {0.0F}},
                      {"IOR", {1.5F, 1.5F, 1.5F}},
                      {"reflectivity", {0.04F, 0.04F, 0.04F}},
                      {"reflectivity90", White()},
                      {"reflectivityProfile", {0.2F}},
                      {"roughness", {0.1F}},
                      {"anisotropy", {-1.0F}},
                      {"anisotropyRotation", {0.0F}}}),
        Rows{{"across",
              "ifgreater_float",
              {{"value1", From("anisotropy")},
               {"value2", Is({0.0F})},
               {"in1", From("anisotropy")},
               {"in2", From("roughness")}}}} +
            AlphaOf(Of("across")) + Turned("anisotropyDirection", "anisotropyRotation") +
            Interior() +
            Rows{{"iorColor", "convert_vector3_color3", {{"in", From("IOR")}}},
                 {"up", "add_color3FA", {{"in1", Of("iorColor")}, {"in2", Is({1.0F})}}},
                 {"down", "subtract_color3FA", {{"in1", Of("iorColor")}, {"in2", Is({1.0F})}}},
                 {"quotient", "divide_color3", {{"in1", Of("down")}, {"in2", Of("up")}}},
                 {"ofIor", "multiply_color3", {{"in1", Of("quotient")}, {"in2", Of("quotient")}}},
                 {"color0",
                  "switch_color3",
                  {{"in1", From("reflectivity")},
                   {"in2", Of("ofIor")},
                   {"which", From("fresnelMode")}}},
                 {"exponent",
                  "divide_float",
                  {{"in1", Is({1.0F})}, {"in2", From("reflectivityProfile")}}},
                 SchlickPart("transmission", "T"),
                 {"inside", "layer_vdf", {{"top", Of("transmission")}, {"base", Of("interior")}}},
                 {"body",
                  "multiply_bsdfC",
                  {{"in1", Of("inside")}, {"in2", From("transmissionTint")}}},
                 SchlickPart("mirror", "R"),
                 {"reflection",
                  "multiply_bsdfC",
                  {{"in1", Of("mirror")}, {"in2", From("reflectionTint")}}},
                 {"", "layer_bsdf", {{"top", Of("reflection")}, {"base", Of("body")}}}}};
}

NodeGraph Iridescence() {
    return {"ND_lama_iridescence",
            {{"roughness", {0.01F}},
             {"anisotropy", {0.0F}},
             {"anisotropyRotation", {0.0F}},
             {"relativeFilmThickness", {0.5F}},
             {"minFilmThickness", {400.0F}},
             {"maxFilmThickness", {800.0F}},
             {"filmIOR", {1.3F}}},
            AnisotropicAlpha() + Turned("anisotropyDirection", "anisotropyRotation") +
                Rows{{"thickness",
                      "mix_float",
                      {{"fg", From("maxFilmThickness")},
                       {"bg", From("minFilmThickness")},
                       {"mix", From("relativeFilmThickness")}}},
                     {"",
                      "dielectric_bsdf",
                      {{"roughness", Of("alpha")},
                       {"ior", Is({1.0F})},
                       {"thinfilm_thickness", Of("thickness")},
                       {"thinfilm_ior", From("filmIOR")},
                       {"tangent", Of("tangent")},
                       {"scatter_mode", Named("RT")}}}}};
}

NodeGraph Emission() {
    return {"ND_lama_emission",
            {{"color", {0.0F, 0.0F, 0.0F}}},
            {{"", "uniform_edf", {{"color", From("color")}}}}};
}

/// \param kind "bsdf" or "edf"
NodeGraph Sum(const std::string& kind) {
    return {"ND_lama_add_" + kind,
            {{"weight1", {1.0F}}, {"weight2", {0.0F}}},
            {{"first",
              "multiply_" + kind + "F",
              {{"in1", From("material1")}, {"in2", From("weight1")}}},
             {"second",
              "multiply_" + kind + "F",
              {{"in1", From("material2")}, {"in2", From("weight2")}}},
             {"", "add_" + kind, {{"in1", Of("first")}, {"in2", Of("second")}}}}};
}

NodeGraph Mixture(const std::string& kind) {
    return {"ND_lama_mix_" + kind,
            {{"mix", {0.0F}}},
            {{"",
              "mix_" + kind,
              {{"fg", From("material2")}, {"bg", From("material1")}, {"mix", From("mix")}}}}};
}

NodeGraph Layer() {
    return {"ND_lama_layer_bsdf",
            {{"topMix", {1.0F}}},
            {{"top", "multiply_bsdfF", {{"in1", From("materialTop")}, {"in2", From("topMix")}}},
             {"", "layer_bsdf", {{"top", Of("top")}, {"base", From("materialBase")}}}}};
}

/// Its front, which is on both sides.
NodeGraph Surface() {
    return {"ND_lama_surface",
            {{"presence", {1.0F}}},
            {{"", "surface", {{"bsdf", From("materialFront")}, {"opacity", From("presence")}}}}};
}

} // namespace

std::vector<NodeGraph> LamaGraphs() {
    return {Diffuse(),
            Translucent(),
            Sheen(),
            Subsurface(),
            Dielectric(),
            Conductor(),
            Iridescence(),
            Emission(),
            Sum("bsdf"),
            Sum("edf"),
            GeneralizedSchlick(),
            Mixture("bsdf"),
            Mixture("edf"),
            Layer(),
            Surface()};
}

} // namespace hds
