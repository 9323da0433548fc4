// SPDX-License-Identifier: Apache-2.0
// Instancers, nested ones too: places, ids, edits.
#include "hydraTest.h"

#include <pxr/base/gf/quath.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/rprim.h>

#include <fstream>
#include <iterator>

namespace hydraHost {

namespace {

using Instancers = HydraTest;

const SdfPath kOuter("/outer");
const SdfPath kInner("/outer/inner");
const SdfPath kLeaf("/outer/inner/leaf");
const SdfPath kOther("/outer/other");

PrimvarData InstancePrimvar(const TfToken& name, const VtValue& value) {
    return {name, HdInterpolationInstance, HdPrimvarRoleTokens->none, value, {}};
}

/// Two levels: the outer instancer places the inner one twice and a quad once, the inner one
/// places a cube three times, one of its places unused.
SceneData NestedScene() {
    SceneData scene = EmptyScene();
    InstancerData outer;
    outer.transform = Translation(0.0, -0.1, 0.0);
    outer.primvars = {
        InstancePrimvar(HdInstancerTokens->instanceTranslations,
                        VtValue(VtVec3fArray{GfVec3f(0.2F, 0.8F, 0), GfVec3f(-0.2F, -0.5F, 0),
                                             GfVec3f(1.2F, -0.2F, -0.3F)})),
        InstancePrimvar(HdInstancerTokens->instanceRotations,
                        VtValue(VtQuathArray{GfQuath(1, 0, 0, 0), GfQuath(0.96F, 0, 0, 0.28F),
                                             GfQuath(0.8F, 0, 0.6F, 0)}))};
    outer.indicesByPrototype = {{kInner, {0, 1}}, {kOther, {2}}};
    scene.instancers[kOuter] = outer;

    InstancerData inner;
    inner.parent = kOuter;
    inner.transform = GfMatrix4d(1.0).SetScale(GfVec3d(1.0, 0.9, 1.0));
    inner.primvars = {
        InstancePrimvar(HdInstancerTokens->instanceTranslations,
                        VtValue(VtVec3fArray{GfVec3f(-1.2F, 0, 0), GfVec3f(9, 9, 9),
                                             GfVec3f(-0.5F, 0.1F, 0), GfVec3f(0.2F, 0, 0)})),
        InstancePrimvar(
            HdInstancerTokens->instanceScales,
            VtValue(VtVec3fArray{GfVec3f(1), GfVec3f(1), GfVec3f(0.7F, 1.2F, 1), GfVec3f(0.8F)}))};
    inner.indicesByPrototype = {{kLeaf, {0, 3, 2}}};
    scene.instancers[kInner] = inner;

    GprimData leaf = MakeCube(0.25F);
    leaf.transform = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(1, 1, 0), 30.0));
    leaf.instancer = kInner;
    scene.gprims[kLeaf] = leaf;
    GprimData other = MakeGrid(0.4F, 0.3F);
    other.instancer = kOuter;
    scene.gprims[kOther] = other;
    return scene;
}

const std::vector<AovRequest> kAovs{HdAovTokens->color, HdAovTokens->primId,
                                    HdAovTokens->instanceId, HdAovTokens->depth};

void ExpectOracle(Host& host) {
    ASSERT_TRUE(host.RenderUntilConverged());
    const Oracle oracle(host);
    ExpectInts(host.Read(HdAovTokens->primId), oracle, [&host](const OracleHit& hit) {
        return hit.isHit ? host.Index().GetRprim(hit.prim)->GetPrimId() : -1;
    });
    ExpectInts(host.Read(HdAovTokens->instanceId), oracle,
               [](const OracleHit& hit) { return hit.isHit ? hit.instance : -1; });
    ExpectFloats(host.Read(HdAovTokens->depth), oracle, 0, 2e-6,
                 [](const OracleHit& hit) { return hit.isHit ? hit.depth : 1.0; });
}

TEST_F(Instancers, NestedInstancesAreParentMajor) {
    Host host(NestedScene(), Quick(kAovs));
    ExpectOracle(host);
}

struct InstancerEdit {
    const char* name;
    SdfPath path;
    HdDirtyBits bits;
    std::function<void(InstancerData&)> change;
};

TEST_F(Instancers, EditsMoveAndChooseInstances) {
    using Tracker = HdChangeTracker;
    const InstancerEdit edits[] = {
        {"translations", kInner, Tracker::DirtyPrimvar,
         [](InstancerData& data) {
             data.primvars[0].value =
                 VtValue(VtVec3fArray{GfVec3f(-1, 0.2F, 0), GfVec3f(9, 9, 9),
                                      GfVec3f(-0.3F, -0.1F, 0), GfVec3f(0.5F, 0.1F, 0)});
         }},
        {"instancer transform", kOuter, Tracker::DirtyTransform,
         [](InstancerData& data) { data.transform = Translation(0.1, 0.1, 0.2); }},
        {"fewer indices", kInner, Tracker::DirtyInstanceIndex,
         [](InstancerData& data) {
             data.indicesByPrototype[kLeaf] = {2, 0};
         }},
        {"more indices", kOuter, Tracker::DirtyInstanceIndex,
         [](InstancerData& data) {
             data.indicesByPrototype[kInner] = {0, 1, 2};
         }},
    };
    const HostOptions options = Quick(kAovs);
    Host host(NestedScene(), options);
    Image before = host.Render(HdAovTokens->depth);
    for (const InstancerEdit& edit : edits) {
        SCOPED_TRACE(edit.name);
        InstancerData data = host.Scene().Data().instancers.at(edit.path);
        edit.change(data);
        host.Scene().SetInstancer(edit.path, data, edit.bits);
        ExpectOracle(host);
        const Image after = host.Read(HdAovTokens->depth);
        EXPECT_NE(after, before);
        EXPECT_EQ(host.Read(), RenderFresh(host, options));
        EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), 0.0);
        before = after;
    }
}

// Velocities are all that moves these: the picture is that of a host that has known the shutter
// from the start.
TEST_F(Instancers, AShutterThatOpensLaterBlursThem) {
    SceneData scene = EmptyScene();
    const SdfPath swarm("/swarm");
    const SdfPath cube("/swarm/cube");
    InstancerData instancer;
    instancer.primvars = {
        InstancePrimvar(HdInstancerTokens->instanceTranslations,
                        VtValue(VtVec3fArray{GfVec3f(-0.7F, 0, 0), GfVec3f(0.7F, 0, 0)})),
        InstancePrimvar(HdInstancerTokens->instanceRotations,
                        VtValue(VtQuathArray{GfQuath(1, 0, 0, 0), GfQuath(0.96F, 0, 0, 0.28F)})),
        InstancePrimvar(HdTokens->velocities,
                        VtValue(VtVec3fArray{GfVec3f(0, 24, 0), GfVec3f(12, 0, 0)})),
        InstancePrimvar(HdTokens->accelerations,
                        VtValue(VtVec3fArray{GfVec3f(240, 0, 0), GfVec3f(0, 240, 0)})),
        InstancePrimvar(HdTokens->angularVelocities,
                        VtValue(VtVec3fArray{GfVec3f(0, 0, 720), GfVec3f(0, 720, 0)}))};
    instancer.indicesByPrototype = {{cube, {0, 1}}};
    scene.instancers[swarm] = instancer;
    GprimData leaf = MakeCube(0.25F);
    leaf.instancer = swarm;
    scene.gprims[cube] = leaf;
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(scene, options);
    const Image still = host.Render();

    SetShutter(host, -0.25, 0.5);
    const Image blurred = host.Render();
    EXPECT_NE(blurred, still);
    EXPECT_EQ(blurred, RenderFresh(host, options));

    SetShutter(host, -0.25, -0.25);
    EXPECT_EQ(host.Render(), still);
}

TEST_F(Instancers, PrototypeMayGoAndComeBack) {
    const HostOptions options = Quick(kAovs);
    Host host(NestedScene(), options);
    const Image before = host.Render();
    const GprimData leaf = host.Scene().Data().gprims.at(kLeaf);
    InstancerData inner = host.Scene().Data().instancers.at(kInner);
    host.Scene().Remove(kLeaf);
    inner.indicesByPrototype.clear();
    host.Scene().SetInstancer(kInner, inner, HdChangeTracker::DirtyInstanceIndex);
    EXPECT_NE(host.Render(), before);
    inner.indicesByPrototype = {{kLeaf, {0, 3, 2}}};
    host.Scene().SetInstancer(kInner, inner, HdChangeTracker::DirtyInstanceIndex);
    host.Scene().SetGprim(kLeaf, leaf);
    EXPECT_EQ(host.Render(), before);
}

std::string DumpOf(Host& host) {
    host.Frame();
    const std::string file = ::testing::TempDir() + "hydraInstancers.txt";
    EXPECT_TRUE(
        host.Delegate().InvokeCommand(TfToken("dumpScene"), {{TfToken("file"), VtValue(file)}}));
    std::ifstream stream(file);
    return std::string(std::istreambuf_iterator<char>(stream), {});
}

TEST_F(Instancers, NamesOfPrototypesWithoutInstancesAreNotKept) {
    SceneData scene = NestedScene();
    scene.gprims[kLeaf].scenePath = SdfPath("/outer/inner/Leaf");
    const SdfPath material("/materials/red");
    scene.materials[material] = MakeMaterial(GfVec3f(0.8F, 0.1F, 0.1F));
    scene.gprims[kLeaf].mesh.SetGeomSubsets(
        {{HdGeomSubset::TypeFaceSet, kLeaf.AppendChild(TfToken("part")), material,
          VtIntArray{0, 2}}});
    const std::string fresh = [&] {
        Host host(scene, Quick());
        return DumpOf(host);
    }();
    ASSERT_NE(fresh.find("/outer/inner/Leaf/part"), std::string::npos);
    SceneData empty = scene;
    empty.instancers[kInner].indicesByPrototype[kLeaf] = {};
    Host host(empty, Quick());
    EXPECT_EQ(DumpOf(host).find("/outer/inner/Leaf"), std::string::npos);
    host.Scene().SetInstancer(kInner, scene.instancers[kInner],
                              HdChangeTracker::DirtyInstanceIndex);
    EXPECT_EQ(DumpOf(host), fresh);
    host.Scene().SetInstancer(kInner, empty.instancers[kInner],
                              HdChangeTracker::DirtyInstanceIndex);
    host.Frame();
    host.Scene().SetInstancer(kInner, scene.instancers[kInner],
                              HdChangeTracker::DirtyInstanceIndex);
    EXPECT_EQ(DumpOf(host), fresh);
}

TEST_F(Instancers, PrimMayMoveBelowAnInstancer) {
    const HostOptions options = Quick(kAovs);
    SceneData scene = NestedScene();
    GprimData& other = scene.gprims.at(kOther);
    other.instancer = SdfPath();
    Host host(scene, options);
    ExpectOracle(host);
    GprimData instanced = other;
    instanced.instancer = kOuter;
    host.Scene().SetGprim(kOther, instanced,
                          HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex);
    ExpectOracle(host);
}

TEST_F(Instancers, NoInstancesDrawNothing) {
    SceneData scene = NestedScene();
    scene.instancers.at(kInner).indicesByPrototype[kLeaf] = {};
    scene.instancers.at(kOuter).indicesByPrototype[kOther] = {};
    Host host(scene, Quick(kAovs));
    ExpectOracle(host);
}

TEST_F(Instancers, InstanceMatricesAreRead) {
    SceneData scene = NestedScene();
    InstancerData& outer = scene.instancers.at(kOuter);
    outer.primvars = {InstancePrimvar(
        HdInstancerTokens->instanceTransforms,
        VtValue(VtMatrix4dArray{Translation(0.2, 0.8, 0.1),
                                GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 0, 1), 70.0)) *
                                    Translation(-0.2, -0.5, 0.0),
                                GfMatrix4d(1.0).SetScale(GfVec3d(-1.5, 1.0, 1.0)) *
                                    Translation(1.2, -0.2, -0.3)}))};
    Host host(scene, Quick(kAovs));
    ExpectOracle(host);
}

// --- Primvars per instance ---

const SdfPath kRow("/row");
const SdfPath kTile("/row/tile");
const TfToken kColor("displayColor");
const TfToken kColorAov("primvars:displayColor");
const GfVec3f kRed(0.75F, 0.125F, 0.25F);
const GfVec3f kBlue(0.125F, 0.25F, 0.875F);

/// Six tiles beside each other, the fourth not drawn.
SceneData RowScene(const std::vector<GfVec3f>& colors) {
    SceneData scene = EmptyScene();
    InstancerData row;
    VtVec3fArray places;
    for (int i = 0; i < 6; ++i) {
        places.push_back(GfVec3f(float(i) * 0.6F - 1.5F, float(i % 2) * 0.3F, 0.0F));
    }
    row.primvars = {InstancePrimvar(HdInstancerTokens->instanceTranslations, VtValue(places))};
    if (!colors.empty()) {
        row.primvars.push_back(
            InstancePrimvar(kColor, VtValue(VtVec3fArray(colors.begin(), colors.end()))));
    }
    row.indicesByPrototype = {{kTile, {0, 1, 2, 4, 5}}};
    scene.instancers[kRow] = row;
    GprimData tile = MakeGrid(0.25F, 0.4F);
    tile.instancer = kRow;
    scene.gprims[kTile] = tile;
    return scene;
}

const std::vector<AovRequest> kColorAovs{HdAovTokens->color, HdAovTokens->primId,
                                         HdAovTokens->instanceId, HdAovTokens->depth, kColorAov};

/// The image has these colours at the drawn instances, and ids and depths are the oracle's.
void ExpectColors(Host& host, const std::vector<GfVec3f>& colorByInstance) {
    ExpectOracle(host);
    const Oracle oracle(host);
    for (int component = 0; component < 3; ++component) {
        ExpectFloats(host.Read(kColorAov), oracle, component, 1e-6, [&](const OracleHit& hit) {
            return hit.isHit ? double(colorByInstance[size_t(hit.instance)][component]) : 0.0;
        });
    }
}

void SetColors(Host& host, const SdfPath& path, const std::vector<GfVec3f>& colors) {
    InstancerData data = host.Scene().Data().instancers.at(path);
    for (PrimvarData& primvar : data.primvars) {
        if (primvar.name == kColor) {
            primvar.value = VtValue(VtVec3fArray(colors.begin(), colors.end()));
        }
    }
    host.Scene().SetInstancer(path, data, HdChangeTracker::DirtyPrimvar);
}

TEST_F(Instancers, EqualValuesAreAConstantPrimvar) {
    Host host(RowScene(std::vector<GfVec3f>(6, kRed)), Quick(kColorAovs));
    ExpectColors(host, std::vector<GfVec3f>(5, kRed));
    Host plain(RowScene({}), Quick(kColorAovs));
    ASSERT_TRUE(plain.RenderUntilConverged());
    EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), plain.Statistic("geometry.chunksBuilt"));
}

TEST_F(Instancers, ValuesPerInstanceAreSeenWhereTheyBelong) {
    Host host(RowScene({kRed, kBlue, kRed, kRed, kBlue, kRed}), Quick(kColorAovs));
    ExpectColors(host, {kRed, kBlue, kRed, kBlue, kRed});
}

TEST_F(Instancers, ValuesOfAMeshWin) {
    SceneData scene = RowScene({kRed, kBlue, kRed, kRed, kBlue, kRed});
    const GfVec3f green(0.0F, 0.5F, 0.0F);
    scene.gprims.at(kTile).SetPrimvar("displayColor", HdInterpolationConstant,
                                      VtValue(VtVec3fArray{green}), HdPrimvarRoleTokens->color);
    Host host(scene, Quick(kColorAovs));
    ExpectColors(host, std::vector<GfVec3f>(5, green));
}

TEST_F(Instancers, EditsOfValuesReachTheMeshes) {
    const HostOptions options = Quick(kColorAovs);
    Host host(RowScene({kRed, kBlue, kRed, kRed, kBlue, kRed}), options);
    ExpectColors(host, {kRed, kBlue, kRed, kBlue, kRed});

    InstancerData moved = host.Scene().Data().instancers.at(kRow);
    moved.transform = Translation(0.0, 0.3, 0.1);
    host.Scene().SetInstancer(kRow, moved, HdChangeTracker::DirtyTransform);
    ExpectColors(host, {kRed, kBlue, kRed, kBlue, kRed});
    EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), 0.0);

    moved.indicesByPrototype = {{kTile, {0, 1, 4, 5}}};
    host.Scene().SetInstancer(kRow, moved, HdChangeTracker::DirtyInstanceIndex);
    ExpectColors(host, {kRed, kBlue, kBlue, kRed});
    EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), 0.0);
    EXPECT_EQ(host.Read(), RenderFresh(host, options));

    SetColors(host, kRow, {kRed, kRed, kRed, kRed, kBlue, kRed}); // the same two groups
    ExpectColors(host, {kRed, kRed, kBlue, kRed});
    EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), 0.0);
    EXPECT_EQ(host.Read(), RenderFresh(host, options));

    const GfVec3f green(0.0F, 0.5F, 0.0F);
    SetColors(host, kRow, {green, kRed, kRed, kRed, kBlue, kRed});
    ExpectColors(host, {green, kRed, kBlue, kRed});
    EXPECT_EQ(host.Read(), RenderFresh(host, options));

    SetColors(host, kRow, std::vector<GfVec3f>(6, kBlue));
    ExpectColors(host, std::vector<GfVec3f>(4, kBlue));
    EXPECT_EQ(host.Read(), RenderFresh(host, options));

    InstancerData plain = host.Scene().Data().instancers.at(kRow);
    plain.primvars.pop_back();
    host.Scene().SetInstancer(kRow, plain, HdChangeTracker::DirtyPrimvar);
    ExpectColors(host, std::vector<GfVec3f>(4, GfVec3f(0.0F)));
    EXPECT_EQ(host.Read(), RenderFresh(host, options));
    EXPECT_EQ(NumWarnings(host, ""), 0);
}

TEST_F(Instancers, SplitMeshesThatGlowKeepTheirIds) {
    SceneData scene = RowScene({kRed, kBlue, kRed, kRed, kBlue, kRed});
    scene.materials[SdfPath("/glow")] = MakeMaterial(GfVec3f(0.5F), GfVec3f(1.0F));
    scene.gprims.at(kTile).material = SdfPath("/glow");
    Host host(scene, Quick(kColorAovs));
    ExpectColors(host, {kRed, kBlue, kRed, kBlue, kRed});
}

TEST_F(Instancers, SplitMeshesMayGoAndComeBack) {
    const HostOptions options = Quick(kColorAovs);
    Host host(RowScene({kRed, kBlue, kRed, kRed, kBlue, kRed}), options);
    const Image before = host.Render();
    const GprimData tile = host.Scene().Data().gprims.at(kTile);
    host.Scene().Remove(kTile);
    const Image empty = host.Render();
    EXPECT_NE(empty, before);
    host.Scene().SetGprim(kTile, tile);
    EXPECT_EQ(host.Render(), before);
    GprimData hidden = tile;
    hidden.isVisible = false;
    host.Scene().SetGprim(kTile, hidden, HdChangeTracker::DirtyVisibility);
    EXPECT_EQ(host.Render(), empty);
    SetColors(host, kRow, std::vector<GfVec3f>(6, kRed));
    host.Scene().SetGprim(kTile, tile, HdChangeTracker::DirtyVisibility);
    ExpectColors(host, std::vector<GfVec3f>(5, kRed));
    EXPECT_EQ(host.Read(), RenderFresh(host, options));
}

TEST_F(Instancers, ValuesOfOuterInstancersAreThoseOfTheirInstances) {
    SceneData scene = NestedScene();
    const auto colors = [](const GfVec3f& first, const GfVec3f& second, const GfVec3f& third) {
        return InstancePrimvar(kColor, VtValue(VtVec3fArray{first, second, third}));
    };
    scene.instancers.at(kOuter).primvars.push_back(colors(kRed, kRed, kBlue));
    {
        Host host(scene, Quick(kColorAovs));
        ExpectOracle(host);
        const Oracle oracle(host);
        ExpectFloats(host.Read(kColorAov), oracle, 0, 1e-6, [](const OracleHit& hit) {
            return !hit.isHit ? 0.0 : double(hit.prim == kLeaf ? kRed[0] : kBlue[0]);
        });
    }
    scene.instancers.at(kOuter).primvars.back() = colors(kRed, kBlue, kBlue);
    Host host(scene, Quick(kColorAovs));
    ExpectOracle(host);
    const Oracle oracle(host);
    ExpectFloats(host.Read(kColorAov), oracle, 0, 1e-6, [](const OracleHit& hit) {
        const bool isFirst = hit.prim == kLeaf && hit.instance < 3; // three leaves in each
        return !hit.isHit ? 0.0 : double(isFirst ? kRed[0] : kBlue[0]);
    });
    EXPECT_EQ(NumWarnings(host, ""), 0);
}

/// 65 tiles of as many values of a primvar.
SceneData ManyScene(const TfToken& name, VtVec3fArray* colors) {
    SceneData scene = RowScene({});
    InstancerData& row = scene.instancers.at(kRow);
    VtVec3fArray places;
    VtFloatArray numbers;
    std::vector<int> indices;
    for (int i = 0; i < 65; ++i) {
        places.push_back(GfVec3f(float(i % 13) * 0.3F - 1.8F, float(i / 13) * 0.5F - 1.0F, 0.0F));
        colors->push_back(GfVec3f(float(i) / 128.0F, 0.5F, 0.5F));
        numbers.push_back(float(i));
        indices.push_back(i);
    }
    row.primvars = {InstancePrimvar(HdInstancerTokens->instanceTranslations, VtValue(places)),
                    InstancePrimvar(name, name == kColor ? VtValue(*colors) : VtValue(numbers))};
    row.indicesByPrototype = {{kTile, VtIntArray(indices.begin(), indices.end())}};
    GprimData tile = MakeGrid(0.12F, 0.2F);
    tile.instancer = kRow;
    scene.gprims[kTile] = tile;
    return scene;
}

TEST_F(Instancers, ValuesMayBeAsManyAsInstances) {
    VtVec3fArray colors;
    Host host(ManyScene(kColor, &colors), Quick(kColorAovs));
    ExpectColors(host, {colors.begin(), colors.end()});
    EXPECT_EQ(host.Statistic("geometry.meshes"), 1.0);
    EXPECT_EQ(NumWarnings(host, ""), 0);
}

TEST_F(Instancers, TooManyValuesOfWhatIsReadOnceAPrimAreAWarning) {
    VtVec3fArray colors;
    SceneData scene = ManyScene(TfToken("hdstream:dielectricPriority"), &colors);
    const std::string warning = "/row: more than 64 different values by instance";
    Host host(scene, Quick(kColorAovs));
    ExpectColors(host, std::vector<GfVec3f>(65, GfVec3f(0.0F)));
    EXPECT_EQ(NumWarnings(host, warning), 1);

    VtIntArray& indices = scene.instancers.at(kRow).indicesByPrototype.at(kTile);
    indices.pop_back(); // 64 are drawn
    Host fewer(scene, Quick(kColorAovs));
    ASSERT_TRUE(fewer.RenderUntilConverged());
    EXPECT_EQ(fewer.Statistic("geometry.meshes"), 64.0);
    EXPECT_EQ(NumWarnings(fewer, warning), 0);
}

TEST_F(Instancers, WhoSeesThemMayDifferBetweenAllInstances) {
    VtVec3fArray colors;
    Host host(ManyScene(TfToken("hdstream:holdout"), &colors),
              Quick({HdAovTokens->color, HdAovTokens->instanceId}));
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(host.Statistic("geometry.meshes"), 1.0);
    EXPECT_EQ(NumWarnings(host, ""), 0);
    const Image image = host.Read();
    const Image ids = host.Read(HdAovTokens->instanceId);
    int numOfFirst = 0; // whose number is 0
    int numHeldOut = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const bool isBlack = image.Float(x, y, 3) == 0.0F && image.Float(x, y, 0) == 0.0F;
            numOfFirst += ids.Int(x, y) == 0;
            numHeldOut += ids.Int(x, y) > 0 && isBlack;
            EXPECT_FALSE(ids.Int(x, y) == 0 && isBlack);
        }
    }
    EXPECT_GT(numOfFirst, 2);
    EXPECT_GT(numHeldOut, 500);
}

} // namespace

} // namespace hydraHost
