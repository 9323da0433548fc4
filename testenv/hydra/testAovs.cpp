// SPDX-License-Identifier: Apache-2.0
// The AOVs of the first hit against brute force in double precision.
#include "hydraTest.h"

#include <pxr/imaging/hd/rprim.h>

#include <algorithm>
#include <cstring>

namespace hydraHost {

namespace {

/// The prim id Hydra gave to a prim.
int PrimId(Host& host, const SdfPath& path) {
    return host.Index().GetRprim(path)->GetPrimId();
}

const std::vector<AovRequest> kAllAovs{
    HdAovTokens->color,     HdAovTokens->depth,  HdAovTokens->primId,     HdAovTokens->instanceId,
    HdAovTokens->elementId, HdAovTokens->normal, HdAovTokens->cameraDepth};

using Aovs = HydraTest;

TEST_F(Aovs, IdsAreHydrasAndBackgroundIsMinusOne) {
    Host host(ThreeMeshes(), Quick(kAllAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    ExpectInts(host.Read(HdAovTokens->primId), oracle,
               [&host](const OracleHit& hit) { return hit.isHit ? PrimId(host, hit.prim) : -1; });
    ExpectInts(host.Read(HdAovTokens->instanceId), oracle,
               [](const OracleHit& hit) { return hit.isHit ? hit.instance : -1; });
}

/// The id is a hash of the path, as Cryptomatte 1.2 says; of /cube by a program of another author.
TEST_F(Aovs, LayersOfCryptomattesHoldIdsOfPathsAndCoverages) {
    const TfToken layer("crypto_object00");
    Host host(ThreeMeshes(), Quick({HdAovTokens->color, HdAovTokens->primId, layer}));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    const Image mattes = host.Read(layer);
    ASSERT_EQ(mattes.format, HdFormatFloat32Vec4);
    int numCubes = 0;
    for (int y = 0; y < mattes.height; ++y) {
        for (int x = 0; x < mattes.width; ++x) {
            const OracleHit hit = oracle.Trace(x, y);
            const float id = mattes.Float(x, y, 0);
            std::uint32_t bits = 0;
            std::memcpy(&bits, &id, sizeof(bits));
            if (!hit.isAmbiguous && mattes.Float(x, y, 1) == 1.0F) {
                EXPECT_TRUE(hit.isHit);
                EXPECT_EQ(bits == 0x21268babU, hit.prim == SdfPath("/cube"));
                numCubes += bits == 0x21268babU ? 1 : 0;
            }
            EXPECT_LE(mattes.Float(x, y, 1) + mattes.Float(x, y, 3), 1.00001F);
        }
    }
    EXPECT_GT(numCubes, 10);
    EXPECT_EQ(host.Delegate().GetDefaultAovDescriptor(TfToken("crypto_object")).format,
              HdFormatInvalid);
}

/// Of names, of expressions as names, and of the settings that render vars leave with a binding.
TEST_F(Aovs, LightPathExpressionsAddUpToColour) {
    const std::vector<const char*> names = {"diffuse", "lpe:C<R[GS]>.*[LO]", "renamed", "emission",
                                            "primaries"};
    std::vector<AovRequest> aovs = {HdAovTokens->color};
    for (const char* name : names) {
        aovs.emplace_back(TfToken(name));
        aovs.back().format = HdFormatFloat32Vec3;
        aovs.back().clearValue = VtValue(GfVec3f(0.0F));
    }
    aovs[3].settings[TfToken("sourceType")] = VtValue(TfToken("lpe"));
    aovs[3].settings[TfToken("sourceName")] = VtValue(std::string("CT.*[LO]"));
    aovs[5].settings[TfToken("sourceType")] = VtValue(std::string("raw"));
    aovs[5].settings[TfToken("sourceName")] = VtValue(std::string("direct"));
    Host host(ThreeMeshes(), Quick(aovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image color = host.Read(HdAovTokens->color);
    double largest = 0.0;
    double direct = 0.0;
    for (int y = 0; y < color.height; ++y) {
        for (int x = 0; x < color.width; ++x) {
            for (int channel = 0; channel < 3; ++channel) {
                float sum = 0.0F;
                for (int i = 0; i < 4; ++i) {
                    sum += host.Read(TfToken(names[i])).Float(x, y, channel);
                }
                EXPECT_NEAR(sum, color.Float(x, y, channel), 1e-5F);
                largest = std::max(largest, double(sum));
                direct =
                    std::max(direct, double(host.Read(TfToken("primaries")).Float(x, y, channel)));
            }
        }
    }
    EXPECT_GT(largest, 0.1);
    EXPECT_GT(direct, 0.05) << "an output of a name that is not ours shows its source";
}

TEST_F(Aovs, OutputsOfOtherNamesShowWhatTheirSourcesUsuallyMean) {
    std::vector<AovRequest> aovs = {TfToken("position"), TfToken("whereItIs")};
    aovs[1].format = HdFormatFloat32Vec3;
    aovs[1].clearValue = VtValue(GfVec3f(0.0F));
    aovs[1].settings[TfToken("sourceType")] = VtValue(TfToken("intrinsic"));
    aovs[1].settings[TfToken("sourceName")] = VtValue(std::string("P"));
    Host host(ThreeMeshes(), Quick(aovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image position = host.Read(TfToken("position"));
    const Image other = host.Read(TfToken("whereItIs"));
    int numSeen = 0;
    for (int y = 0; y < position.height; ++y) {
        for (int x = 0; x < position.width; ++x) {
            numSeen += position.Float(x, y, 0) != 0.0F;
            for (int channel = 0; channel < 3; ++channel) {
                EXPECT_EQ(other.Float(x, y, channel), position.Float(x, y, channel));
            }
        }
    }
    EXPECT_GT(numSeen, 100);
}

TEST_F(Aovs, ExpressionsThatCannotBeReadAreNotOffered) {
    Host host(ThreeMeshes(), Quick({HdAovTokens->color}));
    EXPECT_EQ(host.Delegate().GetDefaultAovDescriptor(TfToken("lpe:C(")).format, HdFormatInvalid);
    EXPECT_EQ(host.Delegate().GetDefaultAovDescriptor(TfToken("lightGroup:a'b")).format,
              HdFormatInvalid);
    EXPECT_NE(host.Delegate().GetDefaultAovDescriptor(TfToken("lightGroup:key")).format,
              HdFormatInvalid);
}

TEST_F(Aovs, ElementIdIsTheAuthoredFace) {
    Host host(ThreeMeshes(), Quick(kAllAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    ExpectInts(host.Read(HdAovTokens->elementId), Oracle(host),
               [](const OracleHit& hit) { return hit.isHit ? hit.face : -1; });
}

TEST_F(Aovs, DepthIsProjectedOfTheHitAndOneBehind) {
    Host host(ThreeMeshes(), Quick(kAllAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    // Float32 depth near 1 resolves 6e-8; the projection is done in float by some renderers.
    ExpectFloats(host.Read(HdAovTokens->depth), oracle, 0, 2e-6,
                 [](const OracleHit& hit) { return hit.isHit ? hit.depth : 1.0; });
    const Image cameraDepth = host.Read(HdAovTokens->cameraDepth);
    const double clear = double(cameraDepth.Float(0, 0));
    ExpectFloats(cameraDepth, oracle, 0, 1e-5,
                 [clear](const OracleHit& hit) { return hit.isHit ? hit.cameraDepth : clear; });
}

TEST_F(Aovs, NormalsAreOfWorldSpaceAndUnitLength) {
    SceneData scene = ThreeMeshes();
    // A sheared, mirrored and scaled transform: normals need the inverse transpose.
    GprimData& cube = scene.gprims.at(SdfPath("/cube"));
    GfMatrix4d shear(1.0);
    shear[1][0] = 0.6;
    shear[2][2] = -0.7;
    cube.transform = shear * cube.transform;
    Host host(scene, Quick(kAllAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    const GfVec3f clear = host.Delegate()
                              .GetDefaultAovDescriptor(HdAovTokens->normal)
                              .clearValue.GetWithDefault<GfVec3f>();
    for (int component = 0; component < 3; ++component) {
        ExpectFloats(host.Read(HdAovTokens->normal), oracle, component, 2e-5,
                     [component, clear](const OracleHit& hit) {
                         return hit.isHit ? hit.normal[component] : double(clear[component]);
                     });
    }
}

TEST_F(Aovs, EyeNormalsAreOfCameraSpace) {
    SceneData scene = ThreeMeshes();
    CameraData& camera = scene.cameras.at(SdfPath("/camera"));
    camera.transform =
        GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 0, 1), 90.0)) * camera.transform;
    Host host(scene, Quick({HdAovTokens->color, HdAovTokens->Neye}));
    ASSERT_TRUE(host.RenderUntilConverged());
    const GfMatrix4d viewFromWorld = host.Task().State().GetWorldToViewMatrix();
    const GfVec3f clear = host.Delegate()
                              .GetDefaultAovDescriptor(HdAovTokens->Neye)
                              .clearValue.GetWithDefault<GfVec3f>();
    const Oracle oracle(host);
    for (int component = 0; component < 3; ++component) {
        ExpectFloats(host.Read(HdAovTokens->Neye), oracle, component, 2e-5,
                     [component, clear, &viewFromWorld](const OracleHit& hit) {
                         return hit.isHit ? viewFromWorld.TransformDir(hit.normal)[component]
                                          : double(clear[component]);
                     });
    }
}

TEST_F(Aovs, ElementIdOfRefinedMeshesAndHolesIsTheAuthoredFace) {
    SceneData scene = EmptyScene();
    // Bilinear subdivision keeps the surface, so that the oracle knows it; face 4 is a hole.
    GprimData grid = MakeGrid(1.3F, 1.0F, 4, 3);
    grid.mesh =
        HdMeshTopology(TfToken("bilinear"), HdTokens->rightHanded, grid.mesh.GetFaceVertexCounts(),
                       grid.mesh.GetFaceVertexIndices(), VtIntArray{4});
    grid.refineLevel = 2;
    grid.transform = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0.2, 1, 0), 20.0));
    scene.gprims[SdfPath("/grid")] = grid;
    HostOptions options = Quick({HdAovTokens->color, HdAovTokens->elementId});
    options.settings[TfToken("subdivision")] = VtValue(std::string("complexity"));
    Host host(scene, options);
    ASSERT_TRUE(host.RenderUntilConverged());
    ExpectInts(host.Read(HdAovTokens->elementId), Oracle(host),
               [](const OracleHit& hit) { return hit.isHit ? hit.face : -1; });
}

TEST_F(Aovs, PrimIdFollowsItsEdit) {
    Host host(ThreeMeshes(), Quick({HdAovTokens->color, HdAovTokens->primId}));
    ASSERT_TRUE(host.RenderUntilConverged());
    // As the index does when it compacts ids; 2^24 + 1 is no float.
    const SdfPath cube("/cube");
    const_cast<HdRprim*>(host.Index().GetRprim(cube))->SetPrimId((1 << 24) + 1);
    // Scene-index emulation drops DirtyPrimID, so that the new id comes with the next edit.
    host.Index().GetChangeTracker().MarkRprimDirty(cube, HdChangeTracker::DirtyPrimID |
                                                             HdChangeTracker::DirtyTransform);
    ASSERT_TRUE(host.RenderUntilConverged());
    ExpectInts(host.Read(HdAovTokens->primId), Oracle(host),
               [&host](const OracleHit& hit) { return hit.isHit ? PrimId(host, hit.prim) : -1; });
}

TEST_F(Aovs, PrimvarIsInterpolated) {
    SceneData scene = EmptyScene();
    GprimData grid = MakeGrid(1.3F, 1.0F, 2, 2);
    // A linear function of the position has the same value however it is interpolated.
    VtVec3fArray colors;
    for (const GfVec3f& point :
         grid.FindPrimvar(HdTokens->points)->value.UncheckedGet<VtVec3fArray>()) {
        colors.push_back(GfVec3f(point[0] * 0.25F + 0.5F, point[1] * 0.25F + 0.5F, 0.125F));
    }
    grid.SetPrimvar("displayColor", HdInterpolationVertex, VtValue(colors),
                    HdPrimvarRoleTokens->color);
    scene.gprims[SdfPath("/grid")] = grid;
    const TfToken aov("primvars:displayColor");
    Host host(scene, Quick({HdAovTokens->color, aov}));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    for (int component = 0; component < 2; ++component) {
        ExpectFloats(host.Read(aov), oracle, component, 1e-5, [component](const OracleHit& hit) {
            return hit.isHit ? hit.position[component] * 0.25 + 0.5 : 0.0;
        });
    }
    // As hosts say it that make names of prims from those of outputs.
    const TfToken alias("primvars_displayColor");
    Host other(scene, Quick({HdAovTokens->color, alias}));
    ASSERT_TRUE(other.RenderUntilConverged());
    EXPECT_EQ(other.Read(alias), host.Read(aov));
}

} // namespace

} // namespace hydraHost
