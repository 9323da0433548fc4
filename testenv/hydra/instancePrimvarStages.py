# SPDX-License-Identifier: Apache-2.0
"""Stages whose instances differ in primvars: WRITERS, name -> function(path)."""

from pxr import Gf, Sdf, UsdGeom, Vt

from stages import author, shapes

_COLORS = [Gf.Vec3f(0.75, 0.1, 0.1), Gf.Vec3f(0.1, 0.6, 0.15), Gf.Vec3f(0.1, 0.2, 0.8)]
_PLACES = [(-2, 0.5, 0), (-1.2, 0.5, 0.5), (-0.4, 0.5, 0), (0.4, 0.5, 0.5), (1.2, 0.5, 0), (2, 0.5, 0.5)]


def _NewStage(path):
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, 25, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.4)
    author.AddCamera(stage, "/World/Camera", eye=(0, 3, 7), target=(0, 0.5, 0))
    return stage


def WritePointPrimvars(path) -> None:
    """A point instancer of three colours, through indices, and one that has colours of its own."""
    stage = _NewStage(path)
    scatter = UsdGeom.PointInstancer.Define(stage, "/World/Scatter")
    author.AddMesh(stage, "/World/Scatter/Box", shapes.Box(0.5, 0.5, 0.5))
    author.AddMesh(stage, "/World/Scatter/Ball", shapes.Sphere(0.3, 16, 32), color=(0.7, 0.7, 0.2))
    scatter.CreatePrototypesRel().SetTargets(["/World/Scatter/Box", "/World/Scatter/Ball"])
    scatter.CreateProtoIndicesAttr([0, 0, 0, 0, 1, 1])
    scatter.CreatePositionsAttr(Vt.Vec3fArray(_PLACES))
    author.AddPrimvar(scatter, "displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex", Vt.Vec3fArray(_COLORS),
                      indices=[0, 1, 2, 0, 1, 2])
    stage.GetRootLayer().Save()


def WriteNativePrimvars(path) -> None:
    """Native instances that inherit colours, from themselves and from above; those of a ball that has its own."""
    stage = _NewStage(path)
    stage.CreateClassPrim("/Copy")
    author.AddMesh(stage, "/Copy/Box", shapes.Box(0.5, 0.5, 0.5))
    author.AddMesh(stage, "/Copy/Top", shapes.Sphere(0.2, 16, 32), translate=(0, 0.5, 0))
    stage.CreateClassPrim("/Own")
    author.AddMesh(stage, "/Own/Ball", shapes.Sphere(0.2, 16, 32), color=(0.7, 0.7, 0.2), translate=(0, -0.3, 0.9))
    for index, place in enumerate(_PLACES):
        group = UsdGeom.Xform.Define(stage, f"/World/Group{index}")
        copies = [UsdGeom.Xform.Define(stage, f"/World/Group{index}/{name}") for name in ("Copy", "Own")]
        for copy, name in zip(copies, ("/Copy", "/Own")):
            copy.GetPrim().GetReferences().AddInternalReference(name)
            copy.GetPrim().SetInstanceable(True)
            author.Place(copy, translate=place)
        if index < 5:  # the last ones inherit nothing
            for prim in [group] if index % 2 else copies:
                author.AddPrimvar(prim, "displayColor", Sdf.ValueTypeNames.Color3fArray, "constant",
                                  Vt.Vec3fArray([_COLORS[index % 3]]))
    stage.GetRootLayer().Save()


WRITERS = {"pointPrimvars": WritePointPrimvars, "nativePrimvars": WriteNativePrimvars}
