# SPDX-License-Identifier: Apache-2.0
"""Shadow rays to where a smooth metal hardly sends light, which are left to chance (docs/wavefront.md, "Light
transport"): the mean is that of the formula, and few of them are traced."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from closedForm import PreviewReflected
from stages import author, shapes

_SIZE, _SAMPLES = 64, 128


@pytest.mark.parametrize("angle, share", [(40, 0.85), (60, 0.35), (80, 0.4)])
def test_the_tail_of_a_highlight_is_that_of_the_formula(angle, share, tmp_path):
    path = f"{tmp_path}/a.usda"
    metal = dict(diffuseColor=(0.9, 0.6, 0.3), metallic=1.0, roughness=0.1)
    stage = author.NewStage(path)
    material = author.AddMaterial(stage, "/World/M", **metal)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(4, 4), material=material)
    author.AddCamera(stage, eye=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1), width=10, aspect=1, orthographic=True)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(angle - 90, 0, 0)), angle=0.0, intensity=1e4)
    stage.GetRootLayer().Save()
    del stage
    picture = ours.Render(path, _SIZE, _SIZE, samples=_SAMPLES, maxDepth=0)
    light = (0.0, np.cos(np.radians(angle)), np.sin(np.radians(angle)))
    expected = 1e4 * PreviewReflected((0, 1, 0), (0, 1, 0), light, **metal)
    values = picture.rgb.reshape(-1, 3)
    error = values.std(0) / len(values) ** 0.5
    assert np.all(error < 0.01 * expected), "enough rays are traced"
    assert np.all(np.abs(values.mean(0) - expected) < 4 * error), (values.mean(0) / expected, error / expected)
    rays = picture.statistics["rays"]
    assert 0 < rays["shadow"] < share * rays["camera"]
