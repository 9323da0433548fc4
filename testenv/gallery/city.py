# SPDX-License-Identifier: Apache-2.0
"""A city by the water at night: every lit window is two emissive triangles, every lamp a light."""

import numpy as np
from pxr import UsdGeom, Vt, Gf

from stages import author, shapes

from . import landscape

_BLOCK, _STREET = 8.0, 3.0
_WARMTH = {"Warm": (1.0, 0.55, 0.2), "White": (1.0, 0.8, 0.55), "Cold": (0.7, 0.85, 1.0)}


def _Quads(corners: np.ndarray) -> shapes.Shape:
    """Corners [n][4][3] as one mesh."""
    return shapes.Shape(corners.reshape(-1, 3), np.full(len(corners), 4), np.arange(4 * len(corners)))


def _Buildings(rng, columns: int, rows: int):
    """(x, z, width, depth, height) of houses, several a block; a quarter of towers in the middle."""
    houses = []
    for i in range(columns):
        for j in range(rows):
            x0, z0 = (i - columns / 2) * (_BLOCK + _STREET), -j * (_BLOCK + _STREET) - 6
            middle = np.exp(-((x0 / 34) ** 2) - ((z0 + 42) / 34) ** 2)
            if rng.random() < 0.06:
                continue  # a square
            splits = 1 if rng.random() < 0.25 + 0.4 * middle else 2
            side = _BLOCK / splits
            for a in range(splits):
                for b in range(splits):
                    height = rng.uniform(2.0, 5.0) + middle * rng.gamma(2.2, 7.0)
                    size = side * rng.uniform(0.72, 0.95, 2)
                    houses.append((x0 + (a + 0.5) * side, z0 - (b + 0.5) * side, size[0], size[1], min(height, 34.0)))
    return np.array(houses)


def _Windows(rng, houses):
    """Corners [n][4][3] of the lit windows, and which warmth each has."""
    corners, kinds = [], []
    for x, z, width, depth, height in houses:
        share, kind = rng.uniform(0.12, 0.5), rng.choice(3, p=(0.45, 0.35, 0.2))
        floors = int(height / 0.55)
        for across, normal, reach, half in (((1, 0, 0), (0, 0, 1), depth / 2, width / 2), ((0, 0, 1), (1, 0, 0), width / 2, depth / 2),
                                            ((0, 0, 1), (-1, 0, 0), width / 2, depth / 2)):
            across, normal = np.array(across, float), np.array(normal, float)
            count = max(1, int(2 * half / 0.42))
            floor, column = (grid.ravel() for grid in np.meshgrid(np.arange(1, floors), np.arange(count), indexing="ij"))
            lit = rng.random(len(floor)) < share * np.where(rng.random(floors)[floor] < 0.12, 2.2, 1.0)
            at = np.array([x, 0, z]) + normal * (reach + 0.01) + across * ((column[lit] + 0.5) / count * 2 - 1)[:, None] * half \
                + np.array([0, 1, 0]) * (floor[lit] * 0.55 + 0.1)[:, None]
            u, v = across * 0.1, np.array([0, 0.17, 0])
            sign = np.sign(np.cross(u, v) @ normal)
            corners.append(np.stack([at - sign * u - v, at + sign * u - v, at + sign * u + v, at - sign * u + v], 1))
            kinds.append(np.where(rng.random(lit.sum()) < 0.15, rng.integers(0, 3, lit.sum()), kind))
    return np.concatenate(corners), np.concatenate(kinds)


def _AddLamps(stage, rng, columns: int, rows: int) -> None:
    """Lamps along the streets and the quay, as instances of two lights."""
    step = _BLOCK + _STREET
    places = []
    for i in range(columns + 1):
        for z in np.arange(-2.0, -rows * step - 4, -2.75):
            places.append(((i - columns / 2) * step - _STREET / 2, 1.1, z))
    for j in range(rows + 1):
        for x in np.arange(-columns * step / 2, columns * step / 2, 2.75):
            places.append((x, 1.1, -j * step - 6 + _STREET / 2))
    places = np.array(places) + rng.normal(0, 0.1, (len(places), 3)) * [1, 0, 1]
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Lamps")
    author.AddLight(stage, "/World/Lamps/Sodium", "Sphere", radius=0.09, intensity=190.0, color=(1.0, 0.5, 0.14))
    author.AddLight(stage, "/World/Lamps/Led", "Sphere", radius=0.07, intensity=260.0, color=(0.95, 0.9, 0.8))
    instancer.CreatePrototypesRel().SetTargets(["/World/Lamps/Sodium", "/World/Lamps/Led"])
    instancer.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, place)) for place in places]))
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy((places[:, 2] > -5).astype(np.int32)))


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(77)
    stage = landscape.NewStage(folder)
    columns, rows = max(3, int(22 * size)), max(2, int(13 * size))
    side = 500.0
    asphalt = author.AddMaterial(stage, "/World/Looks/Asphalt", diffuseColor=(0.06, 0.06, 0.065), roughness=0.35)
    author.AddMesh(stage, "/World/Land", shapes.Plane(side, 200), material=asphalt, translate=(0, 0, -99))
    quay = author.AddMaterial(stage, "/World/Looks/Quay", diffuseColor=(0.14, 0.13, 0.12), roughness=0.8)
    author.AddMesh(stage, "/World/Quay", shapes.Box(side, 1.6, 0.5), material=quay, translate=(0, -0.75, 1.1))
    water = author.AddMaterial(stage, "/World/Looks/Water", diffuseColor=(0.004, 0.008, 0.012), ior=1.33, roughness=0.06)
    waves = landscape.Noise(8, 512, 1.7, lowest=24)
    height = lambda x, z: 0.02 * landscape.Sample(waves, x, 0.45 * z, 60.0)
    author.AddMesh(stage, "/World/Water", shapes.HeightField(120, max(20, int(900 * size)), height), material=water,
                   translate=(0, -1.1, 60))
    houses = _Buildings(rng, columns, rows)
    colours = [(0.16, 0.14, 0.12), (0.1, 0.11, 0.13), (0.2, 0.17, 0.14)]
    for kind, colour in enumerate(colours):
        wall = author.AddMaterial(stage, f"/World/Looks/Wall{kind}", diffuseColor=colour, roughness=0.5)
        boxes = [shapes.Box(w, h, d).Moved((x, h / 2, z)) for x, z, w, d, h in houses[kind::len(colours)]]
        author.AddMesh(stage, f"/World/Houses{kind}", shapes.Merged(boxes), material=wall)
    corners, kinds = _Windows(rng, houses)
    for kind, (name, colour) in enumerate(_WARMTH.items()):
        glow = author.AddMaterial(stage, f"/World/Looks/{name}", diffuseColor=(0.0, 0.0, 0.0),
                                  emissiveColor=tuple(1.9 * np.array(colour)), roughness=0.3)
        author.AddMesh(stage, f"/World/Windows/{name}", _Quads(corners[kinds == kind]), material=glow)
    _AddLamps(stage, rng, columns, rows)
    author.AddLight(stage, "/World/Dusk", "Dome", intensity=0.02, color=(0.32, 0.5, 1.0))
    author.AddCamera(stage, "/World/Camera", eye=(-27, 13.0, 35), target=(1, 5.0, -22), focalLength=32.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
