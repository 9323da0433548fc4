// SPDX-License-Identifier: Apache-2.0
// Parameters of lights: each is read, under Hydra's name and under the attribute's ("inputs:NAME"),
// which is all that some scene delegates answer to (Blender's, with the cone of its spot lights).
#include "hydraTest.h"

#include <pxr/base/gf/vec3f.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <string>

namespace hydraHost {

namespace {

using Lights = HydraTest;
using Params = std::map<TfToken, VtValue>;

const TfToken kTypes[] = {HdPrimTypeTokens->distantLight,  HdPrimTypeTokens->sphereLight,
                          HdPrimTypeTokens->rectLight,     HdPrimTypeTokens->diskLight,
                          HdPrimTypeTokens->cylinderLight, HdPrimTypeTokens->domeLight};

/// Every parameter that a light of any type has, none at its fallback.
Params AllParams() {
    Params params = {
        {HdLightTokens->intensity, VtValue(3.0F)},
        {HdLightTokens->exposure, VtValue(1.5F)},
        {HdLightTokens->diffuse, VtValue(0.5F)},
        {HdLightTokens->specular, VtValue(0.25F)},
        {HdLightTokens->normalize, VtValue(true)},
        {HdLightTokens->color, VtValue(GfVec3f(0.5F, 0.25F, 0.125F))},
        {HdLightTokens->enableColorTemperature, VtValue(true)},
        {HdLightTokens->colorTemperature, VtValue(3000.0F)},
        {HdLightTokens->angle, VtValue(5.0F)},
        {HdLightTokens->radius, VtValue(0.75F)},
        {HdLightTokens->width, VtValue(3.0F)},
        {HdLightTokens->height, VtValue(2.0F)},
        {HdLightTokens->length, VtValue(4.0F)},
        {HdLightTokens->textureFile, VtValue(SdfAssetPath("sky.exr"))},
        {HdLightTokens->textureFormat, VtValue(TfToken("latlong"))},
        {HdLightTokens->shapingFocus, VtValue(2.0F)},
        {HdLightTokens->shapingFocusTint, VtValue(GfVec3f(0.125F, 0.25F, 0.5F))},
        {HdLightTokens->shapingConeAngle, VtValue(30.0F)},
        {HdLightTokens->shapingConeSoftness, VtValue(0.5F)},
        {HdLightTokens->shapingIesFile, VtValue(SdfAssetPath("lamp.ies"))},
        {HdLightTokens->shapingIesAngleScale, VtValue(0.5F)},
        {HdLightTokens->shapingIesNormalize, VtValue(true)},
        {HdLightTokens->shadowEnable, VtValue(false)},
        {HdLightTokens->shadowColor, VtValue(GfVec3f(0.25F, 0.0F, 0.5F))},
        {HdLightTokens->shadowDistance, VtValue(8.0F)},
        {HdLightTokens->shadowFalloff, VtValue(4.0F)},
        {HdLightTokens->shadowFalloffGamma, VtValue(2.0F)},
    };
    params[TfToken("treatAsPoint")] = VtValue(true); // the schema's, no token of Hydra's
    params[TfToken("treatAsLine")] = VtValue(true);
    return params;
}

/// The lines of a light's description, name -> value.
using Lines = std::map<std::string, std::string>;

Lines LinesOf(const TfToken& type, const Params& params) {
    SceneData scene = EmptyScene();
    scene.lights.clear();
    LightData light;
    light.type = type;
    light.params = params;
    scene.lights[SdfPath("/light")] = light;
    Host host(scene, Quick());
    host.Frame();
    const std::string file = ::testing::TempDir() + "hydraLights.txt";
    EXPECT_TRUE(
        host.Delegate().InvokeCommand(TfToken("dumpScene"), {{TfToken("file"), VtValue(file)}}));
    Lines lines;
    std::ifstream stream(file);
    bool isLight = false;
    for (std::string line; std::getline(stream, line);) {
        if (line.compare(0, 1, " ") != 0) {
            isLight = line == "light /light";
        } else if (isLight) {
            const std::size_t colon = line.find(": ");
            lines[line.substr(2, colon - 2)] = line.substr(std::min(colon, line.size()));
        }
    }
    return lines;
}

Params WithPrefix(const Params& params) {
    Params result;
    for (const auto& [name, value] : params) {
        result[TfToken("inputs:" + name.GetString())] = value;
    }
    return result;
}

TEST_F(Lights, EveryParameterCountsUnderHydrasNameAndTheAttributes) {
    for (const TfToken& type : kTypes) {
        const Lines none = LinesOf(type, {});
        const Lines plain = LinesOf(type, AllParams());
        EXPECT_EQ(LinesOf(type, WithPrefix(AllParams())), plain) << type;
        EXPECT_GT(plain.size(), none.size()) << type; // shaping and shadow have lines now
        for (const auto& [name, value] : plain) {
            const auto before = none.find(name);
            const bool isFixed = name == "transform" || name == "type" || name == "visibleToCamera";
            EXPECT_EQ(before != none.end() && before->second == value, isFixed)
                << type << " " << name << value;
        }
    }
}

TEST_F(Lights, GroupsAreReadUnderTheNamesOfHosts) {
    const TfToken type = HdPrimTypeTokens->sphereLight;
    EXPECT_EQ(LinesOf(type, {}).count("group"), 0U);
    for (const char* name : {"hdstream:light:group", "inputs:karma:light:lpetag",
                             "inputs:ri:light:lightGroup", "primvars:arnold:aov"}) {
        const Lines ofString = LinesOf(type, {{TfToken(name), VtValue(std::string("key"))}});
        EXPECT_EQ(ofString.count("group"), 1U) << name;
        EXPECT_NE(ofString.at("group").find("key"), std::string::npos) << name;
        EXPECT_EQ(LinesOf(type, {{TfToken(name), VtValue(TfToken("key"))}}), ofString) << name;
    }
    const Lines both = LinesOf(type, {{TfToken("hdstream:light:group"), VtValue(std::string("a"))},
                                      {TfToken("primvars:arnold:aov"), VtValue(std::string("b"))}});
    EXPECT_NE(both.at("group").find('a'), std::string::npos) << "ours counts first";
}

TEST_F(Lights, HydrasNameWinsOverTheAttributes) {
    Params both = AllParams();
    for (const auto& [name, value] : WithPrefix(AllParams())) {
        both[name] = VtValue(); // answers nothing
    }
    both[TfToken("inputs:intensity")] = VtValue(7.0F);
    EXPECT_EQ(LinesOf(HdPrimTypeTokens->sphereLight, both),
              LinesOf(HdPrimTypeTokens->sphereLight, AllParams()));
}

/// A lamp 2 above a floor of 2 x 2.
SceneData LampOverFloor(const Params& params) {
    SceneData scene = EmptyScene();
    scene.lights.clear();
    scene.gprims[SdfPath("/floor")] = MakeGrid(2.0F, 2.0F);
    LightData lamp;
    lamp.type = HdPrimTypeTokens->sphereLight;
    lamp.transform = Translation(0.0, 0.0, 2.0);
    lamp.params = params;
    scene.lights[SdfPath("/lamp")] = lamp;
    return scene;
}

TEST_F(Lights, AConeUnderTheAttributesNameIsInThePicture) {
    const auto render = [](const Params& params) {
        return Host(LampOverFloor(params), Quick()).Render();
    };
    Params lamp = {{HdLightTokens->radius, VtValue(0.01F)},
                   {HdLightTokens->intensity, VtValue(5000.0F)}};
    const Image open = render(lamp);
    lamp[TfToken("inputs:shaping:cone:angle")] = VtValue(10.0F);
    const Image cone = render(lamp);
    EXPECT_GT(open.Float(12, 24), 0.0F);
    EXPECT_EQ(cone.Float(12, 24), 0.0F); // outside of the cone
    EXPECT_GT(cone.Float(32, 24), 0.0F);
}

/// A lightFilter: what UsdImaging hands over of a UsdLuxLightFilter with a shader id.
LightData Doors(const SdfPath& path, const GfMatrix4d& transform, float width) {
    HdMaterialNode node;
    node.path = path;
    node.identifier = TfToken("PxrBarnLightFilter");
    node.parameters = {{TfToken("width"), VtValue(width)},
                       {TfToken("height"), VtValue(10.0F)},
                       {TfToken("radius"), VtValue(0.0F)}};
    HdMaterialNetworkMap map;
    map.map[HdMaterialTerminalTokens->lightFilter].nodes.push_back(node);
    map.terminals.push_back(path);
    LightData filter;
    filter.type = HdPrimTypeTokens->lightFilter;
    filter.transform = transform;
    filter.resource = VtValue(map);
    return filter;
}

/// Doors half way between them; edits of the filter alone are drawn.
TEST_F(Lights, FiltersAreInThePictureAndTheirEditsToo) {
    const SdfPath path("/doors");
    SceneData scene = LampOverFloor({{HdLightTokens->radius, VtValue(0.01F)},
                                     {HdLightTokens->intensity, VtValue(5000.0F)},
                                     {HdTokens->filters, VtValue(SdfPathVector{path})}});
    scene.lights[path] = Doors(path, Translation(0.0, 0.0, 1.0), 0.25F); // lights |x| < 0.25
    Host host(scene, Quick());
    const auto lit = [&](int x) { return host.Render().Float(x, 24) > 0.0F; };
    const int middle = 32;
    EXPECT_TRUE(lit(middle));
    EXPECT_FALSE(lit(12)) << "behind the doors";
    host.Scene().SetLight(path, Doors(path, Translation(0.0, 0.0, 1.0), 10.0F),
                          HdLight::DirtyParams);
    EXPECT_TRUE(lit(12)) << "the doors are open";
    host.Scene().SetLight(path, Doors(path, Translation(-1.0, 0.0, 1.0), 0.25F), HdLight::AllDirty);
    EXPECT_FALSE(lit(middle)) << "the doors have moved";
    host.Scene().Remove(path);
    EXPECT_TRUE(lit(12)) << "without doors";
    host.Scene().SetLight(path, Doors(path, Translation(0.0, 0.0, 1.0), 0.25F));
    EXPECT_TRUE(lit(middle));
    EXPECT_FALSE(lit(12)) << "behind doors that are back";
    LightData lamp = host.Scene().Data().lights.at(SdfPath("/lamp"));
    lamp.params[HdTokens->filters] = VtValue(SdfPathVector());
    host.Scene().SetLight(SdfPath("/lamp"), lamp, HdLight::DirtyParams);
    EXPECT_TRUE(lit(12)) << "doors of no light";
}

} // namespace

} // namespace hydraHost
