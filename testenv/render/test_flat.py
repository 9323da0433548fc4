# SPDX-License-Identifier: Apache-2.0
"""The flat hierarchy: pictures have the bits of walks level by level, and it is there when it is worth it."""

import pytest

pytest.importorskip("hdstream._core")

import hdstream
import ours
from pxr import Usd
from stages import author, bench, crowd, motion, shapes, streaming
from stages.verify import CASES

_AOVS = ("color", "depth", "instanceId", "primId", "elementId")
_SIZE = (61, 47)


def _OnlyFlat(stage, **settings) -> tuple:
    """(picture by the flat hierarchy, picture level by level)."""
    return tuple(ours.Render(stage, *_SIZE, _AOVS, samples=6, residency="resident", traversal=form, **settings) for form in ("flat", "simd8"))


def _AssertSameBits(flat, levels) -> None:
    assert (flat.statistics["wave"]["traversal"], levels.statistics["wave"]["traversal"]) == ("flat", "simd8")
    assert flat.statistics["geometry"]["flatTriangles"] > 0 and levels.statistics["geometry"]["flatTriangles"] == 0
    for name in levels.layers:
        assert flat.layers[name].tobytes() == levels.layers[name].tobytes(), name


@pytest.mark.parametrize("name", ["instancing", "surfaceCutout", "emissiveMesh", "lambertRoom"])
def test_bits_are_those_of_levels(name, tmp_path):
    _AssertSameBits(*_OnlyFlat(CASES[name].Write(f"{tmp_path}/stage.usda")))


def test_groups_and_what_stays_an_instance(tmp_path):
    """Instancers below instancers: some ways are too long for what is flattened."""
    stage = f"{tmp_path}/nested.usda"
    streaming.WriteNested(stage)
    _AssertSameBits(*_OnlyFlat(stage))


def test_copies_have_trees_of_their_own(tmp_path):
    """What rays do not pay for in each place is there once."""
    stage = f"{tmp_path}/forest.usda"
    bench.WriteForest(stage, instances=150, species=2, leaves=300)
    copies, levels = (ours.Render(stage, *_SIZE, _AOVS, samples=16, residency="resident", **settings) for settings in (
        {}, dict(traversal="simd8")))
    _AssertSameBits(copies, levels)
    geometry = copies.statistics["geometry"]
    assert geometry["flatCopies"] == 150 and levels.statistics["geometry"]["flatCopies"] == 0
    assert geometry["flatTriangles"] == geometry["triangles"], "each once"


def test_curves_stay_instances(tmp_path):
    stage = CASES["lambertRoom"].Write(f"{tmp_path}/stage.usda")
    with open(stage, "a", encoding="utf-8") as file:
        file.write("""
def BasisCurves "Hair" {
    uniform token type = "linear"
    int[] curveVertexCounts = [3, 2]
    point3f[] points = [(-0.5, -0.5, 0), (0, 0.4, 0.3), (0.5, -0.2, 0), (-0.4, 0.5, 0.1), (0.4, 0.5, 0.2)]
    float[] widths = [0.2] (interpolation = "constant")
}
""")
    _AssertSameBits(*_OnlyFlat(stage))


def test_it_is_built_when_rays_pay_for_it(tmp_path):
    stage = CASES["lambertRoom"].Write(f"{tmp_path}/stage.usda")
    forms = {samples: ours.Render(stage, 64, 64, samples=samples).statistics["wave"]["traversal"] for samples in (1, 64)}
    triangles = ours.Render(stage, 8, 8, samples=1).statistics["geometry"]["triangles"]
    assert triangles < 64 * 64 // 4, "another stage is needed for a render that does not pay"
    assert forms == {1: "flat", 64: "flat"}
    assert ours.Render(stage, 2, 1, samples=1).statistics["wave"]["traversal"] == "simd8"


def test_instances_in_chunks_are_left_out(tmp_path):
    """What lies beside them is flattened, if that is most of what is placed."""
    forms = {}
    for instances in (12, 3000):
        path = f"{tmp_path}/crowd{instances}.usda"
        crowd.WriteCrowd(path, instances=instances, rings=3)
        _AddFloor(path)
        auto, levels, tables = (ours.Render(path, *_SIZE, _AOVS, samples=8, residency="resident", **settings) for settings in (
            dict(instanceChunks=1), dict(instanceChunks=1, traversal="simd8"), dict(instanceChunks=0, traversal="simd8")))
        for name in levels.layers:
            assert auto.layers[name].tobytes() == levels.layers[name].tobytes() == tables.layers[name].tobytes(), name
        assert levels.statistics["geometry"]["chunks"] > tables.statistics["geometry"]["chunks"]
        forms[instances] = auto.statistics["wave"]["traversal"]
        floor = 2 * 48 * 23
        assert (auto.statistics["geometry"]["flatTriangles"] > floor + 4 * 24) == (forms[instances] == "flat")
    assert forms == {12: "flat", 3000: "simd8"}


def test_budgets_hold(tmp_path):
    """A pool that geometry fills leaves no room for it."""
    stage = CASES["lambertRoom"].Write(f"{tmp_path}/stage.usda")
    picture = ours.Render(stage, *_SIZE, samples=4, residency="stream", geometryMemory="100%")
    assert picture.statistics["geometry"]["flatBytes"] == 0
    assert picture.statistics["wave"]["traversal"] == "simd8"


def _AddFloor(path):
    """A floor that rests below what moves."""
    stage = Usd.Stage.Open(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Sphere(6.0, 24, 48).Moved((0, -7.5, 0)), color=(0.5, 0.6, 0.5))
    stage.GetRootLayer().Save()


def _OfMotion(path, form, **settings):
    stage = hdstream.Renderer(path, onWarning=lambda line: None)
    return stage.Render(motion.FRAME, aovs=_AOVS, **dict(dict(
        camera="/World/Camera", imageWidth=61, imageHeight=47, samples=6, residency="resident", traversal=form, noCache=True), **settings))


@pytest.mark.parametrize("name", ["way", "turn", "nested", "polygons", "points", "camera"])
def test_what_moves_stays_an_instance(name, tmp_path):
    path = motion.Write(tmp_path / "moving.usda", name)
    _AddFloor(path)
    flat, levels, still = (_OfMotion(path, form, **settings) for form, settings in (
        ("flat", {}), ("simd8", {}), ("flat", dict(motionBlur="off"))))
    assert [picture.statistics["wave"]["traversal"] for picture in (flat, levels, still)] == ["flat", "simd8", "flat"]
    for aov in _AOVS:
        assert flat.aovs[aov].tobytes() == levels.aovs[aov].tobytes(), aov
    assert still.aovs["color"].tobytes() != flat.aovs["color"].tobytes()
    triangles = [picture.statistics["geometry"]["flatTriangles"] for picture in (flat, still)]
    assert 0 < triangles[0] < triangles[1] or name in ("points", "camera") and triangles[0] == triangles[1] > 0


def test_where_most_moves_there_is_none(tmp_path):
    path = motion.Write(tmp_path / "moving.usda", "polygons")
    forms = [_OfMotion(path, "auto", **settings).statistics["wave"]["traversal"] for settings in ({}, dict(motionBlur="off"))]
    assert forms == ["simd8", "flat"]
