# SPDX-License-Identifier: Apache-2.0
"""Skinned points and normals against closed forms and against UsdSkel's own baking; what follows from time and instances.

The stage is that of the golden case `skinning` with an elbow, at x = 2, that bends by 90 degrees about z instead of
180, while the arm, which lies along x, moves by 2 (t - 2) along z.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from hdstream import _core
from hdstream.translate.stageTranslator import TranslateStage

from translateCase import FOLDER, StageOf, Translate

STAGE = str(FOLDER / "skinning" / "scene.usda")
ELBOW = np.array([2.0, 0.0, 0.0])


def Bending():
    stage = Usd.Stage.Open(STAGE)
    stage.SetEditTarget(stage.GetSessionLayer())
    half = Gf.Quatf(np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    stage.GetPrimAtPath("/Arm/Skeleton/Bend").GetAttribute("rotations").Set([Gf.Quatf(1), half])
    weights = stage.GetPrimAtPath("/Arm/DualQuaternion").GetAttribute("primvars:skel:jointWeights")
    weights.Set([1, 0, 0.5, 0.5, 0, 1])
    return stage


def Points(name, time=2.5, stage=None):
    session = Translate(stage or Bending(), time)
    return np.array(session.Scene().geometry[f"/Arm/{name}"].geometry.points)


def Bent(point):
    """Carried by the lower arm: turned by 90 degrees about the elbow."""
    x, y, z = np.asarray(point, float) - ELBOW
    return ELBOW + (-y, x, z)


@pytest.mark.parametrize("time", [2.0, 2.5, 3.0])
def test_linear_blend_of_a_two_bone_arm(time):
    # The mesh's own transform, 5 along z, is no part of where joints carry it (UsdSkel: geomBindTransform is).
    moved = np.array([0, 0, 2 * (time - 2) - 5])
    rest = np.array([(0, 0, 0), (2, 0, 0), (4, 0, 0), (0, 1, 0), (2, 1, 0), (4, 1, 0)], float)
    weights = [0, 0.5, 1, 0, 0.5, 1]
    expected = [(1 - w) * p + w * Bent(p) + moved for p, w in zip(rest, weights)]
    assert Points("Linear", time) == pytest.approx(np.array(expected), abs=2e-6)


def test_dual_quaternions_keep_the_length():
    # Halfway between the joints both turn by 45 degrees: about the elbow, which neither moves.
    half = np.sqrt(0.5)
    expected = [(0, 0, 1), (2 - half, half, 1), tuple(Bent((4, 1, 0)) + (0, 0, 1))]
    assert Points("DualQuaternion") == pytest.approx(np.array(expected), abs=2e-6)


def test_a_rigid_part_follows_its_joint():
    expected = [Bent(p) + (0, 0, 1) for p in ((2, 0, 0), (4, 0, 0), (4, 1, 0))]
    assert Points("Rigid") == pytest.approx(np.array(expected), abs=2e-6)


@pytest.mark.parametrize("time", [2.0, 2.5, 3.0])
def test_curves_and_points_are_carried(time):
    moved = np.array([0, 0, 2 * (time - 2)])
    middle = 0.5 * (np.array([2, 1, 0]) + Bent((2, 1, 0)))
    assert Points("Hair", time) == pytest.approx(np.array([(0, 0, 0), middle, Bent((4, 1, 0))]) + moved, abs=2e-6)
    assert Points("Beads", time) == pytest.approx(np.array([Bent((3, 0, 0)), Bent((4, 1, 0))]) + moved, abs=2e-6)


def test_curves_and_points_move_while_the_shutter_is_open():
    """The arm moves by 2 along z in a frame; at its samples and at the ends of the shutter."""
    session = _core.Session()
    TranslateStage(Bending(), session, 2.5, (-0.25, 0.25))
    for name in ("Hair", "Beads"):
        geometry = session.Scene().geometry[f"/Arm/{name}"].geometry
        still = np.array(geometry.points, float)
        assert [time for time, _ in geometry.samples] == [-0.25, 0.25]
        for time, points in geometry.samples:
            assert np.asarray(points, float).reshape(-1, 3) == pytest.approx(still + (0, 0, 2 * time), abs=2e-6)


CROWD = """def "Lib" {{
    def {model} "Model" (prepend apiSchemas = ["SkelBindingAPI"]) {{
        def {root} "Root" (prepend apiSchemas = ["SkelBindingAPI"]) {{
            {bones}
            def Mesh "Mesh" (prepend apiSchemas = ["SkelBindingAPI"]) {{
                int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2]
                point3f[] points = [(2, 0, 0), (4, 0, 0), (4, 1, 0)]
                uniform token subdivisionScheme = "none"
                int[] primvars:skel:jointIndices = [1] (interpolation = "constant")
                float[] primvars:skel:jointWeights = [1] (interpolation = "constant")
            }}
        }}
    }}
}}
"""
BONES = """def Skeleton "Bones" (prepend apiSchemas = ["SkelBindingAPI"]) {
    uniform token[] joints = ["upper", "upper/lower"]
    uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(2,0,0,1))]
    uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(2,0,0,1))]
}
"""
POSE = """def SkelAnimation "{name}" {{
    uniform token[] joints = ["upper", "upper/lower"]
    quatf[] rotations = [(1, 0, 0, 0), ({cos}, 0, 0, {sin})]
    half3[] scales = [(1, 1, 1), (1, 1, 1)]
    float3[] translations = [(0, 0, 0), (2, 0, 0)]
}}
"""
REST = np.array([(2, 0, 0), (4, 0, 0), (4, 1, 0)], float)


def Turned(degrees):
    """The triangle of the crowd, which the lower arm carries."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return (REST - ELBOW) @ np.array([(c, s, 0), (-s, c, 0), (0, 0, 1)]) + ELBOW


def Poses():
    angles = {"P90": 90, "P30": 30}
    return "".join(POSE.format(name=name, cos=np.cos(np.radians(a / 2)), sin=np.sin(np.radians(a / 2))) for name, a in angles.items())


@pytest.mark.parametrize("model, root", [("SkelRoot", "Scope"), ("Xform", "SkelRoot")], ids=["instance", "within"])
def test_instances_have_the_animations_that_are_bound_to_them(model, root):
    """A crowd: each instance of a model names its own animation. Those of one animation share their geometry."""
    text = CROWD.format(model=model, root=root, bones="rel skel:skeleton = </Lib/Model/Root/Bones>\n" + BONES) + Poses()
    for i, pose in enumerate(("P90", "P30", "P90")):
        text += (f'def "I{i}" (prepend apiSchemas = ["SkelBindingAPI"]; references = </Lib/Model>; instanceable = true) {{\n'
                 f'rel skel:animationSource = </{pose}>\ndouble3 xformOp:translate = (0, {i}, 0)\n'
                 'uniform token[] xformOpOrder = ["xformOp:translate"] }\n')
    scene = Translate(StageOf(text.replace('def "Lib"', 'class "Lib"'))).Scene()
    assert sorted(scene.geometry) == ["/I0/Root/Mesh", "/I1/Root/Mesh"]
    for path, degrees, places in (("/I0/Root/Mesh", 90, [0, 2]), ("/I1/Root/Mesh", 30, [1])):
        prim = scene.geometry[path]
        assert np.array(prim.geometry.points) == pytest.approx(Turned(degrees), abs=2e-6)
        transforms = np.asarray(scene.instancers[prim.placement.instancerPath].instanceTransforms).reshape(-1, 4, 4)
        assert [matrix[3][1] for matrix in transforms] == places


def test_instances_below_a_skelroot_are_skinned():
    """A skeleton carries what it skins wherever the instance lies; the parts of others stay instances."""
    text = CROWD.format(model="Xform", root="Scope", bones="").replace('def "Lib"', 'class "Lib"') + Poses()
    parts = "".join(f'def "I{i}" (references = </Lib/Model>; instanceable = true) {{ double3 xformOp:translate = (0, {i}, 0)\n'
                    'uniform token[] xformOpOrder = ["xformOp:translate"] }\n' for i in (1, 2))
    parts += "".join(f'def "Prop{i}" (references = </Lib/Prop>; instanceable = true) {{}}\n' for i in (1, 2))
    text = text.replace('class "Lib" {', 'class "Lib" { def Xform "Prop" { def Sphere "Ball" {} }\n', 1)
    bones = BONES.replace("{\n", "{\nrel skel:animationSource = </P90>\n", 1)
    text += f'def SkelRoot "Arm" (prepend apiSchemas = ["SkelBindingAPI"]) {{ rel skel:skeleton = </Arm/Bones>\n{bones}\n{parts} }}\n'
    scene = Translate(StageOf(text)).Scene()
    assert sorted(scene.geometry) == ["/Arm/I1/Root/Mesh", "/Arm/I2/Root/Mesh", "/Arm/Prop1/Ball"]
    for i in (1, 2):
        prim = scene.geometry[f"/Arm/I{i}/Root/Mesh"]
        assert np.array(prim.geometry.points) == pytest.approx(Turned(90) - (0, i, 0), abs=2e-6)
        assert prim.placement.worldFromObject[3][1] == i and not prim.placement.instancerPath
    assert scene.geometry["/Arm/Prop1/Ball"].placement.instancerPath


def test_nurbs_curves_are_carried():
    """Of order 4 with the knots of one span they are the Bezier curve of their points."""
    stage = Bending()
    curves = UsdGeom.NurbsCurves.Define(stage, "/Arm/Nurbs")
    UsdSkel.BindingAPI.Apply(curves.GetPrim())
    rest = [(0, 0, 0), (2, 1, 0), (4, 1, 0), (4, 0, 0)]
    curves.CreatePointsAttr(rest)
    curves.CreateCurveVertexCountsAttr([4])
    curves.CreateOrderAttr([4])
    curves.CreateKnotsAttr([0, 0, 0, 0, 1, 1, 1, 1])
    binding = UsdSkel.BindingAPI(curves)
    binding.CreateJointIndicesPrimvar(True, 1).Set([1])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    assert Points("Nurbs", 2.0, stage) == pytest.approx(np.array([Bent(p) for p in rest]), abs=2e-6)


def _AddPatch(stage):
    prim = UsdGeom.NurbsPatch.Define(stage, "/Arm/Solid")
    for name in ("uVertexCount", "vVertexCount", "uOrder", "vOrder"):
        prim.GetPrim().GetAttribute(name).Set(3)
    prim.CreateUKnotsAttr([0, 0, 0, 1, 1, 1])
    prim.CreateVKnotsAttr([0, 0, 0, 1, 1, 1])
    prim.CreatePointsAttr([(2 + x, y, 0.5 * x * y) for y in range(3) for x in range(3)])
    return prim


def _AddTets(stage):
    prim = UsdGeom.TetMesh.Define(stage, "/Arm/Solid")
    prim.CreatePointsAttr([(2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 0, 1)])
    prim.CreateTetVertexIndicesAttr([(0, 1, 2, 3)])
    return prim


@pytest.mark.parametrize("add", [_AddPatch, _AddTets], ids=["patch", "tetrahedra"])
def test_patches_and_tetrahedra_are_carried(add):
    """By one joint: what they are made of at rest, turned. Also between the ends of a shutter, on the joint's arc."""
    stage = Bending()
    solid = add(stage)
    rest = Points("Solid", 2.0, stage)
    binding = UsdSkel.BindingAPI.Apply(solid.GetPrim())
    binding.CreateJointIndicesPrimvar(True, 1).Set([1])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    assert Points("Solid", 2.0, stage) == pytest.approx(np.array([Bent(p) for p in rest]), abs=3e-6)
    rotations = stage.GetPrimAtPath("/Arm/Skeleton/Bend").GetAttribute("rotations")
    for frame, degrees in ((2.0, 0.0), (3.0, 90.0)):
        c, s = np.cos(np.radians(degrees / 2)), np.sin(np.radians(degrees / 2))
        rotations.Set([Gf.Quatf(1), Gf.Quatf(float(c), 0, 0, float(s))], frame)
    session = _core.Session()
    TranslateStage(stage, session, Usd.TimeCode(2.5), (-0.5, 0.5))
    samples = dict(session.Scene().geometry["/Arm/Solid"].geometry.samples)
    turned = rest - ELBOW
    for part in (0.0, 0.25, 0.5, 1.0):
        angle = np.radians(90 * part)
        turn = np.array([(np.cos(angle), np.sin(angle), 0), (-np.sin(angle), np.cos(angle), 0), (0, 0, 1)])
        expected = turned @ turn + ELBOW + (0, 0, 2 * part)
        assert np.array(samples[part - 0.5]) == pytest.approx(expected, abs=1e-5), part


@pytest.mark.parametrize("schema", ["TetMesh", "NurbsPatch"])
def test_what_becomes_a_mesh_is_carried(schema):
    """Tetrahedra by their points; of a patch of order 2 the corners of its grid are its points. Both move while the shutter is
    open."""
    stage = Bending()
    bend = stage.GetPrimAtPath("/Arm/Skeleton/Bend").GetAttribute("rotations")
    bent = bend.Get()
    for time, value in ((1.5, [Gf.Quatf(1), Gf.Quatf(1)]), (2.0, bent)):
        bend.Set(value, time)
    prim = stage.DefinePrim("/Arm/Solid", schema)
    rest = [(2, 0, 0), (4, 0, 0), (2, 1, 0), (4, 1, 0)]
    if schema == "TetMesh":
        rest[3] = (2, 0, 1)
        UsdGeom.TetMesh(prim).CreateTetVertexIndicesAttr([Gf.Vec4i(0, 1, 2, 3)])
    else:
        for axis in "uv":
            prim.GetAttribute(f"{axis}VertexCount").Set(2)
            prim.GetAttribute(f"{axis}Order").Set(2)
            prim.GetAttribute(f"{axis}Knots").Set([0.0, 0.0, 1.0, 1.0])
    prim.GetAttribute("points").Set(rest)
    binding = UsdSkel.BindingAPI.Apply(prim)
    binding.CreateJointIndicesPrimvar(True, 1).Set([1])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    corners = [0, 1, 2, 3] if schema == "TetMesh" else [0, 8, 72, 80]
    assert Points("Solid", 2.0, stage)[corners] == pytest.approx(np.array([Bent(p) for p in rest]), abs=2e-6)
    session = _core.Session()
    TranslateStage(stage, session, 1.5, (0.0, 0.5))
    geometry = session.Scene().geometry["/Arm/Solid"].geometry
    assert np.asarray(geometry.samples[-1][1])[corners] == pytest.approx(np.array([Bent(p) for p in rest]), abs=2e-6)
    if schema == "NurbsPatch":
        normals = next(primvar for primvar in geometry.primvars if primvar.name == "normals").values
        flat = np.cross(geometry.points[8] - geometry.points[0], geometry.points[72] - geometry.points[0])
        assert normals == pytest.approx(np.tile(flat / np.linalg.norm(flat), (81, 1)), abs=1e-5)


@pytest.mark.parametrize("time", [2.0, 2.25, 3.0])
def test_blend_shape_weights_vary_with_time(time):
    weight = time - 2
    expected = [(0, 0, 2 * weight), (1, 0, 0), (0, 1, 4 * weight)]
    assert Points("Shape", time) == pytest.approx(np.array(expected), abs=1e-6)


def test_points_are_those_of_usdskel_baking():
    baked = Usd.Stage.Open(Bending().Flatten())  # a layer of its own
    assert UsdSkel.BakeSkinning(baked.Traverse())
    for name in ("Linear", "DualQuaternion", "Shape", "Hair"):
        for time in (2.0, 3.0):
            expected = np.asarray(baked.GetPrimAtPath(f"/Arm/{name}").GetAttribute("points").Get(time))
            assert Points(name, time) == pytest.approx(expected, abs=1e-5), (name, time)


def Normals(stage, name, time=2.5):
    """[count][3], unit, and the interpolation."""
    geometry = Translate(stage, time).Scene().geometry[f"/Arm/{name}"].geometry
    (normals,) = [primvar for primvar in geometry.primvars if primvar.name == "normals"]
    rows = np.asarray(normals.values, float)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True), normals.interpolation


_AUTHORED = np.array([(0.3, 0.2, 0.93), (-0.1, 0.4, 0.91), (0, 0, 1), (0.5, -0.5, 0.7), (0.1, 0.1, 1), (-0.6, 0.2, 0.77)])


@pytest.mark.parametrize("interpolation", ["vertex", "faceVarying"])
@pytest.mark.parametrize("isRigid", [True, False], ids=["rigid", "bent"])
def test_normals_are_those_of_usdskel_baking(isRigid, interpolation):
    """Where one joint alone carries a face its turn is exact. Where the weights of a face differ UsdSkel weighs normals by
    joints and knows nothing of the face, which the joints shear: within 25 degrees, at an elbow of 90."""
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Linear")
    if isRigid:
        mesh.GetAttribute("primvars:skel:jointWeights").Set([0.0, 1.0] * 6)
    corners = np.array(mesh.GetAttribute("faceVertexIndices").Get())
    normals = mesh.GetAttribute("normals")
    normals.Set(Vt.Vec3fArray.FromNumpy((_AUTHORED if interpolation == "vertex" else _AUTHORED[corners]).astype(np.float32)))
    normals.SetMetadata("interpolation", interpolation)
    baked = Usd.Stage.Open(stage.Flatten())
    assert UsdSkel.BakeSkinning(baked.Traverse())
    expected = np.asarray(baked.GetPrimAtPath("/Arm/Linear").GetAttribute("normals").Get(3.0), float)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    found, kind = Normals(stage, "Linear", 3.0)
    assert kind == getattr(_core.Interpolation, interpolation[0].upper() + interpolation[1:])
    angles = np.degrees(np.arccos(np.clip(np.sum(found * expected, 1), -1, 1)))
    assert angles.max() < (0.01 if isRigid else 25)
    turned = np.degrees(np.arccos(np.clip(np.sum(found * (_AUTHORED if len(found) == 6 else _AUTHORED[corners]), 1), -1, 1)))
    assert not isRigid or turned.max() > 20  # the test can fail


@pytest.mark.parametrize("scales, isOblique", [((3, 3, 3), True), ((1.6, 0.8, 0.5), False)], ids=["uniform", "hardEdges"])
def test_normals_under_scales_are_mapped_by_the_inverse_transpose(scales, isOblique):
    """Oblique normals keep their angles under a uniform scale; those of a box keep standing on its faces under any."""
    stage = Usd.Stage.CreateInMemory()
    root = UsdSkel.Root.Define(stage, "/Arm")
    skeleton = UsdSkel.Skeleton.Define(stage, "/Arm/Skeleton")
    animation = UsdSkel.Animation.Define(stage, "/Arm/Pose")
    for joints in (skeleton.CreateJointsAttr, animation.CreateJointsAttr):
        joints(["joint"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)])
    turn = Gf.Rotation(Gf.Vec3d(1, 2, 3), 50)
    animation.CreateTranslationsAttr([Gf.Vec3f(1, 2, 3)])
    animation.CreateRotationsAttr([Gf.Quatf(turn.GetQuat())])
    animation.CreateScalesAttr([Gf.Vec3h(*scales)])
    mesh = UsdGeom.Mesh.Define(stage, "/Arm/Box")
    mesh.CreatePointsAttr([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5])
    mesh.CreateSubdivisionSchemeAttr("none")
    faces = np.repeat([(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)], 4, axis=0).astype(np.float32)
    authored = faces + (np.random.default_rng(1).uniform(-0.6, 0.6, faces.shape).astype(np.float32) if isOblique else 0)
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(authored.astype(np.float32)))
    mesh.SetNormalsInterpolation("faceVarying")
    for prim in (root, skeleton, mesh):
        UsdSkel.BindingAPI.Apply(prim.GetPrim())
    UsdSkel.BindingAPI(skeleton).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding = UsdSkel.BindingAPI(mesh)
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(True, 1).Set([0])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
    found, _ = Normals(stage, "Box")
    expected = authored.astype(float) / scales @ np.array(Gf.Matrix3d(turn))  # the inverse transpose, of row vectors
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert found == pytest.approx(expected, abs=2e-3)  # the scales are halves


def test_indexed_normals_of_a_primvar_are_carried():
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Linear")
    mesh.RemoveProperty("normals")
    stage.GetPrimAtPath("/Arm/Linear").GetAttribute("normals").Block()
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, "faceVarying")
    primvar.Set([(0, 0, 1), (0, 0, -1)])
    primvar.SetIndices(Vt.IntArray([0, 0, 0, 0, 1, 1, 1, 1]))
    found, _ = Normals(stage, "Linear")
    assert found[:4] == pytest.approx(np.array([(0, 0, 1)] * 4), abs=1e-6)  # the elbow bends in the plane
    assert found[4:] == pytest.approx(np.array([(0, 0, -1)] * 4), abs=1e-6)


def test_normals_follow_blend_shapes():
    """The triangle of the bulge stands in x and y at rest; its points 0 and 2 rise by 2 and 4 times the weight."""
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Shape")
    UsdGeom.Mesh(mesh).CreateNormalsAttr([(0, 0, 1)] * 3)
    for time in (2.0, 2.25, 3.0):
        weight = time - 2
        expected = np.cross((1, 0, -2 * weight), (0, 1, 2 * weight))
        found, _ = Normals(stage, "Shape", time)
        assert found == pytest.approx(np.array([expected / np.linalg.norm(expected)] * 3), abs=1e-6)


def test_normals_that_cannot_be_carried_are_left_out():
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Linear")
    Names = lambda: [p.name for p in Translate(stage, 2.5).Scene().geometry["/Arm/Linear"].geometry.primvars]  # noqa: E731
    assert Names() == ["normals"]
    mesh.GetAttribute("normals").Set([(0, 0, 1)] * 5)  # one is missing
    assert Names() == []
    mesh.GetAttribute("normals").Set([(0, 0, 1)] * 6)
    mesh.GetAttribute("faceVertexIndices").Set([0, 1, 4, 3, 1, 2, 5, 6])
    assert Names() == []
    mesh.GetAttribute("faceVertexIndices").Set([0, 1, 4, 3, 1, 2, 5, 4])
    mesh.GetAttribute("subdivisionScheme").Set("catmullClark")  # has the limit surface's
    assert Names() == []


def test_normals_move_while_the_shutter_is_open():
    """As the arm of the golden case moves along z alone, what turns here is the blend shape's triangle."""
    stage = Bending()
    UsdGeom.Mesh(stage.GetPrimAtPath("/Arm/Shape")).CreateNormalsAttr([(0, 0, 1)] * 3)
    session = _core.Session()
    TranslateStage(stage, session, 2.5, (-0.25, 0.25))
    geometry = session.Scene().geometry["/Arm/Shape"].geometry
    assert [time for time, _ in geometry.normalSamples] == [time for time, _ in geometry.samples]
    for time, normals in geometry.normalSamples:
        found = np.asarray(normals, float).reshape(-1, 3)
        expected = np.cross((1, 0, -2 * (0.5 + time)), (0, 1, 2 * (0.5 + time)))
        assert found == pytest.approx(np.array([expected / np.linalg.norm(expected)] * 3), abs=1e-6)
    assert len(geometry.normalSamples) >= 2


def test_influences_that_do_not_fit_leave_all_points():
    """UsdSkel has moved the first points when it meets the bad joint."""
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Linear")
    indices = mesh.GetAttribute("primvars:skel:jointIndices")
    indices.Set([*list(indices.Get())[:-1], 999])
    session = Translate(stage, 2.5)
    assert np.array_equal(session.Scene().geometry["/Arm/Linear"].geometry.points, mesh.GetAttribute("points").Get())
    assert any("/Arm/Linear: its joint influences do not fit" in line for line in session.Warnings())


@pytest.mark.filterwarnings("error")
def test_singular_skeletons_are_quiet():
    """What is not finite is the core's to name, in a line of ours."""
    stage = Bending()
    stage.GetPrimAtPath("/Arm/Skeleton").GetAttribute("bindTransforms").Set([Gf.Matrix4d(0.0)] * 2)
    Translate(stage, 2.5)


def _Warned(edit):
    """The warnings of the arm after an edit, and whether its rigid part was moved."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(Sdf.Layer.FindOrOpen(STAGE).ExportToString())
    stage = Usd.Stage.Open(layer)
    rest = np.array(stage.GetPrimAtPath("/Arm/Rigid").GetAttribute("points").Get())
    edit(stage)
    session = Translate(stage, 2.5)
    (moved,) = [prim.geometry.points for path, prim in session.Scene().geometry.items() if path.endswith("/Rigid")]
    return session.Warnings(), not np.array_equal(moved, rest)


def _SetJoint(stage):
    stage.GetPrimAtPath("/Arm/Rigid").GetAttribute("primvars:skel:jointIndices").Set([7])


def _SetOwnOrder(stage):
    """Joints of the prim that the skeleton has fewer of."""
    lower = stage.GetPrimAtPath("/Arm/Skeleton").GetAttribute("joints").Get()[1]
    prim = stage.GetPrimAtPath("/Arm/Rigid")
    prim.CreateAttribute("skel:joints", Sdf.ValueTypeNames.TokenArray).Set(["a", "b", lower])
    prim.GetAttribute("primvars:skel:jointIndices").Set([2])


@pytest.mark.parametrize("edit, told", [
    (lambda stage: None, None),
    (_SetOwnOrder, None),
    (lambda stage: stage.GetPrimAtPath("/Arm/Rigid").RemoveAppliedSchema("SkelBindingAPI"), "has no SkelBindingAPI; drawn at rest: 1 prim"),
    (lambda stage: stage.GetPrimAtPath("/Arm").SetTypeName("Xform"), "is below no SkelRoot; drawn at rest: "),
    (lambda stage: stage.RemovePrim("/Arm/Skeleton"), "has no skeleton that they fit; drawn at rest: "),
    (_SetJoint, "/Arm/Rigid: its joint influences do not fit; drawn unskinned"),
])
def test_what_cannot_be_skinned_is_told(edit, told):
    """OpenUSD leaves such prims at rest without a word, or with one that does not name them."""
    warnings, isMoved = _Warned(edit)
    assert isMoved == (told is None)
    assert len([line for line in warnings if told and told in line]) == (told is not None), warnings


def test_a_prim_of_no_influences_is_not_told():
    """Exporters write such arrays for all meshes."""
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Plain")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    prim = mesh.GetPrim()
    prim.CreateAttribute("skel:blendShapes", Sdf.ValueTypeNames.TokenArray).Set([])
    indices = prim.CreateAttribute("primvars:skel:jointIndices", Sdf.ValueTypeNames.IntArray)
    indices.Set([])
    assert not [line for line in Translate(stage).Warnings() if "at rest" in line]
    indices.Set([0])
    assert [line for line in Translate(stage).Warnings() if "at rest" in line]
