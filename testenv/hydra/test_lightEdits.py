# SPDX-License-Identifier: Apache-2.0
"""Edits of light filters and of links of native instances through Hydra: after each the picture of a fresh engine, to the bit."""

import ast
import json
import pathlib

import pytest
from pxr import Sdf, UsdGeom, UsdLux

from frontEnds import MODES, ComparePictures
from openUsd import RunProgram
from stages import author, shapes
from wrapperStage import SETTINGS_PATH, WriteWrapper

WIDTH = 32
_SCRIPT = pathlib.Path(__file__).resolve().parent / "lightEditScript.py"


def _Edits(mode):
    """The names of the script's edits, which only OpenUSD's Python can import. The scene indices of OpenUSD 25.02 do not tell
    that a value of a light filter has changed (docs/hydra.md)."""
    tree = ast.parse(_SCRIPT.read_text(encoding="utf-8"))
    edits = next(node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "EDITS")
    names = [key.value for key in edits.keys]
    return [name for name in names if mode != "sceneIndex" or not name.startswith("value")]


def _AddInstance(stage, name, prototype, **placement):
    place = UsdGeom.Xform.Define(stage, f"/World/{name}")
    author.Place(place, **placement)
    place.GetPrim().GetReferences().AddInternalReference(prototype)
    place.GetPrim().SetInstanceable(True)


def _WriteStage(path):
    """Two instanced halves of a wall, under instanced blocks that shade parts of them; a lamp behind doors, and a linked sun."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Prototype/Tile", shapes.Plane(2, 4), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0))
    author.AddMesh(stage, "/World/Blocks/Tile", shapes.Plane(0.5, 0.5), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0))
    for name in ("Prototype", "Blocks"):
        stage.GetPrimAtPath(f"/World/{name}").SetSpecifier(Sdf.SpecifierOver)
    for side, x in (("Left", -1), ("Right", 1)):
        _AddInstance(stage, side, "/World/Prototype", translate=(x, 0, 0))
        _AddInstance(stage, "Block" + side, "/World/Blocks", translate=(x, 0.5, 0.6))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(0, 0, 2)), intensity=2000.0, radius=0.02)
    doors = UsdLux.LightFilter.Define(stage, "/World/Doors")
    author.Place(doors, translate=(0, 0, 1))
    doors.CreateShaderIdAttr("PxrBarnLightFilter")
    for name, value in (("width", 0.3), ("height", 3.0), ("radius", 0.0)):
        doors.GetPrim().CreateAttribute(f"inputs:{name}", Sdf.ValueTypeNames.Float).Set(value)
    UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lamp")).CreateFiltersRel().SetTargets(["/World/Doors"])
    sun = author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(20, 20, 0)), intensity=1.0, angle=0.0)
    author.LinkLight(sun, "lightLink", excludes=["/World/Left"])
    author.LinkLight(sun, "shadowLink", excludes=["/World/BlockLeft"])
    author.AddCamera(stage, eye=(0, 0, 5), target=(0, 0, 0), width=40.0, orthographic=True)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("mode", MODES)
def test_edits_of_filters_and_links(mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("other renderers have other filters and links")
    _WriteStage(tmp_path / "stage.usda")
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", WIDTH, mode=mode, samples=2, maxDepth=0)
    job = dict(stage=str(wrapper.path), camera=wrapper.camera, settings=SETTINGS_PATH, renderer="HdStreamRendererPlugin",
               width=WIDTH, out=str(tmp_path), edits=_Edits(mode))
    (tmp_path / "job.json").write_text(json.dumps(job), encoding="utf-8")
    environment = {"USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX": "1"} if mode == "sceneIndex" else {}
    run = RunProgram(openUsd.Script(_SCRIPT, tmp_path / "job.json"), openUsd.Environment(plugin, **environment))
    assert run.code == 0, run.output
    wrong = []
    before = tmp_path / "start.exr"
    for edit in _Edits(mode):
        fresh = tmp_path / f"{edit}.fresh.exr"
        assert not ComparePictures(fresh, before).isEqual, f"{edit} shows nothing"
        if not ComparePictures(tmp_path / f"{edit}.exr", fresh).isEqual:
            wrong.append(edit)
        before = fresh
    assert not wrong
