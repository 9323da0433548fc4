# SPDX-License-Identifier: Apache-2.0
"""`--residency auto` begins with little of the geometry and becomes resident where it is when that is worth it; bits
never depend on it. The oracle is a picture of the same session with resident geometry, after which the kernels without
streaming code are there: to become resident costs nothing once all chunks have been seen."""

import pytest

pytest.importorskip("hdstream._core")

from stages import author, bench, shapes, streaming
from streamCase import Case, MovedMesh

_SETTINGS = dict(noCache=True, chunkBytes=1 << 20, samples=20)
_LITTLE = 16 << 20  # docs/streaming.md


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
    return geometry


@pytest.mark.parametrize("settings", [dict(), dict(traversal="scalar"), dict(request="first", geometryEviction="flush")],
                         ids=["lists", "scalar", "report"])
def test_becomes_resident_once_all_is_there(Field, settings):
    Field.Render(residency="resident", **_SETTINGS, **settings)
    geometry = _RenderAuto(Field, **settings)
    assert geometry["mode"] == "resident" and geometry["streamedSamples"] == 1
    assert 0 < geometry["chunksTouched"] == geometry["chunks"]
    assert geometry["uploadedBytes"] == geometry["bytesTotal"] <= geometry["budget"] and geometry["evictions"] == 0


def test_stays_resident_until_an_edit_brings_many_new_pages(Field):
    case, other = Field.Fresh().RenderResident(**_SETTINGS), Field.Fresh()
    assert _RenderAuto(case)["streamedSamples"] == 1
    again = _RenderAuto(case)
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
        edited = _RenderAuto(case)
        assert edited["mode"] == "resident" and edited["uploads"] > 0
        assert edited["streamedSamples"] == (1 if isMuch else 0)
        assert isMuch or edited["uploads"] <= 4


def test_what_nobody_sees_is_not_prepared(tmp_path):
    """To prepare it takes longer than the render."""
    _WriteField(str(tmp_path / "stage.usdc"), cells=100, hidden=700)
    case = Case(tmp_path / "stage.usdc").RenderResident(**_SETTINGS)
    geometry = _RenderAuto(case)
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


def test_what_does_not_fit_streams_to_the_end(Field):
    geometry = _RenderAuto(Field, geometryMemory="12M")
    assert geometry["mode"] == "stream" and geometry["evictions"] > 0
