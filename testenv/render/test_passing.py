# SPDX-License-Identifier: Apache-2.0
"""Surfaces that rays pass by chance: as they are where each ray takes light of one surface alone, and less noisy.

A ray takes along what such a surface sends back (docs/wavefront.md, "Cut-outs"), but for camera rays of deep pictures. The
mean of both is the same.
"""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, UsdShade
from stages import author, imageFile, shapes

_SEEDS = 8
_VEILS = {
    "thin": dict(opacity=0.2),
    "half": dict(opacity=0.5, metallic=0.5),
    "dense": dict(opacity=0.8, roughness=0.3),
    "glowing": dict(opacity=0.04, emissiveColor=(0.4, 0.2, 0.1)),
    "coated": dict(opacity=0.6, clearcoat=1.0),
}


def _Stage(path, inMirror):
    """Two rows of veils before a wall, above a floor that is a mirror, or below which the camera stands where the
    mirror would show it."""
    stage = author.NewStage(path)
    for column, (name, inputs) in enumerate(_VEILS.items()):
        material = author.AddMaterial(stage, f"/World/M_{name}", diffuseColor=(0.7, 0.5, 0.3), **inputs)
        for row, z in enumerate((-2.0, -2.4)):
            author.AddMesh(stage, f"/World/V_{name}{row}", shapes.Plane(1, 5), material=material,
                           translate=(column - 2, 2.7, z), rotate=(90, 0, 0))
    author.AddMesh(stage, "/World/Wall", shapes.Plane(12, 8), color=(0.2, 0.5, 0.8), translate=(0, 4.1, -3), rotate=(90, 0, 0))
    if inMirror:
        mirror = author.AddMaterial(stage, "/World/Mirror", diffuseColor=(1, 1, 1), metallic=1.0, roughness=0.0)
        author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), material=mirror)
    author.AddCamera(stage, eye=(0, 2 if inMirror else -2, 3), target=(0, 0, 0.5), width=26.0, aspect=2)
    for i in range(3):
        author.AddLight(stage, f"/World/L{i}", "Sphere", dict(translate=(0.5 * i - 1, 1.5 + 0.3 * i, 0.5)), radius=0.2, intensity=20.0)
    return stage


def _Means(path, depth, **settings) -> np.ndarray:
    """Means of blocks of 6 x 6 pixels [seed][block][3]."""
    images = [ours.Render(path, 60, 30, samples=64, maxDepth=depth, seed=seed, **settings).rgb for seed in range(_SEEDS)]
    return np.stack([image.reshape(5, 6, 10, 6, 3).mean((1, 3)) for image in images])


def _AssertSameMeans(one, other):
    difference = one.mean(0) - other.mean(0)
    error = np.sqrt((one.var(0, ddof=1) + other.var(0, ddof=1)) / _SEEDS)
    assert other.mean() > 0.05, "the veils are lit"
    assert np.all(np.abs(difference) < 5 * error + 2e-3 * other.mean(0)), np.abs(difference / (5 * error)).max()
    assert np.abs(difference.mean()) < 5e-4 * other.mean() + 4 * np.sqrt((error**2).sum()) / error.size


def test_veils_are_as_where_each_ray_takes_light_of_one(tmp_path):
    """Seen by the camera and in a mirror, where the light has one bounce more before it ends at the veils."""
    paths = {}
    for inMirror in (False, True):
        paths[inMirror] = f"{tmp_path}/{inMirror}.usda"
        stage = _Stage(paths[inMirror], inMirror)
        stage.GetRootLayer().Save()
    alone = _Means(paths[False], 0, deep=True)
    _AssertSameMeans(_Means(paths[False], 0), alone)
    _AssertSameMeans(_Means(paths[True], 1)[:, ::-1], alone)


@pytest.mark.parametrize("inMirror", [False, True])
def test_a_veil_before_nothing_is_as_smooth_as_an_opaque_surface(tmp_path, inMirror):
    """Its light is opacity times that of an opaque one to the last digits, though the rays that stay are few. Those the sample's
    alpha counts, and nothing else."""
    opacity = 0.15
    pictures = {}
    for name, value in (("veil", opacity), ("opaque", 1.0)):
        stage = author.NewStage(f"{tmp_path}/{name}.usda")
        material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.7, 0.5, 0.3), opacity=value)
        UsdShade.Shader(material.GetPrim().GetChild("Surface")).CreateInput("opacityMode", Sdf.ValueTypeNames.Token).Set("presence")
        author.AddMesh(stage, "/World/Veil", shapes.Plane(6, 6), material=material, translate=(0, 3, -2), rotate=(90, 0, 0))
        if inMirror:
            mirror = author.AddMaterial(stage, "/World/Mirror", diffuseColor=(1, 1, 1), metallic=1.0, roughness=0.0)
            author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), material=mirror)
        author.AddCamera(stage, eye=(0, 2 if inMirror else -2, 3), target=(0, 0, 0.5), width=26.0, aspect=2)
        author.AddLight(stage, "/World/L", "Distant", dict(rotate=(-20, 0, 0)), intensity=2.0, angle=0.0)
        stage.GetRootLayer().Save()
        del stage
        pictures[name] = ours.Render(f"{tmp_path}/{name}.usda", 24, 12, aovs=("color", "alpha"), samples=16, maxDepth=int(inMirror))
    veil, opaque = pictures["veil"], pictures["opaque"]
    whole = opaque.layers["alpha"].reshape(12, 24) == 1.0
    if inMirror:
        whole &= opaque.rgb.min(-1) > 0.9 * np.median(opaque.rgb.min(-1))
    assert whole.sum() > 60 and opaque.rgb[whole].min() > 0.05
    assert np.allclose(veil.rgb[whole], opacity * opaque.rgb[whole], rtol=2e-3 if inMirror else 1e-5)
    if not inMirror:
        share = veil.layers["alpha"].reshape(12, 24)[whole]
        assert set(np.unique(16 * share)) <= set(range(17)), "of each sample all or nothing"
        assert abs(share.mean() - opacity) < 4 * np.sqrt(opacity * (1 - opacity) / 16 / share.size)


def test_a_ray_that_has_passed_waits_for_texels_of_its_light_sample(tmp_path):
    """Nothing of it may be written before they are there: the surface is shaded again."""
    path = f"{tmp_path}/a.usda"
    stage = _Stage(path, True)
    values = np.random.default_rng(1).random((256, 256)).astype(np.float32)
    imageFile.WriteExr(f"{tmp_path}/panel.exr", dict(R=values, G=values.T, B=values[::-1]), half=False)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0, 4, 2), rotate=(-60, 0, 0)), width=3.0, height=2.0,
                    intensity=5.0, textureFile="./panel.exr")
    stage.GetRootLayer().Save()
    del stage
    settings = dict(samples=8, maxDepth=3)
    resident = ours.Render(path, 60, 30, residency="resident", **settings)
    streamed = ours.Render(path, 60, 30, residency="stream", textureMemory="8K", waveSize=64, **settings)
    assert streamed.statistics["texture"]["evictions"] > 0, "lines are read again"
    assert streamed.layers["color"].tobytes() == resident.layers["color"].tobytes()
