# SPDX-License-Identifier: Apache-2.0
"""Volumes whose materials compute: noises, functions of position and of fields, images. Quadratures, grids of the same values, and bits."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import test_volumeMotion
import textureCases
import volumeCase
from hdstream import _core
from pxr import Sdf, Usd, UsdShade, UsdVol
from stages import imageFile
from stages.materialX import AddNode

_T = Sdf.ValueTypeNames
_DARK = (("Dome", dict(intensity=0.0)),)
_UNIT = np.ones((16, 16, 16))  # of edge 1
_DENSITY = ("geompropvalue_float", dict(geomprop="density"))
_PLACE = ("position_vector3", {})
_TOLERANCE = 0.01


def _Axis(index):
    return "extract_vector3", {"in": _PLACE, "index": index}


def _Add(stage, value):
    """A value of an input: a constant, or (types of a node, inputs), which are added."""
    if not (isinstance(value, tuple) and isinstance(value[0], str)):
        return value
    name, inputs = value
    number = len(stage.GetPrimAtPath("/World/Look").GetChildren())
    values = {key: _Add(stage, one) for key, one in inputs.items()}
    path = f"/World/Look/{name}_{number}_{len(stage.GetPrimAtPath('/World/Look').GetChildren())}"
    return AddNode(stage, path, f"ND_{name}", **values)


def _AddLook(stage, emission=None, host=None, **medium):
    """The material of a volume. \\param host: (shader id, inputs) in place of MaterialX's nodes."""
    look = UsdShade.Material.Define(stage, "/World/Look")
    if host is not None:
        shader, _ = AddNode(stage, "/World/Look/Host", host[0], _T.Token, **{k: _Add(stage, v) for k, v in host[1].items()})
        look.CreateVolumeOutput().ConnectToSource(shader.GetOutput("out"))
    else:
        values = {name: _Add(stage, value) for name, value in medium.items()}
        inputs = dict(vdf=AddNode(stage, "/World/Look/Vdf", "ND_anisotropic_vdf", _T.Token, **values))
        if emission is not None:
            inputs["edf"] = AddNode(stage, "/World/Look/Edf", "ND_uniform_edf", _T.Token, color=_Add(stage, emission))
        shader, _ = AddNode(stage, "/World/Look/Volume", "ND_volume", _T.Token, **inputs)
        look.CreateVolumeOutput("mtlx").ConnectToSource(shader.GetOutput("out"))
    volume = UsdVol.Volume.Define(stage, "/World/Smoke")  # its fields are handed over by _Render
    UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(look)


def _Render(path, look, grids=None, size=16, lights=(("Dome", {}),), width=2.0, add=None, **settings):
    def Add(stage):
        _AddLook(stage, **look)
        if add is not None:
            add(stage)

    volume = _core.VolumePrim(_core.Placement(np.eye(4)), "default", "/World/Look")
    for name, grid in (grids or dict(density=volumeCase.Grid(_UNIT))).items():
        volume.SetGrid(name, grid)
    stage = volumeCase.Stage(path, lights=lights, width=width, add=Add)
    return volumeCase.Render(stage, {"/World/Smoke": volume}, size, **settings)


def _Mean(picture):
    return picture[..., :3].astype(np.float64).reshape(-1, 3).mean(0)


def _Along(values):
    """Positions, and the linear interpolation of values along z, at 4096 points; and their length."""
    size = len(values)
    at = (np.arange(4096) + 0.5) / 4096 * (size + 2) - 1.5  # in voxels
    density = np.interp(at, np.arange(-1, size + 1), np.concatenate([[0.0], values, [0.0]]))
    return (at - 0.5 * (size - 1)) / size, density, (size + 2) / size


def _Slice(values):
    return np.broadcast_to(np.asarray(values, float), (16, 16, len(values))).copy()


_RANDOM = np.random.default_rng(7).random(16) * 2
_WAVE = ("add_float", dict(in1=1.5, in2=("sin_float", {"in": ("multiply_float", dict(in1=_Axis(2), in2=8.0))})))
_NUMBERS = (1.0, 2.0, 0.5)


def _Times(value):
    return "multiply_color3FA", dict(in1=_NUMBERS, in2=value)


def _Smooth(x):
    t = np.clip((x - 0.2) / 1.2, 0, 1)
    return t * t * (3 - 2 * t)


# name: (absorption over _NUMBERS as a network, the same of z and the interpolated density).
_COMPUTED = {
    "position": (("multiply_float", dict(in1=_DENSITY, in2=_WAVE)), lambda z, d: d * (1.5 + np.sin(8 * z))),
    "position alone follows the density": (_WAVE, lambda z, d: d * (1.5 + np.sin(8 * z))),
    "position twice": (("multiply_float", dict(in1=("multiply_float", dict(in1=_WAVE, in2=_DENSITY)), in2=_WAVE)),
                       lambda z, d: d * (1.5 + np.sin(8 * z))**2),
    "field": (("power_float", dict(in1=_DENSITY, in2=2.0)), lambda z, d: d**2),
    "field's threshold": (("smoothstep_float", {"in": _DENSITY, "low": 0.2, "high": 1.4}), lambda z, d: _Smooth(d)),
    "field and position": (("multiply_float", dict(in1=("exp_float", {"in": ("multiply_float", dict(in1=_DENSITY, in2=_Axis(2)))}),
                                                   in2=_DENSITY)), lambda z, d: d * np.exp(d * z)),
    "below 0": (("multiply_float", dict(in1=_DENSITY, in2=("sin_float", {"in": ("multiply_float", dict(in1=_Axis(2), in2=8.0))}))),
                lambda z, d: np.maximum(d * np.sin(8 * z), 0)),
    "field that is missing": (("multiply_float", dict(in1=_DENSITY, in2=(
        "power_float", dict(in1=("geompropvalue_float", dict(geomprop="heat", default=0.5)), in2=2.0)))), lambda z, d: 0.25 * d),
}


@pytest.mark.parametrize("name", _COMPUTED)
def test_absorption_is_the_integral_of_what_is_computed(tmp_path, name):
    network, function = _COMPUTED[name]
    layers, _, warnings = _Render(tmp_path / "s.usda", dict(absorption=_Times(network)),
                                  dict(density=volumeCase.Grid(_Slice(_RANDOM))), size=32, width=0.5, samples=2048)
    missing = name == "field that is missing"
    assert len(warnings) == missing and all("without the field 'heat'" in str(warning) for warning in warnings)
    z, density, length = _Along(_RANDOM)
    depth = length * function(z, density).mean() * np.array(_NUMBERS)
    assert _Mean(layers["color"]) == pytest.approx(np.exp(-depth), rel=_TOLERANCE)


def test_shadows_are_dimmed_by_what_is_computed(tmp_path):
    from test_volumes import _AddWall

    look = dict(absorption=_Times(("multiply_float", dict(in1=("power_float", dict(in1=_DENSITY, in2=2.0)), in2=_WAVE))))
    grids = dict(density=volumeCase.Grid(_Slice(_RANDOM)))
    options = dict(lights=(("Distant", dict(angle=0.0)),), width=0.5, add=_AddWall)
    dark, *_ = _Render(tmp_path / "s.usda", look, grids, size=32, samples=2048, **options)
    bright, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "t.usda", **options), {}, size=32, samples=16)
    z, density, length = _Along(_RANDOM)
    depth = length * (density**2 * (1.5 + np.sin(8 * z))).mean() * np.array(_NUMBERS)
    assert _Mean(dark["color"]) / _Mean(bright["color"]) == pytest.approx(np.exp(-2 * depth), rel=2 * _TOLERANCE)


def test_emission_is_the_integral_of_what_is_computed(tmp_path):
    layers, *_ = _Render(tmp_path / "s.usda", dict(emission=_Times(("multiply_float", dict(in1=_DENSITY, in2=_WAVE)))),
                         dict(density=volumeCase.Grid(_Slice(_RANDOM))), size=32, width=0.5, lights=_DARK, samples=1024)
    z, density, length = _Along(_RANDOM)
    expected = length * (density * (1.5 + np.sin(8 * z))).mean() * np.array(_NUMBERS)
    assert _Mean(layers["color"]) == pytest.approx(expected, rel=_TOLERANCE)


def _Noise(points):
    """MaterialX's Perlin noise in space, by its GLSL: mx_perlin_noise_float of vec3. \\param points: [..., 3]."""
    def Turn(x, k):
        return (x << np.uint32(k)) | (x >> np.uint32(32 - k))

    def Hash(x, y, z):
        a, b, c = (np.uint32(0xdeadbeef + 12 + 13) + part.astype(np.uint32) for part in (x, y, z))
        c = (c ^ b) - Turn(b, 14)
        a = (a ^ c) - Turn(c, 11)
        b = (b ^ a) - Turn(a, 25)
        c = (c ^ b) - Turn(b, 16)
        a = (a ^ c) - Turn(c, 4)
        b = (b ^ a) - Turn(a, 14)
        return (c ^ b) - Turn(b, 24)

    cell = np.floor(points).astype(np.int64)
    part = points - cell
    fade = part**3 * (part * (part * 6 - 15) + 10)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        at = (cell + corner) & 0xffffffff
        h = Hash(at[..., 0], at[..., 1], at[..., 2]) & np.uint32(15)
        x, y, z = np.moveaxis(part - corner, -1, 0)
        u = np.where(h < 8, x, y)
        v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
        gradient = np.where(h & 1, -u, u) + np.where(h & 2, -v, v)
        total = total + np.prod(np.where(corner, fade, 1 - fade), axis=-1) * gradient
    return 0.9820 * total


def test_the_noise_of_this_file_is_materialXs():
    assert _Noise(np.array([[0.3, 0.7, 0.2]]))[0] == pytest.approx(0.27371189, abs=1e-6)  # as test_patterns has it


def _NoiseNode(scale, types="float"):
    place = ("multiply_vector3FA", dict(in1=_PLACE, in2=scale))
    return f"noise3d_{types}", dict(position=place, amplitude=0.5, pivot=0.5)


def test_a_noise_is_a_grid_of_its_values(tmp_path):
    """A cloud by 3D noise, lit by a dome and a lamp, beside a grid that holds the same values."""
    size = 96
    edge = (np.arange(size) + 0.5) / size - 0.5
    points = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), -1)
    fades = np.clip((0.5 - np.abs(points).max(-1)) * 4, 0, 1)  # so that the edges of the two grids are alike
    values = fades * (0.5 + 0.5 * _Noise(5.0 * points))
    lamp = ("Rect", dict(width=2.0, height=2.0, intensity=5.0, placement=dict(translate=(0, 2, 0), rotate=(-90, 0, 0))))
    options = dict(size=16, width=1.2, lights=(("Dome", dict(intensity=0.3)), lamp), samples=4096)
    product = ("multiply_float", dict(in1=_DENSITY, in2=_NoiseNode(5.0)))
    look = dict(scattering=("multiply_color3FA", dict(in1=(12.0, 6.0, 3.0), in2=product)),
                absorption=("multiply_color3FA", dict(in1=(0.5, 1.0, 2.0), in2=product)), anisotropy=0.3)
    computed, *_ = _Render(tmp_path / "s.usda", look, dict(density=volumeCase.Grid(fades)), **options)
    plain = volumeCase.Volume(volumeCase.Grid(values), scattering=(12.0, 6.0, 3.0), absorption=(0.5, 1.0, 2.0), anisotropy=0.3)
    stage = volumeCase.Stage(tmp_path / "t.usda", lights=options["lights"], width=1.2)
    expected, *_ = volumeCase.Render(stage, {"/V": plain}, 16, samples=4096)
    assert _Mean(computed["color"]) == pytest.approx(_Mean(expected["color"]), rel=_TOLERANCE)
    assert compare.RelMse(computed["color"][..., :3], expected["color"][..., :3]) <= 1e-3


def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path):
    """Scattering and asymmetry by noises, of three channels, and in no place above what collisions are as dense as."""
    look = dict(scattering=("multiply_color3", dict(in1=("multiply_color3FA", dict(in1=(9.0, 3.0, 1.0), in2=_DENSITY)),
                                                    in2=_NoiseNode(6.0, "color3FA"))),
                anisotropy=_NoiseNode(3.0))
    layers, _, warnings = _Render(tmp_path / "s.usda", look, dict(density=volumeCase.Grid(volumeCase.Cloud())), size=32, samples=2048)
    assert not warnings
    deviation = layers["color"][..., :3].std((0, 1)) / 32
    assert np.all(np.abs(_Mean(layers["color"]) - 1) < np.maximum(4 * deviation, 5e-4))


def test_an_image_is_looked_up_by_position(tmp_path):
    """An image across x and y, interpolated, with what lies outside of it repeated."""
    image = textureCases.KeptCodes(4, 8, 1, 3)
    imageFile.WritePng(tmp_path / "codes.png", image)
    at = ("convert_vector3_vector2", {"in": ("add_vector3FA", dict(in1=_PLACE, in2=0.5))})
    lookUp = ("image_float", dict(file=Sdf.AssetPath("./codes.png"), texcoord=at, uaddressmode="periodic", vaddressmode="periodic"))
    layers, _, warnings = _Render(tmp_path / "s.usda", dict(absorption=("multiply_color3FA", dict(in1=(2.0, 4.0, 1.0), in2=lookUp))),
                                  size=16, width=0.8, samples=4096)
    assert not warnings
    fine = ((np.arange(16 * 16) + 0.5) / 256 - 0.5) * 0.8 + 0.5
    s, t = np.meshgrid(fine, fine[::-1])
    amount = textureCases.Bilinear(image / 255.0, np.stack([s, t], -1))[..., 0]
    _, density, length = _Along(_UNIT[0, 0])
    depth = amount[..., None] * length * density.mean() * np.array((2.0, 4.0, 1.0))
    expected = np.exp(-depth).reshape(16, 16, 16, 16, 3).mean((1, 3))
    assert np.abs(layers["color"][..., :3] - expected).max() < 0.04
    assert _Mean(layers["color"]) == pytest.approx(expected.mean((0, 1)), rel=_TOLERANCE)


def test_asymmetry_by_position_is_that_of_two_volumes(tmp_path):
    """Forward on one side and backward on the other, by a condition on x; beside two volumes of a constant each."""
    scattering, sides = (2.0, 1.0, 3.0), (-0.6, 0.7)
    asymmetry = ("ifgreater_float", dict(value1=_Axis(0), value2=0.0, in1=sides[1], in2=sides[0]))
    density = np.ones((16, 16, 16))
    density[7:9] = 0  # nothing is where a voxel of one side would be looked up on the other
    lamp = ("Rect", dict(width=2.0, height=2.0, intensity=5.0, placement=dict(translate=(0.2, 2, -1), rotate=(-60, 0, 0))))
    options = dict(lights=(lamp,), width=1.2)
    one, *_ = _Render(tmp_path / "s.usda", dict(scattering=scattering, anisotropy=asymmetry), dict(density=volumeCase.Grid(density)),
                      samples=4096, **options)
    halves = {}
    for name, side, asymmetry in (("/A", slice(8, None), sides[0]), ("/B", slice(None, 8), sides[1])):
        half = density.copy()
        half[side] = 0
        halves[name] = volumeCase.Volume(volumeCase.Grid(half), scattering=scattering, anisotropy=asymmetry)
    two, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "t.usda", **options), halves, 16, samples=4096)
    assert _Mean(one["color"]) == pytest.approx(_Mean(two["color"]), rel=2 * _TOLERANCE)
    assert compare.RelMse(one["color"][..., :3], two["color"][..., :3]) <= 3e-3


_HOSTS = {
    "arnold": ("arnold:standard_volume",
               dict(density=_NoiseNode(4.0), scatter=1.0, scatter_color=_NoiseNode(3.0, "color3FA"), scatter_anisotropy=_NoiseNode(2.0),
                    transparent=(float(np.exp(-8.0)),) * 3, emission_mode="density", emission=_NoiseNode(5.0),
                    emission_color=(0.5, 0.2, 0.1))),
    "renderman": ("PxrVolume",
                  dict(densityFloat=_NoiseNode(4.0), extinctionDistance=0.125, diffuseColor=_NoiseNode(3.0, "color3FA"),
                       anisotropy=_NoiseNode(2.0), emitIntensity=_NoiseNode(5.0), emitColor=(0.5, 0.2, 0.1),
                       emitColorPrimVar="density")),
}


@pytest.mark.parametrize("name", _HOSTS)
def test_hosts_shaders_compute_as_materialX_does(tmp_path, name):
    """The same volume said by MaterialX: extinction 8 times noise times density, and what part of it scatters."""
    density = ("multiply_float", dict(in1=_NoiseNode(4.0), in2=_DENSITY))
    extinction = ("multiply_color3FA", dict(in1=(8.0, 8.0, 8.0), in2=density))
    albedo = _NoiseNode(3.0, "color3FA")
    look = dict(scattering=("multiply_color3", dict(in1=extinction, in2=albedo)),
                absorption=("multiply_color3", dict(in1=extinction, in2=("invert_color3", {"in": albedo}))), anisotropy=_NoiseNode(2.0),
                emission=("multiply_color3FA", dict(in1=(0.5, 0.2, 0.1), in2=("multiply_float", dict(in1=_NoiseNode(5.0), in2=_DENSITY)))))
    lamp = ("Rect", dict(placement=dict(translate=(0, 2, 0), rotate=(-90, 0, 0))))
    options = dict(lights=(("Dome", {}), lamp), width=1.2, samples=4096, grids=dict(density=volumeCase.Grid(volumeCase.Cloud())))
    host, _, warnings = _Render(tmp_path / "h.usda", dict(host=_HOSTS[name]), **options)
    ours, *_ = _Render(tmp_path / "m.usda", look, **options)
    assert not warnings
    assert _Mean(host["color"]) == pytest.approx(_Mean(ours["color"]), rel=_TOLERANCE)
    assert compare.RelMse(host["color"][..., :3], ours["color"][..., :3]) <= 1e-3


def test_guides_know_what_is_computed(tmp_path):
    """Beer's law of a colour that an image of two texels says, in the albedo of first hits."""
    imageFile.WritePng(tmp_path / "two.png", np.array([[[0], [255]]], np.uint8))
    at = ("combine2_vector2", dict(in1=("add_float", dict(in1=_Axis(0), in2=0.5)), in2=0.5))
    lookUp = ("image_float", dict(file=Sdf.AssetPath("./two.png"), texcoord=at, uaddressmode="clamp", vaddressmode="clamp"))
    look = dict(scattering=("multiply_color3FA", dict(in1=(3.0, 1.0, 2.0), in2=lookUp)), absorption=(1.0, 0.5, 0.0))
    for settings in (dict(residency="resident"), dict(residency="stream", textureMemory="8K")):
        layers, *_ = _Render(tmp_path / "s.usda", look, size=8, width=0.5, aovs=("color", "albedo"), samples=1, **settings)
        x = (np.arange(8) + 0.5) / 16 - 0.25
        amount = np.clip((x + 0.5) * 2 - 0.5, 0, 1)
        scattering = amount[:, None] * np.array((3.0, 1.0, 2.0))
        extinction = scattering + np.array((1.0, 0.5, 0.0))
        expected = scattering / extinction * (1 - np.exp(-extinction))
        np.testing.assert_allclose(layers["albedo"], np.broadcast_to(expected, layers["albedo"].shape), rtol=0.05)


def test_guides_do_not_wait_for_more_than_the_pool_holds(tmp_path):
    """A ray's guides read an image in each cell of a grid; in the smallest pool they are those of resident texels."""
    image = np.random.default_rng(3).integers(0, 256, (1024, 1024, 3)).astype(np.uint8)
    imageFile.WritePng(tmp_path / "large.png", image)
    along = ("combine2_vector2", dict(in1=_Axis(2), in2=_Axis(0)))
    lookUp = ("image_color3", dict(file=Sdf.AssetPath("./large.png"), texcoord=along))
    look = dict(scattering=("multiply_color3FA", dict(in1=lookUp, in2=2.0)), absorption=(1.0, 0.5, 0.2))
    grids = dict(density=volumeCase.Grid(volumeCase.Cloud(160)))
    layers = [_Render(tmp_path / "s.usda", look, grids, size=8, aovs=("color", "albedo"), samples=1, **settings)[0]["albedo"]
              for settings in (dict(residency="resident"), dict(residency="stream", textureMemory="7K"))]
    assert layers[0].max() > 0.1
    np.testing.assert_array_equal(layers[1], layers[0])


def _Busy(folder):
    """Patterns of all kinds in one material: noises, images, fields of other voxels, an asymmetry and a glow."""
    image = np.random.default_rng(1).integers(0, 256, (64, 64, 3)).astype(np.uint8)
    imageFile.WritePng(folder / "busy.png", image)
    at = ("convert_vector3_vector2", {"in": _PLACE})
    lookUp = ("image_color3", dict(file=Sdf.AssetPath("./busy.png"), texcoord=at))
    heat = ("geompropvalue_float", dict(geomprop="heat"))
    product = ("multiply_float", dict(in1=("smoothstep_float", {"in": _DENSITY, "low": 0.1, "high": 0.8}), in2=_NoiseNode(4.0)))
    look = dict(scattering=("multiply_color3FA", dict(in1=("multiply_color3FA", dict(in1=lookUp, in2=9.0)), in2=product)),
                absorption=("multiply_color3FA", dict(in1=(1.0, 2.0, 0.5), in2=_DENSITY)),
                anisotropy=_NoiseNode(2.0),
                emission=("multiply_color3FA", dict(in1=(0.4, 0.2, 0.1), in2=("power_float", dict(in1=heat, in2=2.0)))))
    grids = dict(density=volumeCase.Grid(volumeCase.Cloud(40)), heat=volumeCase.Grid(volumeCase.Cloud(24, 5)))
    return look, grids


@pytest.fixture(scope="module")
def resident(tmp_path_factory):
    folder = tmp_path_factory.mktemp("patterns")
    layers, *_ = _Render(folder / "s.usda", *_Busy(folder), lights=(("Dome", {}), ("Rect", {})), samples=8, residency="resident",
                         aovs=("color", "albedo"))
    return folder, layers


@pytest.mark.parametrize("settings", [
    dict(textureMemory="100%"), dict(textureMemory="10%"), dict(textureMemory="16K", waveSize=64),
    dict(traversal="scalar", residency="resident"), dict(volumeMemory="16K"), dict(waveSize=777, residency="resident")], ids=str)
def test_bits_are_the_same(resident, settings):
    folder, expected = resident
    layers, statistics, warnings = _Render(folder / "s.usda", *_Busy(folder), lights=(("Dome", {}), ("Rect", {})), samples=8,
                                           aovs=("color", "albedo"), **{"residency": "stream", **settings})
    assert not warnings
    for name, layer in expected.items():
        assert np.array_equal(layers[name], layer), name
    if settings.get("residency") != "resident":
        assert statistics["texture"]["uniqueBytesLoaded"] > 0


def test_patterns_go_along_with_what_moves(tmp_path):
    """A wave along x in a block that a velocity carries along x while the shutter is open, against a quadrature."""
    velocity = np.zeros((32, 32, 32, 3))
    velocity[..., 0] = 0.5  # a second, in object space, which the stage scales by 1.25
    try:
        path = test_volumeMotion._Stage(tmp_path, np.ones((32, 32, 32)), velocity, 1 / 16, (-24.0, 24.0), 0.4, width=1.0)
    except FileNotFoundError as error:
        pytest.skip(str(error))
    stage = Usd.Stage.Open(path)
    wave = ("sin_float", {"in": ("multiply_float", dict(in1=_Axis(0), in2=8.0))})
    node, name = _Add(stage, ("multiply_color3FA", dict(in1=(0.4, 0.4, 0.4), in2=("add_float", dict(in1=1.5, in2=wave)))))
    UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Medium")).GetInput("absorption").ConnectToSource(node.GetOutput(name))
    stage.GetRootLayer().Save()
    picture = test_volumeMotion._Render(path, 8, samples=4096)
    assert not picture.warnings
    x = (((np.arange(8 * 32) + 0.5) / 256 - 0.5) / 1.25)[:, None] - 0.5 * ((np.arange(256) + 0.5) / 256 - 0.5)[None]
    expected = np.exp(-0.4 * 2.5 * (1.5 + np.sin(8 * x))).reshape(8, 32 * 256).mean(1)
    assert picture.rgb[..., 0].mean(0) == pytest.approx(expected, abs=0.01)
    assert picture.rgb[..., 0].mean() == pytest.approx(expected.mean(), rel=_TOLERANCE)


_BAD = {
    "no bound": (("divide_float", dict(in1=1.0, in2=_Axis(2))), "no bound (a clamp gives it one)"),
    "no place in the world": (("magnitude_vector3", {"in": ("position_vector3", dict(space="world"))}), "the position in world space"),
    "no surface": (("magnitude_vector3", {"in": ("normal_vector3", {})}), "normals, tangents, directions or slopes"),
}


@pytest.mark.parametrize("name", _BAD)
def test_what_cannot_be_drawn_is_one_warning(tmp_path, name):
    """The products of such patterns are left out, and the rest is drawn."""
    network, text = _BAD[name]
    layers, _, warnings = _Render(tmp_path / "s.usda", dict(absorption=(1.0, 1.0, 1.0), scattering=_Times(network)),
                                  size=8, width=0.5, samples=512)
    assert len(warnings) == 1 and text in str(warnings[0]) and "/World/Smoke" in str(warnings[0])
    assert _Mean(layers["color"]) == pytest.approx(np.exp(-1), rel=0.03)


def test_a_network_that_turns_in_circles_ends(tmp_path):
    """A product of itself with itself, which would have no end."""
    def AddCircle(stage):
        node = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Circle"))
        for name in ("in1", "in2"):
            node.CreateInput(name, _T.Color3f).ConnectToSource(node.GetOutput("out"))

    def Add(stage):
        _AddLook(stage, absorption=(1.0, 1.0, 1.0))
        AddNode(stage, "/World/Look/Circle", "ND_multiply_color3")
        vdf = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Vdf"))
        vdf.CreateInput("scattering", _T.Color3f).ConnectToSource(stage.GetPrimAtPath("/World/Look/Circle").GetPath().AppendProperty("outputs:out"))
        AddCircle(stage)

    volume = _core.VolumePrim(_core.Placement(np.eye(4)), "default", "/World/Look")
    volume.SetGrid("density", volumeCase.Grid(_UNIT))
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5, add=Add), {"/World/Smoke": volume}, 8, samples=64)
    assert len(warnings) == 1 and "a cycle, or too large" in str(warnings[0])
    assert np.isfinite(layers["color"]).all()
