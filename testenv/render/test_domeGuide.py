# SPDX-License-Identifier: Apache-2.0
"""Guides of domes, even or with an image: light through windows has less noise, the same mean, and the same bits however it is rendered."""

import json

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

import hdstream
import ours
from stages import author, imageFile, shapes

WIDTH, HEIGHT = 40, 30
_HOST = dict(camera="/World/Camera", imageWidth=WIDTH, imageHeight=HEIGHT, samples=4, maxDepth=3, noCache=True)
_WALLS = {  # size, place, turn
    "Floor": ((4, 4), (0, 0, 0), (0, 0, 0)),
    "Ceiling": ((4, 4), (0, 3, 0), (180, 0, 0)),
    "Back": ((4, 4), (0, 1, -2), (90, 0, 0)),
    "Front": ((4, 4), (0, 1, 2), (-90, 0, 0)),
    "Left": ((4, 4), (-2, 1, 0), (0, 0, -90)),
    "RightLow": ((1.0, 4), (2, 0.5, 0), (0, 0, 90)),
    "RightHigh": ((1.0, 4), (2, 2.5, 0), (0, 0, 90)),
    "RightFar": ((1.0, 1.5), (2, 1.5, -1.25), (0, 0, 90)),
    "RightNear": ((1.0, 1.5), (2, 1.5, 1.25), (0, 0, 90)),
}


def _Image(path):
    """A sky that is blue above and brighter towards the window, with a small sun on the other side."""
    y, x = np.mgrid[0:64, 0:128]
    image = np.stack([0.4 + 0.6 * (y < 32), 0.5 + 0.5 * (y < 32), 0.6 + 1.4 * (y < 32)], -1) * (1 + np.cos(2 * np.pi * (x[..., None] - 32) / 128))
    image[20:22, 94:96] = 600.0
    imageFile.WriteExr(path, dict(zip("RGB", np.moveaxis(image.astype(np.float32), -1, 0))))
    return str(path)


def _Room(path, sun=True, walls=tuple(_WALLS), gray=None, edit=None, image=None):
    """A room with a window of 1 x 1 in its right wall, below an even sky or that of an image."""
    stage = author.NewStage(str(path))
    for name in walls:
        size, place, turn = _WALLS[name]
        author.AddMesh(stage, f"/World/{name}", shapes.Plane(*size), color=(gray,) * 3 if gray else (0.7, 0.6, 0.5), doubleSided=True, translate=place, rotate=turn)
    author.AddMesh(stage, "/World/Box", shapes.Box(0.8, 0.8, 0.8), color=(0.4, 0.4, 0.6), translate=(0.5, 0.4, -0.5))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=2.0, **({"textureFile": image} if image else {}))
    if sun:
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-30, 80, 0)), intensity=20000.0, angle=0.5)
    author.AddCamera(stage, "/World/Camera", (-1.5, 1.5, 1.6), (1.0, 1.0, -1.0), focalLength=18.0)
    if edit:
        edit(stage)
    stage.GetRootLayer().Save()
    return str(path)


def _Draw(stage, **settings):
    return ours.Render(stage, WIDTH, HEIGHT, **{"samples": 8, "maxDepth": 3, **settings})


def _Error(stage, reference, **settings):
    """Mean of squares over those of the reference, which another seed drew."""
    pictures = [_Draw(stage, seed=seed, samples=16, **settings).rgb for seed in (1, 2)]
    return np.mean([np.mean((picture - reference) ** 2) for picture in pictures])


@pytest.fixture(params=[False, True], ids=["even", "image"])
def stage(request, tmp_path):
    return _Room(tmp_path / "room.usda", sun=not request.param, image=_Image(tmp_path / "sky.exr") if request.param else None)


def test_a_window_is_found(stage):
    """Pictures of hosts that edit have no guide: they are the brute force. The mean is theirs, the noise a part of it."""
    plain = [_Draw(stage, interactive=True, seed=seed, samples=256).rgb for seed in range(11, 15)]
    guided = [_Draw(stage, seed=seed, samples=256).rgb for seed in range(11, 15)]
    difference = np.mean(guided) - np.mean(plain)
    deviation = np.std([p.mean() for p in plain]) / np.sqrt(3) + np.std([p.mean() for p in guided]) / np.sqrt(3)
    assert abs(difference) < 4 * deviation + 1e-4 * np.mean(plain)
    blocks = lambda pictures: np.mean(pictures, 0).mean(-1).reshape(5, 6, 5, 8).mean((1, 3))
    assert blocks(guided) == pytest.approx(blocks(plain), rel=0.06)
    reference = np.mean(guided + plain, 0)
    assert _Error(stage, reference) < 0.5 * _Error(stage, reference, interactive=True)


@pytest.mark.parametrize("settings", [
    dict(residency="stream", geometryMemory="30%", chunkBytes=4096), dict(waveSize=700), dict(kernels="general"), dict(traversal="simd8"),
    dict(clampDirect=1e6),  # by the scalar form of shading
    dict(traversal="scalar", residency="resident")], ids=lambda settings: next(iter(settings.values())))
def test_bits_do_not_depend_on_how_it_is_rendered(settings, stage):
    assert _Draw(stage, **settings).rgb.tobytes() == _Draw(stage, kernels="own", residency="resident").rgb.tobytes()


def test_rounds_have_the_bits_of_any_wave(stage):
    """A picture of so many pixels learns in two rounds."""
    draw = lambda **settings: ours.Render(stage, 256, 144, samples=1, maxDepth=3, **settings).rgb
    assert draw(waveSize=7001).tobytes() == draw().tobytes()


def test_a_crop_has_the_bits_of_the_picture(tmp_path):
    stage = _Room(tmp_path / "room.usda")
    whole = hdstream.Render(stage, **_HOST).aovs["color"]
    crop = hdstream.Render(stage, crop=(10, 12, 30, 24), **_HOST).aovs["color"]
    assert crop.tobytes() == np.ascontiguousarray(whole[12:24, 10:30]).tobytes()


@pytest.mark.parametrize("gray", [0.6, 0.04])
def test_an_open_sky_has_no_guide(gray, tmp_path):
    """Without walls and ceiling nothing changes, not even the noise; nor where little light is reflected."""
    stage = _Room(tmp_path / "plain.usda", walls=("Floor",), gray=gray)
    assert _Draw(stage).rgb.tobytes() == _Draw(stage, interactive=True).rgb.tobytes()


@pytest.mark.parametrize("name", ["hdstream:holdout", "hdstream:shadowCatcher"])
def test_what_passes_leave_out_changes_no_guide(name, tmp_path):
    """Where the box is not before the camera, the bits are those of the plain picture, as compositing needs it."""
    def Say(stage):
        box = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Box"))
        box.CreatePrimvar(name, Sdf.ValueTypeNames.Bool, "constant").Set(True)

    layers = ("color", "primId")
    plain, said = (ours.Render(_Room(tmp_path / "room.usda", edit=edit), WIDTH, HEIGHT, layers, samples=8, maxDepth=3).layers
                   for edit in (None, Say))
    prims = np.squeeze(plain["primId"])
    isBox = prims == prims[HEIGHT // 2 + 4, WIDTH // 2]  # samples of a pixel see what is beside it
    near = np.zeros_like(isBox)
    for y, x in zip(*np.nonzero(isBox)):
        near[max(y - 2, 0):y + 3, max(x - 2, 0):x + 3] = True
    assert 0.05 < near.mean() < 0.6
    assert np.array_equal(plain["color"][~near], said["color"][~near])
    assert not np.array_equal(plain["color"][isBox], said["color"][isBox])
    interactive = _Draw(_Room(tmp_path / "room.usda"), interactive=True)  # there is a guide
    assert not np.array_equal(interactive.layers["color"][~near], plain["color"][~near])


def test_a_wall_that_cameras_do_not_see_hides_no_room(tmp_path):
    """A camera outside that looks through it: the room is learnt."""
    def Cut(stage):
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Front")).CreatePrimvar(
            "hdstream:visibility:camera", Sdf.ValueTypeNames.Bool, "constant").Set(False)
        stage.RemovePrim("/World/Camera")
        author.AddCamera(stage, "/World/Camera", (0, 1.5, 6), (0, 1.0, 0), focalLength=50.0)

    stage = _Room(tmp_path / "room.usda", sun=False, edit=Cut)
    reference = np.mean([_Draw(stage, seed=seed, samples=256, interactive=seed % 2 == 0).rgb for seed in range(11, 15)], 0)
    assert _Error(stage, reference) < 0.6 * _Error(stage, reference, interactive=True)


def test_a_session_forgets_the_guide(tmp_path):
    """What a session has drawn before, by other cameras' guides, is in no picture; nor are counts of rays of the guide."""
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    stage = _Room(tmp_path / "room.usda")
    session = _core.Session()
    TranslateStage(Usd.Stage.Open(stage), session, Usd.TimeCode.Default())

    def Draw(**settings):
        options = _core.Settings()
        options.camera, options.imageWidth, options.imageHeight = "/World/Camera", WIDTH, HEIGHT
        options.pixelFilter, options.pixelFilterWidth, options.russianRoulette, options.noCache = "box", 1.0, False, True
        for name, value in {"samples": 8, "maxDepth": 3, **settings}.items():
            setattr(options, name, value)
        session.Render(options)
        return np.array(session.Layers()[0].pixels)[..., :3].tobytes(), json.loads(session.Statistics())["rays"]

    first = Draw()
    Draw(seed=5)
    interactive = Draw(interactive=True)
    again = Draw()
    assert first[0] == again[0] == _Draw(stage).layers["color"][..., :3].tobytes()
    assert interactive[0] == _Draw(stage, interactive=True).layers["color"][..., :3].tobytes() != first[0]
    for kind in ("camera", "indirect"):
        assert first[1][kind] == interactive[1][kind]
    assert first[1]["shadow"] <= first[1]["camera"] + first[1]["indirect"]
