// SPDX-License-Identifier: Apache-2.0
// Instancers, nested ones too: places, ids, edits.
#include "hydraTest.h"

#include <pxr/base/gf/quath.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/rprim.h>

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
        const double built = host.Statistic("geometry.chunksBuilt");
        InstancerData data = host.Scene().Data().instancers.at(edit.path);
        edit.change(data);
        host.Scene().SetInstancer(edit.path, data, edit.bits);
        ExpectOracle(host);
        const Image after = host.Read(HdAovTokens->depth);
        EXPECT_NE(after, before);
        EXPECT_EQ(host.Read(), RenderFresh(host, options));
        EXPECT_LE(host.Statistic("geometry.chunksBuilt"), built);
        before = after;
    }
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

} // namespace

} // namespace hydraHost
