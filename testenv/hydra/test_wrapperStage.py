# SPDX-License-Identifier: Apache-2.0
"""The tools of the comparison themselves: wrappers change nothing, and differences are found."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from dumpStage import DumpStage
from frontEnds import CompareDumps, ComparePictures
from stages.imageFile import WriteExr
from stages.verify import CASES
from wrapperStage import SETTINGS_PATH, WriteWrapper


@pytest.mark.parametrize("name", ["upAxisZ", "instancing", "cameraPixelAspect"])
def test_a_wrapped_stage_is_the_same_scene(name, tmp_path):
    """All that a root layer says is said again: the dump of a stage with a camera is unchanged."""
    CASES[name].Write(tmp_path / "stage.usda")
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", 80, samples=3)
    assert DumpStage(tmp_path / "stage.usda")[0] == DumpStage(wrapper.path)[0]
    assert wrapper.camera == "/World/Camera"


def test_a_stage_without_camera_gets_one(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    UsdGeom.Sphere.Define(stage, "/Ball")
    stage.GetRootLayer().Save()
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", 100)
    differences = CompareDumps(DumpStage(tmp_path / "stage.usda")[0], DumpStage(wrapper.path)[0])
    assert differences == [f"camera only in Hydra, 1: {wrapper.camera}"]
    assert wrapper.height == 72  # 100 * 15.2908 / 20.955 = 72.97, cut off


def test_metadata_and_settings_are_in_the_wrapper(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    stage.SetStartTimeCode(7)
    stage.SetTimeCodesPerSecond(30)
    UsdGeom.SetStageMetersPerUnit(stage, 0.5)
    stage.GetRootLayer().Save()
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", 100, samples=9, pixelFilter="box")
    wrapped = Usd.Stage.Open(str(wrapper.path))
    assert (wrapped.GetStartTimeCode(), wrapped.GetTimeCodesPerSecond()) == (7, 30)
    assert UsdGeom.GetStageMetersPerUnit(wrapped) == 0.5
    prim = wrapped.GetPrimAtPath(SETTINGS_PATH)
    assert (prim.GetAttribute("hdstream:samples").Get(), prim.GetAttribute("hdstream:pixelFilter").Get()) == (9, "box")
    assert prim.GetRelationship("camera").GetTargets() == [Sdf.Path(wrapper.camera)]


def test_differences_of_scenes_are_found():
    """Each kind once, with an example; equal texts give none."""
    first = "stage /\n  upAxis: Y\nmesh /A\n  points: [1] 0 0 0\nmesh /B\n  purpose: render\n"
    assert CompareDumps(first, first) == []
    second = "stage /\n  upAxis: Z\nmesh /A\n  points: [1] 0 0 1\nmesh /C\n  purpose: render\n"
    assert CompareDumps(first, second) == [
        "mesh only in Hydra, 1: /C", "mesh only in hdstream record, 1: /B",
        "mesh.points, 1: /A points: [1] 0 0 0 != [1] 0 0 1", "stage.upAxis, 1: / upAxis: Y != Z"]
    assert CompareDumps("a /\nb /\n", "b /\na /\n") == ["the order of lines differs"]


def test_prototypes_have_the_names_of_their_instances():
    """Legacy names of materials inside native instances; a prototype of two instances is a difference."""
    record = "material /I/Looks/m\nmaterial /J/Looks/m\nmesh /I/a\n  material: /I/Looks/m\nmesh /J/b\n  material: /J/Looks/m\n"
    hydra = record.replace("/I/Looks", "/__Prototype_2/Looks").replace("/J/Looks", "/__Prototype_1/Looks")
    assert CompareDumps(record, hydra) == []
    assert CompareDumps(record, hydra.replace("/__Prototype_1", "/__Prototype_2")) != []
    assert CompareDumps(record, hydra.replace("Prototype_1/Looks", "Prototype_1/Other")) != []


def test_one_other_bit_of_a_picture_is_found(tmp_path):
    pixels = np.full((4, 5), 0.25, np.float32)
    WriteExr(tmp_path / "a.exr", {name: pixels for name in "RGBA"}, half=False)
    changed = pixels.copy()
    changed[2, 3] = np.nextafter(np.float32(0.25), np.float32(1))
    WriteExr(tmp_path / "b.exr", {**{name: pixels for name in "RGB"}, "A": changed}, half=False)
    assert ComparePictures(tmp_path / "a.exr", tmp_path / "a.exr").isEqual
    difference = ComparePictures(tmp_path / "a.exr", tmp_path / "b.exr")
    assert difference.numUnlike == 1 and not difference.isEqual
    WriteExr(tmp_path / "c.exr", {name: pixels[:3] for name in "RGBA"}, half=False)
    assert not ComparePictures(tmp_path / "a.exr", tmp_path / "c.exr").isEqual
