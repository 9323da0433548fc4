# SPDX-License-Identifier: Apache-2.0
"""The report's stress scene (its figure 5) rebuilt: cards that each show a texture of their own.

26 cards stand in each ring of a tunnel, seen along its axis: near rings are seen large, far ones small and all under
grazing angles, so that every mip has its use. 962 cards (37 rings) of 2048 x 2048 texels are the report's numbers. A
mirror ball in the tunnel shows them again, small and bent. Textures lie in a folder beside the stage.
"""

import concurrent.futures
import os
import pathlib

import numpy as np

from . import author, imageFile, photograph, shapes
from .textured import AddTexturedMaterial

RING = 26
COUNT = 962
SIZE = 2048
_RADIUS = 4.0
_SPACING = 0.9


def _WriteRange(folder: str, size: int, begin: int, end: int, level: int) -> None:
    photographs = photograph.Photographs(size)
    for index in range(begin, end):
        target = pathlib.Path(folder) / f"photo{index:04d}.png"
        if not target.exists():
            partial = target.with_suffix(".part")
            imageFile.WritePng(partial, photographs.Make(index), level)
            partial.rename(target)


def WriteTextures(folder, count: int, size: int, level: int = 0) -> None:
    """`count` pictures on all cores; those that are there stay. Without compression 12 MiB each at 2048 texels."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    numJobs = min(os.cpu_count() or 1, count)
    if count * size * size < 1 << 22:  # processes would take longer
        return _WriteRange(str(folder), size, 0, count, level)
    borders = [count * job // numJobs for job in range(numJobs + 1)]
    with concurrent.futures.ProcessPoolExecutor(numJobs) as pool:
        for job in [pool.submit(_WriteRange, str(folder), size, begin, end, level)
                    for begin, end in zip(borders, borders[1:])]:
            job.result()


def _Card(index: int) -> shapes.Shape:
    """A card of the tunnel's wall, facing its axis, slightly turned."""
    ring, place = divmod(index, RING)
    rng = np.random.default_rng([7, index])
    half = 0.46 * 2 * np.pi * _RADIUS / RING
    angle = 2 * np.pi * (place + 0.5 * (ring % 2)) / RING
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    across = np.array([-np.sin(angle), np.cos(angle), 0.0])
    along = np.array([0.0, 0.0, -1.0])
    tilt = rng.uniform(-0.25, 0.25, 2)
    centre = outward * _RADIUS + along * _SPACING * (ring + 0.5)
    corners = [centre + s * half * across + t * 0.45 * _SPACING * along + (tilt[0] * s + tilt[1] * t) * 0.3 * outward
               for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return shapes.Shape(np.array(corners), np.array([4]), np.array([0, 1, 2, 3]),
                        texcoords=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))


def WriteTextureStress(path, count: int = COUNT, size: int = SIZE, level: int = 0, glows: bool = False) -> None:
    """The stage, and its textures in the folder `textures<size>` beside it. `glows`: cards emit what their textures say
    and reflect nothing, so that pictures have no noise but that of where samples fall in a pixel."""
    path = pathlib.Path(path)
    folder = path.parent / f"textures{size}"
    WriteTextures(folder, count, size, level)
    stage = author.NewStage(str(path))
    for index in range(count):
        material = AddTexturedMaterial(stage, f"/World/Materials/Photo{index}", {
            "emissiveColor" if glows else "diffuseColor": (f"./{folder.name}/photo{index:04d}.png", "rgb")},
            wrap="clamp", roughness=0.7, **(dict(diffuseColor=(0.0, 0.0, 0.0), metallic=1.0) if glows else {}))
        author.AddMesh(stage, f"/World/Cards/Card{index}", _Card(index), material=material, doubleSided=True)
    depth = _SPACING * -(-count // RING)
    mirror = author.AddMaterial(stage, "/World/Materials/Mirror", metallic=1.0, roughness=0.05,
                                diffuseColor=(0.9, 0.9, 0.9))
    author.AddMesh(stage, "/World/Mirror", shapes.Sphere(0.8, 32, 64), material=mirror,
                   translate=(1.2, -1.6, -0.35 * depth))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 2.0), target=(0, 0, -10), focalLength=20.0, aspect=16 / 9)
    author.AddCamera(stage, path="/World/Wall", eye=(-2.0, 0, -0.5 * depth), target=(4.0, 0.0, -0.5 * depth),
                     focalLength=30.0, aspect=16 / 9)  # sees few of them
    stage.GetRootLayer().Save()
