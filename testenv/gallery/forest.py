# SPDX-License-Identifier: Apache-2.0
"""An autumn forest around a lake: leaves on twigs, twigs on trees, trees on hills, each an instance of few meshes."""

import numpy as np
from pxr import UsdGeom

from stages import author, materialX, shapes

from . import landscape, sky

_PERIOD = 420.0
_HILLS = landscape.Noise(4, 256, 2.4)
_GROVES = landscape.Noise(9, 256, 1.6)
_LEAVES = 110  # of a twig
_SPECIES = {"Maple": (0.42, 0.06, 0.015), "Beech": (0.5, 0.2, 0.02), "Birch": (0.55, 0.37, 0.03), "Oak": (0.2, 0.2, 0.025)}
_EYE = (0.0, 9.0, 6.0)


def _Height(x, z):
    """A basin for the lake before the camera, shores, hills that rise away from it."""
    away = np.hypot((x + 4) / 34, (z + 30) / 27)
    hills = 4 + 5 * landscape.Sample(_HILLS, x, z, _PERIOD)
    rise = 62 * landscape.Smooth(62, 250, -z) + 9 * landscape.Smooth(35, 130, abs(x))
    small = 0.35 * landscape.Sample(_HILLS, 9 * x, 9 * z, _PERIOD)
    return -3.0 + landscape.Smooth(0.72, 1.9, away) * (hills + rise) + 3.6 * landscape.Smooth(0.8, 1.12, away) + small


def _Twig(rng) -> shapes.Shape:
    """A stem along +y with curled leaves of four triangles."""
    parts = [shapes.Lathe([0.012, 0.004, 0.0], [0.0, 0.5, 0.62], 5, [1, 1, 1], [0, 0, 0])]
    leaf = np.array([[0, 0, 0], [-0.055, 0.09, 0.02], [0, 0.1, -0.012], [0.055, 0.09, 0.02], [0, 0.21, 0.03]])
    faces = np.array([0, 2, 1, 0, 3, 2, 1, 2, 4, 2, 3, 4])
    for i in range(_LEAVES):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        centre = np.array([0, rng.uniform(0.0, 0.65), 0]) + rng.normal(0, 0.2, 3)
        parts.append(shapes.Shape(leaf @ frame + centre, np.full(4, 3), faces))
    return shapes.Merged([shapes.Shape(p.points, p.counts, p.indices) for p in parts])


def _AddTree(stage, rng, path: str, bark, leaf, numTwigs: int, isPine: bool) -> None:
    """A tree of height 6 or so: a trunk with branches as one mesh, twigs as instances."""
    UsdGeom.Xform.Define(stage, path)
    height = 7.5 if isPine else 5.8
    direction = rng.normal(size=(numTwigs, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    if isPine:
        level = 1 - np.sqrt(rng.random(numTwigs))
        reach = (1 - level) * (0.75 + 0.25 * np.sin(level * 60)) * 1.5 * np.sqrt(rng.uniform(0.2, 1, numTwigs))
        flat = direction[:, [0, 2]] / np.linalg.norm(direction[:, [0, 2]], axis=1, keepdims=True)
        places = np.stack([flat[:, 0] * reach, 0.7 + level * (height - 0.8) - 0.18 * reach, flat[:, 1] * reach], 1)
        towards = np.stack([flat[:, 0], np.full(numTwigs, 0.15), flat[:, 1]], 1)
    else:
        lobes = np.concatenate([rng.normal(0, 0.75, (7, 2)), rng.uniform(2.6, 4.6, (7, 1))], 1)[:, [0, 2, 1]]
        which = rng.integers(0, len(lobes), numTwigs)
        places = lobes[which] + direction * [1.15, 0.95, 1.15] * rng.uniform(0.55, 1.0, (numTwigs, 1)) ** 0.5
        towards = direction + [0, 0.35, 0]
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    heights, radii = np.linspace(-0.4, height * 0.85, 8), np.linspace(0.16, 0.015, 8)
    parts = [shapes.Lathe(radii, heights, 8, np.ones(8), np.full(8, 0.02))]
    for end in places[rng.integers(0, numTwigs, 0 if isPine else 26)]:
        start = np.array([0, 0.35 * end[1] + 0.5, 0])
        across = np.cross(end - start, [0.3, 0.1, 1.0])
        across *= 0.035 / np.linalg.norm(across)
        other = np.cross(across, end - start)
        other *= 0.035 / np.linalg.norm(other)
        points = np.array([start + across, start - across / 2 + other, start - across / 2 - other, end])
        parts.append(shapes.Shape(points, np.full(3, 3), np.array([0, 1, 3, 1, 2, 3, 2, 0, 3])))
    trunk = shapes.Merged([shapes.Shape(p.points, p.counts, p.indices) for p in parts])
    author.AddMesh(stage, f"{path}/Trunk", trunk, material=bark, doubleSided=True)
    author.AddMesh(stage, f"{path}/Twigs/Twig", _Twig(rng), material=leaf, doubleSided=True)
    landscape.AddInstances(stage, f"{path}/Twigs", [f"{path}/Twigs/Twig"], np.zeros(numTwigs), places,
                           rng.uniform(1.0, 1.7, numTwigs) * (0.8 if isPine else 1), landscape.Towards(towards, rng.uniform(0, 6, numTwigs)))


def _Places(rng, wanted: int):
    """Positions of trees on land that the camera may see, denser in groves; and which kind grows there."""
    count = 6 * wanted
    z = -_PERIOD * 0.9 * rng.random(count) ** 0.62 + 3
    x = rng.uniform(-1, 1, count) * (18 - 0.62 * z)
    y = _Height(x, z)
    grove = landscape.Sample(_GROVES, 3 * x, 3 * z, _PERIOD)
    near = np.hypot(x - _EYE[0], z - _EYE[2])
    keep = (y > 0.7) & (near > 7) & (rng.random(count) < landscape.Smooth(-1.6, 0.4, grove)) & ~((abs(x) < 9) & (z > -14))
    x, y, z = x[keep][:wanted], y[keep][:wanted], z[keep][:wanted]
    stand = landscape.Sample(_GROVES, 2 * x + 90, 2 * z, _PERIOD) + 0.5 * rng.normal(size=len(x))
    isPine = landscape.Sample(_HILLS, 3 * x, 3 * z + 50, _PERIOD) + 0.4 * rng.normal(size=len(x)) + 0.012 * y > 1.0
    kind = np.clip(np.floor(2 + 1.5 * stand), 0, len(_SPECIES) - 1).astype(int)
    return np.stack([x, y - 0.1, z], 1), np.where(isPine, len(_SPECIES), kind)


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(12)
    stage = landscape.NewStage(folder)
    grass = author.AddMaterial(stage, "/World/Looks/Grass", diffuseColor=(0.13, 0.12, 0.035), roughness=0.9)
    water = author.AddMaterial(stage, "/World/Looks/Water", diffuseColor=(0.006, 0.012, 0.012), ior=1.33, roughness=0.02)
    bark = author.AddMaterial(stage, "/World/Looks/Bark", diffuseColor=(0.1, 0.075, 0.055), roughness=0.9)
    cells = max(20, int(700 * size))
    ground = shapes.HeightField(2 * _PERIOD, cells, lambda x, z: _Height(x, z - _PERIOD + 30))
    author.AddMesh(stage, "/World/Ground", ground, material=grass, translate=(0, 0, -_PERIOD + 30))
    ripple = lambda x, z: 0.006 * np.sin(2.2 * z + 0.9 * np.sin(0.5 * x) + 0.3 * x) + 0.004 * np.sin(3.1 * z - 1.1 * x)
    author.AddMesh(stage, "/World/Lake", shapes.HeightField(90, max(20, int(500 * size)), ripple), material=water,
                   translate=(-4, 0, -30))
    targets = []
    for name, colour in {**_SPECIES, "Pine": (0.035, 0.06, 0.02)}.items():
        leaf = materialX.AddSurface(stage, f"/World/Looks/{name}", base=0.55, base_color=colour, specular=0.3,
                                    specular_roughness=0.6, subsurface=0.5, subsurface_color=colour, thin_walled=True)
        targets.append(f"/World/Forest/Trees/{name}")
        _AddTree(stage, rng, targets[-1], bark, leaf, max(20, int(170 * size)), name == "Pine")
    places, kinds = _Places(rng, max(60, int(60_000 * size)))
    landscape.AddInstances(stage, "/World/Forest", targets, kinds, places, rng.uniform(0.75, 1.35, len(kinds)),
                           landscape.TurnedUp(rng, len(kinds), 0.1))
    sky.AddSky(stage, folder, max(64, int(512 * size)), elevation=24, azimuth=-128, strength=24.0, ground=(0.1, 0.08, 0.03))
    author.AddCamera(stage, "/World/Camera", eye=_EYE, target=(-3, 8.5, -60), focalLength=34.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
