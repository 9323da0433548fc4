# SPDX-License-Identifier: Apache-2.0
"""Directions of anisotropies: a tangent of any network turns what is stretched as far as its own direction is turned.

The ball's tangents are along s, so its bitangents are along t. A roughness that is stretched along one of them is the same as
the other roughness stretched along the other, which needs no tangent.
"""

import dataclasses
import functools

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Gf, Sdf, UsdShade
from stages.materialX import OPEN_PBR, STANDARD, AddNode, AddSurface, Ball
from test_closures import EDGE, GOLD, Closures, _Picture

VECTOR = Sdf.ValueTypeNames.Vector3f
ALONG, ACROSS = 0.4, 0.05  # GGX's alpha
GLTF = "ND_gltf_pbr_surfaceshader"
SUN = (("Distant", dict(placement=dict(rotate=(-35, 20, 0)), intensity=2.0, angle=0.0)),)  # only light samples find it: no noise


def _Node(stage, name, identifier, **inputs):
    return AddNode(stage, f"/World/Look/{name}", identifier, VECTOR, **inputs)


def _Turned(stage, degrees, axis=True):
    """The surface's tangent, turned about its normal, clockwise as MaterialX turns."""
    own = _Node(stage, "Own", "ND_tangent_vector3", space="world")
    inputs = {"in": own, "amount": degrees}
    normal = _Node(stage, "Axis", "ND_normal_vector3", space="world")
    if axis:
        inputs["axis"] = normal
    else:  # the same vector, which nothing knows to be the normal
        inputs["axis"] = _Node(stage, "Twice", "ND_multiply_vector3FA", in1=normal, in2=2.0)
    return _Node(stage, "Unit", "ND_normalize_vector3", **{"in": _Node(stage, "Turn", "ND_rotate3d_vector3", **inputs)})


def _Metal(roughness, tangent=None, kind="generalized_schlick_bsdf"):
    def Add(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        inputs = dict(color0=GOLD, color82=EDGE) if kind == "generalized_schlick_bsdf" else {}
        if tangent is not None:
            inputs["tangent"] = tangent(stage)
        return AddSurface(stage, "/World/Look", "ND_surface", bsdf=Closures(stage)(kind, roughness=roughness, **inputs))
    return Add


def _Render(tmp_path, add, shape=None):
    picture = _Picture(tmp_path, add, lights=SUN, samples=4, shape=shape or Ball(1.0), maxDepth=0)
    assert not picture.warnings, picture.warnings
    return picture.rgb.astype(np.float64)


def _Error(a, b):
    return np.sqrt(((a - b) ** 2).mean()) / b.mean()


TANGENTS = {
    "bitangent": lambda stage: _Node(stage, "Across", "ND_bitangent_vector3", space="world"),
    "turned": lambda stage: _Turned(stage, 90.0),
    "turnedBack": lambda stage: _Turned(stage, -90.0),
    "turnedByAVector": lambda stage: _Turned(stage, 90.0, axis=False),
}


@pytest.fixture(scope="module")
def Swapped(tmp_path_factory):
    """(stretched along t, along s) of a kind of closure without a tangent."""
    @functools.cache
    def Of(kind):
        return tuple(_Render(tmp_path_factory.mktemp("own"), _Metal(roughness, None, kind))
                     for roughness in ((ACROSS, ALONG), (ALONG, ACROSS)))
    return Of


@pytest.mark.parametrize("kind, name", [*(("generalized_schlick_bsdf", name) for name in TANGENTS), ("conductor_bsdf", "turned"),
                                        ("dielectric_bsdf", "bitangent")])
def test_a_tangent_across_swaps_the_roughnesses(tmp_path, Swapped, kind, name):
    expected, own = Swapped(kind)
    assert _Error(_Render(tmp_path, _Metal((ALONG, ACROSS), TANGENTS[name], kind)), expected) < 2e-3
    assert _Error(own, expected) > 0.05


def test_every_angle_is_that_of_the_vector(tmp_path):
    """The structure of rotate3d about the normal against its arithmetic, which shares nothing with it; both ways differ."""
    pictures = {(degrees, axis): _Render(tmp_path, _Metal((ALONG, ACROSS), lambda stage: _Turned(stage, degrees, axis)))
                for degrees in (35.0, -35.0) for axis in (True, False)}
    for degrees in (35.0, -35.0):
        assert _Error(pictures[degrees, True], pictures[degrees, False]) < 2e-3
    assert _Error(pictures[35.0, True], pictures[-35.0, True]) > 0.05


def _InsideOut(shape, normals):
    """The same points and coordinates, of which the backs are seen; dP/ds and dP/dt are the same."""
    quads = shape.indices.reshape(-1, 4)[:, [0, 3, 2, 1]]  # the same triangles
    return dataclasses.replace(shape, indices=quads.ravel(), normals=normals)


@pytest.mark.parametrize("isSmooth", [True, False])
def test_backs_have_the_tangents_of_fronts(tmp_path, isSmooth):
    """A direction in the world, and one that is turned by a normal that is the other one: 35 degrees are -35."""
    ball = Ball(1.0)
    front = ball if isSmooth else dataclasses.replace(ball, normals=None)
    # With smooth normals of either side: they are the ones to turn about.
    backs = {-35.0: _InsideOut(ball, -ball.normals), 35.0: _InsideOut(ball, ball.normals)} if isSmooth else {-35.0: _InsideOut(ball, None)}
    fixed = _Metal((ALONG, ACROSS), lambda stage: Gf.Vec3f(0.6, 0.5, 0.3))
    turned, other = (_Metal((ALONG, ACROSS), lambda stage, degrees=degrees: _Turned(stage, degrees)) for degrees in (35.0, -35.0))
    ofFront = [_Render(tmp_path, add, front) for add in (fixed, turned)]
    assert _Error(ofFront[1], _Render(tmp_path, other, front)) > 0.05
    for degrees, back in backs.items():
        assert _Error(_Render(tmp_path, fixed, back), ofFront[0]) < 2e-3
        assert _Error(_Render(tmp_path, turned if degrees > 0 else other, back), ofFront[1]) < 2e-3


@pytest.mark.parametrize("identifier, inputs, tangent, turned", [
    (STANDARD, dict(base=1.0, base_color=GOLD, metalness=1.0, specular_roughness=0.4, specular_anisotropy=0.9), "tangent",
     dict(specular_rotation=0.1)),
    (GLTF, dict(base_color=GOLD, metallic=1.0, roughness=0.3, anisotropy_strength=0.8), "tangent",
     dict(anisotropy_rotation=0.2 * np.pi)),
    (OPEN_PBR, dict(base_color=GOLD, base_metalness=1.0, specular_roughness=0.4, specular_roughness_anisotropy=0.9),
     "geometry_tangent", None),
])
def test_surfaces_have_tangents_too(tmp_path, identifier, inputs, tangent, turned):
    """A tenth of a turn towards dP/dt, by the tangent and by the rotation that a model has."""
    own = _Render(tmp_path, lambda stage: AddSurface(stage, "/World/Look", identifier, **inputs))
    known, general = (
        _Render(tmp_path, lambda stage: AddSurface(stage, "/World/Look", identifier, **inputs, **{tangent: _Turned(stage, -36.0, axis)}))
        for axis in (True, False))
    assert _Error(known, general) < 2e-3
    assert _Error(known, own) > 0.05
    if turned is not None:
        rotated = _Render(tmp_path, lambda stage: AddSurface(stage, "/World/Look", identifier, **inputs, **turned))
        assert _Error(known, rotated) < 1e-3


@pytest.mark.parametrize("name, kind, rotation", [
    ("lama_conductor", "anisotropy", "anisotropyRotation"), ("lama_dielectric", "anisotropy", "rotation"),
    ("lama_generalized_schlick", "anisotropy", "anisotropyRotation"), ("lama_iridescence", "anisotropy", "anisotropyRotation"),
])
def test_lama_turns_its_direction(tmp_path, name, kind, rotation):
    """A quarter of a turn is the direction across; a tenth is one way and the other as far from none."""
    def Add(direction=None, **inputs):
        def Surface(stage):
            UsdShade.Material.Define(stage, "/World/Look")
            if direction is not None:
                inputs["direction" if name == "lama_dielectric" else "anisotropyDirection"] = direction(stage)
            bsdf = Closures(stage)(name, roughness=0.25, **{kind: 0.8}, **inputs)
            return AddSurface(stage, "/World/Look", "ND_surface", bsdf=bsdf)
        return Surface
    own = _Render(tmp_path, Add())
    across = _Render(tmp_path, Add(TANGENTS["bitangent"]))
    quarter = _Render(tmp_path, Add(**{rotation: 0.25}))
    assert _Error(quarter, across) < 2e-3 and _Error(quarter, own) > 0.01
    tenth = _Render(tmp_path, Add(**{rotation: 0.1}))
    assert _Error(tenth, _Render(tmp_path, Add(lambda stage: _Turned(stage, -36.0)))) < 1e-3
    assert _Error(tenth, _Render(tmp_path, Add(lambda stage: _Turned(stage, 36.0)))) > 0.005
