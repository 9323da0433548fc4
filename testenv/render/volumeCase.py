# SPDX-License-Identifier: Apache-2.0
"""Scenes with volumes for tests: a stage with a camera and lights, and volumes handed to the session."""

import json

import numpy as np
from pxr import Usd

from hdstream import _core
from hdstream.translate import TranslateStage
from stages import author


def Grid(values, first=(0, 0, 0), objectFromIndex=None) -> "_core.VoxelGrid":
    """A grid of values [x][y][z]. \\param objectFromIndex: row vectors, as Gf; None: voxels of 1 / len(values), centred."""
    values = np.asarray(values, np.float32)
    if objectFromIndex is None:
        size = 1.0 / max(values.shape)
        objectFromIndex = np.diag([size, size, size, 1.0])
        objectFromIndex[3, :3] = [-0.5 * size * (n - 1) for n in values.shape]
    return _core.VoxelGrid(np.ascontiguousarray(values.transpose(2, 1, 0)), values.shape, first, np.array(objectFromIndex))


def Volume(density=None, emissionGrid=None, temperature=None, scale=1.0, absorption=0.0, scattering=0.0, anisotropy=0.0,
           emission=0.0, blackbody=0.0, kelvin=1.0) -> "_core.VolumePrim":
    volume = _core.VolumePrim(_core.Placement(np.diag([scale, scale, scale, 1.0])))
    vectors = [tuple(np.broadcast_to(value, 3).astype(float)) for value in (absorption, scattering, emission, blackbody)]
    volume.SetShading(vectors[0], vectors[1], anisotropy, vectors[2], vectors[3], kelvin, "density",
                      "emission" if emissionGrid is not None else "", "temperature" if temperature is not None else "")
    for name, grid in (("density", density), ("emission", emissionGrid), ("temperature", temperature)):
        if grid is not None:
            volume.SetGrid(name, grid)
    return volume


def Stage(path, lights=(("Dome", {}),), width=2.0, add=None) -> str:
    """Seen along -z by an orthographic camera."""
    stage = author.NewStage(str(path))
    for number, (kind, options) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{number}", kind, **options)
    author.AddCamera(stage, eye=(0, 0, 10), width=10.0 * width, aspect=1.0, orthographic=True)
    if add is not None:
        add(stage)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def RenderSession(stagePath, volumes, size=16, aovs=("color",), **settings):
    """The session of a render. \\param volumes: by path."""
    session = _core.Session()
    TranslateStage(Usd.Stage.Open(str(stagePath)), session, Usd.TimeCode.Default())
    for path, volume in volumes.items():
        session.SetVolume(path, volume)
    options = _core.Settings()
    options.camera, options.imageWidth, options.imageHeight = "/World/Camera", size, size
    options.aovs, options.pixelFilter, options.pixelFilterWidth = list(aovs), "box", 1.0
    options.russianRoulette, options.noCache, options.maxDepth = True, True, 64
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    return session


def Render(stagePath, volumes, size=16, aovs=("color",), **settings):
    """(layers by name, statistics, warnings). \\param volumes: by path."""
    session = RenderSession(stagePath, volumes, size, aovs, **settings)
    layers = {layer.name: np.array(layer.pixels) for layer in session.Layers()}
    return layers, json.loads(session.Statistics()), list(session.Warnings())


def Cloud(size=24, seed=3) -> np.ndarray:
    """Density [x][y][z] that varies from voxel to voxel, with holes of whole cells."""
    numbers = np.random.default_rng(seed)
    values = numbers.random((size, size, size)).astype(np.float32) ** 2
    values[:8, :8] = 0.0
    values[size // 2:, size // 2:, size // 2:] = 0.5
    return values
