# SPDX-License-Identifier: Apache-2.0
"""MaterialX's standard nodes: a card for each, all in one picture, against their definitions in numpy.

A card glows with what a node gives (ND_surface_unlit) and has the same coordinates everywhere. Inputs that count are
read from primvars, so that programs compute them; `[folded]` has the same nodes with constants, which the host folds.
Noise: values of the GLSL text of MaterialX 1.39, compiled apart from us. docs/materials.md lists the nodes.
"""

import colorsys

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

from cardStrip import Strip
from stages.materialX import AddNode

_T = Sdf.ValueTypeNames
_TYPES = {1: ("float", _T.Float), 2: ("vector2", _T.Float2), 3: ("color3", _T.Color3f)}
_A, _B, _X, _Y = np.array([0.2, 0.5, 0.8]), np.array([0.6, 0.3, 0.1]), 0.35, 0.7
_ST = (0.3, 0.7)
_LUMA = np.array([0.2722287, 0.6740818, 0.0536895])


def _Smooth(t):
    t = np.clip(t, 0, 1)
    return t * t * (3 - 2 * t)


def _Hsv(color):
    return np.array(colorsys.rgb_to_hsv(*color))


def _Turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([c * _ST[0] + s * _ST[1], -s * _ST[0] + c * _ST[1]])


def _Chain(name: str, count: int = 24):
    """A chain of mixes in which each takes the one before as its input `name`: (expected, category, types, inputs)."""
    expected, inputs = _A, "A"
    for i in range(count):
        others = dict(fg="B", bg="A", mix=0.9 if i % 2 else 0.6)
        values = {**dict(fg=_B, bg=_A, mix=others["mix"]), name: expected}
        expected = values["bg"] + (values["fg"] - values["bg"]) * values["mix"]
        inputs = ("mix", "color3", {**others, name: inputs})
    return expected, *inputs


# name: (expected, category, types, inputs); "A", "B", "X", "Y" name the values above, "ST" the coordinates.
_CASES = {
    "add": (_A + _B, "add", "color3", dict(in1="A", in2="B")),
    "add_scalar": (_A + _X, "add", "color3FA", dict(in1="A", in2="X")),
    "subtract": (_A - _B, "subtract", "color3", dict(in1="A", in2="B")),
    "multiply": (_A * _B, "multiply", "color3", dict(in1="A", in2="B")),
    "divide": (_A / _B, "divide", "color3", dict(in1="A", in2="B")),
    "modulo": (_A % 0.3, "modulo", "color3FA", dict(in1="A", in2=0.3)),
    "power": (_A**_Y, "power", "color3FA", dict(in1="A", in2="Y")),
    "min": (np.minimum(_A, _B), "min", "color3", dict(in1="A", in2="B")),
    "max": (np.maximum(_A, _B), "max", "color3", dict(in1="A", in2="B")),
    "sqrt": (np.sqrt(_A), "sqrt", "color3", dict(**{"in": "A"})),
    "exp": (np.exp(_A), "exp", "color3", dict(**{"in": "A"})),
    "sin": (np.sin(_A), "sin", "color3", dict(**{"in": "A"})),
    "acos": (np.arccos(_X), "acos", "float", dict(**{"in": "X"})),
    "atan2": (np.arctan2(_X, _Y), "atan2", "float", dict(iny="X", inx="Y")),
    "floor": (np.floor(_A * 10) / 10, "multiply", "color3FA", dict(in1=("floor", "color3", dict(
        **{"in": ("multiply", "color3FA", dict(in1="A", in2=10.0))})), in2=0.1)),
    "invert": (1 - _A, "invert", "color3", dict(**{"in": "A"})),
    "mix": (_B + (_A - _B) * _X, "mix", "color3", dict(fg="A", bg="B", mix="X")),
    "mix_chain": _Chain("fg"),
    "mix_chain_back": _Chain("bg"),
    "mix_color": (_B + (_A - _B) * _A, "mix", "color3_color3", dict(fg="A", bg="B", mix="A")),
    "clamp": (np.clip(_A, 0.3, 0.6), "clamp", "color3FA", dict(low=0.3, high=0.6, **{"in": "A"})),
    "smoothstep": (_Smooth((_X - 0.2) / 0.6), "smoothstep", "float", dict(low=0.2, high=0.8, **{"in": "X"})),
    "remap": (1 + (_A - 0.1) / 0.4 * 2, "remap", "color3FA",
              dict(inlow=0.1, inhigh=0.5, outlow=1.0, outhigh=3.0, **{"in": "A"})),
    "range_gamma": (_X**0.5, "range", "float", dict(gamma=2.0, **{"in": "X"})),
    "contrast": ((_A - 0.4) * 2 + 0.4, "contrast", "color3FA", dict(amount=2.0, pivot=0.4, **{"in": "A"})),
    "luminance": (np.full(3, _A @ _LUMA), "luminance", "color3", dict(**{"in": "A"})),
    "saturate": (_A @ _LUMA * 0.5 + _A * 0.5, "saturate", "color3", dict(amount=0.5, **{"in": "A"})),
    "dotproduct": (_A @ _B, "dotproduct", "vector3", dict(in1="A", in2="B")),
    "crossproduct": (np.abs(np.cross(_A, _B)), "absval", "vector3",
                     dict(**{"in": ("crossproduct", "vector3", dict(in1="A", in2="B"))})),
    "normalize": (_A / np.linalg.norm(_A), "normalize", "vector3", dict(**{"in": "A"})),
    "magnitude": (np.linalg.norm(_A), "magnitude", "vector3", dict(**{"in": "A"})),
    "magnitude2": (np.hypot(*_ST), "magnitude", "vector2", dict(**{"in": "ST"})),
    "rgbtohsv": (_Hsv(_A), "rgbtohsv", "color3", dict(**{"in": "A"})),
    "hsvtorgb": (np.array(colorsys.hsv_to_rgb(*_A)), "hsvtorgb", "color3", dict(**{"in": "A"})),
    "combine": ((_X, _Y, 0.5), "combine3", "color3", dict(in1="X", in2="Y", in3=0.5)),
    "extract": (_A[1], "extract", "color3", dict(index=1, **{"in": "A"})),
    "swizzle": (_A[[2, 0, 0]], "swizzle", "color3_color3", dict(channels="brr", **{"in": "A"})),
    "convert": (np.full(3, _X), "convert", "float_color3", dict(**{"in": "X"})),
    "ifgreater": (_A, "ifgreater", "color3", dict(value1="Y", value2="X", in1="A", in2="B")),
    "ifgreater_not": (_B, "ifgreater", "color3", dict(value1="X", value2="Y", in1="A", in2="B")),
    "ifequal": (_A, "ifequal", "color3", dict(value1="X", value2="X", in1="A", in2="B")),
    "switch": (_B, "switch", "color3", dict(which=1.0, in1="A", in2="B", in3=(0.0, 0.0, 0.0))),
    "screen": (1 - (1 - _A) * (1 - _B), "screen", "color3", dict(fg="A", bg="B")),
    "ramplr": (_A + (_B - _A) * _ST[0], "ramplr", "color3", dict(valuel="A", valuer="B")),
    "ramptb": (_B + (_A - _B) * _ST[1], "ramptb", "color3", dict(valuet="A", valueb="B")),
    "ramp4": (0.7 * (0.7 * _A + 0.3 * _B) + 0.3 * (0.7 * 0.5 + 0.3 * _X), "ramp4", "color3",
              dict(valuetl="A", valuetr="B", valuebl=(0.5,) * 3, valuebr=(_X,) * 3)),
    "splitlr": (_A, "splitlr", "color3", dict(valuel="A", valuer="B", center=0.5)),
    "checkerboard": (_A, "checkerboard", "color3", dict(color1="A", color2="B", uvtiling=(4.0, 4.0))),
    "texcoord": ((*_ST, 0), "convert", "vector2_vector3", dict(**{"in": "ST"})),
    "rotate2d": ((*_Turned(-20), 0), "convert", "vector2_vector3",
                 dict(**{"in": ("rotate2d", "vector2", dict(amount=-20.0, **{"in": "ST"}))})),
    "place2d": ((*(_Turned(-20) / 0.5 + 1), 0), "convert", "vector2_vector3",
                dict(**{"in": ("place2d", "vector2", dict(rotate=-20.0, scale=(0.5, 0.5), offset=(-1.0, -1.0)))})),
    "noise2d": (0.040743679 * 0.5 + 0.5, "noise2d", "float", dict(amplitude=0.5, pivot=0.5)),
    "noise2d_color": (np.array([0.040743679, 0.65101218, -0.30239031]) * 0.5 + 0.5, "noise2d", "color3FA",
                      dict(amplitude=0.5, pivot=0.5)),
    "noise3d": (0.27371189 * 0.5 + 0.5, "noise3d", "float", dict(amplitude=0.5, pivot=0.5, position=(0.3, 0.7, 0.2))),
    "fractal3d": (0.48179933, "fractal3d", "float", dict(position=(0.3, 0.7, 0.2))),
    "cellnoise2d": (0.86031276, "cellnoise2d", "float", {}),
    "normal": ((0, 0, 1), "normal", "vector3", dict(space="world")),
}


def _Value(stage, path, value, folded):
    """A node's input: a constant, a primvar's value, coordinates, or a node of its own."""
    known = {"A": _A, "B": _B, "X": _X, "Y": _Y}
    if value == "ST":
        return AddNode(stage, path, "ND_texcoord_vector2", _T.Float2)
    if isinstance(value, str) and value in known:
        number = known[value]
        if folded:
            return tuple(number) if np.ndim(number) else float(number)
        kind, output = _TYPES[np.size(number)]
        return AddNode(stage, path, f"ND_geompropvalue_{kind}", output, geomprop=f"pattern{value}")
    if isinstance(value, tuple) and isinstance(value[0], str):
        return _Node(stage, path, value, folded)
    return value


def _Node(stage, path, case, folded):
    category, types, inputs = case
    values = {name: _Value(stage, f"{path}_{name}", value, folded) for name, value in inputs.items()}
    return AddNode(stage, path, f"ND_{category}_{types}", **values)


def _Build(case, folded):
    def Build(card):
        stage, root = card.material.GetPrim().GetStage(), str(card.material.GetPath())
        source = _Node(stage, f"{root}/Node", case[1:], folded)
        surface, _ = AddNode(stage, f"{root}/Unlit", "ND_surface_unlit", _T.Token, emission_color=source)
        card.material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))
        api = UsdGeom.PrimvarsAPI(card.mesh)
        for name, number in {"A": _A, "B": _B, "X": _X, "Y": _Y}.items():
            kind = _T.Color3f if np.ndim(number) else _T.Float
            api.CreatePrimvar(f"pattern{name}", kind, "constant").Set(
                tuple(map(float, number)) if np.ndim(number) else float(number))

    return Build


@pytest.fixture(scope="module", params=["computed", "folded"])
def strip(request, tmp_path_factory):
    result = Strip(tmp_path_factory.mktemp("patterns") / "strip.usda")
    for name, case in _CASES.items():
        result.Add(name, _Build(case, request.param == "folded"), st=_ST)
    return result.Render()


@pytest.mark.parametrize("name", _CASES)
def test_node(strip, name):
    pixels = strip.Pixels(name)[:, :3]
    expected = np.maximum(np.broadcast_to(np.asarray(_CASES[name][0], float), 3), 0)  # emission is never negative
    assert pixels == pytest.approx(np.tile(expected, (4, 1)), abs=2e-5), name


def test_no_node_warns(strip):
    assert [w for w in strip.picture.warnings if "is not supported" in w] == []


def test_unknown_nodes_warn_once_with_their_name(tmp_path):
    strip = Strip(tmp_path / "unknown.usda")
    strip.Add("unknown", _Build((0, "ours2d", "float", {}), False), st=_ST)
    warnings = [w for w in strip.Render().picture.warnings if "ours2d" in w]
    assert len(warnings) == 1 and "/World/M0/Node" in warnings[0]
