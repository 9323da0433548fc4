# SPDX-License-Identifier: Apache-2.0
"""Glass that disperses, against pictures of glass that does not: each of one wavelength, whose index is Cauchy's, summed by the
responses of the CIE's observer to red, green and blue."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, UsdShade
from stages import author, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddSurface
from makeFilmTable import Responses

SIZE, BLOCK = 24, 4
GLTF = "ND_gltf_pbr_surfaceshader"


def _Stage(path, identifier=STANDARD, shape=None, dome=0.1, **inputs):
    """A ball of glass before strips that glow."""
    stage = author.NewStage(str(path))
    glass = AddSurface(stage, "/World/Look", identifier, **inputs)
    author.AddMesh(stage, "/World/Ball", shape or shapes.Sphere(1.0, 64, 96), material=glass)
    if shape is None:
        glow = author.AddMaterial(stage, "/World/Glow", emissiveColor=(1.0, 1.0, 1.0), diffuseColor=(0, 0, 0))
        for i in range(4):
            author.AddMesh(stage, f"/World/Strip{i}", shapes.Plane(0.35, 6), material=glow, doubleSided=True,
                           translate=(1.1 * i - 1.5, 0, -2.2), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=dome)
    author.AddCamera(stage, eye=(0, 0, 10), width=22.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Blocks(path, seeds=6, samples=256, first=1, **settings):
    """Means of blocks of independent pictures [seeds][][][3]."""
    pictures = [ours.Render(path, SIZE, SIZE, samples=samples, seed=first + i, maxDepth=6, **settings).rgb for i in range(seeds)]
    return np.array(pictures, np.float64).reshape(seeds, SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).mean((2, 4))


def _Standard(**inputs):
    return dict(base=0.0, specular_roughness=0.0, transmission=1.0, **inputs)


def test_a_picture_is_the_sum_over_wavelengths(tmp_path):
    abbe, numParts = 6.0, 24
    mine = _Blocks(_Stage(tmp_path / "a.usda", **_Standard(transmission_dispersion=abbe)), samples=512)
    wavelengths = np.arange(380.0, 781.0, 1.0)
    responses = np.maximum(Responses(wavelengths), 0.0)
    places = (wavelengths ** -2.0 - 587.56 ** -2.0) / (486.13 ** -2.0 - 656.27 ** -2.0)
    index = 1.5 + 0.5 / abbe * places
    edges = np.linspace(index.min(), index.max() + 1e-9, numParts + 1)
    theirs = 0.0
    for i in range(numParts):
        inside = (index >= edges[i]) & (index < edges[i + 1])
        share = responses[:, inside].sum(1) / responses.sum(1)
        middle = (index[inside] * responses[:, inside].sum(0)).sum() / responses[:, inside].sum()
        still = _Blocks(_Stage(tmp_path / f"{i}.usda", **_Standard(specular_IOR=float(middle))), seeds=2, samples=128, first=50 + 2 * i)
        theirs = theirs + still * share
    error = np.sqrt(mine.var(0, ddof=1) / len(mine) + theirs.var(0, ddof=1) / len(theirs))
    assert np.abs(mine.mean(0) - theirs.mean(0)).max() < 0.012, np.abs(mine.mean(0) - theirs.mean(0)).max()
    assert np.abs(mine.mean((0, 1, 2)) - theirs.mean((0, 1, 2))).max() < 0.003
    plain = _Blocks(_Stage(tmp_path / "plain.usda", **_Standard()), seeds=2)
    assert np.abs(plain.mean(0) - theirs.mean(0)).max() > 0.05, "the test would show little"
    assert error.max() < 0.02


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_white_stays_white(tmp_path, roughness):
    path = _Stage(tmp_path / "a.usda", shape=shapes.Sphere(1.0, 32, 48), dome=1.0,
                  **{**_Standard(transmission_dispersion=10.0), "specular_roughness": roughness})
    picture = ours.Render(path, SIZE, SIZE, samples=1024, maxDepth=32).rgb[8:16, 8:16]
    assert picture.mean((0, 1)) == pytest.approx(np.ones(3), abs=0.01 if roughness == 0.0 else 0.03)


MODELS = {
    "standard": (STANDARD, _Standard(transmission_dispersion=10.0)),
    "openPbr": (OPEN_PBR, dict(base_weight=0.0, transmission_weight=1.0, specular_roughness=0.0, transmission_dispersion_scale=0.5,
                               transmission_dispersion_abbe_number=5.0)),
    "gltf": (GLTF, dict(transmission=1.0, roughness=0.0, base_color=(1, 1, 1), metallic=0.0, thickness=1.0, dispersion=2.0)),
}


@pytest.mark.parametrize("name", ["openPbr", "gltf"])
def test_models_have_one_abbe_number(tmp_path, name):
    standard, other = (_Blocks(_Stage(tmp_path / f"{i}.usda", MODELS[one][0], **MODELS[one][1])).mean(0)
                       for i, one in enumerate(("standard", name)))
    assert np.abs(standard - other).max() < 0.02


def test_bits_do_not_depend_on_waves_and_thin_walls_disperse_nothing(tmp_path):
    path = _Stage(tmp_path / "a.usda", **_Standard(transmission_dispersion=10.0))
    whole, small = (ours.Render(path, SIZE, SIZE, samples=8, **settings).rgb for settings in ({}, dict(waveSize=1024)))
    assert np.array_equal(whole, small)
    thin = [ours.Render(_Stage(tmp_path / f"{abbe}.usda", **_Standard(thin_walled=True, transmission_dispersion=abbe)), SIZE, SIZE,
                        samples=8).rgb for abbe in (0.0, 10.0)]
    assert np.array_equal(*thin)


def test_dispersion_that_varies_is_left_out_with_a_line(tmp_path):
    stage = author.NewStage(str(tmp_path / "a.usda"))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 8, 12), material=AddSurface(stage, "/World/Look", **_Standard()))
    node = UsdShade.Shader.Define(stage, "/World/Look/Primvar")
    node.CreateIdAttr("ND_geompropvalue_float")
    node.CreateInput("geomprop", Sdf.ValueTypeNames.String).Set("abbe")
    surface = UsdShade.Shader.Get(stage, "/World/Look/Surface")
    surface.CreateInput("transmission_dispersion", Sdf.ValueTypeNames.Float).ConnectToSource(
        node.CreateOutput("out", Sdf.ValueTypeNames.Float))
    author.AddCamera(stage)
    stage.GetRootLayer().Save()
    warnings = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=1).warnings
    assert len([line for line in warnings if "transmission_dispersion of /World/Look/Surface: varies" in line]) == 1, warnings
