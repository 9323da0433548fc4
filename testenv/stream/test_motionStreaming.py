# SPDX-License-Identifier: Apache-2.0
"""Geometry that moves streams with the bits of resident geometry."""

import pytest

pytest.importorskip("hdstream._core")

from stages import motion
from streamCase import Case


@pytest.fixture(scope="module")
def Scene(tmp_path_factory):
    path = motion.Write(tmp_path_factory.mktemp("motion") / "stage.usda", "nested", "polygons", "surface", "curves", "points", "camera", "focus", "zoom", "spot", "growing", "swarm",
                        "glow", "flame")
    return Case(path, timeCode=motion.FRAME, shutter=motion.SHUTTER).RenderResident()


@pytest.mark.parametrize("settings", [
    dict(geometryMemory="100%"), dict(geometryMemory="20%"), dict(geometryMemory="10%"),
    dict(geometryMemory="20%", request="first"), dict(geometryMemory="20%", traversal="scalar"),
], ids=["all", "fifth", "tenth", "first", "scalar"])
def test_any_pool_and_form_gives_the_same_bits(Scene, settings):
    geometry = Scene.AssertStreams(**settings)
    assert settings["geometryMemory"] == "100%" or geometry["evictions"] > 0, "the test would show little"
