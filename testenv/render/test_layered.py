# SPDX-License-Identifier: Apache-2.0
"""Layered surfaces in pictures, against closed forms: furnaces, absorption along a way, thin walls, light from behind.

What lobes do by themselves is in testenv/stat/shading/testLayeredSurface.cpp; here paths go through surfaces.
"""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, UsdShade, Vt
from stages import author, imageFile, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddNode, AddSurface

GLTF = "ND_gltf_pbr_surfaceshader"

_GLASS = dict(base=0.0, transmission=1.0, specular_roughness=0.0)


def _Center(tmp_path, shape, surface, light=("Dome", {}), width=1.2, samples=64, maxDepth=24, identifier=STANDARD):
    """Mean colour [3] in the middle of a picture of a shape with a surface, seen along -z."""
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", identifier, **surface)
    author.AddMesh(stage, "/World/Shape", shape, material=material, doubleSided=True,
                   rotate=(90, 0, 0) if len(shape.points) == 4 else (0, 0, 0))
    kind, inputs = light
    author.AddLight(stage, "/World/Light", kind, **inputs)
    author.AddCamera(stage, eye=(0, 0, 10), width=10.0 * width, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=samples, maxDepth=maxDepth)
    return picture.rgb.reshape(-1, 3).mean(0)


@pytest.mark.parametrize("surface, identifier", [
    (dict(base_color=(1.0, 1.0, 1.0)), STANDARD),
    (dict(base_color=(1.0, 1.0, 1.0), metalness=1.0, specular_roughness=0.8), STANDARD),
    (dict(base_color=(1.0, 1.0, 1.0), coat=1.0, sheen=1.0), STANDARD),
    (dict(base_color=(1.0, 1.0, 1.0), fuzz_weight=1.0, coat_weight=0.5, base_diffuse_roughness=1.0), OPEN_PBR),
    (_GLASS, STANDARD),
    (dict(transmission_weight=1.0, specular_roughness=0.0), OPEN_PBR),
], ids=["dielectric", "roughMetal", "coatAndSheen", "openPbr", "glass", "openPbrGlass"])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, surface, identifier):
    color = _Center(tmp_path, shapes.Sphere(1.0, 48, 96), surface, identifier=identifier)
    assert color == pytest.approx(np.ones(3), abs=0.02)


def test_absorption_follows_the_length_of_the_way(tmp_path):
    # A ball of index 1, seen through its middle: transmission_color after half of the way.
    surface = dict(_GLASS, specular_IOR=1.0, transmission_color=(0.25, 0.5, 1.0), transmission_depth=1.0)
    color = _Center(tmp_path, shapes.Sphere(1.0, 96, 192), surface, width=0.1)
    assert color == pytest.approx(np.array([0.25, 0.5, 1.0])**2, rel=0.01)


def test_a_thin_wall_shows_what_is_straight_behind(tmp_path):
    tint = np.array([0.9, 0.5, 0.2])
    surface = dict(_GLASS, specular_roughness=0.1, thin_walled=True, transmission_color=tuple(tint))
    color = _Center(tmp_path, shapes.Plane(4, 4), surface)
    assert color == pytest.approx(0.04 + 0.96 * tint, abs=4e-3)  # Fresnel at normal incidence


@pytest.mark.parametrize("light, expected", [(("Dome", {}), 0.8),
                                             (("Distant", dict(angle=0.0, intensity=1.0, placement=dict(rotate=(180, 0, 0)))), 0.8 / np.pi)],
                         ids=["dome", "distant"])
def test_light_from_behind_comes_through_a_leaf(tmp_path, light, expected):
    surface = dict(base=0.0, specular=0.0, subsurface=1.0, subsurface_color=(0.8, 0.8, 0.8), thin_walled=True)
    color = _Center(tmp_path, shapes.Plane(4, 4), surface, light=light)
    assert color == pytest.approx(np.full(3, expected), rel=0.01)


def test_opacity_shows_what_is_behind(tmp_path):
    surface = dict(base_color=(0.0, 0.0, 0.0), specular=0.0, opacity=(0.25, 0.25, 0.25))
    assert _Center(tmp_path, shapes.Plane(4, 4), surface) == pytest.approx(np.full(3, 0.75), abs=0.02)


def test_what_is_left_out_is_said_once(tmp_path):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", transmission=0.5, transmission_extra_roughness=0.1)
    for i in range(3):
        author.AddMesh(stage, f"/World/Ball{i}", shapes.Sphere(1.0, 8, 16), material=material, translate=(i, 0, 0))
    author.AddCamera(stage)
    stage.GetRootLayer().Save()
    warnings = ours.Render(stage.GetRootLayer().realPath, 4, 4, samples=1).warnings
    assert len([text for text in warnings if "transmission_extra_roughness of /World/Look/Surface" in text]) == 1, warnings


# Exporters write every input, and connect the tangent (Blender). {material: (identifier, inputs, inputs with what shows them)}
_WRITTEN = {
    "Standard": (STANDARD, dict(transmission_extra_roughness=0.1), dict(transmission=0.5)),
}


def _FrameStage(tmp_path, identifier, inputs, frames, isTurned):
    """frames: inputs to which the surface's tangent is connected, normalised; isTurned: turned before that."""
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", identifier, **inputs)
    vector = Sdf.ValueTypeNames.Float3
    tangent, _ = AddNode(stage, "/World/Look/Tangent", "ND_tangent_vector3", vector, space="world")
    if isTurned:
        turn, _ = AddNode(stage, "/World/Look/Turn", "ND_rotate3d_vector3", vector, amount=90.0)
        turn.CreateInput("in", vector).ConnectToSource(tangent.GetOutput("out"))
        tangent = turn
    unit, _ = AddNode(stage, "/World/Look/Unit", "ND_normalize_vector3", vector)
    unit.CreateInput("in", vector).ConnectToSource(tangent.GetOutput("out"))
    surface = UsdShade.Shader.Get(stage, "/World/Look/Surface")
    for frame in frames:
        surface.CreateInput(frame, vector).ConnectToSource(unit.GetOutput("out"))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 8, 16), material=material)
    author.AddCamera(stage)
    author.AddLight(stage, "/World/Light", "Dome")
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, 4, 4, samples=1).warnings


@pytest.mark.parametrize("name", _WRITTEN)
def test_what_a_material_does_not_show_is_not_warned_of(tmp_path, name):
    identifier, written, shown = _WRITTEN[name]
    assert _FrameStage(tmp_path, identifier, written, (), False) == []
    assert len(_FrameStage(tmp_path, identifier, dict(written, **shown), (), False)) == len(written)


_FROSTED = {  # {surface: (its inputs, the name of its roughness)}
    STANDARD: (dict(base=0.0, thin_walled=True, transmission=1.0), "specular_roughness"),
    OPEN_PBR: (dict(geometry_thin_walled=True, transmission_weight=1.0), "specular_roughness"),
    GLTF: (dict(transmission=1.0, metallic=0.0), "roughness"),
}


def _GgxReflection(wo, wi, alpha):
    """f |cos wi| of a mirror of microfacets (Walter et al. 2007, equations 20 and 33; Heitz 2014, equation 99)."""
    h = (wo + wi) / np.linalg.norm(wo + wi, axis=-1, keepdims=True)
    tan2 = lambda w: 1.0 / w[..., 2]**2 - 1.0
    distribution = alpha**2 / (np.pi * h[..., 2]**4 * (alpha**2 + tan2(h))**2)
    smith = lambda w: 0.5 * (np.sqrt(1.0 + alpha**2 * tan2(w)) - 1.0)
    return distribution / (4.0 * wo[..., 2] * (1.0 + smith(wo) + smith(wi)))


def _AlongNormal(alpha, ior):
    """Of light along the normal: what the microfacets keep, and what a dielectric of them reflects."""
    cosine = (np.arange(200000) + 0.5) / 200000
    wi = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], -1)
    f = _GgxReflection(np.array([0.0, 0.0, 1.0]), wi, alpha) * 2 * np.pi / len(cosine)
    half = np.sqrt(0.5 * (1 + cosine))
    within = np.sqrt(1 - (1 - half**2) / ior**2)
    s, p = (half - ior * within) / (half + ior * within), (within - ior * half) / (within + ior * half)
    kept = f.sum()
    f0 = ((ior - 1) / (ior + 1))**2
    return kept, (f * 0.5 * (s**2 + p**2)).sum() * (1 + f0 * (1 - kept) / kept)  # Turquin 2019


@pytest.mark.parametrize("identifier", _FROSTED)
@pytest.mark.parametrize("angle", [0.0, 25.0, 50.0])
def test_a_frosted_thin_wall_spreads_the_sun(tmp_path, identifier, angle):
    """A sun of no width behind it, seen along the normal."""
    inputs, name = _FROSTED[identifier]
    light = ("Distant", dict(angle=0.0, intensity=1.0, placement=dict(rotate=(180 - angle, 0, 0))))
    color = _Center(tmp_path, shapes.Plane(4, 4), {**inputs, name: 0.6}, light=light, samples=16, identifier=identifier)
    kept, reflected = _AlongNormal(0.36, 1.5)
    turned = np.radians(angle)
    wi = np.array([0.0, np.sin(turned), np.cos(turned)])
    expected = (1 - reflected) / kept * _GgxReflection(np.array([0.0, 0.0, 1.0]), wi, 0.36)
    assert color == pytest.approx(np.full(3, expected), rel=0.01)


@pytest.mark.parametrize("identifier", _FROSTED)
def test_a_frosted_thin_wall_is_invisible_in_a_furnace(tmp_path, identifier):
    inputs, name = _FROSTED[identifier]
    color = _Center(tmp_path, shapes.Sphere(1.0, 48, 96), {**inputs, name: 0.5}, identifier=identifier)
    assert color == pytest.approx(np.ones(3), abs=0.02)


def test_lights_and_directions_find_the_same_behind_a_frosted_wall(tmp_path):
    """A broad dome of one side and a lamp, by light samples and by chance: a rect of light, and the same as a mesh that glows."""
    inputs, name = _FROSTED[OPEN_PBR]
    surface = {**inputs, name: 0.6}
    light = ("Rect", dict(width=4.0, height=4.0, intensity=1.0, placement=dict(translate=(0, 0, -3), rotate=(180, 0, 0))))
    sampled = _Center(tmp_path, shapes.Plane(4, 4), surface, light=light, samples=256, identifier=OPEN_PBR, width=0.1)
    kept, reflected = _AlongNormal(0.36, 1.5)
    x, y = np.meshgrid(*[(np.arange(800) + 0.5) / 200 - 2.0] * 2, indexing="ij")
    way = np.stack([x, y, np.full_like(x, 3.0)], -1)
    squared = (way**2).sum(-1)
    wi = way / np.sqrt(squared)[..., None]
    solid = wi[..., 2] / squared / 200**2
    expected = (1 - reflected) / kept * (_GgxReflection(np.array([0.0, 0.0, 1.0]), wi, 0.36) * solid).sum()
    assert sampled == pytest.approx(np.full(3, expected), rel=0.01)


def _ThroughFacets(wi, alpha, eta):
    """f |cos| that GGX refracts from along the normal to wi [3], of all that it reflects and refracts.

    Walter et al. 2007 with the height-correlated masking of Heitz 2014, times what makes the sum 1 (Turquin 2019). `eta` is the index
    where wi is, relative to the viewer's side.
    """
    def Smith(z):
        return np.sqrt(alpha**2 * (1 - z * z) + z * z)

    def Masked(z):  # G2 along the normal and at the cosine z
        return 4 * z * 0.5 / (Smith(z) + z) * (z > 0)

    def Distribution(z):
        return alpha**2 / (np.pi * (z * z * (alpha**2 - 1) + 1) ** 2)

    def Fresnel(cosine):
        sine = (1 - cosine**2) / eta**2
        other = np.sqrt(np.maximum(1 - sine, 0))
        s, p = (cosine - eta * other) / (cosine + eta * other), (eta * cosine - other) / (eta * cosine + other)
        return np.where(sine < 1, 0.5 * (s * s + p * p), 1.0)

    z = (np.arange(200000) + 0.5) / 200000  # of the facet's normal, whose cosine to the viewer it is
    sine = np.sqrt(1 - z * z)
    inside = np.arcsin(np.minimum(sine / eta, 1.0))
    turn = np.arcsin(sine)
    mirrored = np.cos(2 * turn)
    below = np.cos(inside - turn)  # to the normal, on the other side
    kept = (2 * np.pi * Distribution(z) * z * (Fresnel(z) * Masked(mirrored) + (1 - Fresnel(z)) * Masked(below))).mean()
    h = np.array([0.0, 0.0, 1.0]) + eta * wi
    h *= np.sign(h[2]) / np.linalg.norm(h)
    cosO, cosI = h[2], h @ wi
    jacobian = eta**2 * abs(cosI) / (cosO + eta * cosI) ** 2
    return (1 - Fresnel(cosO)) * Distribution(h[2]) * Masked(-wi[2]) * cosO * jacobian / kept


@pytest.mark.parametrize("roughness, angle", [(0.3, 10), (0.5, 10), (0.5, 25)])
def test_a_small_lamp_is_found_through_rough_glass(tmp_path, roughness, angle):
    """From inside of the glass by light samples: directions alone would find so small a lamp some thirty times."""
    turned, distance, radius = np.radians(angle), 3.0, 0.05
    way = np.array([0.0, np.sin(turned), -np.cos(turned)])
    light = ("Sphere", dict(radius=radius, intensity=1e4, placement=dict(translate=tuple(distance * way))))
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", **{**_GLASS, "specular_roughness": roughness})
    author.AddMesh(stage, "/World/Shape", shapes.Plane(4, 4), material=material, doubleSided=True, rotate=(-90, 0, 0))  # its back
    author.AddLight(stage, "/World/Light", light[0], **light[1])
    author.AddCamera(stage, eye=(0, 0, 10), width=0.2, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    color = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=256, maxDepth=2).rgb.reshape(-1, 3).mean(0)
    expected = 1e4 * np.pi * radius**2 / distance**2 * _ThroughFacets(way, roughness**2, 1 / 1.5)
    assert color == pytest.approx(np.full(3, expected), rel=0.025)  # what the table of E is worth from inside


@pytest.mark.parametrize("roughness, coat", [(0.3, {}), (0.5, {}), (0.8, {}), (0.5, dict(coat=1.0, coat_roughness=0.3))], ids=str)
def test_rough_glass_is_invisible_among_panels(tmp_path, roughness, coat):
    """Six panels around a ball are a furnace: what light samples find of each and what directions find add up to 1."""
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", **{**_GLASS, **coat, "specular_roughness": roughness})
    author.AddMesh(stage, "/World/Shape", shapes.Sphere(1.0, 48, 96), material=material)
    for name, rotate in dict(front=(0, 0, 0), back=(0, 180, 0), left=(0, 90, 0), right=(0, -90, 0), top=(90, 0, 0), bottom=(-90, 0, 0)).items():
        light = author.AddLight(stage, f"/World/{name}", "Rect", width=4.0, height=4.0, intensity=1.0)
        for place in (dict(rotate=rotate), dict(translate=(0, 0, 2))):  # each looks at the ball from 2 away
            author.Place(light, **place)
    author.AddCamera(stage, eye=(0, 0, 1.9), width=12.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    color = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=64, maxDepth=48).rgb.reshape(-1, 3).mean(0)
    assert color == pytest.approx(np.ones(3), abs=0.02)


@pytest.mark.parametrize("roughness, isClear", [(0.3, True), (0.6, False)])
@pytest.mark.parametrize("identifier", _FROSTED)
def test_clear_thin_walls_pass_shadow_rays(tmp_path, identifier, roughness, isClear):
    """Behind a wall as rough as the models' defaults a sun lights what faces it; the frosted one is in its way, and says nothing."""
    inputs, name = _FROSTED[identifier]
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    wall = AddSurface(stage, "/World/Look", identifier, **{**inputs, name: roughness})
    author.AddMesh(stage, "/World/Wall", shapes.Plane(4, 4), material=wall, doubleSided=True, translate=(0, 1, 0))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(4, 4), (0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Light", "Distant", angle=0.0, intensity=1.0, placement=dict(rotate=(-90, 0, 0)))
    author.AddCamera(stage, eye=(0, 0.5, 0), target=(0, 0, 0), up=(0, 0, 1), width=1.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 4, 4, samples=16, maxDepth=0)
    assert picture.warnings == []
    assert (picture.rgb.mean() > 0.1) == isClear, picture.rgb.mean()


def _WallOfTwoParts(tmp_path, identifier, isPainted):
    """A wall over a floor in the sun, seen from above: half clear, half as rough as can be. isPainted: by the texels of an image, else
    by two materials."""
    inputs, name = _FROSTED[identifier]
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    image = str(tmp_path / "roughness.exr")
    imageFile.WriteExr(image, {"Y": np.array([[0.0, 1.0]])})
    x = np.array([-2.0, 0.0, 0.0, -2.0, 0.0, 2.0, 2.0, 0.0])
    z = np.array([2.0, 2.0, -2.0, -2.0] * 2)
    st = np.stack([np.repeat([0.25, 0.75], 4), np.full(8, 0.5)], -1)  # a texel each
    both = shapes.Shape(np.stack([x, 0 * x, z], -1), np.full(2, 4), np.arange(8), np.tile([0.0, 1.0, 0.0], (8, 1)), st)
    wall = author.AddMesh(stage, "/World/Wall", both, doubleSided=True, translate=(0, 1, 0))
    if isPainted:
        UsdShade.Material.Define(stage, "/World/Look")
        texels = AddNode(stage, "/World/Look/Image", "ND_image_float", Sdf.ValueTypeNames.Float, file=Sdf.AssetPath(image))
        author.Bind(wall, AddSurface(stage, "/World/Look", identifier, **{**inputs, name: texels}))
    else:
        for face, roughness in enumerate((0.0, 1.0)):
            part = UsdShade.MaterialBindingAPI.Apply(wall.GetPrim()).CreateMaterialBindSubset(f"Part{face}", Vt.IntArray([face]))
            author.Bind(part, AddSurface(stage, f"/World/Look{face}", identifier, **{**inputs, name: roughness}))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), (0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Sun", "Distant", angle=0.0, intensity=1.0, placement=dict(rotate=(-80, 0, 0)))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.1)
    author.AddCamera(stage, eye=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1), width=3.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=16, maxDepth=4)
    assert picture.warnings == []
    return picture.rgb


@pytest.mark.parametrize("identifier", _FROSTED)
def test_a_wall_whose_roughness_varies_is_clear_where_it_is_smooth(tmp_path, identifier):
    """To the bit what two materials on its parts are: the sun passes the clear part, and the other one spreads it."""
    painted, apart = (_WallOfTwoParts(tmp_path, identifier, isPainted) for isPainted in (True, False))
    assert np.array_equal(painted, apart)
    left, right = painted[4:12, :7].mean(), painted[4:12, 9:].mean()
    sun = 0.5 / np.pi * np.cos(np.radians(10.0))  # on the floor
    assert left > 0.9 * sun and abs(right - left) > 0.1 * sun, (left, right)


@pytest.mark.parametrize("identifier, name", [(STANDARD, "thin_walled"), (OPEN_PBR, "geometry_thin_walled"), ("ND_surface", "thin_walled")])
def test_a_thin_wall_by_a_network_that_varies_is_told(tmp_path, identifier, name):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = AddSurface(stage, "/World/Look", identifier)
    test, _ = AddNode(stage, "/World/Look/Test", "ND_ifgreater_floatB", Sdf.ValueTypeNames.Bool, value2=0.5)
    reader, _ = AddNode(stage, "/World/Look/Reader", "ND_geompropvalue_float", Sdf.ValueTypeNames.Float, geomprop="wear")
    test.CreateInput("value1", Sdf.ValueTypeNames.Float).ConnectToSource(reader.GetOutput("out"))
    UsdShade.Shader.Get(stage, "/World/Look/Surface").CreateInput(name, Sdf.ValueTypeNames.Bool).ConnectToSource(test.GetOutput("out"))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 8, 16), material=material)
    author.AddCamera(stage)
    author.AddLight(stage, "/World/Light", "Dome")
    stage.GetRootLayer().Save()
    said = ours.Render(stage.GetRootLayer().realPath, 4, 4, samples=1).warnings
    assert [text for text in said if name in text] == [
        f"/World/Look: {name} of /World/Look/Surface: varies, which is not supported, and counts as false"], said


def test_tangents_that_nothing_shows_are_not_warned_of(tmp_path):
    frames, bent = ("geometry_tangent", "geometry_coat_tangent"), dict(specular_roughness_anisotropy=0.5)
    coated = dict(coat_weight=1.0, coat_roughness_anisotropy=0.5)
    assert _FrameStage(tmp_path, OPEN_PBR, {}, frames, True) == []
    assert _FrameStage(tmp_path, OPEN_PBR, dict(coat_roughness_anisotropy=0.5), frames, True) == []
    assert _FrameStage(tmp_path, OPEN_PBR, bent, frames, False) == []
    assert _FrameStage(tmp_path, OPEN_PBR, bent, frames, True) == []
    assert _FrameStage(tmp_path, OPEN_PBR, coated, frames, True) == []
    assert _FrameStage(tmp_path, OPEN_PBR, coated, frames[1:], True) == []
