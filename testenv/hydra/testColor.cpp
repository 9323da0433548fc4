// SPDX-License-Identifier: Apache-2.0
// The colour buffer: premultiplied alpha, the clear colour, formats.
#include "hydraTest.h"

#include <pxr/imaging/hd/material.h>

#include <algorithm>
#include <cmath>

namespace hydraHost {

namespace {

using Color = HydraTest;

const GfVec3f kEmission(2.0F, 1.0F, 0.25F);

/// A tilted quad that only emits, before nothing: pixels are coverage times emission.
SceneData EmissiveQuad() {
    SceneData scene = EmptyScene();
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(0.0F));
    scene.materials[SdfPath("/emitter")] = MakeMaterial(GfVec3f(0.0F), kEmission);
    GprimData quad = MakeGrid(1.0F, 0.7F);
    quad.transform = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 0, 1), 27.0));
    quad.material = SdfPath("/emitter");
    scene.gprims[SdfPath("/quad")] = quad;
    return scene;
}

HostOptions WithColor(HdFormat format, const VtValue& clearValue) {
    AovRequest color{HdAovTokens->color};
    color.format = format;
    color.clearValue = clearValue;
    HostOptions options = Quick({color}, 4);
    options.settings[HdRenderSettingsTokens->domeLightCameraVisibility] = VtValue(false);
    return options;
}

Image RenderWith(HdFormat format, const GfVec4f& clear) {
    Host host(EmissiveQuad(), WithColor(format, VtValue(clear)));
    return host.Render();
}

TEST_F(Color, IsPremultipliedByCoverage) {
    const Image image = RenderWith(HdFormatFloat32Vec4, GfVec4f(0.0F));
    ASSERT_EQ(image.width, 64);
    int numPartial = 0;
    int numFull = 0;
    int numEmpty = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const float alpha = image.Float(x, y, 3);
            numFull += alpha == 1.0F;
            numEmpty += alpha == 0.0F;
            numPartial += alpha > 0.0F && alpha < 1.0F;
            for (int component = 0; component < 3; ++component) {
                ASSERT_NEAR(image.Float(x, y, component), alpha * kEmission[component], 1e-5F)
                    << x << " " << y;
            }
        }
    }
    EXPECT_GT(numFull, 200);
    EXPECT_GT(numEmpty, 200);
    EXPECT_GT(numPartial, 20);
}

TEST_F(Color, AnOpaqueBackgroundHasAlphaOneAndTheSameColours) {
    const Image image = RenderWith(HdFormatFloat32Vec4, GfVec4f(0.0F));
    HostOptions options = WithColor(HdFormatFloat32Vec4, VtValue(GfVec4f(0.0F)));
    options.settings[TfToken("opaqueBackground")] = VtValue(true);
    const Image opaque = Host(EmissiveQuad(), options).Render();
    ASSERT_EQ(opaque.width, image.width);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            ASSERT_EQ(opaque.Float(x, y, 3), 1.0F);
            for (int component = 0; component < 3; ++component) {
                ASSERT_EQ(opaque.Float(x, y, component), image.Float(x, y, component));
            }
        }
    }
}

TEST_F(Color, IsCompositedOverTheClearColor) {
    const Image plain = RenderWith(HdFormatFloat32Vec4, GfVec4f(0.0F));
    const GfVec4f clear(0.2F, 0.5F, 0.75F, 0.5F);
    const Image over = RenderWith(HdFormatFloat32Vec4, clear);
    ASSERT_EQ(over.bytes.size(), plain.bytes.size());
    for (int y = 0; y < plain.height; ++y) {
        for (int x = 0; x < plain.width; ++x) {
            for (int component = 0; component < 4; ++component) {
                ASSERT_NEAR(over.Float(x, y, component),
                            plain.Float(x, y, component) +
                                (1.0F - plain.Float(x, y, 3)) * clear[component],
                            1e-5F)
                    << x << " " << y;
            }
        }
    }
}

TEST_F(Color, OtherFormatsRoundTheFloats) {
    const Image exact = RenderWith(HdFormatFloat32Vec4, GfVec4f(0.0F));
    const Image unorm = RenderWith(HdFormatUNorm8Vec4, GfVec4f(0.0F));
    const Image half = RenderWith(HdFormatFloat16Vec4, GfVec4f(0.0F));
    const Image vec3 = RenderWith(HdFormatFloat32Vec3, GfVec4f(0.0F));
    ASSERT_EQ(unorm.bytes.size(), size_t(64 * 48 * 4));
    ASSERT_EQ(half.bytes.size(), size_t(64 * 48 * 8));
    ASSERT_EQ(vec3.bytes.size(), size_t(64 * 48 * 12));
    for (int y = 0; y < exact.height; ++y) {
        for (int x = 0; x < exact.width; ++x) {
            for (int component = 0; component < 4; ++component) {
                const float value = exact.Float(x, y, component);
                ASSERT_NEAR(unorm.Float(x, y, component), std::min(value, 1.0F),
                            0.5F / 255.0F + 1e-6F);
                ASSERT_NEAR(half.Float(x, y, component), value, value / 2048.0F);
                if (component < 3) {
                    ASSERT_EQ(vec3.Float(x, y, component), value);
                }
            }
        }
    }
}

TEST_F(Color, LambertUnderAUniformDomeIsItsAlbedo) {
    // Closed form: a convex Lambertian surface below a uniform dome of radiance 1 reflects its
    // albedo; opacity 1, no specular lobe at normal incidence. 64 samples: the tolerance is 5
    // standard errors of the worst estimator, uniform sampling of the hemisphere.
    SceneData scene = EmptyScene();
    GprimData quad = MakeGrid(2.0F, 2.0F);
    quad.SetPrimvar("displayColor", HdInterpolationConstant,
                    VtValue(VtVec3fArray{GfVec3f(0.25F, 0.5F, 0.75F)}), HdPrimvarRoleTokens->color);
    scene.gprims[SdfPath("/quad")] = quad;
    AovRequest color{HdAovTokens->color};
    color.format = HdFormatFloat32Vec4;
    Host host(scene, Quick({color}, 64));
    const Image image = host.Render();
    ASSERT_EQ(image.width, 64);
    double sum[3] = {};
    for (int y = 16; y < 32; ++y) {
        for (int x = 24; x < 40; ++x) {
            for (int component = 0; component < 3; ++component) {
                sum[component] += double(image.Float(x, y, component)) / 256.0;
            }
        }
    }
    EXPECT_NEAR(sum[0], 0.25, 0.02);
    EXPECT_NEAR(sum[1], 0.5, 0.04);
    EXPECT_NEAR(sum[2], 0.75, 0.06);
}

/// What the camera sees of a dome alone, whose colour's metadata name that space.
GfVec3f SeenOfDome(const GfVec3f& color, const char* space) {
    SceneData scene = EmptyScene();
    LightData dome = MakeDome(color);
    if (space != nullptr) {
        HdMaterialNode node;
        node.path = SdfPath("/dome");
        node.identifier = TfToken("DomeLight");
        node.parameters[TfToken("colorSpace:color")] = VtValue(TfToken(space));
        HdMaterialNetworkMap network;
        network.map[HdMaterialTerminalTokens->light].nodes = {node};
        dome.resource = VtValue(network);
    }
    scene.lights[SdfPath("/dome")] = dome;
    AovRequest request{HdAovTokens->color};
    request.format = HdFormatFloat32Vec4;
    const Image image = Host(scene, Quick({request})).Render();
    return {image.Float(5, 5, 0), image.Float(5, 5, 1), image.Float(5, 5, 2)};
}

// Metadata of lights' inputs arrive as those of materials' do, as parameters of a network.
TEST_F(Color, LightsAreInTheSpaceThatTheirColourNames) {
    const GfVec3f color(0.2F, 0.5F, 0.9F);
    EXPECT_EQ(SeenOfDome(color, nullptr), color);
    EXPECT_EQ(SeenOfDome(color, "lin_rec709"), color);
    const GfVec3f decoded = SeenOfDome(color, "srgb_texture");
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(decoded[i], std::pow((color[i] + 0.055F) / 1.055F, 2.4F), 1e-4F);
    }
}

} // namespace

} // namespace hydraHost
