# SPDX-License-Identifier: Apache-2.0
"""What changes its shape around frame 1 without points that are authored over time: skeletons, blend shapes, gprims with sizes,
and surfaces that are made of points. The scenes of stages/motion.py add them."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt

from . import author, shapes


def _Turn(degrees, axis=(0, 0, 1)):
    return Gf.Quatf(Gf.Rotation(Gf.Vec3d(*axis), float(degrees)).GetQuat())


def _AddBones(stage, path):
    """The animation of a SkelRoot with two joints on top of each other that bend, and a skeleton that turns."""
    UsdSkel.Root.Define(stage, path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    animation = UsdSkel.Animation.Define(stage, f"{path}/Pose")
    joints = ["lower", "lower/upper"]
    for attribute in (skeleton.CreateJointsAttr(), animation.CreateJointsAttr()):
        attribute.Set(joints)
    low, high = Gf.Matrix4d().SetTranslate((0, -1.2, 0)), Gf.Matrix4d().SetTranslate((0, 0, 0))
    skeleton.CreateBindTransformsAttr([low, high])
    skeleton.CreateRestTransformsAttr([low, Gf.Matrix4d().SetTranslate((0, 1.2, 0))])
    animation.CreateTranslationsAttr([Gf.Vec3f(0, -1.2, 0), Gf.Vec3f(0, 1.2, 0)])
    animation.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * 2)
    rotations = animation.CreateRotationsAttr()
    rotations.Set(Vt.QuatfArray([_Turn(-30), _Turn(-90)]), 0.0)
    rotations.Set(Vt.QuatfArray([_Turn(40), _Turn(110, (0.3, 0, 1))]), 2.0)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    turn = UsdGeom.Xformable(skeleton).AddRotateYOp()
    turn.Set(-50.0, 0.0)
    turn.Set(60.0, 2.0)
    return animation


def _Bind(prim, skeleton, points, method=None):
    """Weights that go over from one joint to the other along y."""
    binding = UsdSkel.BindingAPI.Apply(prim.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton])
    upper = np.clip(0.5 + np.asarray(points)[:, 1], 0.0, 1.0)
    binding.CreateJointIndicesPrimvar(False, 2).Set(Vt.IntArray([0, 1] * len(upper)))
    binding.CreateJointWeightsPrimvar(False, 2).Set(Vt.FloatArray.FromNumpy(np.stack([1 - upper, upper], -1).reshape(-1).astype(np.float32)))
    if method:
        binding.GetPrim().CreateAttribute("primvars:skel:skinningMethod", Sdf.ValueTypeNames.Token).Set(method)


def _Tube():
    """An open tube along y, from -1.2 to 1.2."""
    around, along = 12, 12
    y, angle = np.meshgrid(np.linspace(-1.2, 1.2, along + 1), np.linspace(0, 2 * np.pi, around, endpoint=False), indexing="ij")
    points = np.stack([0.3 * np.cos(angle), y, 0.3 * np.sin(angle)], -1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    after = (column + 1) % around
    quads = np.stack([row * around + column, (row + 1) * around + column, (row + 1) * around + after, row * around + after], -1)
    return shapes.Shape(points, np.full(along * around, 4), quads.reshape(-1))


def _AddArm(stage, method):
    _AddBones(stage, "/World/Arm")
    tube = _Tube()
    mesh = author.AddMesh(stage, "/World/Arm/Tube", tube, color=(0.8, 0.5, 0.2), doubleSided=True)
    mesh.CreateSubdivisionSchemeAttr("catmullClark" if method == "dualQuaternion" else "none")
    _Bind(mesh, "/World/Arm/Skeleton", tube.points, method)


def AddLinearArm(stage):
    """Joints turn by far more in the shutter than a straight way from its opening to its closing has."""
    _AddArm(stage, "classicLinear")


def AddDualQuaternionArm(stage):
    _AddArm(stage, "dualQuaternion")


def AddFace(stage):
    """A blend shape with an in-between, whose weight goes up and down within the shutter, on a joint that turns."""
    animation = _AddBones(stage, "/World/Face")
    tube = _Tube()
    mesh = author.AddMesh(stage, "/World/Face/Tube", tube, color=(0.3, 0.6, 0.8), doubleSided=True)
    mesh.CreateSubdivisionSchemeAttr("catmullClark")
    _Bind(mesh, "/World/Face/Skeleton", tube.points)
    shape = UsdSkel.BlendShape.Define(stage, "/World/Face/Tube/Wide")
    away = tube.points * (1.0, 0.0, 1.0)
    shape.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy((2.0 * away).astype(np.float32)))
    between = shape.CreateInbetween("half")
    between.SetWeight(0.5)
    between.SetOffsets(Vt.Vec3fArray.FromNumpy((0.4 * away + (0.5, 0.0, 0.0)).astype(np.float32)))
    binding = UsdSkel.BindingAPI(mesh)
    binding.CreateBlendShapesAttr(["wide"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    animation.CreateBlendShapesAttr(["wide"])
    weights = animation.CreateBlendShapeWeightsAttr()
    for time, weight in ((0.5, 0.0), (0.8, 1.0), (1.5, 0.1)):
        weights.Set(Vt.FloatArray([weight]), time)


def AddGprims(stage):
    """Implicit gprims whose sizes change."""
    for path, kind, values in (("Ball", "Sphere", {"radius": (0.3, 1.1)}), ("Box", "Cube", {"size": (1.2, 0.4)}),
                               ("Rod", "Capsule", {"radius": (0.2, 0.3), "height": (0.2, 1.6)}),
                               ("Spike", "Cone", {"radius": (0.6, 0.2), "height": (0.6, 1.5)})):
        prim = getattr(UsdGeom, kind).Define(stage, f"/World/{path}")
        prim.CreateDisplayColorAttr([(0.8, 0.5, 0.2)])
        for name, (first, last) in values.items():
            attribute = prim.GetPrim().GetAttribute(name)
            attribute.Set(first, 0.0)
            attribute.Set(last, 2.0)
        at = {"Ball": (-1.4, 0.8, 0), "Box": (1.4, 0.8, 0), "Rod": (-1.2, -0.9, 0), "Spike": (1.2, -0.9, 0)}[path]
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*at))


def AddPatchAndTets(stage):
    """A NURBS patch and a tetrahedral mesh whose points move."""
    patch = UsdGeom.NurbsPatch.Define(stage, "/World/Patch")
    for name, value in (("uVertexCount", 4), ("vVertexCount", 4), ("uOrder", 4), ("vOrder", 4)):
        patch.GetPrim().GetAttribute(name).Set(value)
    patch.CreateUKnotsAttr([0, 0, 0, 0, 1, 1, 1, 1])
    patch.CreateVKnotsAttr([0, 0, 0, 0, 1, 1, 1, 1])
    patch.CreateDisplayColorAttr([(0.3, 0.7, 0.3)])
    patch.CreateDoubleSidedAttr(True)
    x, y = np.meshgrid(np.linspace(-1.8, -0.1, 4), np.linspace(-1, 1, 4))
    flat = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    tets = UsdGeom.TetMesh.Define(stage, "/World/Tets")
    tets.CreateTetVertexIndicesAttr([(0, 1, 2, 3), (1, 2, 3, 4)])
    tets.CreateDisplayColorAttr([(0.8, 0.4, 0.3)])
    corners = np.array([(0.6, -0.8, 0.0), (1.8, -0.6, 0.3), (1.2, -0.7, -0.9), (1.1, 0.5, 0.2), (1.9, 0.8, -0.2)])
    for time, part in ((0.0, -1.0), (2.0, 1.0)):
        bent = flat + np.stack([0 * flat[:, 0], 0.8 * part * np.sin(3 * flat[:, 0]), part * flat[:, 0] ** 2], -1)
        patch.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(bent.astype(np.float32)), time)
        moved = corners + part * np.array([(0, 0, 0), (0.2, 0.5, 0), (0, -0.3, 0), (-0.6, 0.3, 0.2), (0.1, -0.5, 0)])
        tets.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(moved.astype(np.float32)), time)


def AddNurbsCurves(stage):
    curves = UsdGeom.NurbsCurves.Define(stage, "/World/Nurbs")
    curves.CreateCurveVertexCountsAttr([5])
    curves.CreateOrderAttr([4])
    curves.CreateKnotsAttr([0, 0, 0, 0, 0.5, 1, 1, 1, 1])
    curves.CreateWidthsAttr([0.25])
    curves.SetWidthsInterpolation("constant")
    curves.CreateDisplayColorAttr([(0.8, 0.5, 0.2)])
    rest = np.array([(-1.8, -0.8, 0), (-0.9, 0.9, 0), (0, -0.9, 0.3), (0.9, 0.9, 0), (1.8, -0.8, 0)])
    for time, part in ((0.0, -1.0), (2.0, 1.0)):
        moved = rest + part * np.array([(0, 0.3, 0), (0.4, -0.7, 0), (0, 0.8, 0.4), (-0.5, -0.6, 0), (0, 0.5, 0)])
        curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(moved.astype(np.float32)), time)


SCENES = {"linearArm": AddLinearArm, "quaternionArm": AddDualQuaternionArm, "face": AddFace, "gprims": AddGprims,
          "patches": AddPatchAndTets, "nurbsCurves": AddNurbsCurves}
