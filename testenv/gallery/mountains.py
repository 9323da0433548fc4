# SPDX-License-Identifier: Apache-2.0
"""Mountains after snowfall: one cage of 64 x 64 faces, subdivided and displaced by an image of heights, coloured by another."""

import numpy as np
from pxr import UsdGeom, UsdShade

from stages import author, imageFile, shapes, textured

from . import landscape, sky

_SIDE = 80.0  # of the square
_PEAK = 10.0
_FACES = 64


def _Heights(size: int) -> np.ndarray:
    """[size][size] from 0 to 1: ridges whose detail grows where it is high already, and valleys that stay smooth."""
    x, z = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    warps = [0.03 * landscape.Sample(landscape.Noise(seed, 256, 2.6), x, z, 1.0) for seed in (31, 32)]
    total, weight = np.zeros((size, size)), np.ones((size, size))
    for octave in range(9):
        field = landscape.Noise(50 + octave, 64, 3.2, lowest=1.5)
        frequency, shift = 2**octave, 0.37 * octave
        value = landscape.Sample(field, (x + warps[0]) * frequency + shift, (z + warps[1]) * frequency, 1.0)
        ridge = (1 - np.sqrt(np.minimum(abs(value) / 1.8, 1) ** 2 + 0.002)) * weight
        total += ridge * 0.5**octave
        weight = np.clip(ridge, 0, 1)
    total = (total - total.min()) / (total.max() - total.min())
    massif = landscape.Smooth(0.0, 0.45, z) * 0.75 + 0.25
    return total**1.6 * massif[::-1]


def _Colours(heights: np.ndarray) -> np.ndarray:
    """Snow where it is high and not steep, rock where it is steep, dry grass below. Codes of 8 bits."""
    size = len(heights)
    step = _SIDE / size
    rows, columns = np.gradient(heights * _PEAK, step)
    up = 1 / np.sqrt(1 + rows**2 + columns**2)
    grain = landscape.Noise(71, size, 0.8)
    snow = landscape.Smooth(0.26, 0.4, heights + 0.02 * grain) * landscape.Smooth(0.5, 0.68, up + 0.03 * grain)
    rock = landscape.Smooth(0.78, 0.62, up + 0.02 * grain)
    mix = lambda a, b, share: a + (np.asarray(b) - a) * share[..., None]
    colour = np.broadcast_to(np.array([0.14, 0.12, 0.05]), (size, size, 3))
    colour = mix(colour, (0.035, 0.05, 0.025), landscape.Smooth(0.22, 0.08, heights + 0.015 * grain))
    colour = mix(colour, (0.15, 0.125, 0.105), np.maximum(rock, landscape.Smooth(0.2, 0.3, heights)))
    colour = colour * (1 + 0.13 * grain[..., None])
    colour = mix(colour, (0.86, 0.88, 0.92), snow)
    srgb = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * np.maximum(colour, 1e-6) ** (1 / 2.4) - 0.055)
    return np.clip(srgb * 255 + 0.5, 0, 255).astype(np.uint8)


def Write(folder, size: float = 1.0) -> None:
    stage = landscape.NewStage(folder)
    pixels = max(64, int(1024 * size))
    heights = _Heights(pixels)
    imageFile.WriteExr(folder / "heights.exr", {"Y": heights.astype(np.float32)}, half=False)
    imageFile.WritePng(folder / "colours.png", _Colours(heights), level=4)
    look = textured.AddTexturedMaterial(
        stage, "/World/Looks/Ground", dict(diffuseColor=("./colours.png", "rgb"), displacement=(
            "./heights.exr", "r", dict(sourceColorSpace="raw", scale=(_PEAK,) * 4))), roughness=0.8)
    surface = UsdShade.Shader(stage.GetPrimAtPath("/World/Looks/Ground/Surface"))
    look.CreateDisplacementOutput().ConnectToSource(surface.ConnectableAPI(), "displacement")
    cage = shapes.Plane(_SIDE, _SIDE, _FACES, _FACES)
    cage = shapes.Shape(cage.points, cage.counts, cage.indices, None, cage.texcoords)
    mesh = author.AddMesh(stage, "/World/Ground", cage, material=look)
    mesh.GetSubdivisionSchemeAttr().Set(UsdGeom.Tokens.catmullClark)
    sky.AddSky(stage, folder, max(64, int(512 * size)), elevation=14, azimuth=-75, strength=26.0, ground=(0.3, 0.3, 0.3))
    author.AddCamera(stage, "/World/Camera", eye=(-4, 5.4, 34), target=(2, 4.2, 0), focalLength=34.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
