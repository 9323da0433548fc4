# SPDX-License-Identifier: Apache-2.0
"""Smooth metal and glass (docs/materials.md, "Smooth surfaces"): they show lights as Fresnel's equations say, with their edges, and
take no light samples."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes
from stages.materialX import AddSurface
from test_insideGlass import _LAMPS, _RADIANCE, _Fresnel

_METAL = dict(base=1.0, base_color=(1.0, 1.0, 1.0), metalness=1.0, specular_roughness=0.0)
_GLASS = dict(base=0.0, transmission=1.0, specular_IOR=1.5, specular_roughness=0.0)
_DEGREES = 50.0  # off the normal
_SUN_DEGREES, _SUN_SAMPLES = 1.0, 64


def _Metal() -> float:
    """What it reflects: Standard Surface's metal has an index by its colours, of which 0.99 is the most (Gulbrandsen 2014, eqs. 2
    and 3)."""
    color = 0.99
    index = (1 - color) / (1 + color)
    extinction = np.sqrt(((index + 1) ** 2 * color - (index - 1) ** 2) / (1 - color))
    eta, cosine = complex(index, extinction), np.cos(np.radians(_DEGREES))
    inside = np.sqrt(1 - (1 - cosine**2) / eta**2)
    s, p = (cosine - eta * inside) / (cosine + eta * inside), (eta * cosine - inside) / (eta * cosine + inside)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def _Render(path, addLamp, look, samples, size, field):
    """A sheet that is seen from its outside, below it; `field` is the picture's width over the distance."""
    stage = author.NewStage(str(path))
    material = AddSurface(stage, "/World/Look", **look)
    author.AddMesh(stage, "/World/Sheet", shapes.Plane(400, 400), material=material, translate=(0, 1, 0), rotate=(180, 0, 0))
    addLamp(stage)
    author.AddCamera(stage, target=(np.tan(np.radians(_DEGREES)), 1, 0), eye=(0, 0, 0), up=(0, 0, 1), aspect=1.0, focalLength=35.0,
                     width=35.0 * field)
    stage.GetRootLayer().Save()
    picture = ours.Render(path, size, size, samples=samples, maxDepth=3)
    assert not picture.warnings
    return picture


@pytest.mark.parametrize("lamp", _LAMPS)
def test_metal_shows_a_lamp_by_fresnels_equations_without_light_samples(lamp, tmp_path):
    picture = _Render(tmp_path / "stage.usda", _LAMPS[lamp], _METAL, samples=256, size=16, field=0.02)
    np.testing.assert_allclose(picture.rgb, _RADIANCE * _Metal(), rtol=1e-3)
    assert picture.statistics["rays"]["shadow"] == 0


@pytest.mark.parametrize("lamp", _LAMPS)
def test_glass_shows_a_lamp_by_fresnels_equations_without_light_samples(lamp, tmp_path):
    """A dome is behind the sheet too."""
    picture = _Render(tmp_path / "stage.usda", _LAMPS[lamp], _GLASS, samples=256, size=16, field=0.02)
    part = 1.0 if lamp == "dome" else _Fresnel(np.cos(np.radians(_DEGREES)), 1.5)
    assert picture.rgb.mean() / _RADIANCE == pytest.approx(part, rel=0.02)  # its facets reflect by chance
    assert picture.statistics["rays"]["shadow"] == 0


@pytest.mark.parametrize("look", [_METAL, _GLASS], ids=["metal", "glass"])
def test_a_sun_has_an_edge_in_a_smooth_surface(look, tmp_path):
    """Its disk has the sun's radiance, times what is reflected, and nothing is around it."""
    size, field = 33, 0.06

    def AddSun(stage):
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(90, 0, _DEGREES)), angle=_SUN_DEGREES, intensity=1e6)

    picture = _Render(tmp_path / "stage.usda", AddSun, look, samples=_SUN_SAMPLES, size=size, field=field)
    at = (np.arange(size) - size // 2) * field / size
    away = np.degrees(np.arctan(np.hypot(at[:, None], at[None, :])))
    edge = np.degrees(np.arctan(field / size))  # more than half of a pixel's diagonal
    inside, outside = away < _SUN_DEGREES / 2 - edge, away > _SUN_DEGREES / 2 + edge
    assert inside.sum() > 20 and outside.sum() > 500
    assert np.all(picture.rgb[outside] == 0.0)
    part = _Metal() if look is _METAL else _Fresnel(np.cos(np.radians(_DEGREES)), 1.5)
    error = 4 * np.sqrt((1 - part) / part / (_SUN_SAMPLES * inside.sum())) if look is _GLASS else 0.0
    assert picture.rgb[inside].mean() == pytest.approx(1e6 * part, rel=error + 2e-3)
