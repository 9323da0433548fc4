# SPDX-License-Identifier: Apache-2.0
"""The stage of the usdview test: one prim for every kind of edit and pick.

All sizes are in metres. TARGETS says which prim a pick at the middle of a shape must give.
"""

from pxr import Gf, Usd, UsdGeom, Vt

from stages import author, shapes

# Shape -> (a world point on or in it that "/World/Camera" sees unhidden, path that a pick there gives,
# index of the instance, None: not instanced).
TARGETS = {
    "mesh": ((-1.5, 0.5, 0.0), "/World/Box", None),
    "implicit": ((0.0, 0.5, 0.5), "/World/Ball", None),
    "purpose": ((1.5, 0.4, 0.0), "/World/Prop/Render", None),
    "pointInstance": ((1.0, 1.8, -1.0), "/World/Scatter/Prototype", 2),
    "nativeInstance": ((-1.0, 0.3, 1.5), "/World/CopyB/Geometry", 1),
    "ground": ((2.6, 0.0, 1.6), "/World/Ground", None),
}


def WriteViewStage(path) -> None:
    stage = author.NewStage(path)
    red = author.AddMaterial(stage, "/World/Looks/Red", diffuseColor=(0.7, 0.1, 0.08), roughness=0.4)
    green = author.AddMaterial(stage, "/World/Looks/Green", diffuseColor=(0.1, 0.5, 0.12), roughness=0.7)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.5, 0.5, 0.5))
    author.AddMesh(stage, "/World/Box", shapes.Box(1, 1, 1), material=red, translate=(-1.5, 0.5, 0))
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.CreateRadiusAttr(0.5)
    ball.CreateDisplayColorAttr([Gf.Vec3f(0.2, 0.3, 0.8)])
    author.Place(ball, translate=(0, 0.5, 0.5))
    _AddPurposes(stage)
    _AddInstances(stage, green)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, 25, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.4)
    author.AddCamera(stage, "/World/Camera", eye=(0, 3, 7), target=(0, 0.7, 0))
    author.AddCamera(stage, "/World/Side", eye=(7, 2, 1), target=(0, 0.7, 0))
    stage.GetRootLayer().Save()


def _AddPurposes(stage: Usd.Stage) -> None:
    """A prop with one stand-in a purpose, of different shapes at the same place."""
    for name, shape, color in (("Render", shapes.Sphere(0.4, 32, 64), (0.8, 0.7, 0.1)),
                               ("Proxy", shapes.Box(0.8, 0.8, 0.8), (0.8, 0.2, 0.7)),
                               ("Guide", shapes.Box(0.2, 2.4, 0.2), (0.1, 0.9, 0.9))):
        mesh = author.AddMesh(stage, f"/World/Prop/{name}", shape, color=color, translate=(1.5, 0.4, 0))
        mesh.CreatePurposeAttr(name.lower())


def _AddInstances(stage: Usd.Stage, material) -> None:
    """Point instancers, and two native instances of a class prim."""
    scatter = UsdGeom.PointInstancer.Define(stage, "/World/Scatter")
    author.AddMesh(stage, "/World/Scatter/Prototype", shapes.Box(0.5, 0.5, 0.5), material=material)
    scatter.CreatePrototypesRel().SetTargets(["/World/Scatter/Prototype"])
    scatter.CreateProtoIndicesAttr([0, 0, 0])
    scatter.CreatePositionsAttr(Vt.Vec3fArray([(-1, 1.8, -1), (0, 1.8, -1), (1, 1.8, -1)]))
    # A prototype outside of its instancer, drawn in its own place too.
    author.AddMesh(stage, "/World/Marble", shapes.Sphere(0.25, 16, 32), color=(0.6, 0.2, 0.7), translate=(2.4, 0.25, 1.6))
    row = UsdGeom.PointInstancer.Define(stage, "/World/Row")
    row.CreatePrototypesRel().SetTargets(["/World/Marble"])
    row.CreateProtoIndicesAttr([0, 0])
    row.CreatePositionsAttr(Vt.Vec3fArray([(-3, 0.25, 1), (-3, 0.25, 2)]))
    stage.CreateClassPrim("/Copy")
    author.AddMesh(stage, "/Copy/Geometry", shapes.Sphere(0.3, 32, 64), color=(0.9, 0.5, 0.2))
    for name, x in (("CopyA", -2.2), ("CopyB", -1.0)):
        copy = UsdGeom.Xform.Define(stage, f"/World/{name}")
        copy.GetPrim().GetReferences().AddInternalReference("/Copy")
        copy.GetPrim().SetInstanceable(True)
        author.Place(copy, translate=(x, 0.3, 1.5))
