# SPDX-License-Identifier: Apache-2.0
"""Instancers place every leaf where OpenUSD's own functions say, on random nested stages.

The oracle is usd-core: instance proxies with UsdGeom.XformCache for native instances, and
PointInstancer.ComputeInstanceTransformsAtTime with masks and prototype transforms.
"""

import collections

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt

from translateCase import StageOf, Translate

TIME = Usd.TimeCode(3.0)
PROXIES = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
# Prototypes may be below an over: neither defined nor abstract counts there.
PROTOTYPES = Usd.TraverseInstanceProxies(
    Usd.PrimIsActive & Usd.PrimHasDefiningSpecifier & ~Usd.PrimIsAbstract)


# --- Random stages -------------------------------------------------------------------------------

class RandomStage:
    """Libraries of prototypes of growing depth, then a world that uses them."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.stage = Usd.Stage.CreateInMemory()
        self.numLeaves = 0
        self.library = []
        for level in range(3):
            for index in range(2):
                path = f"/_class_{level}_{index}"
                self.stage.CreateClassPrim(path)
                self.Fill(path, self.library[:2 * level], depth=1)
                self.library.append(path)
        UsdGeom.Xform.Define(self.stage, "/World")
        self.Fill("/World", self.library, depth=2)

    def Place(self, path, canReset=False):
        xform = UsdGeom.Xformable(self.stage.GetPrimAtPath(path))
        if self.rng.random() < 0.8:
            xform.AddTranslateOp().Set(Gf.Vec3d(*map(float, self.rng.normal(size=3))))
        if self.rng.random() < 0.5:
            xform.AddRotateXYZOp().Set(Gf.Vec3f(*map(float, self.rng.uniform(-180, 180, 3))))
        if self.rng.random() < 0.3:
            xform.AddScaleOp().Set(Gf.Vec3f(*map(float, self.rng.uniform(0.5, 2, 3))))
        if canReset and self.rng.random() < 0.2:
            xform.SetResetXformStack(True)

    def AddLeaf(self, parent):
        path = f"{parent}/leaf{self.numLeaves}"
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        # The first coordinate names the leaf in whatever place it turns up.
        mesh.CreatePointsAttr([(self.numLeaves, 0, 0), (1, 0, 0), (0, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        self.numLeaves += 1
        self.Place(path)

    def AddPointInstancer(self, parent, library, name):
        path = f"{parent}/{name}"
        instancer = UsdGeom.PointInstancer.Define(self.stage, path)
        self.Place(path)
        self.stage.OverridePrim(f"{path}/protos")
        targets = []
        for index in range(2):
            target = f"{path}/protos/p{index}"
            UsdGeom.Xform.Define(self.stage, target)
            self.Place(target)
            self.AddLeaf(target)
            if library and self.rng.random() < 0.6:
                self.AddNative(target, library, "native")
            targets.append(target)
        if self.rng.random() < 0.5:
            inner = f"{path}/protos/inner"
            self.AddPointInstancer(f"{path}/protos", [], "inner")
            targets.append(inner)
        instancer.CreatePrototypesRel().SetTargets(targets)
        count = int(self.rng.integers(1, 6))
        instancer.CreateProtoIndicesAttr(self.rng.integers(0, len(targets), count).tolist())
        instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(
            self.rng.normal(size=(count, 3)).astype(np.float32)))
        if self.rng.random() < 0.5:
            quats = self.rng.normal(size=(count, 4))
            quats /= np.linalg.norm(quats, axis=1, keepdims=True)
            if self.rng.random() < 0.5:
                instancer.CreateOrientationsAttr([Gf.Quath(*map(float, q)) for q in quats])
            else:
                instancer.CreateOrientationsfAttr([Gf.Quatf(*map(float, q)) for q in quats])
        if self.rng.random() < 0.5:
            instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(
                self.rng.uniform(0.5, 2, (count, 3)).astype(np.float32)))
        if self.rng.random() < 0.5:
            instancer.CreateVelocitiesAttr([(1, 2, 3)] * count)
        if self.rng.random() < 0.6:
            instancer.CreateIdsAttr([100 + i for i in range(count)])
            instancer.InvisId(100, TIME)
            instancer.DeactivateId(100 + count - 1)

    def AddNative(self, parent, library, name):
        path = f"{parent}/{name}"
        prim = UsdGeom.Xform.Define(self.stage, path).GetPrim()
        prim.GetReferences().AddInternalReference(str(self.rng.choice(library)))
        prim.SetInstanceable(True)
        self.Place(path)
        if self.rng.random() < 0.2:
            UsdGeom.Imageable(prim).MakeInvisible()

    def Fill(self, parent, library, depth):
        self.AddLeaf(parent)
        isWorld = parent.startswith("/World")
        for index in range(int(self.rng.integers(1, 4))):
            kind = self.rng.integers(0, 3)
            name = f"c{index}"
            if kind == 0 and library:
                self.AddNative(parent, library, name)
            elif kind == 1:
                self.AddPointInstancer(parent, library, name)
            elif depth > 0:
                group = UsdGeom.Xform.Define(self.stage, f"{parent}/{name}").GetPath().pathString
                self.Place(group, canReset=isWorld)
                self.Fill(group, library, depth - 1)


# --- Oracle --------------------------------------------------------------------------------------

def OracleLeaves(stage):
    """(leaf, world matrix) of everything drawn, from OpenUSD's own functions."""
    cache = UsdGeom.XformCache(TIME)
    leaves = []

    def WalkBelow(root, isPrototype, worldFromRoot):
        """`worldFromRoot` is None where namespace alone places prims."""
        prims = iter(Usd.PrimRange(root, PROTOTYPES if isPrototype else PROXIES))
        for prim in prims:
            if not IsVisible(prim, root if isPrototype else None):
                prims.PruneChildren()
                continue
            isLeaf = prim.IsA(UsdGeom.Mesh)
            isInstancer = prim.IsA(UsdGeom.PointInstancer)
            if not isLeaf and not isInstancer:
                continue
            if isPrototype:
                relative, _ = cache.ComputeRelativeTransform(prim, root)
                matrix = relative * worldFromRoot
            else:
                matrix = cache.GetLocalToWorldTransform(prim)
            if isLeaf:
                name = int(prim.GetAttribute("points").Get()[0][0])
                leaves.append((name, np.array(matrix)))
            else:
                WalkInstancer(UsdGeom.PointInstancer(prim), matrix)
                prims.PruneChildren()

    def WalkInstancer(instancer, worldFromInstancer):
        matrices = instancer.ComputeInstanceTransformsAtTime(
            TIME, TIME, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask)
        mask = instancer.ComputeMaskAtTime(TIME)
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        indices = instancer.GetProtoIndicesAttr().Get(TIME)
        for number, (index, matrix) in enumerate(zip(indices, matrices)):
            if len(mask) and not mask[number]:
                continue
            WalkBelow(stage.GetPrimAtPath(targets[index]), True, matrix * worldFromInstancer)

    def IsVisible(prim, root):
        """Visibility counts from the prototype's root, or from the stage's."""
        while prim and not prim.IsPseudoRoot():
            imageable = UsdGeom.Imageable(prim)
            if imageable and imageable.GetVisibilityAttr().Get(TIME) == "invisible":
                return False
            if root and prim == root:
                return True
            prim = prim.GetParent()
        return True

    WalkBelow(stage.GetPrimAtPath("/World"), False, None)
    return leaves


# --- What was translated --------------------------------------------------------------------------

def ExpandedLeaves(scene):
    """(leaf, world matrix) of every drawn mesh, by the contract of hdStream/scene/sceneDescription.h."""
    meshes, instancers = scene.geometry, scene.instancers

    def Placements(placement):
        """World matrices (row vectors) of whatever is placed so."""
        local = placement.worldFromObject
        if not placement.instancerPath:
            return [local]
        instancer = instancers[placement.instancerPath]
        if not instancer.placement.visible:
            return []
        transforms = instancer.instanceTransforms.reshape(-1, 4, 4)
        return [local @ transforms[index] @ parent
                for parent in Placements(instancer.placement)
                for index in placement.instances]

    return [(int(prim.geometry.points[0][0]), matrix)
            for prim in meshes.values() if prim.placement.visible
            for matrix in Placements(prim.placement)]


def AssertSameLeaves(found, expected):
    def Grouped(leaves):
        groups = collections.defaultdict(list)
        for name, matrix in leaves:
            groups[name].append(matrix)
        return {name: np.array(sorted(matrices, key=lambda m: m[3].round(6).tolist()))
                for name, matrices in groups.items()}

    found, expected = Grouped(found), Grouped(expected)
    assert found.keys() == expected.keys()
    for name, matrices in expected.items():
        assert len(found[name]) == len(matrices), f"leaf{name}"
        # Products of up to seven matrices in another order: rounding of doubles, no more.
        np.testing.assert_allclose(found[name], matrices, atol=1e-9, err_msg=f"leaf{name}")


@pytest.mark.parametrize("seed", range(40))
def test_leaves_are_where_usd_puts_them(seed):
    stage = RandomStage(seed).stage
    scene = Translate(stage, TIME).Scene()
    expected = OracleLeaves(stage)
    assert expected
    AssertSameLeaves(ExpandedLeaves(scene), expected)


def test_random_stages_have_what_they_are_for():
    """Together they must nest point instancers below native instances and the other way round."""
    chains = collections.Counter()
    for seed in range(40):
        scene = Translate(RandomStage(seed).stage, TIME).Scene()
        instancers = scene.instancers
        for instancer in instancers.values():
            depth = 1
            while instancer.placement.instancerPath:
                instancer = instancers[instancer.placement.instancerPath]
                depth += 1
            chains[depth] += 1
    assert chains[3] > 10 and max(chains) >= 4


def test_a_million_instances_are_arrays():
    """Transforms are those that OpenUSD computes, and the prototype exists once."""
    count = 1000000
    stage = Usd.Stage.CreateInMemory()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    UsdGeom.Cube.Define(stage, "/Points/Box")
    UsdGeom.Sphere.Define(stage, "/Points/Ball")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Box", "/Points/Ball"])
    rng = np.random.default_rng(1)
    indices = rng.integers(0, 2, count).astype(np.int32)
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(indices))
    positions = rng.random((count, 3), np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions))
    scene = Translate(stage).Scene()
    assert len(scene.geometry) == 2
    found = scene.instancers["/Points"]
    assert found.instanceTransforms.shape == (count, 16)
    np.testing.assert_array_equal(found.instanceTransforms[:, 12:15], positions.astype(np.float64))
    np.testing.assert_array_equal(scene.geometry["/Points/Ball"].placement.instances, np.flatnonzero(indices == 1))


@pytest.mark.parametrize("rotations", ["none", "half", "single", "unnormalised"])
@pytest.mark.parametrize("hasScales", [True, False])
def test_the_core_composes_what_is_authored_as_usd_does(rotations, hasScales):
    """Matrices that the core makes of arrays as authored have the bits of ComputeInstanceTransformsAtTime's."""
    count = 3000
    rng = np.random.default_rng(2)
    stage = Usd.Stage.CreateInMemory()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    UsdGeom.Cube.Define(stage, "/Points/Box")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Box"])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(count))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(rng.normal(0, 100, (count, 3)).astype(np.float32)))
    quaternions = rng.normal(size=(count, 4))
    if rotations != "unnormalised":
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    if rotations == "single":
        if not hasattr(instancer, "CreateOrientationsfAttr"):
            pytest.skip("this version of USD has no orientationsf")
        instancer.CreateOrientationsfAttr(Vt.QuatfArray.FromNumpy(quaternions.astype(np.float32)))
    elif rotations != "none":
        instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(quaternions.astype(np.float16)))
    if hasScales:
        instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(rng.normal(0, 2, (count, 3)).astype(np.float32)))
    wanted = np.asarray(instancer.ComputeInstanceTransformsAtTime(
        TIME, TIME, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask))
    found = Translate(stage).Scene().instancers["/Points"].instanceTransforms
    np.testing.assert_array_equal(found.view(np.uint64), np.ascontiguousarray(wanted.reshape(count, 16)).view(np.uint64))


@pytest.mark.parametrize("authored", ["scales", "orientations"])
def test_arrays_that_do_not_match_are_refused(authored):
    stage = Usd.Stage.CreateInMemory()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    UsdGeom.Cube.Define(stage, "/Points/Box")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Box"])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(4))
    instancer.CreatePositionsAttr(Vt.Vec3fArray(4))
    if authored == "scales":
        instancer.CreateScalesAttr(Vt.Vec3fArray(3, (1, 1, 1)))
    else:
        instancer.CreateOrientationsAttr(Vt.QuathArray(3, Gf.Quath(1)))
    assert not Translate(stage).Scene().instancers


_PLACED = """
def PointInstancer "Many" {
    rel prototypes = [</Many/Prototype>]
    int[] protoIndices = [0, 0]
    point3f[] positions = [(0, 0, 0), (2, 0, 0)]
    %s
    def Xform "Prototype" {
        def Mesh "Lamp" (prepend apiSchemas = ["MeshLightAPI"]) {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
            normal3f[] normals.timeSamples = { 0: [(0, 0, 1), (0, 0, 1), (0, 0, 1)], 2: [(1, 0, 0), (1, 0, 0), (1, 0, 0)] }
            uniform token subdivisionScheme = "none"
            uniform bool doubleSided = true
            double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 2: (5, 0, 0) }
            uniform token[] xformOpOrder = ["xformOp:translate"]
            float inputs:intensity = 7
        }
        def BasisCurves "Line" {
            uniform token type = "linear"
            int[] curveVertexCounts = [2]
            point3f[] points.timeSamples = { 0: [(0, 0, 0), (1, 0, 0)], 2: [(0, 1, 0), (1, 2, 0)] }
            float[] widths.timeSamples = { 0: [0.1, 0.1], 2: [0.5, 0.5] }
        }
    }
}
def Camera "Camera" { double shutter:open = -0.5; double shutter:close = 0.5 }
"""


@pytest.mark.parametrize("primvar", [
    'color3f[] primvars:displayColor = [(1, 0, 0), (1, 0, 0)] (interpolation = "vertex")',
    'float[] primvars:hdstream:id = [3, 3] (interpolation = "vertex")'])
def test_constants_of_instances_leave_all_else_of_a_prim(primvar):
    """Light, motion, samples of normals and widths: whatever the scene has without the primvar."""
    without = Translate(StageOf(_PLACED % ""), 1.0).Dump().splitlines()
    text = Translate(StageOf(_PLACED % primvar), 1.0).Dump().splitlines()
    name = primvar.split("primvars:")[1].split()[0]
    ours = [line for line in text if f"primvar {name}: constant" in line]
    assert len(ours) == 2 and [line for line in text if line not in ours] == without
    for part in ("light: ", "transform at ", "normals at ", "points at ", "widths at ", "doubleSided: true"):
        assert any(part in line for line in without), part


@pytest.mark.parametrize("binding", ["rel material:binding = </Prototype/Look>", "rel skel:skeleton = </Prototype/Bones>",
                                     "rel skel:animationSource = </Prototype/Bones/Walk>"])
def test_instances_share_what_their_assets_bind_inside(binding):
    """A target inside an instance is the same for all of them, though its path is another; one outside is not."""
    body = """def Xform "Prototype" (prepend apiSchemas = ["MaterialBindingAPI", "SkelBindingAPI"]) {
        %s
        def Material "Look" { token outputs:surface }
        def Skeleton "Bones" { def SkelAnimation "Walk" {} }
        def Sphere "Ball" {}
    }
    def Material "Other" {}
    """ % binding
    name = binding.split()[1]
    stage = StageOf(body + "".join(f'def Xform "I{i}" (instanceable = true; references = </Prototype>) {{}}\n' for i in range(4))
                    + f'def Xform "J" (instanceable = true; references = </Prototype>) {{ rel {name} = </Other> }}')
    scene = Translate(stage).Scene()
    assert {path: len(instancer.instanceTransforms) for path, instancer in scene.instancers.items()} == {"/I0": 4, "/J": 1}
    assert sorted(scene.geometry) == ["/I0/Ball", "/J/Ball", "/Prototype/Ball"]
    if name == "material:binding":
        assert scene.geometry["/I0/Ball"].materialPath == "/I0/Look"
        assert scene.geometry["/J/Ball"].materialPath == "/Other"
