# SPDX-License-Identifier: Apache-2.0
"""Stages of smooth surfaces and of rays that meet nothing: cut gems of clear glass in a heap (`gems`), a room with mirrors
(`mirrorRoom`), painted balls below softboxes (`softboxes`), and hills below a wide sky (`wideSky`). Camera: /World/Camera.
"""

import pathlib

import numpy as np

from . import author, imageFile, shapes
from .materialX import AddSurface

MAX_DEPTH = {"gems": 10, "mirrorRoom": 8, "softboxes": 6, "wideSky": 4}


def _AddSky(stage, path: str, intensity: float) -> None:
    """A sky of 256 x 128 with a bright patch of cloud."""
    height, width = 128, 256
    y, x = np.mgrid[0:height, 0:width]
    elevation = np.pi / 2 - np.pi * (y + 0.5) / height
    longitude = np.pi - 2 * np.pi * (x + 0.5) / width
    sky = (0.4 + np.exp(-3 * np.abs(elevation)))[..., None] * np.array([0.5, 0.7, 1.1])
    cloud = 8.0 * np.exp(-(((longitude - 0.8) / 0.4) ** 2) - ((elevation - 0.7) / 0.2) ** 2)
    image = np.where(elevation[..., None] > 0, sky + cloud[..., None], np.array([0.2, 0.18, 0.15]))
    file = pathlib.Path(path).with_suffix(".exr")
    imageFile.WriteExr(file, dict(zip("RGB", np.moveaxis(image.astype(np.float32), -1, 0))))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=intensity, textureFile=str(file))


def Gem(facets: int = 8) -> shapes.Shape:
    """A brilliant: table, crown, girdle and pavilion; flat faces, wound to the outside."""
    angles = 2 * np.pi * np.arange(facets) / facets
    ring = lambda radius, height, turn: np.stack([radius * np.cos(angles + turn), np.full(facets, height),
                                                  radius * np.sin(angles + turn)], 1)
    half = np.pi / facets
    points = np.concatenate([ring(0.55, 0.35, half), ring(1.0, 0.05, 0), ring(1.0, -0.02, 0), [[0.0, -0.85, 0.0]]])
    a, b = np.arange(facets), (np.arange(facets) + 1) % facets
    table = a[::-1]
    crown = np.concatenate([np.stack([facets + a, a, facets + b], 1), np.stack([a, b, facets + b], 1)])
    girdle = np.concatenate([np.stack([2 * facets + a, facets + a, facets + b], 1),
                             np.stack([2 * facets + a, facets + b, 2 * facets + b], 1)])
    pavilion = np.stack([np.full(facets, 3 * facets), 2 * facets + a, 2 * facets + b], 1)
    triangles = np.concatenate([crown, girdle, pavilion])
    counts = np.concatenate([[facets], np.full(len(triangles), 3)])
    return shapes.Shape(points, counts, np.concatenate([table, triangles.ravel()]))


def WriteGems(path: str) -> None:
    stage = author.NewStage(path)
    looks = [AddSurface(stage, f"/World/Looks/Gem{i}", base=0.0, transmission=1.0, specular_roughness=0.0, specular_IOR=ior)
             for i, ior in enumerate((1.5, 1.77, 2.4))]
    author.AddMesh(stage, "/World/Table", shapes.Plane(20, 20), color=(0.45, 0.4, 0.36))
    random = np.random.default_rng(3)
    for number in range(40):
        layer = 0 if number < 24 else 1 if number < 36 else 2
        x, z = random.uniform(-1, 1, 2) * (2.6 - 0.9 * layer)
        author.AddMesh(stage, f"/World/Gem{number}", Gem(), material=looks[number % 3], translate=(x, 0.5 + 0.75 * layer, z),
                       rotate=random.uniform(0, 360, 3), scale=random.uniform(0.3, 0.5))
    _AddSky(stage, path, 0.6)
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(3, 5, 2), rotate=(-65, 0, -30)), width=1.5, height=1.0, intensity=25.0)
    author.AddCamera(stage, eye=(0.5, 2.6, 7.0), target=(0, 0.7, 0), aspect=4 / 3, width=30.0)
    stage.GetRootLayer().Save()


def WriteMirrorRoom(path: str) -> None:
    stage = author.NewStage(path)
    mirror = AddSurface(stage, "/World/Looks/Mirror", base=1.0, base_color=(0.9, 0.9, 0.9), metalness=1.0, specular_roughness=0.0)
    gold = AddSurface(stage, "/World/Looks/Gold", base=1.0, base_color=(0.95, 0.75, 0.4), metalness=1.0, specular_roughness=0.05)
    walls = {"Floor": ((6, 6), (0, 0, 0), (0, 0, 0)), "Ceiling": ((6, 6), (0, 3, 0), (180, 0, 0)), "Back": ((6, 3), (0, 1.5, -3), (90, 0, 0)),
             "Front": ((6, 3), (0, 1.5, 3), (-90, 0, 0)), "Left": ((3, 6), (-3, 1.5, 0), (0, 0, -90)),
             "Right": ((3, 6), (3, 1.5, 0), (0, 0, 90))}
    for name, (size, place, turn) in walls.items():
        author.AddMesh(stage, f"/World/{name}", shapes.Plane(*size), color=(0.7, 0.65, 0.6), translate=place, rotate=turn)
    for number, (place, turn) in enumerate((((-2.99, 1.5, -0.5), (0, 0, -90)), ((2.99, 1.5, 0.5), (0, 0, 90)), ((0, 1.5, -2.99), (90, 0, 0)))):
        size = (4, 2.4) if number == 2 else (2.4, 4)
        author.AddMesh(stage, f"/World/Mirror{number}", shapes.Plane(*size), material=mirror, translate=place, rotate=turn)
    for number in range(5):
        author.AddMesh(stage, f"/World/Ball{number}", shapes.Sphere(0.35), material=(mirror, gold)[number % 2],
                       translate=(-1.6 + 0.8 * number, 0.35, -1.2 + 0.6 * (number % 2)))
    author.AddMesh(stage, "/World/Box", shapes.Box(0.6, 1.0, 0.6), color=(0.2, 0.35, 0.6), translate=(0.3, 0.5, 0.8), rotate=(0, 30, 0))
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(0, 2.98, 0), rotate=(-90, 0, 0)), width=1.6, height=1.0, intensity=9.0)
    author.AddCamera(stage, eye=(-1.4, 1.7, 2.7), target=(0.2, 0.9, -0.8), aspect=4 / 3, width=36.0, focalLength=22.0)
    stage.GetRootLayer().Save()


def WriteSoftboxes(path: str) -> None:
    stage = author.NewStage(path)
    paints = [AddSurface(stage, f"/World/Looks/Paint{i}", base=0.8, base_color=color, metalness=0.5, specular_roughness=0.35, coat=1.0,
                         coat_roughness=0.0) for i, color in enumerate(((0.6, 0.05, 0.04), (0.05, 0.15, 0.5), (0.7, 0.7, 0.72)))]
    chrome = AddSurface(stage, "/World/Looks/Chrome", base=1.0, base_color=(0.9, 0.9, 0.9), metalness=1.0, specular_roughness=0.02)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(30, 30), color=(0.3, 0.3, 0.3))
    for number in range(9):
        author.AddMesh(stage, f"/World/Ball{number}", shapes.Sphere(0.6), material=[*paints, chrome][number % 4],
                       translate=(-2 + 2 * (number % 3), 0.6, -2 + 2 * (number // 3)))
    for number, x in enumerate((-3.0, 0.0, 3.0)):
        author.AddLight(stage, f"/World/Softbox{number}", "Rect", dict(translate=(x, 4.0, 0), rotate=(-90, 0, 0)), width=1.2, height=5.0,
                        intensity=5.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.15)
    author.AddCamera(stage, eye=(0.5, 3.0, 8.0), target=(0, 0.4, 0), aspect=4 / 3, width=32.0)
    stage.GetRootLayer().Save()


def WriteWideSky(path: str) -> None:
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Hills", shapes.HeightField(200.0, 128, lambda x, z: 2.0 * np.sin(0.11 * x) * np.cos(0.13 * z)),
                   color=(0.3, 0.4, 0.2))
    for number in range(12):
        author.AddMesh(stage, f"/World/Stone{number}", shapes.Sphere(1.2, 24, 48), color=(0.5, 0.45, 0.4),
                       translate=(-14 + 2.6 * number, 1.5, -8 - (number % 3)))
    _AddSky(stage, path, 1.0)
    author.AddCamera(stage, eye=(0, 5, 12), target=(0, 12, -10), aspect=2.0, width=60.0, focalLength=18.0)
    stage.GetRootLayer().Save()


WRITERS = {"gems": WriteGems, "mirrorRoom": WriteMirrorRoom, "softboxes": WriteSoftboxes, "wideSky": WriteWideSky}
