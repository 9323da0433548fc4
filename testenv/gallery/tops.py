# SPDX-License-Identifier: Apache-2.0
"""Spinning tops, marbles that roll past them and falling confetti while a shutter is open."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from stages import author, shapes

from . import landscape

_FRAMES = (0.0, 1.0, 2.0)  # the picture is of frame 1
_TABLE = (0.28, 0.17, 0.1)


def _Shape(segments: int):
    """A top of radius 1 that stands on y = 0."""
    radii = np.array([0.0, 0.04, 0.12, 0.5, 0.86, 0.98, 1.0, 0.97, 0.8, 0.42, 0.2, 0.13, 0.11, 0.11, 0.15, 0.14, 0.08, 0.0])
    heights = np.array([0.0, 0.02, 0.12, 0.42, 0.66, 0.77, 0.84, 0.9, 0.98, 1.08, 1.16, 1.28, 1.5, 1.72, 1.8, 1.88, 1.92, 1.93])
    slope = np.arctan2(np.gradient(heights), np.gradient(radii))
    return shapes.Lathe(radii, heights, segments, np.sin(slope), -np.cos(slope))


def _AddTop(stage, path: str, place, tilt, size, turn, colours, looks, segments) -> None:
    """`turn`: degrees a frame. Sectors and rings of `colours`."""
    xform = UsdGeom.Xform.Define(stage, path)
    author.Place(xform, translate=place, rotate=tilt, scale=size)
    spin = xform.AddRotateYOp(opSuffix="spin")
    for frame in _FRAMES:
        spin.Set(float(turn * frame), frame)
    shape = _Shape(segments)
    mesh = author.AddMesh(stage, f"{path}/Body", shape, material=looks)
    corners = np.split(shape.indices, np.cumsum(shape.counts)[:-1])
    centres = np.array([shape.points[corner].mean(0) for corner in corners])
    sector = np.floor((np.arctan2(centres[:, 2], centres[:, 0]) / (2 * np.pi) + 0.5) * 6).astype(int) % 2
    radius = np.hypot(centres[:, 0], centres[:, 2])
    kind = np.where(radius < 0.3, 2, np.where((radius > 0.9) | (np.abs(radius - 0.55) < 0.04), 3, sector))
    author.AddPrimvar(mesh, "displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform",
                      Vt.Vec3fArray.FromNumpy(np.array(colours, np.float32)[kind]))


def _AddMarble(stage, path: str, start, way, radius, looks, rings) -> None:
    """Goes `way` in a frame."""
    ball = author.AddMesh(stage, path, shapes.Sphere(radius, rings, 2 * rings), material=looks)
    place = UsdGeom.Xformable(ball).AddTranslateOp()
    for frame in _FRAMES:
        place.Set(Gf.Vec3d(*(np.array(start) + np.array(way) * (frame - 1))), frame)


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(12)
    stage = landscape.NewStage(folder)
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(1)
    segments = max(24, int(384 * size))
    paint = author.AddMaterial(stage, "/World/Looks/Paint", {"diffuseColor": ("displayColor", "float3", (0.5, 0.5, 0.5))}, roughness=0.3,
                               clearcoat=1.0, clearcoatRoughness=0.04)
    wood = author.AddMaterial(stage, "/World/Looks/Table", diffuseColor=_TABLE, roughness=0.28)
    glass = author.AddMaterial(stage, "/World/Looks/Marble", diffuseColor=(0.02, 0.1, 0.22), roughness=0.05, clearcoat=1.0,
                               clearcoatRoughness=0.02)
    author.AddMesh(stage, "/World/Table", shapes.Plane(400, 400), material=wood)
    red, blue, cream, gold, green, violet = ((0.7, 0.04, 0.02), (0.02, 0.12, 0.5), (0.85, 0.75, 0.55), (0.8, 0.5, 0.08),
                                             (0.03, 0.35, 0.12), (0.3, 0.05, 0.4))
    _AddTop(stage, "/World/Tall", (0, 0, 0), (4, 0, -9), 1.3, 170, (red, cream, gold, blue), paint, segments)
    _AddTop(stage, "/World/Left", (-2.7, 0, 0.9), (-7, 0, 6), 0.8, 75, (blue, cream, red, gold), paint, segments)
    _AddTop(stage, "/World/Right", (2.5, 0, 0.7), (9, 0, 12), 0.9, 28, (green, cream, violet, gold), paint, segments)
    _AddTop(stage, "/World/Still", (1.3, 0.62, 2.5), (0, 30, 106), 0.62, 0, (violet, cream, green, gold), paint, segments)
    for i, (start, way) in enumerate((((-1.2, 0.22, 2.5), (1.1, 0, 0.12)), ((-3.3, 0.22, 2.6), (0.5, 0, -0.05)),
                                      ((3.4, 0.22, -1.2), (-1.4, 0, 0.2)))):
        _AddMarble(stage, f"/World/Marble{i}", start, way, 0.22, glass, max(8, int(48 * size)))
    count = max(20, int(420 * size))
    places = rng.uniform((-6, 0.5, -5), (6, 6.5, 2.5), (count, 3))
    tints = np.array([red, blue, gold, green, violet, cream])[rng.integers(0, 6, count)]
    confetti = UsdGeom.Points.Define(stage, "/World/Confetti")
    confetti.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(places.astype(np.float32)), 1.0)
    velocities = rng.normal((0, -9, 0), (1.5, 2.5, 1.5), (count, 3))
    confetti.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(velocities.astype(np.float32)), 1.0)
    confetti.CreateWidthsAttr(Vt.FloatArray.FromNumpy(rng.uniform(0.05, 0.09, count).astype(np.float32)))
    author.AddPrimvar(confetti, "displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex", Vt.Vec3fArray.FromNumpy(tints.astype(np.float32)))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-5, 7, 4), rotate=(-50, -50, 0)), width=4.0, height=3.0, intensity=22.0,
                    color=(1.0, 0.93, 0.82))
    author.AddLight(stage, "/World/Rim", "Rect", dict(translate=(6, 5, -5), rotate=(-35, 130, 0)), width=2.0, height=4.0, intensity=16.0,
                    color=(0.65, 0.8, 1.0))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.3, color=(0.55, 0.65, 0.9))
    camera = author.AddCamera(stage, "/World/Camera", eye=(0.3, 3.7, 9.6), target=(0.05, 1.1, 0), focalLength=42.0, aspect=16 / 9)
    camera.CreateShutterOpenAttr(-0.25)
    camera.CreateShutterCloseAttr(0.25)
    stage.GetRootLayer().Save()
