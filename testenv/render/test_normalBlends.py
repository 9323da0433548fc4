# SPDX-License-Identifier: Apache-2.0
"""Networks that blend normal maps, also with the surface's own normal, are the map that has the blend in its texels."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Gf, Sdf, UsdShade
from stages import author, imageFile, shapes
from stages.materialX import AddNode, AddSurface

_VECTOR, _FLOAT = Sdf.ValueTypeNames.Vector3f, Sdf.ValueTypeNames.Float
_A, _B = np.array((0.6, 0.1, 0.7)), np.array((-0.3, 0.5, 0.8))
_OWN = np.array((0.0, 0.0, 1.0))


def _Unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector)


def _Node(stage, name, kind, type=_VECTOR, **inputs):
    return AddNode(stage, f"/World/Look/{name}", f"ND_{kind}", type, **inputs)


def _Map(stage, name, left, right=None):
    """A normal map: one normal on the left and one on the right. Texels, not a constant, whose frame no coordinates give."""
    values = [Gf.Vec3f(*(0.5 * _Unit(normal) + 0.5)) for normal in (left, left if right is None else right)]
    texels = _Node(stage, f"{name}Texels", "splitlr_vector3", valuel=values[0], valuer=values[1], center=0.5)
    return _Node(stage, name, "normalmap", **{"in": texels})


def _Picture(tmp_path, add):
    return _Lit(tmp_path, lambda stage: AddSurface(stage, "/World/Look", normal=add(stage), base_color=(0.7, 0.4, 0.2),
                                                   specular_roughness=0.5))


def _Lit(tmp_path, addMaterial, sheet=shapes.Plane(2, 2)):
    """Of a sheet that is turned, below a lamp: a normal that is not turned with it is seen."""
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    UsdShade.Material.Define(stage, "/World/Look")
    material = addMaterial(stage)
    author.AddMesh(stage, "/World/Sheet", sheet, material=material, doubleSided=True, rotate=(60, 35, 20))
    author.AddLight(stage, "/World/Lamp", "Sphere", placement=dict(translate=(3, 2, 6)), intensity=30.0)
    author.AddCamera(stage, eye=(0, 0, 10), width=2.4, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, 24, 24, samples=16, maxDepth=1)


_BLENDS = {  # {blend: (its network, the normals that it has on the left and on the right)}
    "mixed": (lambda s: _Node(s, "Blend", "mix_vector3", bg=_Map(s, "A", _A), fg=_Map(s, "B", _B), mix=0.25),
              lambda: [0.75 * _Unit(_A) + 0.25 * _Unit(_B)] * 2),
    "masked": (lambda s: _Node(s, "Blend", "mix_vector3", bg=_Node(s, "Own", "normal_vector3", space="world"), fg=_Map(s, "B", _B),
                               mix=_Node(s, "Mask", "splitlr_float", _FLOAT, valuel=0.0, valuer=1.0, center=0.5)),
               lambda: [_OWN, _B]),
    "summed": (lambda s: _Node(s, "Unit", "normalize_vector3", **{"in": _Node(
        s, "Less", "subtract_vector3", in2=_Node(s, "Own", "normal_vector3"), in1=_Node(
            s, "Sum", "add_vector3", in1=_Map(s, "A", _A, _B), in2=_Node(s, "Twice", "multiply_vector3FA", in1=_Map(s, "B", _B), in2=2.0)))}),
        lambda: [_Unit(_A) + 2.0 * _Unit(_B) - _OWN, 3.0 * _Unit(_B) - _OWN]),
    "faded": (lambda s: _Node(s, "Blend", "mix_vector3", fg=_Map(s, "A", _A, _B), mix=0.5), lambda: [_A, _B]),
}


@pytest.mark.parametrize("name", _BLENDS)
def test_a_blend_is_a_map_of_blends(tmp_path, name):
    network, normals = _BLENDS[name]
    blend = _Picture(tmp_path, network)
    expected = _Picture(tmp_path, lambda stage: _Map(stage, "Whole", *normals()))
    flat = _Picture(tmp_path, lambda stage: _Map(stage, "Flat", _OWN))
    assert blend.warnings == expected.warnings == []
    assert abs(expected.rgb - flat.rgb).mean() > 0.05 * flat.rgb.mean()
    assert blend.rgb == pytest.approx(expected.rgb, rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("other", ["constant", "rotated", "circle"])
def test_what_is_no_normal_of_the_surface_is_told(tmp_path, other):
    def Add(stage):
        if other == "rotated":
            return _Node(stage, "Blend", "rotate3d_vector3", **{"in": _Map(stage, "A", _A)}, amount=30.0)
        blend = _Node(stage, "Blend", "mix_vector3", bg=_Map(stage, "A", _A), fg=Gf.Vec3f(0, 0, 1), mix=0.5)
        if other == "circle":
            blend[0].GetInput("fg").ConnectToSource(blend[0].GetOutput("out"))
        return blend
    picture = _Picture(tmp_path, Add)
    lines = [line for line in picture.warnings if "normal of /World/Look/Surface: is not supported; that of the surface is used" in line]
    assert len(lines) == 1, picture.warnings
    assert np.array_equal(picture.rgb, _Picture(tmp_path, lambda stage: _Map(stage, "Flat", _OWN)).rgb)


_NONE = {  # networks whose blend has no direction
    "nothingConnected": lambda s: _Node(s, "Blend", "mix_vector3", mix=0.5),
    "ofNothing": lambda s: _Node(s, "Unit", "normalize_vector3", **{"in": _Node(s, "Blend", "add_vector3")}),
    "opposite": lambda s: _Node(s, "Unit", "normalize_vector3", **{"in": _Node(
        s, "Blend", "mix_vector3", bg=_Map(s, "A", _A), fg=_Map(s, "B", -_A), mix=0.5)}),
    "byNothing": lambda s: _Node(s, "Blend", "divide_vector3FA", in1=_Node(
        s, "Less", "subtract_vector3", in1=_Map(s, "A", _A), in2=_Map(s, "B", _A)), in2=0.0),
    "grayMap": lambda s: _Node(s, "Map", "normalmap", **{"in": _Node(
        s, "Texels", "splitlr_vector3", valuel=Gf.Vec3f(0.5), valuer=Gf.Vec3f(0.5), center=0.5)}),
}


@pytest.mark.parametrize("name", _NONE)
def test_a_blend_without_a_direction_leaves_the_surfaces_normal(tmp_path, name):
    """Also of a coat, above what is bumped: it does not take that bump for its own."""
    def Look(base, coat):
        return lambda stage: AddSurface(stage, "/World/Look", base_color=(0.7, 0.4, 0.2), specular_roughness=0.5, coat=1.0,
                                        coat_roughness=0.3, **({"normal": base(stage)} if base else {}),
                                        **({"coat_normal": coat(stage)} if coat else {}))
    network = _NONE[name]
    assert _Lit(tmp_path, Look(network, None)).rgb == pytest.approx(_Lit(tmp_path, Look(None, None)).rgb, rel=1e-3)
    bump = lambda stage: _Map(stage, "Bump", _B, _A)  # noqa: E731
    smooth, blended = (_Lit(tmp_path, Look(bump, coat)).rgb for coat in (None, network))
    assert np.isfinite(blended).all()
    assert blended == pytest.approx(smooth, rel=1e-5, abs=1e-6)
    assert abs(smooth - _Lit(tmp_path, Look(bump, bump)).rgb).mean() > 0.05 * smooth.mean()


_DIRECTIONS = {  # {network: (it, by a direction in the space of the sheet or of the world; whether that is the sheet's)}
    "constant": (lambda s, v: _Node(s, "Own", "constant_vector3", value=Gf.Vec3f(*v)), False),
    "computed": (lambda s, v: _Node(s, "Unit", "normalize_vector3", **{"in": _Node(
        s, "Sum", "add_vector3", in1=Gf.Vec3f(*(3 * v - (0, 1, 0))), in2=Gf.Vec3f(0, 1, 0))}), False),
    "behind": (lambda s, v: _Node(s, "Own", "constant_vector3", value=Gf.Vec3f(*-v)), False),
    "objectMap": (lambda s, v: _Node(s, "Map", "normalmap", space="object", scale=3.0, **{"in": Gf.Vec3f(*(0.5 * v + 0.5))}), True),
    "objectTexels": (lambda s, v: _Node(s, "Map", "normalmap", space="object", **{"in": _Texel(s, 0.5 * v + 0.5)}), True),
}


def _Texel(stage, value):
    """By an image of one texel, which is turned on the surface: what is in object space does not care."""
    path = str(Path(stage.GetRootLayer().realPath).parent / "texel.exr")
    imageFile.WriteExr(path, {name: np.full((1, 1), x) for name, x in zip("RGB", value)}, half=False)
    st = _Node(stage, "Placed", "place2d_vector2", Sdf.ValueTypeNames.Float2, texcoord=_Node(
        stage, "St", "texcoord_vector2", Sdf.ValueTypeNames.Float2), rotate=70.0)
    return _Node(stage, "Texel", "image_vector3", file=Sdf.AssetPath(path), texcoord=st)


@pytest.mark.parametrize("name", _DIRECTIONS)
def test_any_direction_is_a_normal(tmp_path, name):
    """As authored normals of the mesh. In world space, on the side that is seen; normal maps of MaterialX 1.38 also in object space."""
    network, isObjects = _DIRECTIONS[name]
    own = _Unit((0.5, 0.5, -0.6))  # in the sheet's space
    turn = Gf.Rotation(Gf.Vec3d(1, 0, 0), 60) * Gf.Rotation(Gf.Vec3d(0, 1, 0), 35) * Gf.Rotation(Gf.Vec3d(0, 0, 1), 20)
    turned = own if isObjects else np.array(turn.TransformDir(Gf.Vec3d(*own)))
    seen = _Picture(tmp_path, lambda stage: network(stage, turned))
    plain = lambda stage: AddSurface(stage, "/World/Look", base_color=(0.7, 0.4, 0.2), specular_roughness=0.5)  # noqa: E731
    sheet = shapes.Plane(2, 2)
    expected = _Lit(tmp_path, plain, replace(sheet, normals=np.tile(own, (4, 1))))
    assert seen.warnings == []
    assert abs(expected.rgb - _Lit(tmp_path, plain).rgb).mean() > 0.05 * expected.rgb.mean()
    assert seen.rgb == pytest.approx(expected.rgb, rel=2e-3, abs=1e-4)


@pytest.mark.parametrize("depth", [8, 60])
def test_blends_of_blends_are_read_once(tmp_path, depth):
    """2^60 ways to one map end, and its registers are free after their last use: no depth is too deep."""
    def Add(stage):
        node = _Map(stage, "A", _A)
        for index in range(depth):
            node = _Node(stage, f"Blend{index}", "mix_vector3", bg=node, fg=node, mix=0.5)
        return node
    picture, whole = _Picture(tmp_path, Add), _Picture(tmp_path, lambda stage: _Map(stage, "Whole", _A))
    assert picture.warnings == []
    assert abs(picture.rgb - whole.rgb).max() < 1e-4
