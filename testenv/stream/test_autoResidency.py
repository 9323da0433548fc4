# SPDX-License-Identifier: Apache-2.0
"""`--residency auto`, and `stream` with a pool that holds everything, begin with little of the geometry and become
resident where it is when that is worth it; bits never depend on it. The oracle is a picture of the same session with resident geometry, after which the kernels without
streaming code are there: to become resident costs nothing once all chunks have been seen."""

import json

import pytest

pytest.importorskip("hdstream._core")

from stages import author, bench, curves, shapes, streaming
from streamCase import SIZE, Case, MovedMesh

_SETTINGS = dict(noCache=True, chunkBytes=1 << 20, samples=20)
_LITTLE = 16 << 20  # docs/streaming.md
_BOTH = pytest.mark.parametrize("residency", ["auto", "stream"])


def _WriteField(path, cells=600, hidden=0):
    """A field that the camera sees all of, from above, and a little one; below it another that nothing sees."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Field", shapes.HeightField(4.0, cells, bench.Bumps), doubleSided=True)
    author.AddMesh(stage, "/World/Little", shapes.HeightField(0.5, 20, bench.Bumps), doubleSided=True, translate=(0, 1.5, 0))
    if hidden:
        author.AddMesh(stage, "/World/Hidden", shapes.HeightField(0.4, hidden, bench.Bumps), translate=(0, -1, 0))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1, 3, 1)), intensity=20.0, radius=0.4)
    author.AddCamera(stage, eye=(0, 9, 0.01), target=(0, 0, 0))
    stage.GetRootLayer().Save()


@pytest.fixture(scope="module")
def Field(tmp_path_factory):
    path = tmp_path_factory.mktemp("field") / "stage.usdc"
    _WriteField(str(path))
    case = Case(path).RenderResident(**_SETTINGS)
    assert case.statistics["geometry"]["bytesTotal"] > _LITTLE
    return case


def _RenderAuto(case, **settings):
    layers, statistics = case.Render(**{"residency": "auto", **_SETTINGS, **settings})
    case.AssertBits(layers)
    geometry = statistics["geometry"]
    assert (geometry["mode"] == "stream") == (geometry["streamedSamples"] == statistics["image"]["samples"])
    assert (geometry["mode"] == "stream") == (geometry["streamedPaths"] == statistics["rays"]["camera"])
    assert (geometry["streamedPaths"] > 0) == (geometry["streamedSamples"] > 0)
    return geometry


@pytest.mark.parametrize("settings", [dict(), dict(traversal="scalar"), dict(request="first", geometryEviction="flush"),
                                      dict(residency="stream"), dict(residency="stream", traversal="scalar"),
                                      dict(residency="stream", geometryEviction="flush", geometryMemory="100%")],
                         ids=["lists", "scalar", "report", "stream", "stream-scalar", "stream-flush"])
def test_becomes_resident_once_all_is_there(Field, settings):
    Field.Render(**{**_SETTINGS, **settings, "residency": "resident"})
    geometry = _RenderAuto(Field, **settings)
    assert geometry["mode"] == "resident" and geometry["streamedSamples"] == 1
    assert 0 < geometry["chunksTouched"] == geometry["chunks"]
    assert geometry["uploadedBytes"] == geometry["bytesTotal"] <= geometry["budget"] and geometry["evictions"] == 0


@_BOTH
def test_stays_resident_until_an_edit_brings_many_new_pages(Field, residency):
    case, other = Field.Fresh().RenderResident(**_SETTINGS), Field.Fresh()
    assert _RenderAuto(case, residency=residency)["streamedSamples"] == 1
    again = _RenderAuto(case, residency=residency)
    assert again["mode"] == "resident" and again["streamedSamples"] == again["uploads"] == 0
    meshes = dict(case.session.Scene().geometry)
    # The first edit finds a pool that is full: with the next one it has room to spare.
    for path, offset, isMuch in (("/World/Little", 0.1, True), ("/World/Little", 0.2, False), ("/World/Field", 0.1, True),
                                 ("/World/Little", 0.3, False)):
        moved = MovedMesh(case.core, meshes[path], (offset, 0, 0))
        for session in (case.session, other.session):
            session.SetGeometry(path, moved)
        other.RenderResident(**_SETTINGS)
        case.layers = other.layers
        edited = _RenderAuto(case, residency=residency)
        assert edited["mode"] == "resident" and edited["uploads"] > 0
        assert edited["streamedSamples"] == (1 if isMuch else 0)
        assert isMuch or edited["uploads"] <= 4


@_BOTH
def test_what_nobody_sees_is_not_prepared(tmp_path, residency):
    """To prepare it takes longer than the render."""
    _WriteField(str(tmp_path / "stage.usdc"), cells=100, hidden=700)
    case = Case(tmp_path / "stage.usdc").RenderResident(**_SETTINGS)
    geometry = _RenderAuto(case, residency=residency)
    assert geometry["mode"] == "stream" and 0 < geometry["chunksBuilt"] < 0.5 * geometry["chunks"]


def test_the_rest_is_loaded_when_it_is_worth_it(tmp_path):
    """Pages that lie ready in host memory cost next to nothing, many samples are to come."""
    streaming.WriteOverlap(str(tmp_path / "stage.usdc"), meshes=16, rings=130)
    settings = dict(_SETTINGS, samples=64, chunkBytes=1 << 16)
    case = Case(tmp_path / "stage.usdc").RenderResident(**settings)
    case.AssertStreams(geometryMemory="100%", **settings)  # leaves all of them there
    geometry = _RenderAuto(case, **settings)
    assert geometry["chunksTouched"] < geometry["chunks"]
    assert geometry["mode"] == "resident" and geometry["uploadedBytes"] == geometry["bytesTotal"]
    assert geometry["pinnedBytes"] > 0


@pytest.mark.parametrize("settings", [dict(prepare="eager"), dict(geometryMemory="100%")], ids=["eager", "percent"])
def test_what_is_prepared_anyhow_is_resident_from_the_start(Field, settings):
    geometry = _RenderAuto(Field, **settings)
    assert geometry["mode"] == "resident" and geometry["streamedSamples"] == 0


def test_little_is_resident_from_the_start(tmp_path):
    _WriteField(str(tmp_path / "stage.usda"), cells=60)
    case = Case(tmp_path / "stage.usda").RenderResident(**_SETTINGS)
    geometry = _RenderAuto(case)
    assert geometry["mode"] == "resident" and geometry["streamedSamples"] == 0


def test_what_rays_pay_for_is_resident_from_the_start(Field):
    """Three camera rays a triangle, or a flat hierarchy that is asked for; not where the number of rays is unknown or somebody edits."""
    triangles = Field.statistics["geometry"]["triangles"]
    size = dict(imageWidth=400, imageHeight=300)
    enough = -(-3 * triangles // (400 * 300))
    for settings, isResident in ((dict(size, samples=enough), True), (dict(size, samples=enough - 1), False),
                                 (dict(size, samples=enough, timeLimit=1000.0), False), (dict(size, samples=enough, interactive=True), False),
                                 (dict(size, samples=enough, residency="stream"), False), (dict(size, samples=enough, traversal="simd8"), False),
                                 (dict(traversal="flat"), True)):
        case = Field.Fresh()
        # The first report, before which all is prepared, ends it.
        case.Start(lambda progress: progress.fraction == 0.0, **{"residency": "auto", **_SETTINGS, **settings})
        geometry = json.loads(case.session.Statistics())["geometry"]
        assert (geometry["streamedPaths"] == 0) == isResident, settings
        assert geometry["mode"] == ("resident" if isResident else "stream"), settings


def test_curves_are_not_paid_for_by_the_rays_of_few_triangles(tmp_path):
    case = Case(curves.WriteHair(tmp_path / "hair.usdc", 40000))
    case.Start(lambda progress: progress.fraction == 0.0, **{**_SETTINGS, "residency": "auto", "samples": 20})
    geometry = json.loads(case.session.Statistics())["geometry"]
    assert geometry["bytesTotal"] > _LITTLE and 4 * geometry["triangles"] < SIZE[0] * SIZE[1] * 20
    assert geometry["streamedPaths"] > 0
    assert geometry["mode"] == "stream"


def test_what_does_not_fit_streams_to_the_end(Field):
    geometry = _RenderAuto(Field, geometryMemory="12M")
    assert geometry["mode"] == "stream" and geometry["evictions"] > 0


# A sample of each pixel takes eleven waves. Level by level: a pool of 100 % has no room for the flat hierarchy, so its kernels
# would be others than those of RenderResident.
_WAVES = dict(_SETTINGS, chunkBytes=1 << 12, waveSize=256, traversal="simd8")


@pytest.fixture(scope="module")
def LittleField(tmp_path_factory):
    path = tmp_path_factory.mktemp("littleField") / "stage.usda"
    _WriteField(str(path), cells=60)
    return Case(path).RenderResident(**_WAVES)


def _EqualPart(paths, most):
    """The size of the next wave, where the waves that are left are of equal size."""
    return -(-paths // -(-paths // most))


# So many samples that loading what is hidden is worth it from the second wave on, also on a machine with other work.
@pytest.mark.parametrize("settings", [dict(_WAVES, samples=100), dict(_WAVES, waveSize=0, chunkBytes=1 << 20, samples=2, imageWidth=400, imageHeight=300)],
                         ids=["small", "default"])
def test_waves_after_it_are_resident(LittleField, settings):
    """In the middle of a pass, after which waves may have another size: each path is traced once. By default they do where two
    cores share the image."""
    case = LittleField.Fresh()
    pixels = settings.get("imageWidth", SIZE[0]) * settings.get("imageHeight", SIZE[1])
    for memory in ("100%", "99%"):
        case.RenderResident(**settings)
        layers, statistics = case.Render(**settings, residency="stream", geometryMemory=memory)
        case.AssertBits(layers)
        geometry = statistics["geometry"]
        assert statistics["rays"]["camera"] == pixels * settings["samples"]
        if memory == "100%":
            assert geometry["mode"] == "resident" and 0 < geometry["chunksTouched"] <= geometry["chunks"]
            # What is hidden is loaded once the rate is known: after two waves.
            if settings["waveSize"] > 0:
                first = _EqualPart(pixels, settings["waveSize"])
                assert geometry["streamedPaths"] in (first, first + _EqualPart(pixels - first, settings["waveSize"]))
            else:
                assert 0 < geometry["streamedPaths"] <= pixels
        else:
            assert geometry["mode"] == "stream" and geometry["streamedPaths"] == statistics["rays"]["camera"]


def test_what_becomes_resident_is_flat_where_there_is_room(LittleField):
    settings = dict(_WAVES, traversal="auto", samples=100)
    case = LittleField.Fresh().RenderResident(**settings)
    assert case.statistics["wave"]["traversal"] == "flat"
    total = case.statistics["geometry"]["bytesTotal"]
    layers, statistics = case.Render(**settings, residency="stream", geometryMemory=str(8 * total))
    case.AssertBits(layers)
    assert statistics["geometry"]["mode"] == "resident" and statistics["geometry"]["streamedPaths"] > 0
    assert statistics["wave"]["traversal"] == "flat" and statistics["geometry"]["flatBytes"] > 0


def test_no_more_device_memory_than_resident(LittleField):
    peaks = []
    for settings in (dict(residency="resident"), dict(residency="stream", geometryMemory="100%")):
        case = LittleField.Fresh().RenderResident(**_WAVES)  # its kernels
        case.Render(residency="stream", geometryMemory="30%", **_WAVES)
        statistics = case.Render(**_WAVES, **settings)[1]
        assert statistics["geometry"]["mode"] == "resident"
        peaks.append(statistics["memory"]["pathState"] + statistics["geometry"]["budget"])
    assert peaks[1] <= peaks[0]


def test_edits_and_smaller_pools_stream_again(LittleField):
    case, other = LittleField.Fresh().RenderResident(**_WAVES), LittleField.Fresh()
    total = case.statistics["geometry"]["bytesTotal"]
    spare = dict(_WAVES, geometryMemory=str(total * 5 // 4))
    assert case.AssertStreams(**spare)["mode"] == "resident"
    assert case.AssertStreams(**dict(_WAVES, geometryMemory="30%"))["mode"] == "stream"
    assert case.AssertStreams(**spare)["mode"] == "resident"
    meshes = dict(case.session.Scene().geometry)
    for old, new, mode in (("/World/Little", "/World/Little", "resident"), ("/World/Field", "/World/More", "stream")):
        moved = MovedMesh(case.core, meshes[old], (0.1, 0.0, 0.0))
        for session in (case.session, other.session):
            session.SetGeometry(new, moved)
        other.RenderResident(**_WAVES)
        case.layers, case.statistics = other.layers, other.statistics
        assert case.AssertStreams(**spare)["mode"] == mode
    for session in (case.session, other.session):
        session.Remove("/World/More")
    other.RenderResident(**_WAVES)
    case.layers, case.statistics = other.layers, other.statistics
    assert case.AssertStreams(**spare)["mode"] == "resident"


def test_a_render_may_be_stopped_on_either_side(LittleField):
    """And the next one has the bits."""
    case = LittleField.Fresh().RenderResident(**_WAVES)
    for stopsAt in (1, 3, 12, 14):
        case.AssertStreams(geometryMemory="30%", **_WAVES)
        reports = iter(range(1, 1000))
        result = case.Start(lambda progress: next(reports) < stopsAt, residency="stream", geometryMemory="100%", **_WAVES)
        assert result == case.core.RenderResult.Stopped
        case.AssertStreams(geometryMemory="100%", **_WAVES)
