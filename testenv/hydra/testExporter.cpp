// SPDX-License-Identifier: Apache-2.0
// What Blender's exporters write otherwise than it is meant is turned back where the host says that
// it is Blender (render setting hostExporter), and nowhere else.
#include "hydraTest.h"

#include <pxr/base/tf/diagnosticMgr.h>
#include <pxr/base/tf/error.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

namespace hydraHost {

namespace {

using Exporter = HydraTest;

constexpr const char* kBlender = "blender";

/// The dump of what arrives of a scene.
std::string DumpOf(const SceneData& scene, const std::string& exporter) {
    HostOptions options = Quick();
    options.settings[TfToken("hostExporter")] = VtValue(exporter);
    Host host(scene, options);
    host.Frame();
    const std::string file = ::testing::TempDir() + "hydraExporter.txt";
    EXPECT_TRUE(
        host.Delegate().InvokeCommand(TfToken("dumpScene"), {{TfToken("file"), VtValue(file)}}));
    std::ifstream stream(file);
    return std::string(std::istreambuf_iterator<char>(stream), {});
}

/// The number of a line "  NAME: NUMBER"; NaN where there is none.
double Number(const std::string& dump, const std::string& name) {
    const std::string key = "\n  " + name + ": ";
    const std::size_t at = dump.find(key);
    return at == std::string::npos ? std::nan("") : std::stod(dump.substr(at + key.size()));
}

SceneData WithLight(const TfToken& type, const std::map<TfToken, VtValue>& params) {
    SceneData scene = EmptyScene();
    scene.lights.clear();
    LightData& light = scene.lights[SdfPath("/light")];
    light.type = type;
    light.params = params;
    return scene;
}

/// A floor with a material of one node of MaterialX behind an input of the surface.
SceneData WithMaterial(const std::map<TfToken, VtValue>& surface,
                       const std::map<TfToken, VtValue>& image, const char* input = "base_color") {
    SceneData scene = EmptyScene();
    HdMaterialNode texture;
    texture.path = SdfPath("/Image");
    texture.identifier = TfToken("ND_image_color3");
    texture.parameters = image;
    HdMaterialNode node;
    node.path = SdfPath("/Surface");
    node.identifier = TfToken("ND_open_pbr_surface_surfaceshader");
    node.parameters = surface;
    HdMaterialNetworkMap map;
    HdMaterialNetwork& network = map.map[HdMaterialTerminalTokens->surface];
    network.nodes = {texture, node};
    network.relationships = {{texture.path, TfToken("out"), node.path, TfToken(input)}};
    map.terminals.push_back(node.path);
    scene.materials[SdfPath("/look")] = map;
    scene.gprims[SdfPath("/floor")] = MakeGrid(2.0F, 2.0F);
    scene.gprims[SdfPath("/floor")].material = SdfPath("/look");
    return scene;
}

TEST_F(Exporter, SunsHaveTheirStrengthAndOtherLightsKeepTheirs) {
    for (const TfToken& type : {HdPrimTypeTokens->distantLight, HdPrimTypeTokens->sphereLight,
                                HdPrimTypeTokens->rectLight, HdPrimTypeTokens->domeLight}) {
        const SceneData scene = WithLight(type, {{HdLightTokens->intensity, VtValue(3.0F)}});
        const double factor = type == HdPrimTypeTokens->distantLight ? 4.0 : 1.0;
        EXPECT_EQ(Number(DumpOf(scene, kBlender), "intensity"), 3.0 * factor) << type;
        EXPECT_EQ(Number(DumpOf(scene, "another"), "intensity"), 3.0) << type;
        EXPECT_EQ(DumpOf(scene, "another"), DumpOf(scene, "")) << type;
    }
}

TEST_F(Exporter, ABlendOfSpotsLetsTheFluxOfCyclesThrough) {
    constexpr double kHalf = 40.0 * 3.14159265358979323846 / 180.0;
    for (const double blend : {0.15, 0.6, 1.0}) {
        const SceneData scene =
            WithLight(HdPrimTypeTokens->sphereLight,
                      {{HdLightTokens->shapingConeAngle, VtValue(40.0F)},
                       {HdLightTokens->shapingConeSoftness, VtValue(float(blend))}});
        EXPECT_FLOAT_EQ(float(Number(DumpOf(scene, ""), "shaping coneSoftness")), float(blend));
        const double softness = Number(DumpOf(scene, kBlender), "shaping coneSoftness");
        // Cycles: a smooth step of (cos - cos(half)) / (blend (1 - cos(half))). Ours: of the angle.
        double cycles = 0.0;
        double ours = 0.0;
        constexpr int kNumSteps = 200000;
        for (int i = 0; i < kNumSteps; ++i) {
            const double cosine = std::cos(kHalf) + (1.0 - std::cos(kHalf)) * (i + 0.5) / kNumSteps;
            const auto step = [](double t) {
                t = std::clamp(t, 0.0, 1.0);
                return t * t * (3.0 - 2.0 * t);
            };
            cycles += step((cosine - std::cos(kHalf)) / (blend * (1.0 - std::cos(kHalf))));
            ours += step((kHalf - std::acos(cosine)) / (softness * kHalf));
        }
        EXPECT_NEAR(ours / cycles, 1.0, 1e-3) << blend;
    }
    const SceneData hard = WithLight(HdPrimTypeTokens->sphereLight,
                                     {{HdLightTokens->shapingConeAngle, VtValue(40.0F)}});
    EXPECT_EQ(DumpOf(hard, kBlender), DumpOf(hard, ""));
}

/// The exporter of USD switches the temperature of all lamps on. UsdImaging has the parameters with
/// UsdLux's fallbacks, and what is authored alone in the lamp's network.
TEST_F(Exporter, LampsHaveTheTemperatureThatIsWrittenAndNoOther) {
    const TfToken& enable = HdLightTokens->enableColorTemperature;
    const TfToken& temperature = HdLightTokens->colorTemperature;
    for (const bool isWritten : {false, true}) {
        SceneData scene = WithLight(HdPrimTypeTokens->sphereLight,
                                    {{enable, VtValue(true)}, {temperature, VtValue(6500.0F)}});
        HdMaterialNode node;
        node.path = SdfPath("/light");
        node.parameters[enable] = VtValue(true);
        if (isWritten) {
            node.parameters[temperature] = VtValue(6500.0F);
        }
        HdMaterialNetworkMap map;
        map.map[HdMaterialTerminalTokens->light].nodes = {node};
        scene.lights[SdfPath("/light")].resource = VtValue(map);
        for (const std::string& exporter : {std::string(), std::string(kBlender)}) {
            const bool isOn = isWritten || exporter.empty();
            const std::string line =
                std::string("\n  enableColorTemperature: ") + (isOn ? "true" : "false");
            EXPECT_NE(DumpOf(scene, exporter).find(line), std::string::npos)
                << isWritten << exporter;
        }
    }
}

TEST_F(Exporter, CoatsDoNotDarkenUnlessANodeSaysSo) {
    const SceneData coat = WithMaterial({{TfToken("coat_weight"), VtValue(1.0F)}}, {});
    EXPECT_TRUE(std::isnan(Number(DumpOf(coat, ""), "  coat_darkening")));
    EXPECT_EQ(Number(DumpOf(coat, kBlender), "  coat_darkening"), 0.0);
    const SceneData authored = WithMaterial(
        {{TfToken("coat_weight"), VtValue(1.0F)}, {TfToken("coat_darkening"), VtValue(0.5F)}}, {});
    EXPECT_EQ(Number(DumpOf(authored, kBlender), "  coat_darkening"), 0.5);
}

TEST_F(Exporter, ColoursOfGlassAreThoseOfTheWayInAndOut) {
    const auto line = [](const std::string& dump, const std::string& text) {
        return dump.find("\n    transmission_color: " + text) != std::string::npos;
    };
    const GfVec3f color(0.5625F, 0.25F, 0.0625F);
    const SceneData plain = WithMaterial({{TfToken("transmission_color"), VtValue(color)}}, {});
    EXPECT_TRUE(line(DumpOf(plain, ""), "[3] 0.5625 0.25 0.0625")) << DumpOf(plain, "");
    EXPECT_TRUE(line(DumpOf(plain, kBlender), "[3] 0.75 0.5 0.25")) << DumpOf(plain, kBlender);
    const SceneData connected = WithMaterial({}, {}, "transmission_color");
    EXPECT_TRUE(line(DumpOf(connected, ""), "<- /Image.out")) << DumpOf(connected, "");
    const std::string dump = DumpOf(connected, kBlender);
    EXPECT_TRUE(line(dump, "<- /Surface_transmission_color")) << dump;
    EXPECT_NE(dump.find("ND_power_color3FA"), std::string::npos) << dump;
    EXPECT_NE(dump.find("in1: <- /Image.out"), std::string::npos) << dump;
}

/// Smooth glass of index 1.5 below a white sky, seen along the normals of both its faces: a ray is
/// reflected (R), or goes in, and out after any number of reflections: R + (1 - R)^2 c / (1 - R).
TEST_F(Exporter, ASlabOfGlassDimsAsPrincipledDoes) {
    const GfVec3f color(0.36F, 0.25F, 0.04F);
    SceneData scene = WithMaterial({{TfToken("transmission_weight"), VtValue(1.0F)},
                                    {TfToken("specular_roughness"), VtValue(0.0F)},
                                    {TfToken("specular_ior"), VtValue(1.5F)},
                                    {TfToken("transmission_color"), VtValue(color)}},
                                   {});
    scene.gprims.clear();
    scene.gprims[SdfPath("/slab")] = MakeCube(1.0F);
    scene.gprims[SdfPath("/slab")].material = SdfPath("/look");
    scene.cameras[SdfPath("/camera")] = MakeOrthographicCamera(GfVec3d(0.0, 0.0, 5.0), 0.5);
    HostOptions options = Quick({HdAovTokens->color}, 256);
    options.settings[TfToken("maxDepth")] = VtValue(8);
    for (const std::string& exporter : {std::string(), std::string(kBlender)}) {
        options.settings[TfToken("hostExporter")] = VtValue(exporter);
        Host host(scene, options);
        host.RenderUntilConverged();
        const Image image = host.Read();
        for (int channel = 0; channel < 3; ++channel) {
            double mean = 0.0;
            for (int i = 0; i < image.width * image.height; ++i) {
                mean += image.Float(i % image.width, i / image.width, channel);
            }
            mean /= image.width * image.height;
            const double once = exporter.empty() ? color[channel] : std::sqrt(color[channel]);
            EXPECT_NEAR(mean, 0.04 + 0.96 * once * once, 2e-3) << exporter << " " << channel;
        }
    }
}

/// A floor whose material is made of nodes and links.
class Look {
public:
    void Add(const char* path, const char* identifier,
             const std::map<TfToken, VtValue>& parameters = {}) {
        HdMaterialNode node;
        node.path = SdfPath(path);
        node.identifier = TfToken(identifier);
        node.parameters = parameters;
        _network.nodes.push_back(node);
    }
    void Connect(const std::string& from, const char* to, const char* input) {
        _network.relationships.push_back(
            {SdfPath(from), TfToken("out"), SdfPath(to), TfToken(input)});
    }
    void AddTransparent() {
        Add("/Transparent_BSDF", "ND_oren_nayar_diffuse_bsdf",
            {{TfToken("color"), VtValue(GfVec3f(1.0F))}});
    }
    void AddDiffuse(const char* path, float albedo) {
        Add(path, "ND_oren_nayar_diffuse_bsdf",
            {{TfToken("color"), VtValue(GfVec3f(albedo))}, {TfToken("roughness"), VtValue(0.0F)}});
    }
    /// As far as it matters here: a layer, whose top reflects nothing.
    void AddPrincipled(const char* path, float albedo) {
        AddDiffuse("/node_base", albedo);
        Add("/node_top", "ND_dielectric_bsdf",
            {{TfToken("weight"), VtValue(0.0F)},
             {TfToken("scatter_mode"), VtValue(std::string("R"))}});
        Add(path, "ND_layer_bsdf");
        Connect("/node_top", path, "top");
        Connect("/node_base", path, "base");
    }
    void AddEmission(const char* path, float radiance) {
        Add(path, "ND_uniform_edf", {{TfToken("color"), VtValue(GfVec3f(radiance))}});
    }
    /// \param opacity what the exporter writes: sides that are neither Principled nor Transparent
    /// BSDFs count there as if they were not. \param edf empty: none.
    void AddSurface(float opacity, const char* bsdf, const std::string& edf) {
        Add("/Surface", "ND_surface", {{TfToken("opacity"), VtValue(opacity)}});
        Connect(bsdf, "/Surface", "bsdf");
        if (!edf.empty()) {
            Connect(edf, "/Surface", "edf");
        }
    }

    /// On a floor.
    SceneData Scene() const {
        SceneData scene = EmptyScene();
        HdMaterialNetworkMap map;
        map.map[HdMaterialTerminalTokens->surface] = _network;
        map.terminals.push_back(SdfPath("/Surface"));
        scene.materials[SdfPath("/look")] = map;
        scene.gprims[SdfPath("/floor")] = MakeGrid(2.0F, 2.0F);
        scene.gprims[SdfPath("/floor")].material = SdfPath("/look");
        return scene;
    }

    /// What is seen of it from above, below a white sky.
    double Seen(const std::string& exporter) const {
        SceneData scene = Scene();
        scene.cameras[SdfPath("/camera")] = MakeOrthographicCamera(GfVec3d(0.0, 0.0, 5.0), 0.5);
        HostOptions options = Quick({HdAovTokens->color}, 64);
        options.settings[TfToken("hostExporter")] = VtValue(exporter);
        Host host(scene, options);
        host.RenderUntilConverged();
        const Image image = host.Read();
        double sum = 0.0;
        for (int i = 0; i < image.width * image.height; ++i) {
            sum += image.Float(i % image.width, i / image.width, 0);
        }
        return sum / (image.width * image.height);
    }

private:
    HdMaterialNetwork _network;
};

VtValue Half() {
    return VtValue(0.5F);
}

/// Blender's mix, by a half, of a Principled BSDF that also emits and a Transparent BSDF: what its
/// exporter writes of it. \param isSwapped whether the transparent one comes first.
Look TransparentMix(float albedo, float emission, bool isSwapped) {
    Look look;
    look.AddTransparent();
    look.AddPrincipled("/Glow_BSDF", albedo);
    look.AddEmission("/Glow_EDF", emission);
    look.Add("/Mix_BSDF", "ND_mix_bsdf", {{TfToken("mix"), Half()}});
    look.Add("/Mix_EDF", "ND_multiply_edfF", {{TfToken("in2"), Half()}});
    look.Connect("/Transparent_BSDF", "/Mix_BSDF", isSwapped ? "bg" : "fg");
    look.Connect("/Glow_BSDF", "/Mix_BSDF", isSwapped ? "fg" : "bg");
    look.Connect("/Glow_EDF", "/Mix_EDF", "in1");
    look.AddSurface(0.5F, "/Mix_BSDF", "/Mix_EDF");
    return look;
}

/// Half of the floor's albedo and emission is seen, and half of the sky.
TEST_F(Exporter, MixesWithATransparentSideLetItsShareThrough) {
    for (const bool isSwapped : {false, true}) {
        const Look look = TransparentMix(0.6F, 0.3F, isSwapped);
        EXPECT_NEAR(look.Seen(""), 0.5 * (0.5 * 0.6 + 0.5 + 0.5 * 0.3) + 0.5, 5e-3) << isSwapped;
        EXPECT_NEAR(look.Seen(kBlender), 0.5 * (0.6 + 0.3) + 0.5, 5e-3) << isSwapped;
    }
}

/// A quarter of a mix is another one, by a half, of a bright diffuse and a Transparent BSDF; the
/// rest is dark. Either may emit.
struct NestedMixes {
    bool isSwapped;    ///< the dark side comes first
    bool areLinked;    ///< factors come from nodes
    bool isPrincipled; ///< the dark side; else a diffuse BSDF
    float darkGlow;    ///< 0: it has no emission
    float brightGlow;  ///< 0: it has no emission

    static constexpr float kDark = 0.2F;
    static constexpr float kBright = 0.8F;

    Look Make() const {
        Look look;
        look.AddTransparent();
        look.AddDiffuse("/Bright_BSDF", kBright);
        isPrincipled ? look.AddPrincipled("/Dark_BSDF", kDark)
                     : look.AddDiffuse("/Dark_BSDF", kDark);
        look.Add("/Inner_BSDF", "ND_mix_bsdf", Factor("mix", 0.5F));
        look.Connect("/Bright_BSDF", "/Inner_BSDF", "fg");
        look.Connect("/Transparent_BSDF", "/Inner_BSDF", "bg");
        const float factor = isSwapped ? 0.75F : 0.25F;
        look.Add("/Outer_BSDF", "ND_mix_bsdf", Factor("mix", factor));
        look.Connect("/Inner_BSDF", "/Outer_BSDF", isSwapped ? "bg" : "fg");
        look.Connect("/Dark_BSDF", "/Outer_BSDF", isSwapped ? "fg" : "bg");
        if (areLinked) {
            look.Add("/Half_FLOAT", "ND_constant_float", {{TfToken("value"), Half()}});
            look.Add("/Factor_FLOAT", "ND_constant_float", {{TfToken("value"), VtValue(factor)}});
            look.Connect("/Half_FLOAT", "/Inner_BSDF", "mix");
            look.Connect("/Factor_FLOAT", "/Outer_BSDF", "mix");
        }
        AddEmission(factor, &look);
        look.AddSurface(Opacity(), "/Outer_BSDF", "/Outer_EDF");
        return look;
    }

    double Expected() const {
        return 0.75 * (kDark + darkGlow) + 0.125 * (kBright + brightGlow) + 0.125;
    }
    double AsWritten() const {
        const double seen =
            0.75 * (kDark + darkGlow) + 0.25 * (0.5 * kBright + 0.5 + 0.5 * brightGlow);
        return Opacity() * seen + 1.0 - Opacity();
    }

private:
    /// That the exporter writes.
    float Opacity() const { return isPrincipled ? 0.75F : 0.0F; }

    std::map<TfToken, VtValue> Factor(const char* input, float value) const {
        return areLinked ? std::map<TfToken, VtValue>()
                         : std::map<TfToken, VtValue>{{TfToken(input), VtValue(value)}};
    }

    void AddEmission(float factor, Look* look) const {
        look->AddEmission("/Bright_EDF", brightGlow);
        look->AddEmission("/Dark_EDF", darkGlow);
        look->Add("/Inner_EDF", "ND_multiply_edfF", {{TfToken("in2"), Half()}});
        look->Connect("/Bright_EDF", "/Inner_EDF", "in1");
        if (brightGlow > 0.0F && darkGlow > 0.0F) {
            look->Add("/Outer_EDF", "ND_mix_edf", {{TfToken("mix"), VtValue(factor)}});
            look->Connect("/Inner_EDF", "/Outer_EDF", isSwapped ? "bg" : "fg");
            look->Connect("/Dark_EDF", "/Outer_EDF", isSwapped ? "fg" : "bg");
        } else {
            const bool isDark = darkGlow > 0.0F;
            look->Add("/Outer_EDF", "ND_multiply_edfF",
                      {{TfToken("in2"), VtValue(isDark ? 0.75F : 0.25F)}});
            look->Connect(isDark ? "/Dark_EDF" : "/Inner_EDF", "/Outer_EDF", "in1");
        }
    }
};

TEST_F(Exporter, MixesInsideOfMixesCoverWhatTheyCover) {
    constexpr NestedMixes kAll[] = {{false, false, false, 0.0F, 0.5F},
                                    {true, false, true, 0.4F, 0.0F},
                                    {false, true, true, 0.4F, 0.5F},
                                    {true, true, false, 0.0F, 0.5F},
                                    {true, false, false, 0.4F, 0.5F}};
    for (const NestedMixes& mixes : kAll) {
        const Look look = mixes.Make();
        EXPECT_NEAR(look.Seen(""), mixes.AsWritten(), 5e-3) << mixes.isSwapped << mixes.areLinked;
        EXPECT_NEAR(look.Seen(kBlender), mixes.Expected(), 5e-3)
            << mixes.isSwapped << mixes.areLinked << mixes.darkGlow << mixes.brightGlow;
    }
}

/// No side of such a mix is transparent, and the diffuse one counts, too.
TEST_F(Exporter, MixesOfPrincipledAndOthersAreOpaque) {
    Look look;
    look.AddPrincipled("/Principled_BSDF", 0.2F);
    look.AddDiffuse("/Diffuse_BSDF", 0.8F);
    look.Add("/Mix_BSDF", "ND_mix_bsdf", {{TfToken("mix"), VtValue(0.25F)}});
    look.Connect("/Principled_BSDF", "/Mix_BSDF", "bg");
    look.Connect("/Diffuse_BSDF", "/Mix_BSDF", "fg");
    look.AddSurface(0.75F, "/Mix_BSDF", "");
    EXPECT_NEAR(look.Seen(kBlender), 0.75 * 0.2 + 0.25 * 0.8, 5e-3);
}

/// Of a mix of the mix of an Emission and a Transparent BSDF: what has no BSDF covers, too.
TEST_F(Exporter, WhatOnlyEmitsCoversItsShareOfAMix) {
    Look look;
    look.AddTransparent();
    look.AddDiffuse("/Dark_BSDF", 0.2F);
    look.AddEmission("/Glow_EDF", 0.5F);
    look.Add("/Inner_BSDF", "ND_multiply_bsdfF", {{TfToken("in2"), Half()}});
    look.Connect("/Transparent_BSDF", "/Inner_BSDF", "in1");
    look.Add("/Inner_EDF", "ND_multiply_edfF", {{TfToken("in2"), Half()}});
    look.Connect("/Glow_EDF", "/Inner_EDF", "in1");
    look.Add("/Outer_BSDF", "ND_mix_bsdf", {{TfToken("mix"), VtValue(0.25F)}});
    look.Connect("/Inner_BSDF", "/Outer_BSDF", "fg");
    look.Connect("/Dark_BSDF", "/Outer_BSDF", "bg");
    look.Add("/Outer_EDF", "ND_multiply_edfF", {{TfToken("in2"), VtValue(0.25F)}});
    look.Connect("/Inner_EDF", "/Outer_EDF", "in1");
    look.AddSurface(0.0F, "/Outer_BSDF", "/Outer_EDF");
    EXPECT_NEAR(look.Seen(kBlender), 0.75 * 0.2 + 0.125 * 0.5 + 0.125, 5e-3);
}

/// Of a glossy BSDF; those that are parts of Principled have a node for it.
TEST_F(Exporter, RoughnessOfSingleBsdfsIsSquared) {
    const auto dump = [](const char* source, const char* exporter) {
        Look look;
        look.Add("/Glossy", "ND_conductor_bsdf",
                 {{TfToken("roughness"), VtValue(GfVec2f(0.5F, 0.25F))}});
        if (*source != 0) {
            look.Add("/Rough", source);
            look.Connect("/Rough", "/Glossy", "roughness");
        }
        look.AddSurface(1.0F, "/Glossy", "");
        return DumpOf(look.Scene(), exporter);
    };
    const auto has = [](const std::string& text, const char* line) {
        return text.find(line) != std::string::npos;
    };
    EXPECT_TRUE(has(dump("", ""), "\n    roughness: [2] 0.5 0.25"));
    EXPECT_TRUE(has(dump("", kBlender), "\n    roughness: [2] 0.25 0.0625")) << dump("", kBlender);
    const std::string connected = dump("ND_convert_float_vector2", kBlender);
    EXPECT_TRUE(has(connected, "\n    roughness: <- /Glossy_roughnessSquare")) << connected;
    EXPECT_TRUE(has(connected, "\n    in1: <- /Rough.out")) << connected;
    EXPECT_TRUE(has(connected, "\n    in2: <- /Rough.out")) << connected;
    const char* principled = "ND_roughness_anisotropy";
    EXPECT_EQ(dump(principled, kBlender), dump(principled, ""));
}

/// The exporter turns it by -90 degrees less a turn of 360. Once, however many BSDFs share it.
TEST_F(Exporter, TangentsOfPrincipledAreTurnedBack) {
    const auto dump = [](bool isPart, bool isLinked, const char* exporter) {
        Look look;
        look.Add("/Turn", "ND_rotate3d_vector3", {{TfToken("amount"), VtValue(-126.0F)}});
        look.Add("/Unit", "ND_normalize_vector3");
        look.Connect("/Turn", "/Unit", "in");
        if (isLinked) {
            look.Add("/Angle", "ND_constant_float");
            look.Connect("/Angle", "/Turn", "amount");
        }
        if (isPart) {
            look.Add("/Rough", "ND_roughness_anisotropy");
            for (const char* bsdf : {"/Metal", "/Top"}) {
                look.Add(bsdf, bsdf[1] == 'M' ? "ND_conductor_bsdf" : "ND_dielectric_bsdf");
                look.Connect("/Rough", bsdf, "roughness");
                look.Connect("/Unit", bsdf, "tangent");
            }
            look.AddSurface(1.0F, "/Metal", "/Top");
        } else {
            look.Add("/Surface", "ND_open_pbr_surface_surfaceshader");
            look.Connect("/Unit", "/Surface", "geometry_tangent");
        }
        return DumpOf(look.Scene(), exporter);
    };
    for (const bool isPart : {false, true}) {
        EXPECT_EQ(Number(dump(isPart, false, ""), "  amount"), -126.0);
        EXPECT_EQ(Number(dump(isPart, false, kBlender), "  amount"), -36.0) << isPart;
        const std::string linked = dump(isPart, true, kBlender);
        EXPECT_NE(linked.find("amount: <- /Turn_amountTurn"), std::string::npos) << linked;
        EXPECT_EQ(Number(linked, "  in2"), 90.0) << linked;
    }
}

TEST_F(Exporter, ImagesThatBlenderWroteAsLinearOnesAreNotDecodedAgain) {
    const auto decodes = [](const std::string& file, const char* space, const char* exporter) {
        const SceneData scene =
            WithMaterial({}, {{TfToken("file"), VtValue(SdfAssetPath(file))},
                              {TfToken("colorSpace:file"), VtValue(TfToken(space))}});
        const std::string dump = DumpOf(scene, exporter);
        EXPECT_NE(dump.find(file), std::string::npos) << dump;
        return dump.find("\"srgb_texture\"") != std::string::npos;
    };
    const std::string cache = "/tmp/blender_abc/usd/image_cache/img_0x12";
    EXPECT_FALSE(decodes(cache + ".exr", "srgb_texture", kBlender));
    EXPECT_FALSE(decodes(cache + ".hdr", "srgb_texture", kBlender));
    EXPECT_TRUE(decodes(cache + ".png", "srgb_texture", kBlender)) << "holds what the image held";
    EXPECT_TRUE(decodes(cache + ".exr", "srgb_texture", "")) << "another host's";
    EXPECT_TRUE(decodes("/tmp/wood.exr", "srgb_texture", kBlender)) << "the user's own file";
}

#if PXR_VERSION >= 2502
/// Counts the errors that a host would print.
class ErrorCounter : public TfDiagnosticMgr::Delegate {
public:
    ErrorCounter() { TfDiagnosticMgr::GetInstance().AddDelegate(this); }
    ~ErrorCounter() override { TfDiagnosticMgr::GetInstance().RemoveDelegate(this); }
    void IssueError(const TfError&) override { ++count; }
    void IssueFatalError(const TfCallContext&, const std::string&) override {}
    void IssueStatus(const TfStatus&) override {}
    void IssueWarning(const TfWarning&) override {}

    std::atomic<int> count{0};
};

TEST_F(Exporter, ConfigurationsOfMaterialXAreNoErrors) {
    SceneData scene = WithMaterial({}, {});
    const VtDictionary version{{"version", VtValue(std::string("1.39"))}};
    const ErrorCounter errors;
    DumpOf(scene, kBlender);
    EXPECT_EQ(errors.count, 0);
    scene.materials[SdfPath("/look")].config["mtlx"] = VtValue(version);
    const std::string dump = DumpOf(scene, kBlender);
    EXPECT_EQ(errors.count, 0);
    EXPECT_NE(dump.find("ND_open_pbr_surface_surfaceshader"), std::string::npos) << dump;
}
#endif

} // namespace

} // namespace hydraHost
