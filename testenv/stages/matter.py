# SPDX-License-Identifier: Apache-2.0
"""Stages with light inside matter that renderers are compared on: two volumes, a body without a surface, and wax.

Beside a volume's OpenVDB file lies NAME.npz for rivals that do not read such files: `values` [x][y][z] and the size `voxel`
of one; voxel 0 is at the volume's origin. Voxels of the border are 0, so that it does not matter how a rival goes on there."""

import pathlib

import numpy as np
from pxr import Sdf, UsdShade

from . import author, materialX, shapes, smoke

MAX_DEPTH = 16  # bounces at surfaces; events in volumes are none


def _Volume(stage, path: str, scattering, absorption, anisotropy: float):
    """A material whose volume has these coefficients a unit of length."""
    look = UsdShade.Material.Define(stage, path)
    medium = smoke.AddShader(stage, f"{path}/Medium", "ND_anisotropic_vdf", scattering=tuple(scattering),
                             absorption=tuple(absorption), anisotropy=float(anisotropy))
    volume = smoke.AddShader(stage, f"{path}/Volume", "ND_volume")
    UsdShade.Shader(volume.GetPrim()).CreateInput("vdf", Sdf.ValueTypeNames.Token).ConnectToSource(medium)
    look.CreateVolumeOutput("mtlx").ConnectToSource(volume)
    return look


def _Stage(path: str, sky: float):
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.4, 0.4, 0.4))
    lamp = dict(translate=(-2.5, 4, 1.5), rotate=(-65, -30, 0))
    author.AddLight(stage, "/World/Lamp", "Rect", lamp, width=2.0, height=2.0, intensity=20.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=sky, color=(0.6, 0.8, 1.0))
    author.AddCamera(stage, eye=(0, 1.3, 4.5), target=(0, 0.7, 0), aspect=1.5, width=22.0)
    return stage


def _AddGrid(stage, path: str, values, look) -> None:
    """Along x two units long, over the ground."""
    values = np.array(values, np.float32)
    for axis in range(3):
        np.moveaxis(values, axis, 0)[[0, -1]] = 0.0
    voxel, file = 2.0 / values.shape[0], pathlib.Path(path).with_suffix(".vdb")
    smoke.WriteVdb(file, voxel, (0, 0, 0), density=values)
    np.savez(file.with_suffix(".npz"), values=values, voxel=voxel)
    smoke._AddVolume(stage, "/World/Smoke", file.name, look, (-1.0, 0.2, -0.5), 1.0, density="density")


def WriteCloud(path: str, size: int = 128) -> None:
    """Dense and white, with forward scattering: long paths."""
    stage = _Stage(path, 0.5)
    _AddGrid(stage, path, smoke._Cloud(size), _Volume(stage, "/World/Look", (24,) * 3, (0,) * 3, 0.6))
    stage.GetRootLayer().Save()


def WriteInk(path: str, size: int = 128) -> None:
    """Thin, and of other colours in what it scatters: short paths, one extinction."""
    stage = _Stage(path, 0.2)
    albedo = np.array((0.9, 0.7, 0.35))
    _AddGrid(stage, path, smoke._Cloud(size), _Volume(stage, "/World/Look", 6 * albedo, 6 * (1 - albedo), 0.0))
    stage.GetRootLayer().Save()


def _AddBody(stage, look) -> None:
    author.AddMesh(stage, "/World/Body", shapes.Torus(0.55, 0.25), material=look, translate=(0, 0.85, 0), rotate=(65, 0, 0))


def WriteJade(path: str) -> None:
    """A body that is nothing but a medium: what a random walk below a surface is, without the surface."""
    stage = _Stage(path, 0.2)
    albedo = np.array((0.9, 0.98, 0.93))
    _AddBody(stage, _Volume(stage, "/World/Look", 16 * albedo, 16 * (1 - albedo), 0.0))
    stage.GetRootLayer().Save()


def WriteWax(path: str) -> None:
    """The random walk of Standard Surface, without its specular lobe."""
    stage = _Stage(path, 0.2)
    _AddBody(stage, materialX.AddSurface(stage, "/World/Look", base=0.0, specular=0.0, subsurface=1.0,
                                         subsurface_color=(0.8, 0.5, 0.3), subsurface_radius=(0.1, 0.1, 0.1)))
    stage.GetRootLayer().Save()
