# SPDX-License-Identifier: Apache-2.0
"""smoothTerminator: coarse meshes with smooth normals against the fine meshes that they stand for, and what stays as it is."""

import pathlib
import sys

import numpy as np
import pytest
from pxr import Gf, UsdGeom

pytest.importorskip("hdstream._core")

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench"))

import hdstream
import terminator
from stages import author, shapes


@pytest.mark.parametrize("name, rings, least", [("sphere", 8, 2.0), ("sphere", 32, 2.0), ("torus", 16, 1.25), ("torus", 32, 1.7)])
def test_coarse_meshes_are_nearer_to_the_fine_ones(name, rings, least):
    """By a factor that is at least so large; at 16 samples, whose noise is the same off and on."""
    make, _ = terminator.SHAPES[name]
    fine, mask, _ = terminator.Render(terminator.MakeStage(make(terminator.FINEST)), False, 16)
    pictures = [terminator.Render(terminator.MakeStage(make(rings)), smooth, 16) for smooth in (False, True)]
    inner = terminator.Inner([mask] + [one[1] for one in pictures])
    assert inner.sum() > 1000
    off, on = (np.sqrt(((one[0] - fine)[inner] ** 2).mean()) for one in pictures)
    assert off > least * on, (off, on)


def _Render(stage, smooth, **settings):
    renderer = hdstream.Renderer(stage, onWarning=lambda line: None)
    return renderer.Render(1.0, **{**terminator.SETTINGS, **dict(samples=4, noCache=True, smoothTerminator=smooth), **settings}).aovs["color"]


@pytest.mark.parametrize("kind", ["flat", "hollow"])
def test_what_has_nothing_to_smooth_is_where_it_was(kind):
    """Meshes without normals, and the inner side of a bowl, whose surface lies in front of that of its normals."""
    stage = terminator.MakeStage(shapes.Sphere(1.0, 12, 24))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Shape"))
    mesh.CreateDoubleSidedAttr(True)
    if kind == "flat":
        mesh.GetNormalsAttr().Clear()
    else:
        camera = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Camera"))
        camera.ClearXformOpOrder()
        camera.AddTranslateOp(opSuffix="in").Set(Gf.Vec3d(0, 0, 0.3))
        stage.RemovePrim("/World/Sun")
        author.AddLight(stage, "/World/Lamp", "Sphere", intensity=3.0, radius=0.2)
    off, on = _Render(stage, False, samples=16), _Render(stage, True, samples=16)
    assert off[..., :3].max() > 0.05, "the test would show little"
    assert np.abs(off - on).max() < 1e-4 * off.max()  # other programs of the device's compiler, the same numbers


def test_a_furnace_stays_white():
    """Where a white ball is seen from the front it is as bright as the room around it, and its facets hide nothing of that."""
    stage = terminator.MakeStage(shapes.Sphere(1.0, 8, 16))
    stage.RemovePrim("/World/Sun")
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    white = author.AddMaterial(stage, "/World/White", diffuseColor=(1.0, 1.0, 1.0), ior=1.0, specularColor=(0.0, 0.0, 0.0),
                               useSpecularWorkflow=1)
    author.Bind(stage.GetPrimAtPath("/World/Shape"), white)
    middle = slice(terminator.SIZE // 2 - 20, terminator.SIZE // 2 + 20)
    off, on = (_Render(stage, smooth, samples=64)[middle, middle, :3].mean() for smooth in (False, True))
    assert abs(on - 1.0) < 1e-3
    assert off < 1.0 - 2e-3, "the test would show little"
