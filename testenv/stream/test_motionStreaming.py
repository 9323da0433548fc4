# SPDX-License-Identifier: Apache-2.0
"""Geometry that moves streams with the bits of resident geometry."""

import pytest

pytest.importorskip("hdstream._core")

from stages import motion
from streamCase import Case


@pytest.fixture(scope="module")
def Scene(tmp_path_factory):
    path = motion.Write(tmp_path_factory.mktemp("motion") / "stage.usda", "nested", "polygons", "surface", "curves", "points", "camera")
    return Case(path, timeCode=motion.FRAME, shutter=motion.SHUTTER).RenderResident()


@pytest.mark.parametrize("pool", ["100%", "20%", "10%"])
def test_any_pool_gives_the_same_bits(Scene, pool):
    Scene.AssertStreams(geometryMemory=pool)
