# SPDX-License-Identifier: Apache-2.0
"""Volumes whose coefficients are sums of products of fields: closed forms, quadratures, Mitsuba, and bits."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import ours
import test_volumeMotion
import volumeCase
from pxr import Sdf, Usd, UsdShade, UsdVol
from stages import smoke

_DARK = (("Dome", dict(intensity=0.0)),)
_UNIT = np.ones((16, 16, 16))  # of edge 1
_NONE = (0.0, 0.0, 0.0)
# One number for the closed forms of this file; docs/volumes.md says it too.
_TOLERANCE = 0.01


def _Volume(grids, terms, **options):
    """\\param grids: by name. \\param terms: (names, absorption, scattering, emission)."""
    volume = volumeCase.Volume(None, **options)
    for name, grid in grids.items():
        volume.SetGrid(name, grid)
    for names, *coefficients in terms:
        volume.AddTerm(names, *[tuple(np.broadcast_to(value, 3).astype(float)) for value in coefficients])
    return volume


def _Mean(picture):
    return picture[..., :3].astype(np.float64).reshape(-1, 3).mean(0)


def _Slice(values, size=16):
    """Of edge 1: values along z, even across."""
    return np.broadcast_to(np.asarray(values, float), (size, size, len(values))).copy()


def _Along(values, size):
    """Linear interpolation along z at 4096 points of a cube of edge 1, and half a voxel's fading beyond each end."""
    at = (np.arange(4096) + 0.5) / 4096 * (size + 2) - 1.5  # in voxels; their centres are integers
    return np.interp(at, np.arange(-1, size + 1), np.concatenate([[0.0], values, [0.0]])), (size + 2) / size


def test_absorption_is_the_integral_of_the_sum(tmp_path):
    """Three products with other fields in each channel, a field squared, one below 0, beside Beer's law by quadrature."""
    random = np.random.default_rng(4)
    a, b = random.random(16) * 2, random.random(16)
    terms = [(["a", "b"], (1.0, 0.0, 2.0), _NONE, _NONE), (["a"], (0.0, 1.5, 0.5), _NONE, _NONE),
             (["b", "b"], (0.5, 1.0, 0.0), _NONE, _NONE), (["a", "b"], (0.0, -1.0, 0.0), _NONE, _NONE)]
    grids = dict(a=volumeCase.Grid(_Slice(a)), b=volumeCase.Grid(_Slice(b)))
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5),
                                            {"/V": _Volume(grids, terms)}, size=32, samples=2048)
    assert not warnings
    (fa, length), (fb, _) = _Along(a, 16), _Along(b, 16)
    depth = length * np.array([(fa * fb + 0.5 * fb * fb).mean(), (1.5 * fa + fb * fb - fa * fb).mean(),
                               (2 * fa * fb + 0.5 * fa).mean()])
    assert _Mean(layers["color"]) == pytest.approx(np.exp(-depth), rel=_TOLERANCE)


def test_fields_of_other_resolution_and_place(tmp_path):
    """A density of 16 voxels times a colour of 5 in another place, which ends inside of it."""
    random = np.random.default_rng(5)
    a, c = random.random(16) * 2, random.random(5) + 0.5
    place = np.diag([0.5, 0.5, 0.15, 1.0])
    place[3, :3] = (-1.0, -1.0, -0.4)  # its voxels are at z = -0.4 + 0.15 k
    grids = dict(a=volumeCase.Grid(_Slice(a)), c=volumeCase.Grid(_Slice(c, 5), objectFromIndex=place))
    terms = [(["a", "c"], (1.0, 0.0, 2.0), _NONE, _NONE), (["c"], (0.0, 1.0, 0.0), _NONE, _NONE)]
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.4), {"/V": _Volume(grids, terms)},
                                   size=32, samples=2048)
    z = (np.arange(8192) + 0.5) / 8192 * 2 - 1
    fa = np.interp(z, (np.arange(-1, 17) - 7.5) / 16, np.concatenate([[0], a, [0]]))
    fc = np.interp(z, -0.4 + 0.15 * np.arange(-1, 6), np.concatenate([[0], c, [0]]))
    expected = np.exp(-2 * np.array([(fa * fc).mean(), fc.mean(), 2 * (fa * fc).mean()]))
    assert _Mean(layers["color"]) == pytest.approx(expected, rel=_TOLERANCE)


def test_shadows_are_dimmed_by_the_sum(tmp_path):
    from test_volumes import _AddWall

    random = np.random.default_rng(6)
    a, b = random.random(16) + 0.2, random.random(16) + 0.2
    terms = [(["a"], (0.5, 0.0, 0.2), _NONE, _NONE), (["b"], (0.0, 0.5, 0.2), _NONE, _NONE),
             (["a", "b"], (0.3, 0.3, 1.0), _NONE, _NONE)]
    grids = dict(a=volumeCase.Grid(_Slice(a)), b=volumeCase.Grid(_Slice(b)))
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=(("Distant", dict(angle=0.0)),), width=0.5, add=_AddWall)
    dark, *_ = volumeCase.Render(stage, {"/V": _Volume(grids, terms)}, size=32, samples=2048)
    bright, *_ = volumeCase.Render(stage, {}, size=32, samples=16)
    (fa, length), (fb, _) = _Along(a, 16), _Along(b, 16)
    both = length * np.stack([fa, fb, fa * fb]).mean(1)
    depth = np.array([[0.5, 0, 0.3], [0, 0.5, 0.3], [0.2, 0.2, 1.0]]) @ both
    assert _Mean(dark["color"]) / _Mean(bright["color"]) == pytest.approx(np.exp(-2 * depth), rel=2 * _TOLERANCE)


def test_emission_of_products_without_extinction_is_its_integral(tmp_path):
    """Of a colour of three fields, with nothing that takes light: no field is called density."""
    red, heat = volumeCase.Cloud(16, 1), volumeCase.Cloud(16, 2)
    terms = [(["red", "heat"], _NONE, _NONE, (1.0, 0.0, 0.5)), (["heat"], _NONE, _NONE, (0.0, 2.0, 0.0))]
    grids = dict(red=volumeCase.Grid(red), heat=volumeCase.Grid(heat))
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", lights=_DARK), {"/V": _Volume(grids, terms)},
                                            size=32, samples=1024)
    assert not warnings
    # The integral of a product of linear interpolations: by Simpson's weights of each pair of neighbours, along each axis.
    product = 0.0
    for step in np.ndindex(3, 3, 3):
        shift = np.array(step) - 1
        weight = np.prod(np.where(shift == 0, 2 / 3, 1 / 6))
        padded = np.pad(heat, 1)
        other = padded[tuple(slice(1 + s, 17 + s) for s in shift)]
        product += weight * (red * other).mean()
    assert _Mean(layers["color"]) == pytest.approx(np.array([product, 2 * heat.mean(), 0.5 * product]) / 4, rel=_TOLERANCE)


@pytest.mark.parametrize("anisotropy", [0.0, 0.6])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, anisotropy):
    """Scattering by three fields, a channel each."""
    grids = {name: volumeCase.Grid(volumeCase.Cloud(24, seed)) for name, seed in (("r", 1), ("g", 2), ("b", 3))}
    terms = [(["r"], _NONE, (6.0, 0.0, 1.0), _NONE), (["g"], _NONE, (0.0, 6.0, 0.0), _NONE),
             (["r", "b"], _NONE, (0.0, 1.0, 9.0), _NONE)]
    volume = _Volume(grids, terms, anisotropy=anisotropy)
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volume}, size=32, samples=2048)
    deviation = layers["color"][..., :3].std((0, 1)) / 32
    assert np.all(np.abs(_Mean(layers["color"]) - 1) < np.maximum(4 * deviation, 5e-4))


def test_no_scattering_is_above_the_extinction(tmp_path):
    """An absorption below 0, which a colour above 1 makes: a furnace stays at 1."""
    grids = dict(density=volumeCase.Grid(volumeCase.Cloud(16, 1)), Cd=volumeCase.Grid(volumeCase.Cloud(16, 2) * 3))
    terms = [(["density"], 4.0, _NONE, _NONE), (["Cd", "density"], -4.0, 4.0, _NONE)]
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": _Volume(grids, terms)}, size=32, samples=512)
    assert layers["color"][..., :3].max() < 1.001


def _Colored(channels=("r", "g", "b"), extinction=12.0, **options):
    """A density, and an albedo by three fields."""
    density, colors = _ColoredVoxels()
    grids = dict(density=volumeCase.Grid(density), **{name: volumeCase.Grid(color) for name, color in zip(channels, colors)})
    terms = [(["density"], extinction, _NONE, _NONE)]
    for number, name in enumerate(channels):
        own = extinction * np.eye(3)[number]
        terms.append((["density", name], -own, own, _NONE))
    return _Volume(grids, terms, **options)


def _ColoredVoxels(size=24):
    density = volumeCase.Cloud(size)
    density[[0, -1]] = density[:, [0, -1]] = density[:, :, [0, -1]] = 0.0  # beyond its grid Mitsuba goes on, we fade
    return density, [0.3 + 0.7 * np.random.default_rng(seed).random((size,) * 3) for seed in (11, 12, 13)]


def test_a_cloud_of_colors_equals_mitsubas(tmp_path):
    """Mitsuba's volpathmis with a grid of albedos."""
    mi = pytest.importorskip("mitsuba")
    import mitsubaScene
    from test_volumes import _MitsubaCloud

    mitsubaScene.UseVariant("scalar_rgb")
    density, colors = _ColoredVoxels()
    grid = mi.VolumeGrid(np.ascontiguousarray(np.stack(colors, -1).transpose(2, 1, 0, 3)).astype(np.float32))
    fits = mi.ScalarTransform4f().translate([-0.5, -0.5, -0.5])
    albedo = dict(type="gridvolume", grid=grid, to_world=fits, wrap_mode="clamp", raw=True)
    lamp = ("Rect", dict(width=6.0, height=6.0, intensity=1.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", lights=(lamp,), width=1.2),
                                   {"/V": _Colored(anisotropy=0.4)}, samples=4096)
    picture = layers["color"][..., :3].astype(np.float64)
    reference = _MitsubaCloud(density, 12.0, albedo, 0.4, 1024)
    assert picture.mean((0, 1)) == pytest.approx(reference.mean((0, 1)), rel=_TOLERANCE)
    assert compare.RelMse(picture, reference) <= 1e-3


def _Mixed():
    """One with terms, that glows, beside one without, in the same place."""
    colored = _Colored()
    colored.AddTerm(["density", "r"], _NONE, _NONE, (0.2, 0.0, 0.4))
    plain = volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud(40, 5)), scattering=(2, 5, 1), absorption=1.0)
    return {"/A": colored, "/B": plain}


@pytest.fixture(scope="module")
def resident(tmp_path_factory):
    path = volumeCase.Stage(tmp_path_factory.mktemp("terms") / "s.usda", lights=(("Dome", {}), ("Rect", {})))
    return path, volumeCase.Render(path, _Mixed(), samples=8, residency="resident")[0]["color"]


@pytest.mark.parametrize("settings", [
    dict(textureMemory="100%"), dict(textureMemory="5%"), dict(textureMemory="2%", waveSize=64),
    dict(traversal="scalar", residency="resident"), dict(volumeMemory="16K"), dict(waveSize=777, residency="resident")], ids=str)
def test_bits_are_the_same(resident, settings):
    path, expected = resident
    layers, statistics, _ = volumeCase.Render(path, _Mixed(), samples=8, **{"residency": "stream", **settings})
    assert np.array_equal(layers["color"], expected)
    if settings.get("residency") != "resident":
        assert statistics["texture"]["uniqueBytesLoaded"] > 0


def test_one_term_is_the_plain_form(tmp_path):
    """The picture of a volume of one density, said as a term: the same but for noise."""
    lamp = ("Rect", dict(placement=dict(translate=(0, 2, 0), rotate=(-90, 0, 0))))
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=(("Dome", {}), lamp))
    grid, options = volumeCase.Grid(volumeCase.Cloud()), dict(anisotropy=0.5)
    plain = volumeCase.Volume(grid, absorption=(1, 2, 0.5), scattering=(8, 4, 6), emission=(0.5, 0, 1), **options)
    terms = _Volume(dict(density=grid), [(["density"], (1, 2, 0.5), (8, 4, 6), (0.5, 0, 1))], **options)
    a = volumeCase.Render(stage, {"/V": plain}, samples=4096)[0]["color"]
    b = volumeCase.Render(stage, {"/V": terms}, samples=4096)[0]["color"]
    assert _Mean(b) == pytest.approx(_Mean(a), rel=_TOLERANCE / 2)
    assert compare.RelMse(b[..., :3], a[..., :3]) <= 1e-3


def test_guides_know_the_color_of_each_cell(tmp_path):
    """Beer's law of two halves of other albedo, in the albedo of first hits; and the depth of half the light."""
    near, far = _UNIT.copy(), _UNIT.copy()
    near[..., :8] = 0  # z >= 0, at the camera's side
    far[..., 8:] = 0
    grids = dict(near=volumeCase.Grid(near), far=volumeCase.Grid(far))
    terms = [(["near"], _NONE, (1.0, 0.5, 2.0), _NONE), (["far"], (0.5, 1.0, 0.0), (0.5, 0.0, 1.0), _NONE)]
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5), {"/V": _Volume(grids, terms)},
                                   aovs=("color", "albedo", "volumeDepth"), samples=1)
    scattering = np.array((1.0, 0.5, 2.0)) / 2 + np.array((0.5, 0.0, 1.0)) / 2
    extinction = scattering + np.array((0.5, 1.0, 0.0)) / 2
    expected = scattering / extinction * (1 - np.exp(-extinction))
    np.testing.assert_allclose(layers["albedo"], np.broadcast_to(expected, layers["albedo"].shape), rtol=_TOLERANCE)
    # The mean of the channels is 3.5 / 3 a unit of length before the middle, and 1 behind it.
    np.testing.assert_allclose(layers["volumeDepth"], 10 + (np.log(2) - 3.5 / 6) / 1.0, atol=1 / 16)


def _AddFactor(path, tmp_path, voxel):
    """Makes a stage of test_volumeMotion absorb by the product of its density with a field of ones in voxels half as large."""
    smoke.WriteVdb(tmp_path / "ones.vdb", voxel / 2, (-40,) * 3, ones=np.ones((80, 80, 80)))
    stage = Usd.Stage.Open(path)
    volume = UsdVol.Volume(stage.GetPrimAtPath("/World/Smoke"))
    asset = UsdVol.OpenVDBAsset.Define(stage, "/World/Smoke/ones")
    asset.CreateFilePathAttr("./ones.vdb")
    volume.CreateFieldRelationship("ones", asset.GetPath())
    medium = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Medium"))
    product = smoke.AddShader(stage, "/World/Look/Product", "ND_multiply_color3")
    for name, field in (("in1", "density"), ("in2", "ones")):
        reader = smoke.AddShader(stage, f"/World/Look/{field}", "ND_geompropvalue_float", geomprop=field)
        UsdShade.Shader(product.GetPrim()).CreateInput(name, Sdf.ValueTypeNames.Color3f).ConnectToSource(reader)
    medium.GetInput("absorption").ConnectToSource(product)
    stage.GetRootLayer().Save()


def test_what_moves_is_looked_up_by_all_factors(tmp_path):
    """A product of two fields of other voxels, carried by a velocity while the shutter is open, against a quadrature."""
    density = volumeCase.Cloud(16) * 3
    velocity = np.random.default_rng(2).uniform(-0.5, 0.5, (16, 16, 16, 3))
    velocity[:5] = 0
    shutter, size, width, voxel = (-24.0, 24.0), 8, 2.0, 1 / 16
    path = test_volumeMotion._Stage(tmp_path, density, velocity, voxel, shutter, 2.0, width=width)
    _AddFactor(path, tmp_path, voxel)
    picture = test_volumeMotion._Render(path, size, samples=4096)
    assert not picture.warnings
    expected = test_volumeMotion._Expected(density, velocity.astype(np.float32), voxel, voxel, shutter, 1.0, size, width, 256, 96)
    assert picture.rgb[..., 0].mean() == pytest.approx(expected.mean(), abs=0.004)
    assert picture.rgb[..., 0] == pytest.approx(expected, abs=0.025)
    streamed = test_volumeMotion._Render(path, size, samples=8, residency="stream", volumeMemory="16K", waveSize=64)
    assert np.array_equal(streamed.rgb, test_volumeMotion._Render(path, size, samples=8, residency="resident").rgb)


def _Network(stage, path):
    """density x mix(dark, Cd, 1) as scattering, density x (1 - Cd) as absorption, heat x Cd as emission."""
    look = UsdShade.Material.Define(stage, path)

    def Add(name, identifier, **inputs):
        shader = UsdShade.Shader.Define(stage, f"{path}/{name}")
        shader.CreateIdAttr(identifier)
        for key, value in inputs.items():
            if isinstance(value, str):
                shader.CreateInput(key, Sdf.ValueTypeNames.String).Set(value)
            elif isinstance(value, UsdShade.Output):
                shader.CreateInput(key, Sdf.ValueTypeNames.Color3f).ConnectToSource(value)
            else:
                shader.CreateInput(key, Sdf.ValueTypeNames.Color3f).Set(value)
        return shader.CreateOutput("out", Sdf.ValueTypeNames.Color3f)

    density = Add("Density", "ND_geompropvalue_float", geomprop="density")
    color = Add("Color", "ND_geompropvalue_color3", geomprop="Cd")
    heat = Add("Heat", "ND_geompropvalue_float", geomprop="heat")
    rest = Add("Rest", "ND_invert_color3", **{"in": color})
    absorption = Add("Absorption", "ND_multiply_color3FA", in1=rest, in2=density)
    mixed = Add("Mixed", "ND_mix_color3", bg=(9.0, 9.0, 9.0), fg=color, mix=(1.0, 1.0, 1.0))
    scattering = Add("Scattering", "ND_multiply_color3FA", in1=mixed, in2=density)
    vdf = Add("Vdf", "ND_anisotropic_vdf", absorption=absorption, scattering=scattering)
    glow = Add("Glow", "ND_multiply_color3FA", in1=color, in2=heat)
    edf = Add("Edf", "ND_uniform_edf", color=glow)
    look.CreateVolumeOutput("mtlx").ConnectToSource(Add("Volume", "ND_volume", vdf=vdf, edf=edf))
    return look


def test_a_network_of_a_vector_grid(tmp_path):
    """From USD: a slab with a colour grid of an OpenVDB file, beside the same volume by terms of three scalar grids."""
    size = 16
    density, colors = _ColoredVoxels(size)
    heat = volumeCase.Cloud(size, 8)
    try:
        smoke.WriteVdb(tmp_path / "smoke.vdb", 1 / size, (0, 0, 0), density=4 * density, Cd=np.stack(colors, -1), heat=heat)
    except FileNotFoundError as error:
        pytest.skip(str(error))

    def Add(stage):
        smoke._AddVolume(stage, "/World/Smoke", "smoke.vdb", _Network(stage, "/World/Look"), (-0.5 + 0.5 / size,) * 3, 1.0,
                         density="density", Cd="Cd", heat="heat")

    lights = (("Dome", dict(intensity=0.3)), ("Rect", dict(intensity=3.0, placement=dict(translate=(0, 2, 0), rotate=(-90, 0, 0)))))
    picture = ours.Render(volumeCase.Stage(tmp_path / "s.usda", width=1.2, lights=lights, add=Add), 16, 16, samples=4096)
    assert not picture.warnings
    grids = {name: volumeCase.Grid(voxels) for name, voxels in zip(("density", "heat", *"rgb"), (density, heat, *colors))}
    terms = [(["density"], 4.0, _NONE, _NONE)]
    for number, name in enumerate("rgb"):
        own = np.eye(3)[number]
        terms += [(["density", name], -4.0 * own, 4.0 * own, _NONE), (["heat", name], _NONE, _NONE, own)]
    expected, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "t.usda", width=1.2, lights=lights), {"/V": _Volume(grids, terms)},
                                     samples=4096)
    assert picture.rgb.mean((0, 1)) == pytest.approx(_Mean(expected["color"]), rel=_TOLERANCE)
    assert compare.RelMse(picture.rgb, expected["color"][..., :3]) <= 1e-3


def test_fields_that_are_missing_take_their_terms_along(tmp_path):
    terms = [(["density"], 1.0, _NONE, _NONE), (["density", "Cd"], 5.0, _NONE, _NONE)]
    volume = _Volume(dict(density=volumeCase.Grid(_UNIT)), terms)
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5), {"/V": volume}, size=16, samples=1024)
    assert len(warnings) == 1 and "without the field 'Cd'" in str(warnings[0])
    assert _Mean(layers["color"]) == pytest.approx(np.exp(-1), rel=0.02)


def test_too_many_products_are_one_warning_each(tmp_path):
    terms = [(["density"] * 5, 1.0, _NONE, _NONE), (["density"], 1.0, _NONE, _NONE)]
    volume = _Volume(dict(density=volumeCase.Grid(_UNIT)), terms)
    _, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5), {"/V": volume}, size=8, samples=4)
    assert len(warnings) == 1 and "too many products of fields" in str(warnings[0])
