# SPDX-License-Identifier: Apache-2.0
"""Volumes in pictures: closed forms, brute-force integrals, and the same bits at any budget."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import ours
import volumeCase
from pxr import UsdGeom
from stages import author, shapes
from stages.smoke import WriteVdb

_DARK = (("Dome", dict(intensity=0.0)),)
_UNIT = np.ones((16, 16, 16))  # of edge 1: interpolation fades over half a voxel beyond


def _Mean(picture, rows=slice(None)):
    return picture[rows, rows, :3].astype(np.float64).reshape(-1, 3).mean(0)


@pytest.mark.parametrize("density, scattering, anisotropy", [
    (_UNIT, 3.0, 0.0), (_UNIT, (0.5, 2.0, 8.0), 0.7), (volumeCase.Cloud(), (1.0, 4.0, 8.0), -0.5)])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, density, scattering, anisotropy):
    volume = volumeCase.Volume(volumeCase.Grid(density), scattering=scattering, anisotropy=anisotropy)
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volume}, size=32, samples=2048)
    assert not warnings
    deviation = layers["color"][..., :3].std((0, 1)) / 32
    assert np.all(np.abs(_Mean(layers["color"]) - 1) < np.maximum(4 * deviation, 5e-4))


@pytest.mark.parametrize("absorption, samples, tolerance", [
    ((1.0, 2.0, 0.5), 1024, dict(rel=0.01, abs=1e-3)),  # events are chances: those of thin slabs say more for the same samples
    ((0.2, 0.1, 0.05), 8192, dict(rel=1e-3)), ((0.2, 0.2, 0.2), 8192, dict(rel=1e-3))], ids=["deep", "thin", "grey"])
def test_absorption_is_beers(tmp_path, absorption, samples, tolerance):
    absorption = np.array(absorption)
    volume = volumeCase.Volume(volumeCase.Grid(_UNIT), absorption=absorption, scale=2.0)
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=1.0), {"/V": volume}, size=32, samples=samples)
    assert _Mean(layers["color"]) == pytest.approx(np.exp(-2 * absorption), **tolerance)
    assert layers["color"][..., 3].mean() > 0.99  # the dome behind it


@pytest.mark.parametrize("axis", range(3))
def test_each_pixel_has_the_integral_of_its_linear_interpolation(tmp_path, axis):
    """A row of pixels across voxels of different density: what is between two voxels is their mix."""
    shape = np.full(3, 3)
    shape[axis] = 4
    density = np.zeros(shape)
    np.moveaxis(density, axis, 0)[:] = np.array((0.0, 4.0, 1.0, 8.0))[:, None, None]
    place = np.eye(4)[[(k - axis) % 3 for k in range(3)] + [3]]  # the axis goes along x
    place[3, :3] = (-1.5, -1.0, -1.0)
    volume = volumeCase.Volume(volumeCase.Grid(density, objectFromIndex=place), absorption=0.25)
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=4.0), {"/V": volume}, size=32, samples=4096)
    x = (np.arange(32) + 0.5) / 8 - 2 + 1.5
    fine = x[:, None] + (np.arange(64) + 0.5)[None, :] / 512 - 1 / 16
    along = np.interp(fine, np.arange(-1, 5), (0.0, 0.0, 4.0, 1.0, 8.0, 0.0))
    expected = np.exp(-0.25 * along * 3.0).mean(1)  # three voxels deep, with the ends that fade
    assert layers["color"][14:18, :, 0].mean(0) == pytest.approx(expected, abs=0.012)


def test_alpha_is_what_is_in_the_way(tmp_path):
    volume = volumeCase.Volume(volumeCase.Grid(_UNIT), scattering=0.3, absorption=0.7)
    stage = volumeCase.Stage(tmp_path / "s.usda", width=0.5, lights=(("Sphere", dict(placement=dict(translate=(0, 5, 0)))),))
    layers, *_ = volumeCase.Render(stage, {"/V": volume}, size=32, samples=1024)
    assert layers["color"][..., 3].mean() == pytest.approx(1 - np.exp(-1), rel=0.01)


def test_emission_without_extinction_is_its_integral(tmp_path):
    density, emission = volumeCase.Cloud(16, 1), volumeCase.Cloud(16, 2)
    volume = volumeCase.Volume(volumeCase.Grid(density), volumeCase.Grid(emission), emission=(1.0, 0.0, 2.0))
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=_DARK)
    layers, *_ = volumeCase.Render(stage, {"/V": volume}, size=32, samples=1024)
    total = emission.mean() * np.array((1.0, 0.0, 2.0)) / 4  # a cube of edge 1 in a window of 2 x 2
    assert _Mean(layers["color"]) == pytest.approx(total, rel=0.01)


def test_emission_is_dimmed_by_what_is_before_it(tmp_path):
    """A slab that glows as it absorbs: (1 - exp(-sigma)) emission / sigma, by channel."""
    sigma = np.array((0.5, 1.0, 4.0))
    volume = volumeCase.Volume(volumeCase.Grid(_UNIT), absorption=sigma, emission=(1.0, 2.0, 3.0))
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=_DARK, width=0.5)
    layers, *_ = volumeCase.Render(stage, {"/V": volume}, size=32, samples=1024)
    assert _Mean(layers["color"]) == pytest.approx(np.array((1.0, 2.0, 3.0)) * (1 - np.exp(-sigma)) / sigma, rel=0.01)


def test_two_volumes_in_one_place_are_their_sum(tmp_path):
    """Of different colours: what the weights of one walk leave out shows in the other channels."""
    stage = volumeCase.Stage(tmp_path / "s.usda", width=0.5)
    a = dict(absorption=(0.2, 1.0, 0.0), emission=(0.3, 0.0, 0.5))
    b = dict(absorption=(1.0, 0.1, 2.0), emission=(0.0, 0.4, 0.1))
    sigma = np.add(a["absorption"], b["absorption"])
    expected = np.exp(-sigma) + np.add(a["emission"], b["emission"]) * (1 - np.exp(-sigma)) / sigma
    layers, *_ = volumeCase.Render(stage, {"/A": volumeCase.Volume(volumeCase.Grid(_UNIT), **a),
                                           "/B": volumeCase.Volume(volumeCase.Grid(_UNIT), **b)}, size=32, samples=2048)
    assert _Mean(layers["color"]) == pytest.approx(expected, rel=0.012)


def test_instances_are_volumes(tmp_path):
    """A slab at its own place, and twice more by an instancer: exp(-3 sigma)."""
    def AddInstances(stage):
        _AddSmoke(stage)
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/I")
        instancer.CreatePositionsAttr([(0, 0, -1.5), (0, 0, -3)])
        instancer.CreateProtoIndicesAttr([0, 0])
        instancer.CreatePrototypesRel().SetTargets(["/World/Smoke"])

    _WriteVdb(tmp_path / "smoke.vdb", density=_UNIT, flame=0 * _UNIT + 1e-30)
    picture = ours.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5, add=AddInstances), 32, 32, samples=1024)
    assert not picture.warnings
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(np.exp(-3 * np.array((0.5, 1.0, 2.0))), rel=0.02, abs=1e-3)
    assert picture.statistics["volume"]["volumes"] == 3 and picture.statistics["volume"]["grids"] == 2


def test_instances_of_scale_0_take_no_other(tmp_path):
    """As particles are hidden: exp(-3 sigma) of the others, and a line."""
    def AddInstances(stage):
        _AddSmoke(stage)
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/I")
        instancer.CreatePositionsAttr([(0, 0, -1.5), (0, 0, -5), (0, 0, -3)])
        instancer.CreateScalesAttr([(1, 1, 1), (0, 0, 0), (1, 1, 1)])
        instancer.CreateProtoIndicesAttr([0, 0, 0])
        instancer.CreatePrototypesRel().SetTargets(["/World/Smoke"])

    _WriteVdb(tmp_path / "smoke.vdb", density=_UNIT, flame=0 * _UNIT + 1e-30)
    picture = ours.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5, add=AddInstances), 32, 32, samples=1024)
    assert len(picture.warnings) == 1 and "1 instances of a volume dropped" in str(picture.warnings[0])
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(np.exp(-3 * np.array((0.5, 1.0, 2.0))), rel=0.02, abs=1e-3)
    assert picture.statistics["volume"]["volumes"] == 3


def test_shadows_are_beers(tmp_path):
    """A floor below a slab, lit from above: exp(-sigma) of what it is without the slab."""
    absorption = np.array((0.5, 1.0, 2.0))
    grid = volumeCase.Grid(_UNIT)
    volume = volumeCase.Volume(grid, absorption=absorption, scale=1.0)
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=(("Distant", dict(angle=0.0)),), width=0.5, add=_AddWall)
    dark, *_ = volumeCase.Render(stage, {"/V": volume}, size=32, samples=512)
    bright, *_ = volumeCase.Render(stage, {}, size=32, samples=16)
    # Along -z both ways: the light comes and the picture is seen through the slab.
    assert _Mean(dark["color"]) / _Mean(bright["color"]) == pytest.approx(np.exp(-2 * absorption), rel=0.02)


def test_shadows_of_a_cloud_are_the_integrals_of_its_voxels(tmp_path):
    """Seen and lit along -z through voxels of which each differs: exp(-2 depth), by channel, pixel blocks and mean."""
    size, absorption = 24, np.array((0.5, 2.0, 4.0))
    voxels = volumeCase.Cloud(size) + 0.25
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=(("Distant", dict(angle=0.0)),), width=0.5, add=_AddWall)
    dark, *_ = volumeCase.Render(stage, {"/V": volumeCase.Volume(volumeCase.Grid(voxels), absorption=absorption)}, size=32,
                                 samples=2048)
    bright, *_ = volumeCase.Render(stage, {}, size=32, samples=16)
    at = ((np.arange(256) + 0.5) / 256 - 0.5) * 0.5 * size + 0.5 * (size - 1)  # in voxels, eight points a pixel
    columns = voxels.sum(2) / size
    along = np.array([np.interp(at, np.arange(size), row) for row in columns.T]).T  # [x][voxel of y]
    depth = np.array([np.interp(at, np.arange(size), row) for row in along])[:, ::-1].T  # [row][x]
    exact = np.exp(-2 * depth[..., None] * absorption).reshape(8, 32, 8, 32, 3).mean((1, 3))
    ratio = (dark["color"][..., :3] / bright["color"][..., :3].mean()).reshape(8, 4, 8, 4, 3).mean((1, 3))
    assert ratio.mean((0, 1)) == pytest.approx(exact.mean((0, 1)), rel=0.02)
    assert np.abs(ratio / exact - 1)[..., :2].max() < 0.12


def _AddWall(stage):
    wall = shapes.Sphere(0.4, 4, 8)
    author.AddMesh(stage, "/World/Wall", wall, translate=(0, 0, -2), scale=(8, 8, 0.01))


def _TwoVolumes():
    return {
        "/A": volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud()), volumeCase.Grid(volumeCase.Cloud(24, 9)), scale=1.5,
                                scattering=(3, 1, 8), absorption=(0.5, 0.1, 0.0), anisotropy=0.6, emission=(0.1, 0.0, 0.3)),
        "/B": volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud(40, 5)), temperature=volumeCase.Grid(volumeCase.Cloud(40, 6)),
                                scattering=(2, 5, 1), absorption=1.0, kelvin=3000.0, blackbody=0.02)}


@pytest.fixture(scope="module")
def resident(tmp_path_factory):
    path = volumeCase.Stage(tmp_path_factory.mktemp("volumes") / "s.usda", lights=(("Dome", {}), ("Rect", {})), add=_AddWall)
    return path, volumeCase.Render(path, _TwoVolumes(), samples=8, residency="resident")[0]["color"]


@pytest.mark.parametrize("settings", [
    dict(textureMemory="100%"), dict(textureMemory="30%"), dict(textureMemory="5%"), dict(textureMemory="2%"),
    dict(traversal="scalar", residency="resident"), dict(waveSize=777, residency="resident"),
    dict(waveSize=64, textureMemory="5%"), dict(volumeMemory="100%"), dict(volumeMemory="30%"), dict(volumeMemory="4K"),
    dict(volumeMemory="5%", textureMemory="64M", waveSize=64)], ids=str)
def test_bits_are_the_same(resident, settings):
    path, expected = resident
    layers, statistics, _ = volumeCase.Render(path, _TwoVolumes(), samples=8, **{"residency": "stream", **settings})
    assert np.array_equal(layers["color"], expected)
    if settings.get("residency") != "resident":
        assert statistics["texture"]["uniqueBytesLoaded"] > 0


def _Waves(size=40) -> np.ndarray:
    """A density that changes little from voxel to voxel, with holes and an edge: blocks bound it well."""
    x, y, z = np.meshgrid(*[np.arange(size) / size * 2 * np.pi] * 3, indexing="ij")
    return np.maximum(1.2 + np.sin(2 * x + y) + np.cos(3 * z - x), 0.0)


def _Grey(scattering=12.0):
    return {"/A": volumeCase.Volume(volumeCase.Grid(_Waves()), scattering=scattering, absorption=1.0, scale=1.5),
            "/B": volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud(24, 9)), scattering=(2, 5, 1), absorption=0.5)}


def test_what_bounds_of_blocks_decide_is_what_voxels_do(tmp_path):
    """A grey volume, in which most collisions need no voxel where bricks stream, and a coloured one. Of the same, but for its colour,
    which is no grey by a millionth, nearly all collisions read."""
    path = volumeCase.Stage(tmp_path / "s.usda", lights=(("Dome", {}), ("Rect", {})), add=_AddWall)
    expected = volumeCase.Render(path, _Grey(), samples=8, residency="resident")[0]["color"]
    for settings in (dict(textureMemory="100%"), dict(textureMemory="5%"), dict(volumeMemory="4K", waveSize=64)):
        layers, grey, _ = volumeCase.Render(path, _Grey(), samples=8, residency="stream", **settings)
        assert np.array_equal(layers["color"], expected), settings
    almost, colored, _ = volumeCase.Render(path, _Grey((12.0, 12.0, 12.00001)), samples=8, residency="stream", textureMemory="100%")
    assert np.median(np.abs(almost["color"] / expected - 1)) < 1e-5  # few paths come to another end by rounding
    read = [run["texture"]["lookups"] - run["texture"]["misses"] for run in (grey, colored)]
    assert 0 < read[0] < 0.7 * read[1]


def test_bounds_are_kept_of_densities_alone(tmp_path):
    """Of two grids of as many bricks, one of which glows: 72 bytes for each brick of the other, where bricks stream."""
    density, emission = (volumeCase.Grid(np.random.default_rng(seed).random((24, 24, 24))) for seed in (1, 2))
    volumes = {"/A": volumeCase.Volume(density, emission, scattering=1.0, emission=1.0)}
    path = volumeCase.Stage(tmp_path / "s.usda")
    resident, streamed = (volumeCase.Render(path, volumes, samples=1, residency=one)[1]["volume"] for one in ("resident", "stream"))
    assert streamed["bricks"] == 54
    assert streamed["alwaysResidentBytes"] - resident["alwaysResidentBytes"] == 72 * 27


def test_volumes_keep_their_budget(resident):
    """A pool for voxels alone, which the statistics tell from that for textures; by default they share one."""
    path, _ = resident
    whole = volumeCase.Render(path, _TwoVolumes(), samples=8, residency="resident")[1]["volume"]
    assert whole["uploadedBytes"] == whole["uniqueBytesLoaded"] >= whole["bytesTotal"] and whole["budget"] == 0
    shared = volumeCase.Render(path, _TwoVolumes(), samples=8, residency="stream", textureMemory="10%")[1]
    assert shared["volume"]["budget"] == 0 == shared["volume"]["peakBytes"] and shared["volume"]["evictions"] > 0
    apart = volumeCase.Render(path, _TwoVolumes(), samples=8, residency="stream", volumeMemory="10%")[1]
    assert apart["volume"]["budget"] == whole["bytesTotal"] // 10
    assert 0.7 * apart["volume"]["budget"] < apart["volume"]["peakBytes"] <= apart["volume"]["budget"]
    assert apart["volume"]["uniqueBytesLoaded"] == shared["volume"]["uniqueBytesLoaded"] < apart["volume"]["uploadedBytes"]
    with pytest.raises(volumeCase._core.Error, match="--volumeMemory: 4095 bytes cannot hold .* takes 4096 bytes"):
        volumeCase.Render(path, _TwoVolumes(), samples=1, residency="stream", volumeMemory="4095")


def test_light_path_expressions_know_volumes(resident):
    """What glows is no light, what scatters is an event, and the parts are the picture."""
    path, color = resident
    parts = ("emission", "diffuse", "specular", "transmission", "volume")
    layers, *_ = volumeCase.Render(path, _TwoVolumes(), samples=8, aovs=("color", *parts, "lpe:CO", "lpe:CV+O"))
    assert np.array_equal(layers["color"], color)
    total = sum(layers[name].astype(np.float64) for name in parts)
    assert total == pytest.approx(color[..., :3], rel=1e-5, abs=1e-5)
    for name in ("emission", "diffuse", "volume", "lpe:CO", "lpe:CV+O"):
        assert layers[name].max() > 0.01, name


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_grids_without_a_brick(tmp_path, value):
    """All voxels of whole tiles alike: there is no line to load."""
    grid = volumeCase.Grid(np.full((128, 128, 128), value), first=(-64, -64, -64), objectFromIndex=np.eye(4) / 64 + np.diag(
        [0, 0, 0, 63 / 64]))
    stage = volumeCase.Stage(tmp_path / "s.usda", width=1.0)
    for residency in ("resident", "stream"):
        layers, *_ = volumeCase.Render(stage, {"/V": volumeCase.Volume(grid, absorption=0.5)}, size=8, samples=1024,
                                       residency=residency)
        assert _Mean(layers["color"])[0] == pytest.approx(np.exp(-0.5 * 2 * value), rel=0.02)


@pytest.mark.parametrize("broken, text", [
    (dict(absorption=-1.0), "makes no sense"), (dict(scattering=np.nan), "makes no sense"), (dict(scale=0.0), "makes no sense")])
def test_bad_volumes_are_left_out(tmp_path, broken, text):
    volume = volumeCase.Volume(volumeCase.Grid(_UNIT), **broken)
    layers, _, warnings = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volume}, size=8, samples=4)
    assert len(warnings) == 1 and text in str(warnings[0])
    assert np.all(layers["color"][..., :3] == 1)


def test_hidden_volumes_are_not_drawn(tmp_path):
    _WriteVdb(tmp_path / "smoke.vdb", density=_UNIT, flame=_UNIT)

    def AddHidden(stage):
        _AddSmoke(stage)
        UsdGeom.Imageable(stage.GetPrimAtPath("/World/Smoke")).MakeInvisible()

    assert np.all(ours.Render(volumeCase.Stage(tmp_path / "s.usda", add=AddHidden), 8, 8, samples=4).rgb == 1)


def test_numbers_that_are_none_count_as_nothing(tmp_path):
    density = np.full((16, 16, 16), np.nan)
    density[8:] = -1.0
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volumeCase.Volume(
        volumeCase.Grid(density), absorption=1.0)}, size=8, samples=4)
    assert np.all(layers["color"][..., :3] == 1)


@pytest.mark.parametrize("value", [0.0, -0.0, np.inf, -np.inf, -3e38], ids=str)
def test_grids_of_nothing_are_not_there(tmp_path, value):
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volumeCase.Volume(
        volumeCase.Grid(np.full((16, 16, 16), value)), absorption=1.0, scattering=1.0)}, size=8, samples=4)
    assert np.all(layers["color"][..., :3] == 1)


@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_numbers_that_are_none_are_the_zeros_of_their_places(tmp_path, residency):
    """Beside good voxels: the picture has the bits of that of zeros in their places."""
    random = np.random.default_rng(4)
    density = random.random((24, 24, 24))
    places = random.random(density.shape) < 0.2
    pictures = []
    for values in (0.0, random.choice([np.nan, np.inf, -np.inf, -2.0], density.shape)):
        volume = volumeCase.Volume(volumeCase.Grid(np.where(places, values, density)), absorption=0.5, scattering=2.0)
        layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda"), {"/V": volume}, size=16, samples=16, residency=residency)
        pictures.append(layers["color"])
    assert np.isfinite(pictures[1]).all() and pictures[1][..., :3].min() < 0.9
    assert np.array_equal(*pictures)


def _MitsubaCloud(density, extinction, albedo, asymmetry, samples, seed=3):
    """A cloud in a cube of edge 1 below a lamp, by Mitsuba's volpathmis. \\param albedo: a colour, or a volume of Mitsuba's."""
    import mitsuba as mi

    color = lambda values: dict(type="rgb", value=[float(value) for value in values])
    place = mi.ScalarTransform4f
    fits = place().translate([-0.5, -0.5, -0.5])
    grid = mi.VolumeGrid(np.ascontiguousarray(density.transpose(2, 1, 0)[..., None]).astype(np.float32))
    medium = dict(type="heterogeneous", scale=float(extinction), phase=dict(type="hg", g=asymmetry), albedo=(
        albedo if isinstance(albedo, dict) else dict(type="constvolume", value=color(albedo))), sigma_t=dict(
            type="gridvolume", grid=grid, to_world=fits, wrap_mode="clamp"))
    film = dict(type="hdrfilm", width=16, height=16, rfilter=dict(type="box"), pixel_format="rgb")
    view = place().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0]) @ place().scale([0.6, 0.6, 1])
    lamp = place().translate([0, 3, 0]) @ place().rotate([1, 0, 0], 90) @ place().scale([3, 3, 1])
    scene = mi.load_dict(dict(
        type="scene", integrator=dict(type="volpathmis", max_depth=1000, rr_depth=1000),
        sensor=dict(type="orthographic", to_world=view, film=film, sampler=dict(type="independent")),
        cloud=dict(type="cube", to_world=place().scale([0.5] * 3), bsdf=dict(type="null"), interior=medium),
        lamp=dict(type="rectangle", to_world=lamp, emitter=dict(type="area", radiance=color((1.0,) * 3)))))
    return np.array(mi.render(scene, spp=samples, seed=seed)).astype(np.float64)


def test_a_cloud_below_a_lamp_equals_mitsubas(tmp_path):
    pytest.importorskip("mitsuba")
    import mitsubaScene

    mitsubaScene.UseVariant("scalar_rgb")  # see test_media.py
    density = volumeCase.Cloud(24)
    density[[0, -1]] = density[:, [0, -1]] = density[:, :, [0, -1]] = 0.0  # beyond its grid Mitsuba goes on, we fade
    albedo = np.array((0.95, 0.8, 0.5))
    volume = volumeCase.Volume(volumeCase.Grid(density), scattering=12.0 * albedo, absorption=12.0 * (1 - albedo), anisotropy=0.4)
    lamp = ("Rect", dict(width=6.0, height=6.0, intensity=1.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", lights=(lamp,), width=1.2), {"/V": volume}, samples=4096)
    picture = layers["color"][..., :3].astype(np.float64)
    reference = _MitsubaCloud(density, 12.0, albedo, 0.4, 1024)
    assert picture.mean((0, 1)) == pytest.approx(reference.mean((0, 1)), rel=0.01)
    assert compare.RelMse(picture, reference) <= 1e-3


def _WriteVdb(path, **grids):
    try:
        WriteVdb(path, 1 / 16, (-8, -8, -8), **grids)
    except FileNotFoundError as error:
        pytest.skip(str(error))


_USD = """
def Volume "Smoke" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    rel material:binding = </World/Look>
    rel field:density = </World/Smoke/D>
    rel field:heat = </World/Smoke/T>
    def OpenVDBAsset "D" {{
        asset filePath = @./{file}@
        token fieldName = "{grid}"
    }}
    def OpenVDBAsset "T" {{
        asset filePath = @./{file}@
        token fieldName = "flame"
    }}
}}
def Material "Look" {{
    token outputs:mtlx:volume.connect = </World/Look/V.outputs:out>
    def Shader "V" {{
        uniform token info:id = "ND_volume"
        token inputs:vdf.connect = </World/Look/M.outputs:out>
        token inputs:edf.connect = </World/Look/E.outputs:out>
        token outputs:out
    }}
    def Shader "M" {{
        uniform token info:id = "ND_anisotropic_vdf"
        vector3f inputs:absorption = (0.5, 1, 2)
        vector3f inputs:scattering = (0, 0, 0)
        token outputs:out
    }}
    def Shader "E" {{
        uniform token info:id = "ND_uniform_edf"
        color3f inputs:color.connect = </World/Look/P.outputs:out>
        token outputs:out
    }}
    def Shader "P" {{
        uniform token info:id = "ND_multiply_color3FA"
        color3f inputs:in1 = (0.25, 0.5, 0)
        float inputs:in2.connect = </World/Look/G.outputs:out>
        color3f outputs:out
    }}
    def Shader "G" {{
        uniform token info:id = "ND_geompropvalue_float"
        string inputs:geomprop = "heat"
        float outputs:out
    }}
}}
"""


def _AddSmoke(stage, file="smoke.vdb", grid="density"):
    layer = stage.GetRootLayer()
    text = layer.ExportToString().rstrip()
    assert text.endswith("}")
    layer.ImportFromString(text[:-1] + _USD.format(file=file, grid=grid) + "}\n")


def test_a_stage_with_an_openvdb_file(tmp_path):
    """The slab that glows and absorbs, all of it authored in USD with MaterialX."""
    _WriteVdb(tmp_path / "smoke.vdb", density=_UNIT, flame=2 * _UNIT)
    path = volumeCase.Stage(tmp_path / "s.usda", width=0.5, add=_AddSmoke)
    picture = ours.Render(path, 32, 32, samples=1024)
    assert not picture.warnings
    sigma, emission = np.array((0.5, 1.0, 2.0)), np.array((0.5, 1.0, 0.0))
    expected = np.exp(-sigma) + emission * (1 - np.exp(-sigma)) / sigma
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("file, grid, text", [
    ("missing.vdb", "density", "missing.vdb"), ("smoke.vdb", "fog", "has no grid 'fog'"), ("broken.vdb", "density", "broken.vdb")])
def test_bad_files_are_one_line(tmp_path, file, grid, text):
    _WriteVdb(tmp_path / "smoke.vdb", density=_UNIT)
    (tmp_path / "broken.vdb").write_bytes((tmp_path / "smoke.vdb").read_bytes()[:300])
    path = volumeCase.Stage(tmp_path / "s.usda", add=lambda stage: _AddSmoke(stage, file, grid))
    picture = ours.Render(path, 8, 8, samples=4)
    named = [warning for warning in picture.warnings if "field 'density'" in str(warning)]
    assert len(named) == 1 and "/World/Smoke" in str(named[0]) and text in str(named[0])
    assert np.all(picture.rgb == 1)
