# SPDX-License-Identifier: Apache-2.0
"""Lights that move or change around frame 1. The scenes of stages/motion.py add them."""

import pathlib

import numpy as np
from pxr import Gf, Sdf, UsdGeom

from . import author, imageFile, shapes
from .ways import AddBox, AddWay


def _AddLamp(stage):
    """A lamp that is seen, and its shadows, on a way."""
    AddBox(stage, "/World/Box")
    lamp = author.AddLight(stage, "/World/Lamp", "Sphere", intensity=12.0, radius=0.4)
    AddWay(lamp, (-3.5, 0.6, 1.5), (3.5, 1.6, 1.0))


def _AddSpot(stage):
    """A flat light with a beam, that turns about itself while it moves."""
    AddBox(stage, "/World/Box")
    spot = author.AddLight(stage, "/World/Spot", "Rect", intensity=60.0, width=0.8, height=0.5)
    author.ShapeLight(spot, coneAngle=35.0, coneSoftness=0.3, focus=2.0)
    AddWay(spot, (-0.5, 0.3, 3.0), (0.8, 0.0, 3.2))
    turn = UsdGeom.Xformable(spot).AddRotateYOp()
    turn.Set(-70.0, 0.0)
    turn.Set(70.0, 2.0)


def _AddSun(stage):
    """A narrow sun that goes over the sky."""
    AddBox(stage, "/World/Box")
    sun = author.AddLight(stage, "/World/Moon", "Distant", intensity=2.0, angle=1.0, normalize=True)
    turn = UsdGeom.Xformable(sun).AddRotateYOp()
    turn.Set(-65.0, 0.0)
    turn.Set(65.0, 2.0)


def _AddSky(stage):
    """A dome whose image turns, which is seen in a mirror."""
    mirror = author.AddMaterial(stage, "/World/Mirror", metallic=1.0, roughness=0.05, diffuseColor=(0.9, 0.9, 0.9))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 24, 32), material=mirror)
    folder = pathlib.Path(stage.GetRootLayer().realPath).parent
    texels = np.zeros((32, 64, 3), np.float32)
    texels[:, ::16] = texels[:, 1::16] = (3.0, 1.0, 0.5)
    imageFile.WriteExr(folder / "sky.exr", {channel: texels[..., i] for i, channel in enumerate("RGB")})
    sky = author.AddLight(stage, "/World/Sky", "Dome", intensity=1.0, textureFile=str(folder / "sky.exr"))
    turn = UsdGeom.Xformable(sky).AddRotateYOp()
    turn.Set(0.0, 0.0)
    turn.Set(120.0, 2.0)


def _AddLamps(stage):
    """So many that there is a light tree: in a ring that turns."""
    AddBox(stage, "/World/Box")
    AddWay(UsdGeom.Xform.Define(stage, "/World/Ring"), (0, 0, 0.8), (0, 0, 0.8), degrees=25.0)
    for i in range(40):
        angle = 2.0 * np.pi * i / 40
        where = (2.4 * np.cos(angle), 1.8 * np.sin(angle), 0.2 * (i % 3))
        kind = ("Sphere", "Disk")[i % 2]
        author.AddLight(stage, f"/World/Ring/Lamp{i}", kind, dict(translate=where), intensity=1.0 + 14.0 * (i % 7 == 0), radius=0.15)


def _AddLampSwarm(stage):
    """Lamps of an instancer whose instances move, and which turns itself."""
    AddBox(stage, "/World/Box")
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Lamps")
    AddWay(swarm, (0, 0, 1.2), (0, 0.4, 1.2), degrees=70.0)
    author.AddLight(stage, "/World/Lamps/Lamp", "Rect", intensity=14.0, width=0.7, height=0.3)
    swarm.CreatePrototypesRel().SetTargets(["/World/Lamps/Lamp"])
    swarm.CreateProtoIndicesAttr([0, 0])
    positions = swarm.CreatePositionsAttr()
    positions.Set([(-2.5, 0, 0), (2, 1, 0)], 0.0)
    positions.Set([(2.5, 0.5, 0), (0, -1.5, 0.6)], 2.0)


def _SetLight(light, **ends):
    """Inputs of a light at the frames 0 and 2."""
    for name, (first, last) in ends.items():
        attribute = light.GetPrim().GetAttribute(f"inputs:{name}") or light.GetPrim().CreateAttribute(
            f"inputs:{name}", Sdf.ValueTypeNames.Float)
        for time, value in ((0.0, first), (2.0, last)):
            attribute.Set(Gf.Vec3f(*value) if isinstance(value, tuple) else float(value), time)


def _AddGrowingLights(stage):
    """Lights whose sizes change by their inputs: a ball that is seen and goes along, a panel, a disk, a tube, a moon; some have
    the same power all the time."""
    AddBox(stage, "/World/Box")
    ball = author.AddLight(stage, "/World/Ball", "Sphere", intensity=6.0, radius=0.4)
    AddWay(ball, (-2.0, 0.6, 1.5), (2.0, 1.2, 1.0))
    _SetLight(ball, radius=(0.02, 0.9))
    panel = author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2.2, 0.2, 0.4)), intensity=12.0, normalize=True)
    _SetLight(panel, width=(0.1, 2.0), height=(1.4, 0.2))
    disk = author.AddLight(stage, "/World/Disk", "Disk", dict(translate=(2.2, -0.6, 0.4)), intensity=5.0)
    _SetLight(disk, radius=(0.9, 0.1))
    tube = author.AddLight(stage, "/World/Tube", "Cylinder", dict(translate=(0, -1.4, 0.2)), intensity=3.0)
    _SetLight(tube, length=(0.3, 3.0), radius=(0.3, 0.05))
    moon = author.AddLight(stage, "/World/Moon", "Distant", dict(rotate=(40, -20, 0)), intensity=2.0)
    _SetLight(moon, angle=(2.0, 40.0))


def _AddFlicker(stage):
    """Lights that get brighter and darker, and change their colour; one of them is dark for a while. The dome dims."""
    AddBox(stage, "/World/Box")
    ball = author.AddLight(stage, "/World/Ball", "Sphere", dict(translate=(-1.8, 0.6, 1.0)), intensity=6.0, radius=0.4)
    _SetLight(ball, intensity=(-6.0, 12.0), color=((1.0, 0.2, 0.1), (0.1, 0.3, 1.0)))
    panel = author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(1.8, 0.2, 1.2)), intensity=4.0)
    _SetLight(panel, exposure=(-2.0, 2.0))
    sky = author.AddLight(stage, "/World/Sky", "Dome", intensity=1.0)
    _SetLight(sky, intensity=(0.0, 1.0))


def _AddStretchedLights(stage):
    """Lights that transforms stretch while they turn and go along, from nearly nothing, below so many others that there is a light
    tree."""
    AddBox(stage, "/World/Box")
    for name, kind, where, size in (("Ball", "Sphere", (-1.8, 0.5, 1.0), dict(radius=0.4)),
                                    ("Beam", "Rect", (1.6, 0.2, 1.6), dict(width=0.8, height=0.6))):
        light = author.AddLight(stage, f"/World/{name}", kind, intensity=14.0, **size)
        AddWay(light, where, (where[0] + 0.6, where[1] - 0.4, where[2]), degrees=80.0)
        if name == "Beam":
            author.ShapeLight(light, coneAngle=50.0, coneSoftness=0.3, focus=1.0)
        grow = UsdGeom.Xformable(light).AddScaleOp()
        grow.Set(Gf.Vec3f(0.02, 0.05, 0.02), 0.0)
        grow.Set(Gf.Vec3f(1.8, 0.7, 1.2), 2.0)
    for i in range(36):
        angle = 2.0 * np.pi * i / 36
        author.AddLight(stage, f"/World/Lamp{i}", "Sphere", dict(translate=(2.4 * np.cos(angle), 1.8 * np.sin(angle), 0.4)),
                        intensity=1.0, radius=0.1)


def _AddFlatLights(stage):
    """Lights that have no extent along z by their scale, which is nothing for them, and turn fast, one about a slanted axis."""
    AddBox(stage, "/World/Box")
    for name, kind, where, tilt, size in (("Disk", "Disk", (-1.8, 0.5, 1.2), 0.0, dict(radius=0.7)),
                                          ("Panel", "Rect", (1.6, 0.2, 1.6), 40.0, dict(width=1.2, height=0.3))):
        light = author.AddLight(stage, f"/World/{name}", kind, intensity=8.0, **size)
        AddWay(light, where, (where[0] + 0.4, where[1] - 0.3, where[2]), degrees=500.0)
        UsdGeom.Xformable(light).AddRotateXOp().Set(tilt)
        UsdGeom.Xformable(light).AddScaleOp().Set(Gf.Vec3f(1.0, 1.2, 0.0))


SCENES = {
    "lamp": _AddLamp, "spot": _AddSpot, "sun": _AddSun, "sky": _AddSky, "lamps": _AddLamps, "lampSwarm": _AddLampSwarm,
    "growingLights": _AddGrowingLights, "flicker": _AddFlicker, "stretchedLights": _AddStretchedLights, "flatLights": _AddFlatLights,
}
