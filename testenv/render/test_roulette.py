# SPDX-License-Identifier: Apache-2.0
"""Russian roulette of paths (docs/wavefront.md, "Light transport"): it takes rays away, and no light."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes
from stages.materialX import AddSurface

_DEPTH, _SAMPLES, _SIZE = 8, 256, 24


def _Furnace(path, albedo: float):
    """A closed box of one grey that glows, seen from inside: every ray finds 1 + a + a^2 + ..."""
    stage = author.NewStage(str(path))
    look = AddSurface(stage, "/World/Look", base=albedo, base_color=(1.0, 1.0, 1.0), specular=0.0, emission=1.0, emission_color=(1.0, 1.0, 1.0))
    author.AddMesh(stage, "/World/Box", shapes.Box(2, 2, 2), material=look, doubleSided=True)
    author.AddCamera(stage, eye=(0, 0, 0.5), target=(0, 0, -1), aspect=1.0)
    stage.GetRootLayer().Save()
    return path


def _Render(path, hasRoulette: bool):
    picture = ours.Render(path, _SIZE, _SIZE, samples=_SAMPLES, maxDepth=_DEPTH, russianRoulette=hasRoulette)
    assert not picture.warnings
    return picture


def _Rays(picture) -> int:
    return picture.statistics["rays"]["indirect"]


@pytest.mark.parametrize("albedo", [0.15, 0.3, 0.7])
def test_a_furnace_keeps_its_light(albedo, tmp_path):
    path = _Furnace(tmp_path / "furnace.usda", albedo)
    plain, roulette = _Render(path, False), _Render(path, True)
    expected = np.sum(albedo ** np.arange(_DEPTH + 2))
    for picture in (plain, roulette):
        pixels = picture.rgb.mean(-1).ravel()
        error = pixels.std() / np.sqrt(len(pixels))
        assert error < 2e-3 * expected
        assert pixels.mean() == pytest.approx(expected, abs=4 * error + 1e-4 * expected)
    assert _Rays(roulette) < _Rays(plain)
