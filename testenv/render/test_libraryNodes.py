# SPDX-License-Identifier: Apache-2.0
"""Nodes that MaterialX's library builds of others, geometry, and slopes of heights: a card for each, in one picture.

Oracles: the library's own node graphs, evaluated in numpy (nodeGraphs.py); noise by cells from the GLSL text of MaterialX
1.39, compiled apart from us; closed forms for geometry and slopes. A card glows with what a node gives.
"""

import numpy as np
import pytest
from pxr import Sdf, UsdLux, UsdShade

pytest.importorskip("hdstream._core")
pytest.importorskip("MaterialX")

from cardStrip import Strip
from flakes import Flake
from nodeGraphs import Value
from stages import author, imageFile
from stages.materialX import STANDARD, AddNode

_T = Sdf.ValueTypeNames
_KELVINS = (2000, 3200, 6500, 10000)
_A, _B = (0.2, 0.5, 0.8), (0.6, 0.3, 0.1)
_FRONT, _BACK = (0.2, 0.5, 0.8, 0.4), (0.6, 0.3, 0.1, 0.7)
_ST = (0.3, 0.7)
_UP, _SIDE = (0.0, 0.0, 1.0), (0.48, 0.6, 0.64)
_LIGHT = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])


def _Rotate(x, bits):
    return (x << bits | x >> (32 - bits)) & 0xFFFFFFFF


def _CellNoise(inputs):
    """Jenkins' lookup3 of two integers."""
    x, y = (int(np.floor(v)) & 0xFFFFFFFF for v in inputs["texcoord"].astype(np.float32))
    start = (0xDEADBEEF + 8 + 13) & 0xFFFFFFFF
    v = [(start + x) & 0xFFFFFFFF, (start + y) & 0xFFFFFFFF, start]
    for k, bits in zip((2, 0, 1, 2, 0, 1, 2), (14, 11, 25, 16, 4, 14, 24)):
        other = v[k - 1]
        v[k] = ((v[k] ^ other) - _Rotate(other, bits)) & 0xFFFFFFFF
    return np.array([v[2] / 0xFFFFFFFF])


def _Image(inputs):
    """The images of triplanarprojection: s, t and a share of its own."""
    share = {"x.exr": 0.2, "y.exr": 0.5, "z.exr": 0.9}[inputs["file"]]
    return np.array([*(inputs["texcoord"] % 1), share])


def _HextileTiles(inputs, st=_ST):
    """By Mikkelsen 2022 and the text of MaterialX's hextiledimage, with matrices: (angle, place) and weight of each tile."""
    size = 2 * np.sqrt(3)
    toGrid = np.array([[1, -0.57735027], [0, 1.15470054]])
    grid = toGrid @ (np.asarray(st) * inputs["tiling"] * size)
    x, y = grid - np.floor(grid)
    if x + y < 1:
        tiles = [((0, 0), 1 - x - y), ((0, 1), y), ((1, 0), x)]
    else:
        tiles = [((1, 1), x + y - 1), ((1, 0), 1 - y), ((0, 1), 1 - x)]
    places = []
    for offset, _ in tiles:
        cell = np.floor(grid) + offset
        center = np.linalg.inv(toGrid) @ (cell / size)
        p = np.modf((cell + 0.12345)[[0, 1, 0]] * (0.1031, 0.1030, 0.0973))[0] % 1
        p = p + p @ (p[[1, 2, 0]] + 33.33)
        random = (p[0] + p[1:]) * p[[2, 1]] % 1
        angle = np.radians(inputs["rotationrange"][0] + np.ptp(inputs["rotationrange"]) * random[0] * inputs["rotation"])
        scale = 1 + inputs["scale"] * (inputs["scalerange"][0] + np.ptp(inputs["scalerange"]) * random[1] - 1)
        move = inputs["offsetrange"][0] + np.ptp(inputs["offsetrange"]) * random * inputs["offset"]
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        place = turned @ (np.asarray(st) * inputs["tiling"] - center) / scale + center + move
        places.append((angle, place))
    return places, [weight for _, weight in tiles]


def _Gained(weights, falloff):
    """Of the sum 1, by Schlick's gain."""
    weights = weights / weights.sum()
    a = (1 / falloff - 2) * (1 - 2 * weights)
    weights = np.where(weights < 0.5, weights / (a + 1), (a - weights) / (a - 1))
    return weights / weights.sum()


def _Hextiled(inputs):
    tiles, weights = _HextileTiles(inputs)
    colors = np.array([_Image(dict(file=inputs["file"], texcoord=place)) for _, place in tiles])
    lights = 1 - inputs["falloffcontrast"] + inputs["falloffcontrast"] * (colors @ inputs["lumacoeffs"])
    return _Gained(lights * np.array(weights) ** 7, inputs["falloff"]) @ colors


def _Tiles(**inputs):
    given = dict(file="z.exr", tiling=(1.3, 0.9), rotation=0.2, rotationrange=(0.0, 360.0), scale=0.5, scalerange=(0.5, 2.0), offset=1.0,
                 offsetrange=(0.0, 1.0), falloff=0.5, falloffcontrast=0.5, lumacoeffs=(0.2722287, 0.6740818, 0.0536895))
    given.update(inputs)
    return _Hextiled({name: value if isinstance(value, str) else np.asarray(value) for name, value in given.items()}), \
        "hextiledimage", "color3", given


def _Product(*cases):
    """The product of cases of colors: more values that are used again than the machine has registers."""
    (value, *source), *others = cases
    source = tuple(source)
    for other, *its in others:
        value, source = value * other, ("multiply", "color3", dict(in1=source, in2=tuple(its)))
    return value, *source


def _HextiledNormal(inputs, st=_ST):
    """By the text of MaterialX's hextilednormalmap, with a normal along z; in tangent space."""
    tiles, weights = _HextileTiles(inputs, st)
    weights = _Gained(np.array([weight**7 for weight in weights]), inputs["falloff"])
    slope = np.zeros(2)
    for (angle, place), weight in zip(tiles, weights):
        normal = 2 * _Image(dict(file=inputs["file"], texcoord=place)) - 1
        normal[1] *= -1 if inputs["flip_g"] else 1
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ normal[:2]
        slope += weight * inputs["strength"] * turned / abs(normal[2])
    result = np.array([*slope, 1.0])
    return result / np.linalg.norm(result)


def _TiledNormal(**inputs):
    given = dict(file="z.exr", tiling=(1.3, 0.9), rotation=0.2, rotationrange=(0.0, 360.0), scale=0.5, scalerange=(0.5, 2.0), offset=1.0,
                 offsetrange=(0.0, 1.0), falloff=0.5, strength=0.5, flip_g=False)
    given.update(inputs)
    return _HextiledNormal({name: value if isinstance(value, str) else np.asarray(value) for name, value in given.items()}), \
        "hextilednormalmap", "vector3", given


_FLAKES = dict(size=0.35, roughness=0.6, coverage=0.8)


def _Flakes(output):
    """Of flake3d, at places with a flake and without."""
    for number, place in enumerate(np.random.default_rng(4).uniform(-3, 3, (12, 3)).astype(np.float32)):
        place = tuple(map(float, place))
        yield f"flake3d_{output}_{number}", (Flake(place, **_FLAKES)[output], "flake3d", "", dict(position=place, output=output, **_FLAKES))


def _Graph(category, types, **inputs):
    """A case whose value its node graph gives."""
    given = {name: _ST if value == "ST" else value for name, value in inputs.items()}
    own = {} if "normal" in inputs or "position" in inputs or "in" in inputs else {"texcoord": _ST}
    leaves = {"cellnoise2d": _CellNoise, "image": _Image,
              "over": lambda i: (i["fg"] + i["bg"] * (1 - i["fg"][3])) * i["mix"] + i["bg"] * (1 - i["mix"])}
    return Value(category, types, leaves, **{**own, **given}), category, types, inputs


def _Value(category, inputs):
    """A case of a node that looks along -z at a card that faces it."""
    up = {"normal": lambda i: np.array(_UP), "viewdirection": lambda i: -np.array(_UP),
          "reflect": lambda i: i["in"] - 2 * (i["normal"] @ i["in"]) * i["normal"]}
    return Value(category, "", up, **inputs), category, "", inputs


def _Ramp(**inputs):
    return _Graph("ramp", "", num_intervals=4, interval2=0.3, interval3=0.6, color1=_BACK, color2=_FRONT,
                  color3=(0.9, 0.1, 0.4, 1.0), color4=(0.0, 0.7, 0.3, 1.0), **inputs)


def _Tiled(category, **inputs):
    """A tiled shape at several places, some inside and some outside."""
    for number, move in enumerate(((0.0, 0.0), (0.2, 0.45), (-0.35, 0.3), (0.4, 0.65), (0.1, -0.2))):
        for isStaggered in (False, True):
            yield (f"{category}_{number}{'_staggered' * isStaggered}",
                   _Graph(category, "color3", uvtiling=(2.0, 1.7), uvoffset=move, staggered=isStaggered, **inputs))


def _Shapes():
    """Shapes whose centres lie at several places around the point."""
    for number, center in enumerate(((0.3, 0.7), (0.1, 0.4), (0.55, 0.9), (0.72, 0.7), (0.3, 0.25), (0.05, 0.4))):
        for category in ("hexagon", "cloverleaf"):
            yield f"{category}_{number}", _Graph(category, "float", center=center, radius=0.4)


_SPACES = ("g18_rec709", "g22_rec709", "rec709_display", "acescg", "g22_ap1", "srgb_texture", "lin_adobergb", "adobergb",
           "srgb_displayp3", "lin_displayp3")
_M33 = np.array([[0.9, 0.2, 0.1], [0.1, 0.7, 0.3], [0.05, 0.4, 1.1]])
_M44 = np.vstack([np.hstack([_M33, np.zeros((3, 1))]), [0.1, 0.2, 0.05, 1.0]])
_ROWS33 = {f"in{k + 1}": tuple(row) for k, row in enumerate(_M33)}
_NODE33 = ("creatematrix", "vector3_matrix33", _ROWS33)
_NODE44 = ("creatematrix", "vector4_matrix44", {f"in{k + 1}": tuple(row) for k, row in enumerate(_M44)})
_N33 = np.array([[0.8, 0.1, 0.3], [0.2, 0.9, 0.1], [0.3, 0.2, 0.7]])
_OTHER33 = ("creatematrix", "vector3_matrix33", {f"in{k + 1}": tuple(row) for k, row in enumerate(_N33)})
_MATRICES = {
    "transformmatrix": (_A @ _M33, "transformmatrix", "vector3", dict(mat=_NODE33, **{"in": _A})),
    "transformmatrix_transposed": (_M33 @ _A, "transformmatrix", "vector3",
                                   dict(mat=("transpose", "matrix33", {"in": _NODE33}), **{"in": _A})),
    "transformmatrix_inverse": (_M33.T @ np.linalg.inv(_M33), "transformmatrix", "vector3", dict(
        mat=("invertmatrix", "matrix33", {"in": _NODE33}), **{"in": tuple(_M33.T[0])})),
    "transformmatrix_point": (np.array([*_A, 1]) @ _M44, "transformmatrix", "vector3M4", dict(mat=_NODE44, **{"in": _A})),
    "transformmatrix_inversePoint": (np.array([*_A, 1]) @ np.linalg.inv(_M44), "absval", "vector3", {"in": (
        "transformmatrix", "vector3M4", dict(mat=("invertmatrix", "matrix44", {"in": _NODE44}), **{"in": _A}))}),
    "determinant": (np.linalg.det(_M33), "determinant", "matrix33", {"in": _NODE33}),
    "determinant_44": (np.linalg.det(_M44), "determinant", "matrix44", {"in": _NODE44}),
    "transformmatrix_multiply": (_A @ _M33 @ _N33, "transformmatrix", "vector3", dict(
        mat=("multiply", "matrix33", dict(in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "transformmatrix_divide": (_A @ _M33 @ np.linalg.inv(_N33), "transformmatrix", "vector3", dict(
        mat=("divide", "matrix33", dict(in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "transformmatrix_multiply44": (np.array([*_A, 1]) @ _M44 @ _M44.T, "transformmatrix", "vector3M4", dict(
        mat=("multiply", "matrix44", dict(in1=_NODE44, in2=("transpose", "matrix44", {"in": _NODE44}))), **{"in": _A})),
    "transformmatrix_add": (_A @ (_M33 + _N33), "transformmatrix", "vector3", dict(
        mat=("add", "matrix33", dict(in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "transformmatrix_addNumber": (_A @ (_M33 + 0.2), "transformmatrix", "vector3", dict(
        mat=("add", "matrix33FA", dict(in1=_NODE33, in2=0.2)), **{"in": _A})),
    "transformmatrix_subtract": (_A @ (_M33 - 0.1 * _N33), "transformmatrix", "vector3", dict(
        mat=("subtract", "matrix33", dict(in1=_NODE33, in2=("creatematrix", "vector3_matrix33", {
            f"in{k + 1}": tuple(0.1 * row) for k, row in enumerate(_N33)}))), **{"in": _A})),
    "transformmatrix_dot": (_A @ _M33, "transformmatrix", "vector3", dict(mat=("dot", "matrix33", {"in": _NODE33}), **{"in": _A})),
    "transformmatrix_ifgreater": (_A @ _N33, "transformmatrix", "vector3", dict(
        mat=("ifgreater", "matrix33", dict(value1=0.2, value2=0.3, in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "transformmatrix_ifequal": (_A @ _M33, "transformmatrix", "vector3", dict(
        mat=("ifequal", "matrix33", dict(value1=0.3, value2=0.3, in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "transformmatrix_switch": (_A @ _N33, "transformmatrix", "vector3", dict(
        mat=("switch", "matrix33", dict(which=1.0, in1=_NODE33, in2=_OTHER33)), **{"in": _A})),
    "extract_matrix": (_M33[1], "extract", "matrix33", {"in": _NODE33, "index": 1}),
    # The shape of the point makes one that no constant folds.
    "determinant_varying": (np.linalg.det([[0.3, 0.7, 0], *_M33[1:]]), "determinant", "matrix33", {"in": (
        "creatematrix", "vector3_matrix33", {**_ROWS33, "in1": ("convert", "vector2_vector3", {"in": ("texcoord", "vector2", {})})})}),
}
_MATRICES["transformmatrix_inverse"] = (_M33.T[0] @ np.linalg.inv(_M33), *_MATRICES["transformmatrix_inverse"][1:])
_MATRICES["transformmatrix_inversePoint"] = (np.abs(_MATRICES["transformmatrix_inversePoint"][0]),
                                             *_MATRICES["transformmatrix_inversePoint"][1:])
_TRIPLANAR = dict(filex="x.exr", filey="y.exr", filez="z.exr", position=(0.3, 0.6, 0.45))
_CASES = {
    "worleynoise2d": (0.600949407, "worleynoise2d", "float", {}),
    "worleynoise2d_solid": (0.86031276, "worleynoise2d", "float", dict(style=1)),
    "worleynoise2d_three": ((0.600949407, 0.632518709, 1.04592454), "worleynoise2d", "vector3", {}),
    "worleynoise2d_threeSolid": ((0.611067653, 0.185823783, 0.0413060673), "worleynoise2d", "vector3", dict(style=1)),
    "worleynoise3d": (0.442312181, "worleynoise3d", "float", dict(position=(0.3, 0.7, 0.2))),
    "worleynoise3d_jitter": ((0.380079895, 0.865686357, 0.955073059), "worleynoise3d", "vector3",
                             dict(position=(0.3, 0.7, 0.2), jitter=0.7)),
    "worleynoise3d_threeSolid": ((0.111572966, 0.325099885, 0.339947283), "worleynoise3d", "vector3",
                                 dict(position=(0.3, 0.7, 0.2), style=1)),
    "fractal2d": (0.259577245, "absval", "float", dict(**{"in": ("fractal2d", "float", {})})),
    "fractal2d_three": ((0.259577245, 1.00612557, 0.112889051), "absval", "color3",
                        dict(**{"in": ("fractal2d", "color3FA", {})})),
    "unifiednoise2d": (0.5 - 0.186872661 / 2, "unifiednoise2d", "float", dict(freq=(2.0, 2.0), offset=(0.25, 0.25))),
    "unifiednoise2d_worley": (0.0520906821, "unifiednoise2d", "float", dict(freq=(2.0, 2.0), offset=(0.25, 0.25), type=2)),
    "unifiednoise2d_fractal": (1 - 0.428980321, "unifiednoise2d", "float",
                               dict(freq=(2.0, 2.0), offset=(0.25, 0.25), type=3, outmin=1.0, outmax=2.0, clampoutput=False)),
    "unifiednoise3d": (0.5 + 0.264776587 / 2, "unifiednoise3d", "float", dict(freq=(2.0,) * 3, position=(0.3, 0.7, 0.2))),
    "unifiednoise3d_cell": (0.819399655, "unifiednoise3d", "float", dict(freq=(2.0,) * 3, position=(0.3, 0.7, 0.2), type=1)),
    "randomfloat": _Graph("randomfloat", "float", seed=3, max=0.5, **{"in": 0.35}),
    "randomcolor": _Graph("randomcolor", "float", seed=5, huelow=0.2, saturationhigh=0.9, **{"in": 0.35}),
    "circle": _Graph("circle", "float", center=(0.1, 0.3)),
    "circle_outside": _Graph("circle", "float", radius=0.4),
    "line": _Graph("line", "float", radius=0.3),
    "line_beside": _Graph("line", "float", radius=0.2),
    "grid": _Graph("grid", "color3", uvtiling=(3.0, 3.0), thickness=0.3),
    "grid_staggered": _Graph("grid", "color3", uvtiling=(3.0, 3.0), thickness=0.3, staggered=True),
    "ramp": _Ramp(),
    "ramp_linear": _Ramp(interpolation=0),
    "ramp_step": _Ramp(interpolation=2, type=2),
    "ramp_radial": _Ramp(type=1),
    "ramp_circular": _Ramp(type=2),
    "ramp_box": _Ramp(type=3),
    "triplanar": _Graph("triplanarprojection", "color3", normal=_SIDE, **_TRIPLANAR),
    "triplanar_up": _Graph("triplanarprojection", "color3", normal=_SIDE, upaxis=1, blend=0.4, **_TRIPLANAR),
    "triplanar_x": _Graph("triplanarprojection", "color3", normal=(0.9, 0.3, 0.2), upaxis=0, **_TRIPLANAR),
    "rotate3d": (Value("rotate3d", "vector3", amount=30.0, axis=(0.2, 1.0, 0.4), **{"in": _A}), "rotate3d", "vector3",
                 dict(amount=30.0, axis=(0.2, 1.0, 0.4), **{"in": _A})),
    "reflect": _Graph("reflect", "vector3", normal=_UP, **{"in": (0.3, 0.4, -0.8)}),
    "refract": _Graph("refract", "vector3", normal=(0.0, 0.0, -1.0), ior=0.7, **{"in": (0.3, 0.4, 0.8660254)}),
    "safepower": _Graph("safepower", "color3FA", in1=_A, in2=0.7),
    "trianglewave": _Graph("trianglewave", "float", **{"in": 2.7}),
    "mincomponent": (min(_A), "mincomponent", "color3", dict(**{"in": _A})),
    "maxcomponent": (max(_A), "maxcomponent", "color3", dict(**{"in": _A})),
    "colorcorrect": _Graph("colorcorrect", "color3", hue=0.2, saturation=0.6, gamma=1.7, lift=0.1, gain=1.5, contrast=1.2,
                           contrastpivot=0.3, exposure=0.5, **{"in": _A}),
    "overlay": _Graph("overlay", "color3", fg=_A, bg=_B, mix=0.8),
    "burn": (1 - (1 - np.array(_A)) / _B * 0.5 - 0.5 * (1 - np.array(_A)), "burn", "color3", dict(fg=_B, bg=_A, mix=0.5)),
    "dodge": (np.array(_A) / (1 - np.array(_B)), "dodge", "color3", dict(fg=_B, bg=_A)),
    "premult": (np.array(_A) * 0.4, "premult", "color4", dict(**{"in": _FRONT})),
    "over": (np.array(_A) + np.array(_B) * 0.6, "over", "color4", dict(fg=_FRONT, bg=_BACK)),
    "in": (np.array(_A) * 0.7, "in", "color4", dict(fg=_FRONT, bg=_BACK)),
    "out": (np.array(_A) * 0.3, "out", "color4", dict(fg=_FRONT, bg=_BACK)),
    "mask": (np.array(_B) * 0.4, "mask", "color4", dict(fg=_FRONT, bg=_BACK)),
    "matte": (np.array(_A) * 0.4 + np.array(_B) * 0.6, "matte", "color4", dict(fg=_FRONT, bg=_BACK)),
    "gltf_colorimage": ((0.75 * 0.2, 0.6 * 0.5, 0.9 * 0.8), "gltf_colorimage", "",
                        dict(file="z.exr", texcoord=(0.25, 0.6), color=(0.2, 0.5, 0.8, 1.0), offset=(0.5, 0.0))),
    "gltf_image": ((0.5 * 0.3, 0.5 * 0.5, 0.9 * 0.7), "gltf_image", "color3_color3_1_0",
                   dict(file="z.exr", texcoord=(0.25, 0.75), scale=(2.0, 2.0), factor=(0.3, 0.5, 0.7))),
    "gltf_normalmap": ((0.5, 0.2, 0.8), "gltf_normalmap", "vector3_1_0", dict(file="z.exr", texcoord=(0.75, 0.6))),
    "gltf_iridescence_thickness": _Graph("gltf_iridescence_thickness", "float_1_0", file="z.exr", texcoord=(0.25, 0.6),
                                         thicknessMin=0.25, thicknessMax=0.75),
    "latlongimage": _Graph("latlongimage", "", file="z.exr", viewdir=(0.48, 0.6, 0.64), rotation=70.0),
    "latlongimage_behind": _Graph("latlongimage", "", file="z.exr", viewdir=(0.48, -0.6, -0.64)),
    "hextiledimage": _Tiles(),
    "hextiledimage_gain": _Tiles(falloff=0.3, falloffcontrast=0.8),
    "hextiledimage_thrice": _Product(_Tiles(), _Tiles(falloff=0.3, falloffcontrast=0.8), _Tiles(rotation=0.7)),
    "hextilednormalmap": _TiledNormal(),
    "hextilednormalmap_gain": _TiledNormal(falloff=0.3, strength=1.5, flip_g=True),
    **dict(_Flakes("presence")), **dict(_Flakes("rand")), **dict(_Flakes("flakenormal")),
    "flake3d_id": (Flake((0.3, 0.2, 0.1), **_FLAKES)["id"] / 16777215, "divide", "float", dict(
        in1=("flake3d", "", dict(position=(0.3, 0.2, 0.1), output="id", **_FLAKES)), in2=16777215.0)),
    "flake2d": (Flake((*_ST, 0.0), **_FLAKES)["rand"], "flake2d", "", dict(output="rand", **_FLAKES)),
    **{f"logical_{name}{a}{b}": (float(value), "convert", "boolean_float",
                                 {"in": (f"logical_{name}", "", dict(in1=bool(a), in2=bool(b)))})
       for a, b in ((0, 0), (0, 1), (1, 1)) for name, value in (("and", a and b), ("or", a or b), ("xor", a != b))},
    "logical_not": (1.0, "convert", "boolean_float", {"in": ("logical_not", "", {"in": False})}),
    **dict(_Shapes()), **dict(_Tiled("tiledcircles")), **dict(_Tiled("tiledhexagons", size=0.7)),
    **dict(_Tiled("tiledcloverleafs", size=0.8)), **dict(_Tiled("crosshatch", thickness=0.3)),
    **{space: _Graph(f"{space}_to_lin_rec709", "color3", **{"in": (0.02, 0.3, 0.8)}) for space in _SPACES},
    **_MATRICES,
    "gooch_shade": (*_Value("gooch_shade", dict(light_direction=(0.2, -0.1, -1.0), shininess=4.0, specular_intensity=0.2)),),
    "disjointover": (np.array(_A) + np.array(_B) * (0.6 / 0.7), "disjointover", "color4", dict(fg=_FRONT, bg=_BACK)),
    "disjointover_apart": (0.5 * (np.array(_A) + 2 * np.array(_B)), "disjointover", "color4",
                           dict(fg=_FRONT, bg=(*_B, 0.5), mix=0.5)),
    "blur": (_A, "blur", "color3", {"in": _A}),
    "anisotropy_image": (0.9 * 0.5, "gltf_anisotropy_image", "", dict(file="z.exr", texcoord=(0.25, 0.6), anisotropy_strength=0.5)),
    "viewdirection": ((0, 0, 1), "absval", "vector3", dict(**{"in": ("viewdirection", "vector3", {})})),
    "facingratio": (1.0, "facingratio", "float", {}),
    "facingratio_inverted": (0.0, "facingratio", "float", dict(invert=True)),
}
# Cards with coordinates 0 to 1 across, which lie along x and y: what depends on how they vary.
_H = ("dotproduct", "vector2", dict(in1=("texcoord", "vector2", {}), in2=(8.0, 4.0)))
_ALONG_X = ("multiply", "float", dict(in1=("extract", "vector3", dict(index=0, **{"in": ("position", "vector3", {})})), in2=8.0))


def _Encoded(x, y):
    return np.array([x, y, 1]) / np.linalg.norm([x, y, 1]) * 0.5 + 0.5


_VARYING = {
    "tangent": ((1, 0, 0), "tangent", "vector3", dict(space="world")),
    "tangent_object": ((1, 0, 0), "tangent", "vector3", {}),
    "bitangent": ((0, 1, 0), "bitangent", "vector3", dict(space="world")),
    "bitangent_object": ((0, 0, 1), "absval", "vector3", dict(**{"in": ("bitangent", "vector3", {})})),
    "flake3d": (Flake((1.3, 2.2, 0.7), **_FLAKES)["rand"], "flake3d", "", dict(output="rand", **_FLAKES, position=(
        "add", "vector3", dict(in1=("multiply", "vector3FA", dict(in1=("position", "vector3", {}), in2=1e-4)), in2=(1.3, 2.2, 0.7))))),
    "heighttonormal": (_Encoded(-0.5, -0.25), "heighttonormal", "vector3", dict(**{"in": _H})),
    "heighttonormal_scale": (_Encoded(-1, -0.5), "heighttonormal", "vector3", dict(scale=2.0, **{"in": _H})),
    "heighttonormal_position": (_Encoded(-0.5, 0), "heighttonormal", "vector3", dict(**{"in": _ALONG_X})),
    "heighttonormal_image": (_Encoded(-0.5, 0), "heighttonormal", "vector3", dict(
        **{"in": ("multiply", "float", dict(in1=("image", "float", dict(file="z.exr")), in2=8.0))})),
    "heighttonormal_placed": (_Encoded(-1, -0.5), "heighttonormal", "vector3", dict(
        texcoord=("multiply", "vector2FA", dict(in1=("texcoord", "vector2", {}), in2=0.5)), **{"in": _H})),
    "heighttonormal_constant": ((0.5, 0.5, 1), "heighttonormal", "vector3", dict(**{"in": 0.7})),
}


def _Output(category, types):
    if category == "determinant":
        return _T.Float
    return {"float": _T.Float, "vector2": _T.Float2, "vector2FA": _T.Float2}.get(types, _T.Color3f)


def _Node(stage, path, folder, category, types, inputs):
    values = {}
    for name, value in inputs.items():
        if isinstance(value, tuple) and isinstance(value[0], str):
            value = _Node(stage, f"{path}_{name}", folder, *value)
        elif isinstance(value, str) and value.endswith(".exr"):
            value = Sdf.AssetPath(str(folder / value))
        values[name] = value
    output = values.pop("output", None)
    node, out = AddNode(stage, path, f"ND_{category}_{types}" if types else f"ND_{category}", _Output(category, types), **values)
    if output is not None:
        node.CreateOutput(output, _T.Vector3f if output == "flakenormal" else _T.Float)
        return node, output
    if category == "gltf_anisotropy_image":
        node.CreateOutput("anisotropy_strength_out", _T.Float)
        return node, "anisotropy_strength_out"
    if category == "gltf_colorimage":
        node.CreateOutput("outcolor", _T.Color3f)
        return node, "outcolor"
    if types == "color4" or category == "ramp":
        return AddNode(stage, path + "_rgb", "ND_convert_color4_color3", **{"in": (node, out)})
    return node, out


def _Glowing(folder, case):
    def Build(card):
        stage, root = card.material.GetPrim().GetStage(), str(card.material.GetPath())
        source = _Node(stage, f"{root}/Node", folder, *case[1:])
        surface, _ = AddNode(stage, f"{root}/Unlit", "ND_surface_unlit", _T.Token, emission_color=source)
        card.material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))

    return Build


# Bumps: (tangent-space normal, what feeds the surface's normal).
_BUMPS = {
    "none": ((0, 0, 1), None),
    "bump": ((-0.5, -0.25, 1), ("bump", "vector3", dict(height=_H))),
    "bump_scale": ((-0.15, -0.075, 1), ("bump", "vector3", dict(height=_H, scale=0.3))),
    "heighttonormal": ((-0.5, -0.25, 1), ("normalmap", "", dict(**{"in": ("heighttonormal", "vector3", dict(**{"in": _H}))}))),
    "flakes": (Flake((1.3, 2.2, 0.7), **_FLAKES)["flakenormal"], ("flake3d", "", dict(position=(1.3, 2.2, 0.7), output="flakenormal", **_FLAKES))),
    "hextilednormalmap": (_TiledNormal()[0], ("hextilednormalmap", "vector3", dict(_TiledNormal()[3], texcoord=_ST))),
    "bump_image": ((-0.5, 0, 1), ("bump", "vector3", dict(height=_VARYING["heighttonormal_image"][3]["in"]))),
}


def _Bumped(folder, source):
    def Build(card):
        stage, root = card.material.GetPrim().GetStage(), str(card.material.GetPath())
        inputs = dict(base=1.0, base_color=(0.8,) * 3, specular=0.0)
        if source is not None:
            inputs["normal"] = _Node(stage, f"{root}/Node", folder, *source)
        surface, _ = AddNode(stage, f"{root}/Surface", STANDARD, _T.Token, **inputs)
        card.material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))

    return Build


def _WriteImages(folder) -> None:
    t, s = (np.indices((256, 256)) + 0.5) / 256
    for name in ("x.exr", "y.exr", "z.exr"):
        share = _Image(dict(file=name, texcoord=np.zeros(2)))[2]
        imageFile.WriteExr(folder / name, dict(R=s, G=1 - t, B=np.full_like(s, share)), half=False)


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    _WriteImages(folder)
    result = Strip(folder / "strip.usda")
    for name, case in _CASES.items():
        result.Add(name, _Glowing(folder, case), st=_ST)
    for kelvin in _KELVINS:
        result.Add(f"blackbody {kelvin}", _Glowing(folder, (0, "blackbody", "", dict(temperature=float(kelvin)))))
    for name, case in _VARYING.items():
        result.Add(f"varying {name}", _Glowing(folder, case))
    result.Add("facingratio_tilted", _Glowing(folder, (0, "facingratio", "float", {})), tilt=60.0)
    return result.Render()


@pytest.fixture(scope="module")
def bumps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bumps")
    _WriteImages(folder)
    result = Strip(folder / "strip.usda")
    for name, (_, source) in _BUMPS.items():
        result.Add(name, _Bumped(folder, source))
    elevation, azimuth = np.degrees(np.arcsin(_LIGHT[1])), np.degrees(np.arctan2(_LIGHT[0], _LIGHT[2]))
    author.AddLight(result.stage, "/World/Sun", "Distant", dict(rotate=(-elevation, azimuth, 0)), angle=0.0, intensity=1.0)
    return result.Render()


@pytest.mark.parametrize("name", _CASES)
def test_node(strip, name):
    expected = np.asarray(_CASES[name][0], float)[..., :3] if np.ndim(_CASES[name][0]) else _CASES[name][0]
    expected = np.maximum(np.broadcast_to(expected if np.size(expected) > 1 else np.ravel(expected)[0], 3), 0)
    isImage = name.startswith(("triplanar", "gltf", "latlong", "hextiled", "anisotropy"))  # texels are kept in half precision
    assert strip.Pixels(name)[:, :3] == pytest.approx(np.tile(expected, (4, 1)), abs=5e-4 if isImage else 3e-5), name


@pytest.mark.parametrize("name", _VARYING)
def test_geometry_and_slopes(strip, name):
    expected = np.broadcast_to(np.asarray(_VARYING[name][0], float), 3)
    assert strip.Pixels(f"varying {name}")[:, :3] == pytest.approx(np.tile(expected, (4, 1)), abs=5e-4), name


@pytest.mark.parametrize("kelvin", _KELVINS)
def test_blackbodies_have_the_colour_of_their_temperature(strip, kelvin):
    """Against UsdLux, which fits Planck's spectra by another curve; the node's own fit is within 3 % of those."""
    color = strip.Pixels(f"blackbody {kelvin}")[0, :3]
    expected = np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin))
    luminance = np.array([0.2126, 0.7152, 0.0722])
    assert color @ luminance == pytest.approx(1.0, abs=2e-3)
    assert color == pytest.approx(expected / (expected @ luminance), abs=0.04)


def test_facingratio_is_the_cosine(strip):
    assert strip.Pixels("facingratio_tilted")[:, :3] == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize("name", _BUMPS)
def test_bumps_turn_the_surface(bumps, name):
    """Lambert's cosine against the light, of the normal by the slopes of the height; the card's tangents are x and y."""
    normal = np.array(_BUMPS[name][0], float)
    cosine = normal @ _LIGHT / np.linalg.norm(normal)
    assert bumps.Pixels(name)[:, :3] == pytest.approx(0.8 / np.pi * cosine, rel=2e-3), name  # irradiance 1


def test_what_is_not_blurred_is_said(tmp_path):
    result = Strip(tmp_path / "strip.usda")
    result.Add("blur", _Glowing(tmp_path, (0, "blur", "color3", {"in": _A, "size": 0.5, "filtertype": "gaussian"})))
    result.Render()
    assert result.Pixels("blur")[:, :3] == pytest.approx(np.tile(_A, (4, 1)), abs=1e-6)
    assert sum("is left out; its input is shown as it is" in line for line in result.picture.warnings) == 1


def test_no_node_warns(strip):
    assert [w for w in strip.picture.warnings if "supported" in w or "cannot" in w] == []
