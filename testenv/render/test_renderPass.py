# SPDX-License-Identifier: Apache-2.0
"""Pictures of UsdRenderPasses.

Oracles: the stage with prims deactivated, or invisible, to the bit; the whole picture, where the camera does not see what a pass
hides from it, to the bit; that the pictures of what is held out in turn add up to the whole.
"""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdRender

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

WIDTH, HEIGHT = 60, 44
_A, _B, _FLOOR, _COPY = "/World/A", "/World/B", "/World/Floor", "/World/Copy2"


def _Write(path, edit=None, **collections):
    """A floor, two boxes, and three native instances of a ball, under a lamp and a dome; with a pass at /Pass."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, _FLOOR, shapes.Box(7.0, 0.2, 7.0), color=(0.6, 0.6, 0.6), translate=(0, -0.1, 0))
    author.AddMesh(stage, _A, shapes.Box(1.2, 1.2, 1.2), color=(0.9, 0.3, 0.1), translate=(-0.9, 0.9, 0))
    author.AddMesh(stage, _B, shapes.Box(0.9, 1.6, 0.9), color=(0.1, 0.4, 0.9), translate=(0.4, 0.8, -0.3), rotate=(0, 30, 0))
    prototype = stage.CreateClassPrim("/Prototype")
    author.AddMesh(stage, "/Prototype/Ball", shapes.Box(0.6, 0.6, 0.6), color=(0.4, 0.9, 0.2))
    for number in range(3):
        copy = stage.DefinePrim(f"/World/Copy{number}", "Xform")
        copy.GetReferences().AddInternalReference(prototype.GetPath())
        copy.SetInstanceable(True)
        author.Place(copy, translate=(1.0 + 0.5 * number, 0.3, 2.0 - 0.8 * number))
    author.AddLight(stage, "/World/Lamp", "Rect", placement=dict(translate=(0, 4, 0), rotate=(-90, 0, 0)), intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(2.0, 3.0, 6.0), target=(0, 0.4, 0), focalLength=30.0)
    renderPass = UsdRender.Pass.Define(stage, "/Pass").GetPrim()
    for name, paths in collections.items():
        api = Usd.CollectionAPI.Apply(renderPass, name)
        isTaken = name in ("matte", "prune")
        (api.CreateIncludesRel() if isTaken else api.CreateExcludesRel()).SetTargets(paths)
    if edit:
        edit(stage)
    stage.GetRootLayer().Save()
    return str(path)


def _Layers(tmp_path, aovs=("color", "alpha"), edit=None, samples=8, settings=None, **collections):
    path = _Write(tmp_path / "stage.usda", edit, **collections)
    return ours.Render(path, WIDTH, HEIGHT, aovs, renderPass="/Pass" if collections else "", samples=samples, maxDepth=3,
                       domeVisible=False, **(settings or {})).layers


def _Deactivate(*paths):
    return lambda stage: [stage.GetPrimAtPath(path).SetActive(False) for path in paths]


def _Hide(*paths):
    return lambda stage: [UsdGeom.Imageable(stage.GetPrimAtPath(path)).MakeInvisible() for path in paths]


def _AssertSameBits(a, b):
    assert a.keys() == b.keys()
    for name, pixels in a.items():
        assert pixels.tobytes() == b[name].tobytes(), name


@pytest.mark.parametrize("paths", [(_A,), (_B, "/World/Lamp"), (_COPY, _FLOOR)])
def test_pruned_is_deactivated_and_left_out_is_invisible(tmp_path, paths):
    """To the bit. A light that is gone lights nothing; an instance that is gone leaves the others."""
    aovs = ("color", "alpha", "primId", "cameraDepth", "crypto_object")
    expected = _Layers(tmp_path, aovs, _Deactivate(*paths))
    _AssertSameBits(_Layers(tmp_path, aovs, prune=paths), expected)
    aovs = ("color", "alpha", "cameraDepth", "crypto_object")
    expected = _Layers(tmp_path, aovs, _Hide(*paths))
    _AssertSameBits(_Layers(tmp_path, aovs, renderVisibility=paths), expected)
    assert expected["color"].tobytes() != _Layers(tmp_path)["color"].tobytes()


_ALL = (_A, _B, _FLOOR, "/World/Copy0", "/World/Copy1", _COPY)


def _AlphaOf(tmp_path, *paths):
    """Alpha where these are alone: camera rays are the same to the bit."""
    return _Layers(tmp_path, ("color", "alpha"), _Deactivate(*(path for path in _ALL if path not in paths)))["alpha"]


@pytest.mark.parametrize("paths", [(_A,), (_COPY, _B)])
def test_cameraVisibility_changes_what_camera_rays_meet_and_nothing_else(tmp_path, paths):
    """Alpha is that of the scene without them. Elsewhere the picture keeps its bits: shadows, light that bounces off them."""
    whole, hidden = _Layers(tmp_path), _Layers(tmp_path, cameraVisibility=paths)
    without = _Layers(tmp_path, ("color", "alpha"), _Deactivate(*paths))
    assert hidden["alpha"].tobytes() == without["alpha"].tobytes()
    elsewhere = _AlphaOf(tmp_path, *paths)[..., 0] == 0.0
    assert elsewhere.mean() > 0.5
    assert np.array_equal(hidden["color"][elsewhere], whole["color"][elsewhere])
    assert not np.array_equal(hidden["color"][~elsewhere], whole["color"][~elsewhere])
    assert (hidden["color"][elsewhere] != without["color"][elsewhere]).any(-1).mean() > 0.05  # they still cast shadows


def test_lights_that_the_camera_does_not_see(tmp_path):
    def Show(stage):
        stage.GetPrimAtPath("/World/Lamp").GetAttribute("xformOp:translate").Set((0, 1.0, 2.5))
        stage.GetPrimAtPath("/World/Lamp").GetAttribute("xformOp:rotateXYZ").Set((0, 180, 0))

    seen = _Layers(tmp_path, edit=Show)["color"]
    hidden = _Layers(tmp_path, edit=Show, cameraVisibility=("/World/Lamp",))["color"]
    assert seen.tobytes() != hidden.tobytes()
    assert np.array_equal(hidden, _Layers(tmp_path, edit=Show, settings={"lightsVisible": False})["color"])


@pytest.mark.parametrize("paths", [(_A,), (_FLOOR, _COPY), (_B, "/World/Copy0", "/World/Copy1")])
def test_what_is_held_out_in_turn_adds_up_to_the_whole(tmp_path, paths):
    """On opaque surfaces; colour and alpha."""
    rest = tuple(path for path in _ALL if path not in paths)
    whole, first, second = _Layers(tmp_path), _Layers(tmp_path, matte=paths), _Layers(tmp_path, matte=rest)
    for name in ("color", "alpha"):
        assert np.abs(first[name] + second[name] - whole[name]).max() < 1e-5, name
        for part in (first, second):
            assert np.abs(part[name] - whole[name]).max() > 0.1, name


def test_a_matte_pass_knows_nothing_of_other_rays(tmp_path):
    """Where nothing held out stands before the camera, the picture keeps its bits: shadows and bounces are as they were."""
    whole, matte = _Layers(tmp_path), _Layers(tmp_path, matte=(_A,))
    elsewhere = _AlphaOf(tmp_path, _A)[..., 0] == 0.0
    assert np.array_equal(matte["color"][elsewhere], whole["color"][elsewhere])
    full = _AlphaOf(tmp_path, _A)[..., 0] == 1.0
    assert (matte["color"][full] == 0.0).all(-1).mean() > 0.5  # B stands before the rest


def test_expressions_say_the_same(tmp_path):
    def Author(stage):
        api = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Pass"), "matte")
        api.CreateMembershipExpressionAttr(Sdf.PathExpression("/World/A /World/Copy*//"))

    paths = (_A, "/World/Copy0", "/World/Copy1", _COPY)
    path = _Write(tmp_path / "stage.usda", Author)
    found = ours.Render(path, WIDTH, HEIGHT, ("color", "alpha"), renderPass="/Pass", samples=8, maxDepth=3, domeVisible=False)
    _AssertSameBits(found.layers, _Layers(tmp_path, matte=paths))


@pytest.mark.parametrize("settings", [{"waveSize": 1024}, {"residency": "stream", "geometryMemory": "1M", "chunkBytes": 16384}])
def test_a_pass_has_the_same_bits_at_any_wave_and_pool(tmp_path, settings):
    collections = dict(matte=(_A,), cameraVisibility=(_COPY,), prune=("/World/Copy0",))
    _AssertSameBits(_Layers(tmp_path, settings=settings, **collections), _Layers(tmp_path, **collections))


def test_passes_take_away_whatever_prims_say(tmp_path):
    """A prim that says that the camera sees it is hidden by the pass; one that says it does not stays hidden."""
    def Say(**values):
        def Edit(stage):
            for name, value in values.items():
                UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/World/{name}")).CreatePrimvar(
                    "hdstream:visibility:camera", Sdf.ValueTypeNames.Bool, "constant").Set(value)

        return Edit

    both = _Layers(tmp_path, cameraVisibility=(_A, _B))
    _AssertSameBits(_Layers(tmp_path, edit=Say(A=True, B=False), cameraVisibility=(_A,)), both)
    instances = _Layers(tmp_path, cameraVisibility=("/World/Copy0", _COPY))
    _AssertSameBits(_Layers(tmp_path, edit=Say(Copy0=True, Copy1=True, Copy2=False), cameraVisibility=("/World/Copy0",)), instances)
