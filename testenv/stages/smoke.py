# SPDX-License-Identifier: Apache-2.0
"""A cloud and a fire: OpenVDB files beside the stage, which the build's program writeVdb writes."""

import pathlib
import subprocess
import tempfile

import numpy as np
from pxr import Gf, Sdf, UsdShade, UsdVol

from . import author, shapes

_BUILDS = pathlib.Path(__file__).resolve().parents[2] / "build"


def WriteVdb(path, voxelSize, first, **grids) -> None:
    """Writes grids of one shape, each [x][y][z], vectors [x][y][z][3]. Raises FileNotFoundError without a build."""
    with tempfile.TemporaryDirectory() as folder:
        files = {}
        for name, values in grids.items():
            values = np.asarray(values, np.float32)
            file = pathlib.Path(folder) / name
            file.write_bytes(np.ascontiguousarray(np.swapaxes(values, 0, 2)).tobytes())
            files[name + (":3" if values.ndim == 4 else "")] = file
        WriteVdbOfFiles(path, voxelSize, first, np.asarray(next(iter(grids.values()))).shape[:3], files)


def WriteVdbOfFiles(path, voxelSize, first, shape, files: dict) -> None:
    """The same of files of floats [z][y][x], by the grids' names (testenv/tools/writeVdb.cpp). \\param shape: x, y, z."""
    programs = sorted(_BUILDS.glob("*/testenv/writeVdb"), key=lambda program: program.parts[-3] != "release")
    if not programs:
        raise FileNotFoundError("writeVdb is not built")
    words = [word for name, file in files.items() for word in (name, str(file))]
    subprocess.run([str(programs[0]), str(path), *map(str, (voxelSize, *first, *shape)), *words], check=True)


def _Noise(points, seed, octaves=5):
    """Fractal noise about 0: cubic interpolation of random lattices."""
    total, random = np.zeros(points.shape[:-1]), np.random.default_rng(seed)
    for octave in range(octaves):
        lattice = random.uniform(-1, 1, (16, 16, 16))
        at = points * 2**octave
        cell = np.floor(at).astype(int)
        part = at - cell
        part = part * part * (3 - 2 * part)
        value = 0.0
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, part, 1 - part), axis=-1)
            value = value + weight * lattice[tuple(np.moveaxis((cell + corner) % 16, -1, 0))]
        total += value * 0.55**octave
    return total


def _Points(shape):
    """Of voxels, [x][y][z][3], in [-1, 1] along x."""
    axes = [(np.arange(n) + 0.5 - n / 2) / (shape[0] / 2) for n in shape]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)


def _Cloud(size):
    points = _Points((size, size // 2, size // 2))
    balls = [((0, -0.1, 0), 0.33), ((-0.42, -0.17, 0.05), 0.24), ((0.4, -0.15, -0.05), 0.27), ((0.12, 0.1, 0.08), 0.24),
             ((0.68, -0.24, 0.1), 0.17), ((-0.7, -0.25, 0), 0.15)]
    distance = np.min([np.linalg.norm(points - centre, axis=-1) - radius for centre, radius in balls], axis=0)
    return np.clip((0.16 * _Noise(4 * points, 1) - distance) * 12, 0, 1)


def _Fire(size):
    """Density and temperature."""
    points = _Points((size // 2, size, size // 2))
    height = (points[..., 1] + 2) / 4
    swirl = points * (3, 1.2, 3) + 0.5 * np.stack([_Noise(1.5 * points + k, 7 + k, 3) for k in range(3)], -1)
    around = np.hypot(points[..., 0] + 0.3 * _Noise(points, 20, 2) * height, points[..., 2])
    shape = 0.34 * np.sqrt(np.clip(height * 6, 0, 1)) * (1.15 - height) - around + 0.16 * _Noise(swirl, 3)
    heat = np.clip(shape * 5, 0, 1) * np.clip(1.25 - 1.5 * height, 0, 1)
    smoke = np.clip((shape + 0.12) * 3, 0, 1) * np.clip(height * 2 - 0.5, 0, 1)
    return smoke + 0.2 * heat, heat


def _AddVolume(stage, path, file, look, translate, scale, **fields):
    volume = UsdVol.Volume.Define(stage, path)
    for name, grid in fields.items():
        asset = UsdVol.OpenVDBAsset.Define(stage, f"{path}/{name}")
        asset.CreateFilePathAttr(f"./{file}")
        asset.CreateFieldNameAttr(grid)
        volume.CreateFieldRelationship(name, asset.GetPath())
    volume.AddTranslateOp().Set(Gf.Vec3d(*translate))
    volume.AddScaleOp().Set(Gf.Vec3f(*np.broadcast_to(scale, 3).tolist()))
    UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(look)


def AddShader(stage, path, identifier, **inputs):
    """A shader by its inputs: texts, floats and colours. Returns its output."""
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(identifier)
    for name, value in inputs.items():
        kind = Sdf.ValueTypeNames.Token if isinstance(value, str) else (
            Sdf.ValueTypeNames.Float if isinstance(value, float) else Sdf.ValueTypeNames.Color3f)
        shader.CreateInput(name, kind).Set(value if isinstance(value, (str, float)) else Gf.Vec3f(*value))
    return shader.CreateOutput("out", Sdf.ValueTypeNames.Token)


def _Looks(stage):
    cloud = UsdShade.Material.Define(stage, "/World/Looks/Cloud")
    medium = AddShader(stage, "/World/Looks/Cloud/Medium", "ND_anisotropic_vdf", absorption=(0.0, 0.0, 0.0),
                        scattering=(24.0, 24.0, 24.0), anisotropy=0.6)
    volume = AddShader(stage, "/World/Looks/Cloud/Volume", "ND_volume")
    UsdShade.Shader(volume.GetPrim()).CreateInput("vdf", Sdf.ValueTypeNames.Token).ConnectToSource(medium)
    cloud.CreateVolumeOutput("mtlx").ConnectToSource(volume)
    fire = UsdShade.Material.Define(stage, "/World/Looks/Fire")
    fire.CreateVolumeOutput().ConnectToSource(AddShader(
        stage, "/World/Looks/Fire/Volume", "arnold:standard_volume", density=9.0, scatter_color=(0.3, 0.3, 0.3),
        emission_mode="blackbody", temperature=0.38, temperature_channel="temperature", blackbody_intensity=12.0))
    return cloud, fire


def WriteSmoke(path: str, size: int = 192) -> None:
    """\\param size: voxels along the cloud."""
    folder = pathlib.Path(path).parent
    WriteVdb(folder / "cloud.vdb", 2.0 / size, (0, 0, 0), density=_Cloud(size))
    density, heat = _Fire(size)
    WriteVdb(folder / "fire.vdb", 2.0 / size, (0, 0, 0), density=density, temperature=heat)
    stage = author.NewStage(path)
    cloud, fire = _Looks(stage)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(30, 30), color=(0.3, 0.28, 0.25))
    author.AddMesh(stage, "/World/Stone", shapes.Sphere(0.45, 32, 64), color=(0.5, 0.5, 0.5), translate=(-0.3, 0.45, 0.6))
    _AddVolume(stage, "/World/Cloud", "cloud.vdb", cloud, (-3.6, 1.0, -1.6), 1.9, density="density")
    _AddVolume(stage, "/World/Fire", "fire.vdb", fire, (0.75, 0.0, -0.4), (1.9, 1.3, 1.9), density="density", temperature="temperature")
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-38, -50, 0)), angle=1.0, intensity=15000.0, color=(1.0, 0.93, 0.82))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.6, color=(0.45, 0.62, 1.0))
    author.AddCamera(stage, eye=(0, 1.5, 6.2), target=(0, 1.35, 0), aspect=2.0, width=27.0)
    stage.GetRootLayer().Save()
