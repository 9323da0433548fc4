# SPDX-License-Identifier: Apache-2.0
"""UsdPreviewSurfaces with random inputs on a ball below a sky and a wide sun look as their formula says, integrated in double precision."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")
pytest.importorskip("MaterialX")

import ours
import previewBall
from stages import author, randomMaterials
from stages.materialX import Ball

SIZE, BLOCK, SKY, SUN, SUN_ANGLE = 32, 8, 0.5, 4.0, 50.0


def _Blocks(picture):
    """Of those inside of the ball."""
    return picture.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).mean((1, 3))[1:3, 1:3]


# Of seed 1: what emits, a free specular colour below a coat, what is half metal below a coat and emits, metal below a coat.
@pytest.mark.parametrize("index", [0, 3, 8, 11])
def test_random_surfaces_have_their_formula(tmp_path, index):
    inputs = randomMaterials.Inputs("UsdPreviewSurface", 1, index)
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    look = author.AddMaterial(stage, "/World/Look", **inputs)
    author.AddMesh(stage, "/World/Ball", Ball(1.0), material=look)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=SKY)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 0, 0)), angle=SUN_ANGLE, intensity=SUN)
    author.AddCamera(stage, eye=(0, 0, 10), width=20.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    color = ours.Render(stage.GetRootLayer().realPath, SIZE, SIZE, samples=128, maxDepth=1).rgb
    turn = np.radians(40)
    expected = previewBall.Picture(SIZE, inputs, SKY, SUN, (0.0, np.sin(turn), np.cos(turn)), np.radians(SUN_ANGLE / 2))
    assert _Blocks(color) == pytest.approx(_Blocks(expected), rel=0.015)
