# SPDX-License-Identifier: Apache-2.0
"""`frame` and `time`: what they give at frames of one stage, as constants and in programs, by closed forms."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdShade

hdstream = pytest.importorskip("hdstream")

from stages import author, shapes
from stages.materialX import AddNode

_T = Sdf.ValueTypeNames
_SETTINGS = dict(imageWidth=4, imageHeight=2, samples=1, maxDepth=0, camera="/World/Camera")
_S = 0.25
_FRAMES = (1.0, 36.5, 1001.25)
_FPS = 25.0
_SCALE = 2.0**-10  # so that emissions are no large numbers


def _Stage(isProgram):
    """A card that glows with (frame, frame * s, seconds) * _SCALE. s is _S: a texture coordinate, so that a program computes
    the product, or a constant."""
    stage = Usd.Stage.CreateInMemory()
    path = "/World/Look"
    material = UsdShade.Material.Define(stage, path)
    frame, out = AddNode(stage, f"{path}/Frame", "ND_frame_float", _T.Float)
    time, _ = AddNode(stage, f"{path}/Time", "ND_time_float", _T.Float, fps=_FPS)
    product, _ = AddNode(stage, f"{path}/Product", "ND_multiply_float", _T.Float)
    product.CreateInput("in1", _T.Float).ConnectToSource(frame.ConnectableAPI(), out)
    if isProgram:
        st, _ = AddNode(stage, f"{path}/St", "ND_texcoord_vector2", _T.Float2)
        s, _ = AddNode(stage, f"{path}/S", "ND_dotproduct_vector2", _T.Float)
        s.CreateInput("in1", _T.Float2).ConnectToSource(st.ConnectableAPI(), out)
        s.CreateInput("in2", _T.Float2).Set((1.0, 0.0))
        product.CreateInput("in2", _T.Float).ConnectToSource(s.ConnectableAPI(), out)
    else:
        product.CreateInput("in2", _T.Float).Set(_S)
    color, _ = AddNode(stage, f"{path}/Color", "ND_combine3_color3")
    for name, source in (("in1", frame), ("in2", product), ("in3", time)):
        color.CreateInput(name, _T.Float).ConnectToSource(source.ConnectableAPI(), out)
    surface, _ = AddNode(stage, f"{path}/Surface", "ND_surface_unlit", _T.Token, emission=_SCALE)
    surface.CreateInput("emission_color", _T.Color3f).ConnectToSource(color.ConnectableAPI(), out)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.ConnectableAPI(), out)
    plane = shapes.Plane(4, 4)
    plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, np.tile([_S, 0.75], (4, 1)))
    author.AddMesh(stage, "/World/Card", plane, material=material, rotate=(90, 0, 0))
    author.AddCamera(stage, eye=(0, 0, 5), width=20.0, aspect=2.0, orthographic=True)
    return stage


def _Pixels(renderer, timeCode):
    return renderer.Render(timeCode, **_SETTINGS).aovs["color"][..., :3].reshape(-1, 3)


def _Expected(frame, fps=_FPS):
    return np.tile(np.array([frame, frame * _S, frame / fps]) * _SCALE, (8, 1))


@pytest.mark.parametrize("isProgram", (False, True))
def test_each_frame_of_a_stage_has_its_values(isProgram):
    """Nothing else in the stage varies in time."""
    warnings = []
    renderer = hdstream.Renderer(_Stage(isProgram), onWarning=warnings.append)
    for frame in (*_FRAMES, _FRAMES[0]):
        assert _Pixels(renderer, frame) == pytest.approx(_Expected(frame), rel=1e-5)
    assert warnings == []


def test_edits_of_the_material_keep_the_frame():
    stage = _Stage(True)
    renderer = hdstream.Renderer(stage)
    _Pixels(renderer, 36.5)
    UsdShade.Shader.Get(stage, "/World/Look/Time").GetInput("fps").Set(30.0)
    assert _Pixels(renderer, 36.5) == pytest.approx(_Expected(36.5, 30.0), rel=1e-5)


def test_the_default_time_is_no_frame():
    warnings = []
    renderer = hdstream.Renderer(_Stage(False), onWarning=warnings.append)
    assert np.all(_Pixels(renderer, Usd.TimeCode.Default()) == 0.0)
    assert sum("the frame, which is not known" in line for line in warnings) == 1
