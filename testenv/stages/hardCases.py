# SPDX-License-Identifier: Apache-2.0
"""Stages where methods fail: extreme scales, grazing light, thin and coincident surfaces, odd values. Each is written next
to one that shows the same and is easy, or has a closed form. Judged by testenv/render/stabilityCases.py."""

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from . import author, shapes

_NUMBERS = {"nan": float("nan"), "inf": float("inf"), "-inf": float("-inf")}


def _Save(stage, path) -> str:
    stage.GetRootLayer().Save()
    return str(path)


def Scaled(shape, factor) -> shapes.Shape:
    return shapes.Shape(shape.points * factor, shape.counts, shape.indices, shape.normals, shape.texcoords)


def Room(path, scale=1.0, cameraScale=1.0, clip=None) -> str:
    """A ground, a ball, a slab, a rect light and a dome, `scale` times as large. The camera's aperture and focal length
    (tenths of a unit) are `cameraScale` times as large: the same field."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", Scaled(shapes.Plane(8, 8), scale), color=(0.6, 0.55, 0.5))
    author.AddMesh(stage, "/World/Ball", Scaled(shapes.Sphere(0.7, 48, 96), scale), color=(0.2, 0.45, 0.75),
                   translate=np.array([0.6, 0.7, 0.5]) * scale)
    author.AddMesh(stage, "/World/Slab", Scaled(shapes.Box(0.3, 2.0, 1.6), scale), color=(0.75, 0.7, 0.3),
                   translate=np.array([-1.0, 1.0, -0.6]) * scale, rotate=(0, 25, 0))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=np.array([0, 4, 2]) * scale, rotate=(-70, 0, 0)),
                    width=2.0 * scale, height=1.0 * scale, intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    camera = author.AddCamera(stage, eye=np.array([0, 2.0, 6.0]) * scale, target=np.array([0, 0.7, 0]) * scale,
                              width=36.0 * cameraScale, focalLength=35.0 * cameraScale)
    camera.GetClippingRangeAttr().Set(tuple(clip) if clip else (0.01 * scale, 1000.0 * scale))
    return _Save(stage, path)


def InstancedRoom(path, factor=1.0) -> str:
    """Balls by a point instancer: the mesh is `factor` times as large, the instances as much smaller."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.6, 0.55, 0.5))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    author.AddMesh(stage, "/World/Many/Ball", Scaled(shapes.Sphere(0.4, 24, 48), factor), color=(0.2, 0.5, 0.7))
    places = [(x, 0.4, z) for x in (-1.5, 0.0, 1.5) for z in (-1.0, 0.5)]
    instancer.CreatePositionsAttr([Gf.Vec3f(*place) for place in places])
    instancer.CreateScalesAttr([Gf.Vec3f(1.0 / factor)] * len(places))
    instancer.CreateProtoIndicesAttr(Vt.IntArray([0] * len(places)))
    instancer.CreatePrototypesRel().AddTarget("/World/Many/Ball")
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0, 4, 2), rotate=(-70, 0, 0)), width=2.0, height=1.0, intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 2.0, 6.0), target=(0, 0.4, 0))
    return _Save(stage, path)


def SmallBesideHuge(path, groundSize, size=1.0) -> str:
    """A ball of `size` on a ground of one quad of `groundSize`, seen from near it, from above."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(groundSize, groundSize), color=(0.6, 0.55, 0.5))
    author.AddMesh(stage, "/World/Ball", Scaled(shapes.Sphere(0.5, 48, 96), size), color=(0.2, 0.45, 0.75), translate=(0, 0.5 * size, 0))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=np.array([1, 3, 2]) * size, rotate=(-60, 20, 0)), width=1.0 * size,
                    height=1.0 * size, intensity=8.0)
    camera = author.AddCamera(stage, eye=np.array([0, 3.0, 2.0]) * size, target=np.array([0, 0.2, 0]) * size)
    camera.GetClippingRangeAttr().Set((0.01 * size, 1000.0 * size))
    return _Save(stage, path)


def Plate(path, light, cells=1, turn=(0, 0, 0), copies=1) -> str:
    """A white plate from straight above, orthographic, 4 units wide. `light`: arguments of AddLight. `cells`: it is as many
    quads along a side. `turn` turns plate, light and camera together. `copies` of the plate lie at the same place."""
    stage = author.NewStage(path)
    author.Place(UsdGeom.Xform.Define(stage, "/World/Turned").GetPrim(), rotate=turn)
    for copy in range(copies):
        author.AddMesh(stage, f"/World/Turned/Plate{copy}", shapes.Plane(40, 40, cells, cells), color=(0.5,) * 3)
    kind, placement, inputs = light
    author.AddLight(stage, "/World/Turned/Light", kind, placement, **inputs)
    author.AddCamera(stage, path="/World/Turned/Camera", eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=40.0, orthographic=True)
    return _Save(stage, path)


def ClosedBox(path, thickness, turn=(17, 31, 5)) -> str:
    """Inside of a box with walls of a thickness; a bright dome and a lamp are outside. Nothing is to be seen."""
    stage = author.NewStage(path)
    outer, inner = shapes.Box(4 + 2 * thickness, 4 + 2 * thickness, 4 + 2 * thickness), shapes.Box(4, 4, 4)
    author.AddMesh(stage, "/World/Outer", outer, color=(0.9,) * 3, rotate=turn)
    author.AddMesh(stage, "/World/Inner", inner, color=(0.9,) * 3, rotate=turn)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1e4)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(0, 6, 0)), radius=0.5, intensity=1e6)
    author.AddCamera(stage, eye=(0.3, -0.2, 0.1), target=(1, 0.2, 0.4), focalLength=10.0)
    return _Save(stage, path)


def ClosedShell(path, shape, scale=1.0) -> str:
    """Inside of one closed mesh of thin or degenerate triangles, a bright dome outside."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Shell", Scaled(shape, scale), color=(0.9,) * 3, rotate=(3, 40, 11))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1e4)
    camera = author.AddCamera(stage, eye=np.array([0.1, -0.05, 0.03]) * scale, target=np.array([1.0, 0.1, 0.2]) * scale, focalLength=8.0)
    camera.GetClippingRangeAttr().Set((0.001 * scale, 1000.0 * scale))
    return _Save(stage, path)


def NeedleDrum(strips: int) -> shapes.Shape:
    """A closed drum of radius and half height 2: strips and fans of triangles a thousand times as long as wide."""
    angles = np.linspace(0, 2 * np.pi, strips, endpoint=False)
    ring = np.stack([2 * np.cos(angles), 0 * angles, 2 * np.sin(angles)], 1)
    points = np.concatenate([ring - [0, 2, 0], ring + [0, 2, 0], [[0, -2, 0], [0, 2, 0]]])
    this, following = np.arange(strips), (np.arange(strips) + 1) % strips
    low, high = np.full(strips, 2 * strips), np.full(strips, 2 * strips + 1)
    indices = np.concatenate([np.stack([this, this + strips, following + strips], 1), np.stack([this, following + strips, following], 1),
                              np.stack([low, this, following], 1), np.stack([high, following + strips, this + strips], 1)])
    return shapes.Shape(points, np.full(len(indices), 3), indices.ravel())


def Corridor(path, roughness, length=1.0) -> str:
    """Two mirrors that face each other in a white dome, open to the sky: each pixel is 1 whatever the number of bounces. No ray of the
    camera is at right angles to the mirrors."""
    stage = author.NewStage(path)
    mirror = author.AddMaterial(stage, "/World/Mirror", diffuseColor=(1.0, 1.0, 1.0), metallic=1.0, roughness=float(roughness))
    for side in (-1, 1):
        author.AddMesh(stage, f"/World/Wall{side + 1}", shapes.Plane(8, 4), material=mirror, doubleSided=True,
                       translate=(0, 0, side * length), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(1.0, 0.4, -1), focalLength=24.0)
    return _Save(stage, path)


def OddMaterial(path, **inputs) -> str:
    """A ball and a plate of one material under a lamp and a dome; inputs as texts may be "nan", "inf"."""
    stage = author.NewStage(path)
    values = {name: _NUMBERS.get(value, value) for name, value in inputs.items()}
    look = author.AddMaterial(stage, "/World/Look", **values)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 24, 48), material=look)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(6, 6), material=look, translate=(0, -1, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(2, 3, 2)), radius=0.3, intensity=20.0)
    author.AddCamera(stage, eye=(0, 1, 5))
    return _Save(stage, path)


def Blocks(path, edit=None) -> str:
    """The Lambert room of Room(); `edit` adds to the stage."""
    Room(path)
    stage = Usd.Stage.Open(str(path))
    if edit:
        edit(stage)
    return _Save(stage, path)
