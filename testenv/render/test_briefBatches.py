# SPDX-License-Identifier: Apache-2.0
"""Batches of few rays are traced and shaded without a wait in between: pictures and counts of rays are those of large ones."""

import numpy as np
import pytest
from pxr import UsdLux

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

WIDTH, HEIGHT, SAMPLES = 64, 48, 4


def _WriteStage(path, isCutOut):
    """Balls in a corner below a dome, a lamp and a panel that glows; with cut-outs a veil before them."""
    stage = author.NewStage(str(path))
    for i in range(4):
        author.AddMesh(stage, f"/World/Ball{i}", shapes.Sphere(0.5, 8, 16), color=(0.8, 0.4 + 0.1 * i, 0.3), translate=(i - 1.5, 0.5, -0.3 * i))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.7, 0.7, 0.7))
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(3, 2, 1))
    author.AddMesh(stage, "/World/Panel", shapes.Plane(1, 1), material=glow, translate=(0, 2.5, 0), rotate=(180, 0, 0))
    if isCutOut:
        veil = author.AddMaterial(stage, "/World/Veil", diffuseColor=(0.2, 0.3, 0.9), opacity=0.5)
        author.AddMesh(stage, "/World/Screen", shapes.Plane(3, 3), material=veil, translate=(0, 0.8, 1.2), rotate=(70, 0, 0))
    UsdLux.DomeLight.Define(stage, "/World/Dome").CreateIntensityAttr(0.3)
    author.AddCamera(stage, eye=(0, 1.5, 5), target=(0, 0.5, 0))
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("isCutOut", [False, True], ids=["opaque", "cutOut"])
def test_pictures_and_counts_are_those_of_large_batches(isCutOut, tmp_path):
    _WriteStage(tmp_path / "a.usda", isCutOut)

    def Render(**settings):
        settings = dict(kernels="own") | settings
        return ours.Render(tmp_path / "a.usda", WIDTH, HEIGHT, samples=SAMPLES, maxDepth=6, residency="resident", **settings)

    expected = Render(waveSize=WIDTH * HEIGHT * SAMPLES)
    brief = expected.statistics["geometry"]["briefBatches"]
    assert brief < expected.statistics["geometry"]["rayBatches"], "what it is compared with"
    assert expected.statistics["wave"]["size"] > 2048 and expected.statistics["rays"]["shadow"] > 4096
    for settings in (dict(waveSize=301), dict(waveSize=3001), dict(waveSize=301, traversal="scalar")):
        picture = Render(**settings)
        geometry = picture.statistics["geometry"]
        assert geometry["briefBatches"] > 0, settings
        if "traversal" not in settings and settings["waveSize"] == 301:
            assert geometry["briefBatches"] == geometry["rayBatches"]
        assert np.array_equal(picture.layers["color"], expected.layers["color"]), settings
        for kind in ("camera", "indirect", "shadow"):
            assert picture.statistics["rays"][kind] == expected.statistics["rays"][kind], (settings, kind)
    if isCutOut:  # general kernels pass cut-outs in launches of their own
        picture = Render(waveSize=301, kernels="general")
        assert picture.statistics["wave"]["kernels"] == "general" and picture.statistics["geometry"]["briefBatches"] == 0
        assert np.array_equal(picture.layers["color"], expected.layers["color"])
        assert picture.statistics["rays"]["shadow"] == expected.statistics["rays"]["shadow"]
