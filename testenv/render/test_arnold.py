# SPDX-License-Identifier: Apache-2.0
"""Arnold's shaders look to the bit like the nodes of MaterialX and USD that mean the same; values of colours in closed form."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from cardStrip import Strip
from pxr import Gf, Sdf, UsdShade
from stages import author, imageFile, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddNode, Ball

RED, GOLD, BLUE = (0.7, 0.1, 0.08), (0.95, 0.7, 0.35), (0.2, 0.3, 0.9)
ZERO = Gf.Vec3f(0.0)
# What exporters write of every surface: the defaults by Arnold's user guide.
EXPORTED = dict(
    base=1.0, base_color=(0.8,) * 3, diffuse_roughness=0.0, metalness=0.0, specular=1.0, specular_color=(1, 1, 1), specular_roughness=0.2,
    specular_IOR=1.5, specular_anisotropy=0.0, specular_rotation=0.0, transmission=0.0, transmission_color=(1, 1, 1), transmission_depth=0.0,
    transmission_scatter=(0, 0, 0), transmission_scatter_anisotropy=0.0, transmission_dispersion=0.0, transmission_extra_roughness=0.0,
    subsurface=0.0, subsurface_color=(1, 1, 1), subsurface_radius=(1, 1, 1), subsurface_scale=1.0, subsurface_anisotropy=0.0,
    subsurface_type="randomwalk", sheen=0.0, sheen_color=(1, 1, 1), sheen_roughness=0.3, coat=0.0, coat_color=(1, 1, 1), coat_roughness=0.1,
    coat_anisotropy=0.0, coat_rotation=0.0, coat_IOR=1.5, coat_affect_color=0.0, coat_affect_roughness=0.0, thin_film_thickness=0.0,
    thin_film_IOR=1.5, emission=0.0, emission_color=(1, 1, 1), opacity=(1, 1, 1), thin_walled=False, normal=ZERO, coat_normal=ZERO,
    tangent=ZERO, caustics=False, internal_reflections=True, exit_to_background=False, indirect_diffuse=1.0, indirect_specular=1.0,
    transmit_aovs=False, id1=(0, 0, 0), aov_id1="")
LOOKS = {
    "default": {}, "painted": dict(base_color=RED, diffuse_roughness=0.7, specular=0.5, specular_color=GOLD, specular_roughness=0.4),
    "metal": dict(metalness=1.0, base_color=GOLD, specular_anisotropy=0.6, specular_rotation=0.2),
    "glass": dict(transmission=1.0, transmission_color=BLUE, transmission_depth=0.5, specular_IOR=1.8, transmission_dispersion=20.0),
    "wax": dict(subsurface=0.8, subsurface_color=GOLD, subsurface_radius=(0.2, 0.1, 0.05), subsurface_scale=2.0, subsurface_anisotropy=0.3),
    "coated": dict(coat=1.0, coat_color=GOLD, coat_roughness=0.3, coat_IOR=1.7, coat_affect_color=0.5, coat_affect_roughness=0.5, sheen=0.6,
                   sheen_color=BLUE, sheen_roughness=0.5),
    "film": dict(thin_film_thickness=400.0, thin_film_IOR=1.8, emission=0.5, emission_color=BLUE, opacity=(0.5, 0.5, 0.5)),
    "wall": dict(thin_walled=True, subsurface=1.0, subsurface_color=RED),
}


def _Ball(tmp_path, context, identifier, inputs, samples=4):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    material = UsdShade.Material.Define(stage, "/World/Look")
    shader, _ = AddNode(stage, "/World/Look/Surface", identifier, Sdf.ValueTypeNames.Token, **inputs)
    material.CreateSurfaceOutput(context).ConnectToSource(shader.GetOutput("out"))
    author.AddMesh(stage, "/World/Shape", Ball(1.0), material=material)
    author.AddLight(stage, "/World/Lamp", "Sphere", placement=dict(translate=(3, 3, 3)), intensity=20.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 0, 10), width=2.4, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=samples)


@pytest.mark.parametrize("look", LOOKS)
def test_a_standard_surface_is_MaterialXs(tmp_path, look):
    """All that an exporter writes counts as nothing beside what is set."""
    ownPicture = _Ball(tmp_path, "arnold", "arnold:standard_surface", EXPORTED | LOOKS[look])
    expected = _Ball(tmp_path, "mtlx", STANDARD, LOOKS[look])
    assert np.array_equal(ownPicture.rgb, expected.rgb) and expected.rgb.std() > 0.01
    assert ownPicture.warnings == expected.warnings == []


def test_an_open_pbr_surface_is_MaterialXs(tmp_path):
    inputs = dict(base_color=RED, specular_roughness=0.5, coat_weight=0.7, fuzz_weight=0.4, geometry_opacity=0.5)
    ownPicture = _Ball(tmp_path, "arnold", "arnold:openpbr_surface", inputs | dict(geometry_normal=ZERO, dielectric_priority=0))
    assert np.array_equal(ownPicture.rgb, _Ball(tmp_path, "mtlx", OPEN_PBR, inputs).rgb) and ownPicture.warnings == []


def test_a_lambert_is_a_standard_surface_that_reflects_nothing(tmp_path):
    ownPicture = _Ball(tmp_path, "arnold", "arnold:lambert", dict(Kd=0.8, Kd_color=RED, opacity=(0.5, 0.5, 0.5), normal=ZERO))
    expected = _Ball(tmp_path, "mtlx", STANDARD, dict(base=0.8, base_color=RED, specular=0.0, opacity=(0.5, 0.5, 0.5)))
    assert np.array_equal(ownPicture.rgb, expected.rgb)


def test_what_is_left_out_is_told_in_one_line(tmp_path):
    own = dict(indirect_diffuse=0.5, internal_reflections=False, subsurface_type="diffusion", caustics=True)
    assert _Ball(tmp_path, "arnold", "arnold:standard_surface", EXPORTED | own, samples=1).warnings == [
        "/World/Look: arnold:standard_surface of /World/Look/Surface: not supported and left out: internal_reflections, indirect_diffuse, "
        "subsurface_type diffusion"]


class _Cards:
    """Strips of cards whose surfaces are nodes of Arnold's, or such of MaterialX's that emit a node's colour."""

    def __init__(self, path):
        self.strip, self._count = Strip(path), 0

    def Node(self, name, output=Sdf.ValueTypeNames.Color3f, **inputs):
        self._count += 1
        return AddNode(self.strip.stage, f"/World/Node{self._count}", name, output, **inputs)

    def Channel(self, node, channel):
        shader, _ = node
        shader.CreateOutput(channel, Sdf.ValueTypeNames.Float)
        return shader, channel

    def Add(self, name, node, **settings):
        def Build(card):
            card.material.GetSurfaceOutput().ConnectToSource(node[0].GetOutput(node[1]))
            author.AddPrimvar(card.mesh, "tint", Sdf.ValueTypeNames.Color3fArray, "constant", [Gf.Vec3f(0.1, 0.6, 0.3)])
            author.AddPrimvar(card.mesh, "level", Sdf.ValueTypeNames.FloatArray, "constant", [0.375])
        self.strip.Add(name, Build, **settings)

    def Picture(self, **settings):
        return self.strip.Render(**settings).picture


def test_values_of_colours(tmp_path):
    """Colours where a surface hangs are what is seen. Formulas: Arnold's user guide."""
    cards = _Cards(tmp_path / "stage.usda")
    Node, a, b = cards.Node, np.array([0.5, 0.25, 0.75]), np.array([0.2, 0.4, 0.1])
    color = Node("arnold:flat", color=tuple(a))
    place = dict(st=(0.625, 0.25))
    mean = Node("arnold:float_to_rgb", r=color, g=cards.Channel(color, "g"), b=0.125)
    expected = {
        "flat": (color, a), "flatDefault": (Node("arnold:flat"), [1, 1, 1]),
        "add": (Node("arnold:add", input1=color, input2=tuple(b)), a + b),
        "subtract": (Node("arnold:subtract", input1=color, input2=tuple(b / 2)), a - b / 2),
        "multiply": (Node("arnold:multiply", input1=color, input2=tuple(b)), a * b), "multiplyDefault": (Node("arnold:multiply", input1=color), a),
        "divide": (Node("arnold:divide", input1=color, input2=tuple(b)), a / b),
        "mix": (Node("arnold:mix_rgba", input1=color, input2=(*b, 1.0), mix=0.25), 0.75 * a + 0.25 * b),
        "mixDefault": (Node("arnold:mix_rgba", input1=color, input2=(*b, 1.0)), 0.5 * (a + b)),
        "range": (Node("arnold:range", input=color, input_min=0.25, input_max=0.75, output_min=1.0, output_max=3.0, contrast_pivot=0.0),
                  1 + 4 * (a - 0.25)),
        "correct": (Node("arnold:color_correct", input=color, exposure=1.0, multiply=tuple(b), add=(0.1, 0.2, 0.3)), 2 * a * b + [0.1, 0.2, 0.3]),
        "correctDefault": (Node("arnold:color_correct", input=color), a),
        "meanAndChannel": (mean, [0.5, 0.25, 0.125]),
        "primvar": (Node("arnold:user_data_rgb", attribute="tint"), [0.1, 0.6, 0.3]),
        "noPrimvar": (Node("arnold:user_data_rgb", attribute="none", default=tuple(b)), b),
        "number": (Node("arnold:user_data_float", attribute="level"), [0.375] * 3),
        "places": (Node("arnold:float_to_rgb", r=Node("arnold:state_float", variable="u"), g=Node("arnold:state_float", variable="v")),
                   [0.625, 0.25, 0]),
    }
    for name, (node, _) in expected.items():
        cards.Add(name, node, **place)
    picture = cards.Picture(samples=1)
    assert picture.warnings == ["the stage has no lights: lit by a uniform dome of radiance 1"] or picture.warnings == []
    for name, (_, value) in expected.items():
        assert cards.strip.Pixels(name)[:, :3] == pytest.approx(np.tile(value, (4, 1)), abs=2e-6), name


def _Ramp(place, positions, colors, interpolations):
    """By the knots in the order of their positions, constant or linear from each to the next, and constant beyond."""
    knots = sorted(zip(positions, colors, interpolations), key=lambda knot: knot[0])
    if place <= knots[0][0]:
        return knots[0][1]
    for (low, a, kind), (high, b, _) in zip(knots, knots[1:]):
        if place < high:
            return a + (b - a) * (place - low) / (high - low) if kind else a
    return knots[-1][1]


def test_patterns(tmp_path):
    """Checkerboards and ramps. That the first colour is where the sum of cells is odd, and that one is linear, is what Arnold's own pictures
    of its tests 0041, 0055 and 0135 show."""
    cards = _Cards(tmp_path / "stage.usda")
    Node, floats, colors3, ints = cards.Node, Sdf.ValueTypeNames.FloatArray, Sdf.ValueTypeNames.Color3fArray, Sdf.ValueTypeNames.IntArray

    def Ramp(kind, positions, values, interpolations=None, **inputs):
        node = Node(f"arnold:ramp_{kind}", **inputs)
        node[0].CreateInput("position", floats).Set(list(positions))
        if kind == "rgb":
            node[0].CreateInput("color", colors3).Set([Gf.Vec3f(*map(float, value)) for value in values])
        else:
            node[0].CreateInput("value", floats).Set([float(value) for value in values])
        if interpolations is not None:
            node[0].CreateInput("interpolation", ints).Set(list(interpolations))
        return node

    positions, values, kinds = [0.125, 0.75, 0.5], np.array([RED, GOLD, BLUE]), [1, 1, 0]  # not in their order
    expected = {}
    for i, (u, v) in enumerate([(0.0625, 0.25), (0.3125, 0.5625), (0.625, 0.875), (0.875, 0.0625)]):
        place = dict(st=(u, v))
        isOdd = (np.floor(2 * 3 * u) + np.floor(2 * 5 * v)) % 2 == 1
        checks = Node("arnold:checkerboard", color1=RED, color2=BLUE, u_frequency=3.0, v_frequency=5.0, contrast=1.0, filter_strength=1.0)
        mask = Node("arnold:checkerboard")
        level = Node("arnold:user_data_float", attribute="level")
        for name, node, value in (
                ("checks", checks, RED if isOdd else BLUE),
                ("number", Node("arnold:mix_rgba", input1=GOLD, input2=(*BLUE, 1.0), mix=mask),
                 BLUE if (np.floor(2 * u) + np.floor(2 * v)) % 2 == 1 else GOLD),
                ("u", Ramp("rgb", positions, values, kinds, type="u"), _Ramp(u, positions, values, kinds)),
                ("v", Ramp("rgb", positions, values, type="v"), _Ramp(v, positions, values, [1, 1, 1])),
                ("float", Ramp("float", [0.0, 1.0], [0.25, 0.75], [1, 1], type="u", wrap_uvs=True), np.full(3, 0.25 + 0.5 * u)),
                ("one", Ramp("rgb", [0.5], [GOLD], type="u"), GOLD),
                ("custom", Ramp("rgb", positions, values, [1, 1, 1], input=level), _Ramp(0.375, positions, values, [1, 1, 1]))):
            cards.Add(f"{name}{i}", node, **place)
            expected[f"{name}{i}"] = np.asarray(value)
    knot = Ramp("rgb", [0.0, 1.0], [RED, BLUE], [1, 1], type="u")
    source = Node("arnold:flat", color=GOLD)
    knot[0].CreateInput("color:i1", Sdf.ValueTypeNames.Color3f).ConnectToSource(source[0].GetOutput("out"))
    cards.Add("knot", knot, st=(0.25, 0.5))
    expected["knot"] = 0.75 * np.array(RED) + 0.25 * np.array(GOLD)
    picture = cards.Picture(samples=1)
    assert [line for line in picture.warnings if "no lights" not in line] == []
    for name, value in expected.items():
        assert cards.strip.Pixels(name)[:, :3] == pytest.approx(np.tile(value, (4, 1)), abs=3e-6), name


def test_what_patterns_leave_out_is_told(tmp_path):
    cards = _Cards(tmp_path / "stage.usda")
    checks = cards.Node("arnold:checkerboard", u_offset=0.25, contrast=0.5, u_frequency=cards.Node("arnold:flat"))
    cards.Add("checks", checks)
    smooth, radial = (cards.Node("arnold:ramp_float", type=kind) for kind in ("u", "circular"))
    for node in (smooth, radial):
        node[0].CreateInput("position", Sdf.ValueTypeNames.FloatArray).Set([0.0, 1.0])
        node[0].CreateInput("value", Sdf.ValueTypeNames.FloatArray).Set([0.0, 1.0])
        node[0].CreateInput("interpolation", Sdf.ValueTypeNames.IntArray).Set([2, 2])
    cards.Add("smooth", cards.Node("arnold:flat", color=smooth))
    cards.Add("radial", cards.Node("arnold:flat", color=radial))
    cards.Add("alone", radial)
    warnings = [line for line in cards.Picture(samples=1).warnings if "no lights" not in line]
    assert sorted(warnings) == [
        "/World/M0: arnold:checkerboard of /World/Node2: not supported and left out: u_frequency, u_offset, contrast",
        "/World/M1: arnold:ramp_float of /World/Node3: not supported and left out: interpolation that is neither constant nor linear",
        "/World/M2: shader arnold:ramp_float of /World/Node4 is not supported here",
        "/World/M3: surface shader arnold:ramp_float of /World/Node4 is not supported; displayColor is used"]


# Of arnold:image, and of the UsdUVTexture with the same wraps, factors and placement: s' = (s scale + move).
IMAGES = {
    "plain": ({}, {}, None), "linear": (dict(color_space="linear"), dict(sourceColorSpace="raw"), None),
    "raw": (dict(color_space="raw"), dict(sourceColorSpace="raw"), None), "sRGB": (dict(color_space="sRGB"), dict(sourceColorSpace="sRGB"), None),
    "wraps": (dict(swrap="mirror", twrap="clamp", sscale=3.0, tscale=2.0), dict(wrapS="mirror", wrapT="clamp"), ((3, 2), (0, 0))),
    "black": (dict(swrap="black", soffset=0.25), dict(wrapS="black"), ((1, 1), (0.25, 0))),
    "factors": (dict(multiply=GOLD, offset=(0.1, 0.0, 0.2)), dict(scale=(*GOLD, 1), bias=(0.1, 0, 0.2, 0)), None),
    "flips": (dict(sflip=True, tflip=True), {}, ((-1, -1), (1, 1))),
    "all": (dict(soffset=0.25, toffset=0.5, sflip=True, sscale=2.0, tscale=0.5), {}, ((-2, 0.5), (1.5, 0.25))),
    "set": (dict(uvset="other"), {}, "other"),
}


@pytest.mark.parametrize("channel", ["", "g"])
def test_images_are_those_of_UsdUVTexture(tmp_path, channel):
    """Their names for wraps, colour spaces, factors and placement."""
    pixels = np.random.default_rng(7).integers(0, 256, (8, 8, 3)).astype(np.uint8)
    imageFile.WritePng(tmp_path / "noise.png", pixels)
    imageFile.WritePng(tmp_path / "tile.1001.png", pixels)
    own, reference = _Cards(tmp_path / "own.usda"), _Cards(tmp_path / "reference.usda")

    def Show(cards, name, image, output):
        cards.Add(name, cards.Node("ND_surface_unlit", emission_color=cards.Channel(image, channel) if channel else (image[0], output)))
        author.AddPrimvar(cards.strip.cards[name].mesh, "other", Sdf.ValueTypeNames.TexCoord2fArray, "vertex",
                          [Gf.Vec2f(0.5 * x, 0.25 + y) for x, y in ((0, 0), (1, 0), (0, 1), (1, 1))])

    images = IMAGES | {"tiles": ({}, {}, None)}
    for name, (inputs, others, place) in images.items():
        file = "tile.<{}>.png" if name == "tiles" else "noise.png"
        Show(own, name, own.Node("arnold:image", filename=Sdf.AssetPath(file.format("udim")), **inputs), "out")
        st = reference.Node("UsdPrimvarReader_float2", Sdf.ValueTypeNames.Float2, varname=place if isinstance(place, str) else "st")
        if isinstance(place, tuple):
            st = reference.Node("UsdTransform2d", Sdf.ValueTypeNames.Float2, **{"in": st, "scale": place[0], "translation": place[1]})
        others = dict(wrapS="repeat", wrapT="repeat", sourceColorSpace="auto") | others
        texture, _ = reference.Node("UsdUVTexture", file=Sdf.AssetPath(file.format("UDIM")), st=st, **others)
        texture.CreateOutput("rgb", Sdf.ValueTypeNames.Color3f)
        Show(reference, name, (texture, "rgb"), "rgb")
    ownPicture, expected = own.Picture(samples=4), reference.Picture(samples=4)
    for name in images:
        assert np.array_equal(own.strip.Pixels(name), reference.strip.Pixels(name)) and own.strip.Pixels(name).max() > 0.05, name
    assert np.array_equal(ownPicture.rgb, expected.rgb) and ownPicture.warnings == expected.warnings


def test_one_channel_of_an_image_is_all_of_it(tmp_path):
    imageFile.WriteExr(tmp_path / "even.exr", {c: np.full((4, 4), v) for c, v in zip("RGB", (0.75, 0.25, 0.5))})
    cards = _Cards(tmp_path / "stage.usda")
    image = cards.Node("arnold:image", filename=Sdf.AssetPath("even.exr"), single_channel=True, start_channel=2)
    cards.Add("single", image)
    whole = cards.Node("arnold:image", filename=Sdf.AssetPath("even.exr"))
    cards.Add("mean", cards.Node("arnold:float_to_rgb", r=whole, g=cards.Channel(whole, "b")))
    other = cards.Node("UsdUVTexture", file=Sdf.AssetPath("even.exr"), wrapS="repeat", wrapT="repeat")  # Arnold takes any name of its output
    cards.Add("other", cards.Node("arnold:flat", color=other))
    cards.Picture(samples=1)
    assert cards.strip.Pixels("other")[:, :3] == pytest.approx(np.tile([0.75, 0.25, 0.5], (4, 1)))
    assert cards.strip.Pixels("single")[:, :3] == pytest.approx(np.full((4, 3), 0.5))
    assert cards.strip.Pixels("mean")[:, :3] == pytest.approx(np.tile([0.5, 0.5, 0], (4, 1)))


@pytest.mark.parametrize("own, scale", [({}, (1, 1)), (dict(strength=0.5), (0.5, 0.5)), (dict(invert_y=True), (1, -1)),
                                        (dict(color_to_signed=False), None)], ids=str)
def test_normal_maps_are_MaterialXs(tmp_path, own, scale):
    codes = np.float32([0.7, 0.6, 0.9])
    pictures = []
    for isOwn in (True, False):
        stage = author.NewStage(str(tmp_path / f"{isOwn}.usda"))
        vector = Sdf.ValueTypeNames.Vector3f
        material = UsdShade.Material.Define(stage, "/World/Look")
        isSigned = isOwn and scale is None
        ramp = AddNode(stage, "/World/Look/Ramp", "ND_ramplr_vector3", vector,
                       **{name: Gf.Vec3f(*map(float, 2 * value - 1 if isSigned else value))
                          for name, value in (("valuel", codes), ("valuer", codes[::-1] * 0.5 + 0.25))})
        if isOwn:
            map_ = AddNode(stage, "/World/Look/Map", "arnold:normal_map", vector, input=ramp, **own)
        else:
            map_ = AddNode(stage, "/World/Look/Map", "ND_normalmap_vector2", vector, scale=scale or (1, 1), **{"in": ramp})
        surface, _ = AddNode(stage, "/World/Look/S", "arnold:standard_surface" if isOwn else STANDARD, Sdf.ValueTypeNames.Token, normal=map_)
        material.CreateSurfaceOutput("arnold" if isOwn else "mtlx").ConnectToSource(surface.GetOutput("out"))
        author.AddMesh(stage, "/World/Shape", shapes.Plane(2, 2), material=material, rotate=(90, 0, 0))
        author.AddLight(stage, "/World/Lamp", "Sphere", placement=dict(translate=(3, 3, 3)), intensity=20.0)
        author.AddCamera(stage, eye=(0, 0, 10), width=2.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        pictures.append(ours.Render(stage.GetRootLayer().realPath, 12, 12, samples=4))
    assert pictures[0].warnings == pictures[1].warnings == []
    if scale is None:  # a code and back is rounded
        assert pictures[0].rgb == pytest.approx(pictures[1].rgb, rel=1e-4)
    else:
        assert np.array_equal(pictures[0].rgb, pictures[1].rgb) and pictures[0].rgb.std() > 0


def test_what_displaces_and_what_is_not_known_is_told(tmp_path):
    cards = _Cards(tmp_path / "stage.usda")
    cards.Add("card", cards.Node("arnold:flat", color=cards.Node("arnold:noise")))
    range_ = cards.Node("arnold:range")
    cards.strip.cards["card"].material.CreateDisplacementOutput().ConnectToSource(range_[0].GetOutput("out"))
    warnings = [line for line in cards.Picture(samples=1).warnings if "no lights" not in line]
    assert warnings == ["/World/M0: displacement by arnold:range of /World/Node3 is not supported and is left out",
                        "/World/M0: shader arnold:noise of /World/Node1 is not supported here"]
    assert cards.strip.Pixels("card")[:, :3] == pytest.approx(1.0)
