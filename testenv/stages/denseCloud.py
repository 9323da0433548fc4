# SPDX-License-Identifier: Apache-2.0
"""A cloud of which nearly every brick differs, as large as one likes: for what streams voxels."""

import pathlib

import numpy as np
from pxr import Gf, Sdf, Usd, UsdShade, UsdVol

from . import author, bench, shapes, smoke, textureStress
from .textured import AddTexturedMaterial

_OCTAVES = ((6, 0.62), (24, 0.3), (96, 0.12))  # random lattices: points an edge, amplitude
_SLAB = 32  # planes at a time
SCATTERING, ABSORPTION, ANISOTROPY = 6.0, 2.0, 0.3
SIZE = 2.0  # edge of its cube, in units of the world


def _Weights(size: int, points: int) -> np.ndarray:
    """[size][points]: linear interpolation from a lattice to `size` places, in each cell with the slopes of a cubic."""
    at = (np.arange(size) + 0.5) / size * (points - 1)
    cell = np.minimum(at.astype(int), points - 2)
    part = at - cell
    part = part * part * (3 - 2 * part)
    weights = np.zeros((size, points), np.float32)
    weights[np.arange(size), cell], weights[np.arange(size), cell + 1] = 1 - part, part
    return weights


def WriteDensity(path, size: int) -> None:
    """Floats [z][y][x] of a cube of `size` voxels: noise in a ball, 0 around it, and nowhere alike over eight voxels."""
    random = np.random.default_rng(11)
    lattices = [(_Weights(size, points), amplitude * random.uniform(-1, 1, (points,) * 3).astype(np.float32))
                for points, amplitude in _OCTAVES]
    axis = ((np.arange(size) + 0.5) / size * 2 - 1).astype(np.float32)
    flat = axis[:, None] ** 2 + axis[None, :] ** 2
    with open(path, "wb") as file:
        for begin in range(0, size, _SLAB):
            planes = slice(begin, min(size, begin + _SLAB))
            total = 1.1 - np.sqrt(flat[None] + axis[planes, None, None] ** 2) * 1.15
            for weights, lattice in lattices:
                rows = np.tensordot(weights[planes], lattice, (1, 0))
                total += np.matmul(np.matmul(weights, rows), weights.T)
            file.write(np.maximum(total, 0).astype(np.float32).tobytes())


def _AddCloud(stage, file: str, size: int) -> UsdVol.Volume:
    asset = UsdVol.OpenVDBAsset.Define(stage, "/World/Cloud/density")
    asset.CreateFilePathAttr(f"./{file}")
    asset.CreateFieldNameAttr("density")
    volume = UsdVol.Volume.Define(stage, "/World/Cloud")
    volume.CreateFieldRelationship("density", asset.GetPath())
    look = UsdShade.Material.Define(stage, "/World/Looks/Cloud")
    medium = UsdShade.Shader.Define(stage, "/World/Looks/Cloud/Medium")
    medium.CreateIdAttr("ND_anisotropic_vdf")
    for name, value in (("absorption", ABSORPTION), ("scattering", SCATTERING)):
        medium.CreateInput(name, Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(value))
    medium.CreateInput("anisotropy", Sdf.ValueTypeNames.Float).Set(ANISOTROPY)
    shader = UsdShade.Shader.Define(stage, "/World/Looks/Cloud/Volume")
    shader.CreateIdAttr("ND_volume")
    shader.CreateInput("vdf", Sdf.ValueTypeNames.Token).ConnectToSource(
        medium.CreateOutput("out", Sdf.ValueTypeNames.Token))
    look.CreateVolumeOutput("mtlx").ConnectToSource(shader.CreateOutput("out", Sdf.ValueTypeNames.Token))
    UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(look)
    voxel = SIZE / size
    author.Place(volume, translate=(0.5 * voxel - 0.5 * SIZE,) * 3)
    return volume


def WriteCloud(path, size: int) -> pathlib.Path:
    """A cube of `size` voxels an edge, [-1, 1]^3, below a sun; seen along -z by an orthographic camera. Files of voxels lie
    beside the stage, and are kept where they are there. Returns that of the floats [z][y][x]."""
    path = pathlib.Path(path)
    file, raw = f"cloud{size}.vdb", path.parent / f"density{size}.f32"
    if not raw.exists():
        part = raw.with_suffix(".part")
        WriteDensity(part, size)
        part.rename(raw)
    if not (path.parent / file).exists():
        smoke.WriteVdbOfFiles(path.parent / file, SIZE / size, (0, 0, 0), (size,) * 3, {"density": raw})
    stage = author.NewStage(str(path))
    _AddCloud(stage, file, size)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), angle=0.0, intensity=3.0)
    author.AddCamera(stage, eye=(0, 0, 10), width=10.0 * SIZE, aspect=16 / 9, orthographic=True)
    stage.GetRootLayer().Save()
    return raw


def WriteAll(path, size: int, cells: int, cards: int, texels: int) -> None:
    """That cloud over a terrain of 2 cells^2 triangles, before a wall of cards^2 photographs."""
    path = pathlib.Path(path)
    WriteCloud(path, size)
    folder = path.parent / f"textures{texels}"
    textureStress.WriteTextures(folder, cards * cards, texels)
    stage = Usd.Stage.Open(str(path))
    author.AddMesh(stage, "/World/Terrain", shapes.HeightField(8.0, cells, lambda x, z: 0.1 * bench.Bumps(6 * x, 6 * z)),
                   color=(0.4, 0.35, 0.3), translate=(0, -1.3, 0))
    width = 6.0 / cards
    card = shapes.Shape(np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]) * 0.96 * width, np.array([4]), np.arange(4),
                        texcoords=np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]))
    for number in range(cards * cards):
        look = AddTexturedMaterial(stage, f"/World/Looks/Card{number}", {
            "diffuseColor": (f"./{folder.name}/photo{number:04d}.png", "rgb")}, wrap="clamp", roughness=0.7)
        author.AddMesh(stage, f"/World/Cards/Card{number}", card, material=look, doubleSided=True, translate=(
            width * (number % cards) - 3.0, width * (number // cards) - 1.5, -2.2))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    author.AddCamera(stage, path="/World/All", eye=(0, 0.6, 5.5), target=(0, 0.1, 0), focalLength=30.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
