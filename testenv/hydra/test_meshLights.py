# SPDX-License-Identifier: Apache-2.0
"""Mesh lights through Hydra: the picture of `hdstream record`, also below instancers, and after each edit of a drawn stage the
picture of a fresh engine, to the bit."""

import ast
import json
import pathlib

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, Vt

from frontEnds import MODES, ComparePictures, FrontEnds, ReadColor
from openUsd import RunProgram
from stages import author, shapes
from wrapperStage import SETTINGS_PATH, WriteWrapper

WIDTH = 32
_SCRIPT = pathlib.Path(__file__).resolve().parent / "meshLightScript.py"
_DOWN = dict(rotate=(180, 0, 0))
_PLACES = [(-1.2, 0.8, -0.6), (-0.4, 1.0, 0.7)]


def _Edits():
    """The names of the script's edits, which only OpenUSD's Python can import."""
    tree = ast.parse(_SCRIPT.read_text(encoding="utf-8"))
    edits = next(node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "EDITS")
    return [key.value for key in edits.keys]


def _AddLamp(stage, path, size, intensity, mode="materialGlowTintsLight", **placement):
    mesh = author.AddMesh(stage, path, shapes.Plane(size, size), **placement)
    light = UsdLux.LightAPI(UsdLux.MeshLightAPI.Apply(mesh.GetPrim()).GetPrim())
    light.CreateIntensityAttr(intensity)
    light.GetMaterialSyncModeAttr().Set(mode)
    return mesh


def _WriteStage(path):
    """A plate under a lamp that tints, one whose glow varies, and lamps of a point instancer and of native instances."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Plate", shapes.Plane(6, 6), color=(0.5, 0.5, 0.5))
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(0.5, 1.0, 2.0))
    varied = author.AddMaterial(stage, "/World/Varied", {"emissiveColor": ("glow", "float3", (0.0, 0.0, 0.0))}, diffuseColor=(0, 0, 0))
    author.Bind(_AddLamp(stage, "/World/Lamp", 0.5, 4.0, translate=(0.8, 1.0, 0), **_DOWN), glow)
    pair = _AddLamp(stage, "/World/Pair", 0.4, 6.0, translate=(-1.0, 1.1, 0.4), **_DOWN)
    author.Bind(pair, varied)
    author.AddPrimvar(pair, "glow", Sdf.ValueTypeNames.Color3fArray, "vertex",
                      Vt.Vec3fArray([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0), Gf.Vec3f(0, 0, 1), Gf.Vec3f(1, 1, 1)]))
    bulbs = UsdGeom.PointInstancer.Define(stage, "/World/Bulbs")
    _AddLamp(stage, "/World/Bulbs/Bulb", 0.2, 8.0, "noMaterialResponse", **_DOWN)
    bulbs.CreatePrototypesRel().AddTarget("/World/Bulbs/Bulb")
    bulbs.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(*place) for place in _PLACES]))
    bulbs.CreateProtoIndicesAttr(Vt.IntArray([0] * len(_PLACES)))
    _AddLamp(stage, "/World/Shared/Bulb", 0.2, 10.0, "noMaterialResponse", **_DOWN)
    stage.GetPrimAtPath("/World/Shared").SetSpecifier(Sdf.SpecifierOver)
    for name, x in (("Left", -0.3), ("Right", 0.5)):
        place = UsdGeom.Xform.Define(stage, f"/World/{name}")
        author.Place(place, translate=(x, 0.9, -0.8))
        place.GetPrim().GetReferences().AddInternalReference("/World/Shared")
        place.GetPrim().SetInstanceable(True)
    # Gprims that become meshes are lights, and their sizes are no inputs of them; what has no faces is none.
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.CreateRadiusAttr(0.15)
    author.Place(ball, translate=(1.4, 0.6, 0.7))
    UsdLux.LightAPI.Apply(ball.GetPrim())
    UsdLux.LightAPI(ball.GetPrim()).CreateIntensityAttr(3.0)
    dots = UsdGeom.Points.Define(stage, "/World/Dots")
    dots.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(-1.5, 0.3, 1.0), Gf.Vec3f(-1.6, 0.3, 0.8)]))
    dots.CreateWidthsAttr(Vt.FloatArray([0.1, 0.1]))
    UsdLux.LightAPI.Apply(dots.GetPrim())
    author.AddCamera(stage, eye=(0, 3, 2), target=(0, 0.3, 0), focalLength=30.0)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("mode", MODES)
def test_edits_of_mesh_lights(mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("other renderers have other mesh lights")
    _WriteStage(tmp_path / "stage.usda")
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", WIDTH, mode=mode, samples=2, maxDepth=1)
    job = dict(stage=str(wrapper.path), camera=wrapper.camera, settings=SETTINGS_PATH, renderer="HdStreamRendererPlugin",
               width=WIDTH, out=str(tmp_path))
    (tmp_path / "job.json").write_text(json.dumps(job), encoding="utf-8")
    environment = {"USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX": "1"} if mode == "sceneIndex" else {}
    run = RunProgram(openUsd.Script(_SCRIPT, tmp_path / "job.json"), openUsd.Environment(plugin, **environment))
    assert run.code == 0, run.output
    assert "/World/Lamp: links of a mesh light do not come through Hydra; ignored" in run.output
    # Each engine says it of the points, and of nothing else.
    said = [line for line in run.output.splitlines() if "LightAPI makes lights of what has faces" in line]
    assert len(said) == 1 + len(_Edits()) and all("/World/Dots: " in line for line in said)
    before = "start"
    for edit in _Edits():
        difference = ComparePictures(tmp_path / f"{edit}.exr", tmp_path / f"{edit}.fresh.exr")
        assert difference.isEqual, f"{edit}: {difference}"
        isSame = ComparePictures(tmp_path / f"{edit}.exr", tmp_path / f"{before}.exr").isEqual
        assert isSame == (edit == "linked"), f"{edit} shows"
        before = edit
    record = FrontEnds.RunRecord(wrapper, tmp_path / "record.exr")
    assert record.code == 0, record.output
    difference = ComparePictures(tmp_path / "start.exr", tmp_path / "record.exr")
    assert difference.isEqual, difference
    assert np.median(ReadColor(tmp_path / "start.exr")[..., 0]) > 0.0
