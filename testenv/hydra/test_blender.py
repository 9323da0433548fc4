# SPDX-License-Identifier: Apache-2.0
"""Blender's extension in Blender's module bpy: passes, framing, film, status, messages, edits, panels. Cycles is the judge of
passes and framing. testenv/install/test_blenderExtension.py judges what needs no Blender."""

import json
import re
import sys

import numpy as np
import pytest
from blenderCase import MakeExtension
from openUsd import HERE, RunProgram


@pytest.fixture(scope="module")
def blenders(openUsd, plugin):
    if not openUsd.isBlenders:
        pytest.skip("the plug-in was not built for a Blender: there is no bpy for it")
    return openUsd


@pytest.fixture(scope="module")
def extension(blenders, tmp_path_factory):
    version = RunProgram(blenders.Script("-c", "import bpy; print('blender', *bpy.app.version[:2], sep='.')"),
                         blenders.Environment()).output
    return MakeExtension(tmp_path_factory.mktemp("blender"), re.search(r"blender\.(\d+\.\d+)", version).group(1))


@pytest.fixture(scope="module")
def found(blenders, extension, tmp_path_factory):
    """A function that runs a scenario of blenderScript.py, once, and gives what it has found."""
    work = tmp_path_factory.mktemp("scenarios")

    def Find(name):
        place = work / f"{name}.json"
        if not place.exists():
            command = [blenders.python, HERE / "blenderScript.py", extension, work, name]
            result = RunProgram(command, blenders.Environment(BLENDER_USER_RESOURCES=str(work)))
            assert result.code == 0, result.output[-4000:]
        return json.loads(place.read_text())

    return Find


@pytest.mark.parametrize("method", ("HYDRA", "USD"))
def test_passes_are_those_of_cycles(found, method):
    """Means over pixels at edges are Cycles' alone: ours are those of the pixel's centre. So some pixels differ. Cycles' albedo
    of the background is the world's colour, ours is 0."""
    passes = found("Passes")[method]
    assert passes["errors"] == ""
    for name in ("Depth.Z", "Position.X", "Position.Y", "Position.Z", "Normal.X", "Normal.Y", "Normal.Z", "UV.U", "UV.V", "UV.A",
                 "Denoising Normal.X", "Denoising Normal.Y", "Denoising Normal.Z", "Denoising Albedo.R of hits",
                 "Denoising Albedo.G of hits", "Denoising Albedo.B of hits"):
        assert passes["shares"][name] > 0.93, (name, passes["shares"])
    assert abs(passes["ratio"] - 1.0) < 0.02


def test_the_cryptomatte_node_reads_our_files(blenders, tmp_path):
    """Mattes of the compositor are those of our own decoder."""
    pytest.importorskip("hdstream._core")
    import matteCase
    file, names = str(tmp_path / "all.exr"), ["/World/Card", "/World/Mover", "/World/Wall"]
    stage = matteCase.WriteMatteStage(tmp_path / "all.usda")
    assert not matteCase.RenderMattes(stage, ("color", "crypto_object")).Write(file)
    result = RunProgram([blenders.python, HERE / "cryptomatteScript.py", file, matteCase.WIDTH, matteCase.HEIGHT, json.dumps(names),
                         tmp_path / "mattes.npz"], blenders.Environment())
    assert result.code == 0, result.output[-4000:]
    ours = matteCase.Cryptomatte(file, "crypto_object")
    with np.load(tmp_path / "mattes.npz") as mattes:
        for name in names:
            assert np.allclose(mattes[name], ours.Matte(name), atol=1e-6) and ours.Matte(name).max() > 0.3


def test_borders_and_percentages_are_those_of_cycles(found):
    for name, framing in found("Framing").items():
        assert framing["errors"] == "", name
        assert framing["shape"] == framing["wanted"], name
        assert framing["drawn"] == framing["drawnWanted"], name
        assert framing["difference"] < 0.05, (name, framing)


def test_background_has_alpha_one_unless_the_film_is_transparent(found):
    film = found("Film")
    assert film["False"]["alpha"] == 1.0 and film["False"]["blue"] > 0.5
    assert film["True"]["alpha"] == 0.0 and film["True"]["blue"] == 0.0
    assert film["True"]["alphaOfBall"] == 1.0


def test_exposure_of_the_film_is_cycles(found):
    """Also of the background, and with a film that takes in nothing. Alpha has no exposure."""
    for factor, exposure in found("Exposure").items():
        assert exposure["errors"] == "" and exposure["alpha"] == 1.0, factor
        if float(factor) == 0.0:
            assert exposure["brightest"] < 1e-6 and exposure["wanted"] == 0.0
        else:
            assert abs(exposure["ratio"] - 1.0) < 0.02 and abs(exposure["background"] - 1.0) < 0.005, (factor, exposure)


def test_the_camera_sees_no_lamp(found):
    assert found("Lamp")["brightest"] < 1.5  # the lamp itself is many times as bright as what it lights


def test_status_tells_samples_time_left_and_bytes(found):
    status = found("Status")
    assert status["isDone"] and status["steps"] > 5 and not status["reports"]
    pattern = re.compile(r"Sample (\d+)/4096( \| Left [\d:]+)? \| Resident [\d.]+[BKMG] \| Loaded [\d.]+[BKMG]")
    matches = [pattern.fullmatch(line) for line in status["lines"]]
    assert all(matches), status["lines"]
    samples = [int(match.group(1)) for match in matches]
    assert samples == sorted(samples)


def test_a_render_can_be_cancelled_and_the_next_one_is_whole(found):
    cancel = found("Cancel")
    assert not cancel["isDone"] and cancel["steps"] == 3
    assert cancel["after"] == 4 and cancel["afterIsDone"]


@pytest.mark.parametrize("case, kind, words", [
    ("no plug-in", "ERROR", "the plug-in is missing"), ("damaged plug-in", "ERROR", "could not be loaded"),
    ("wrong Blender", "ERROR", "made for Blender 4.2"), ("wrong OpenUSD", "ERROR", "made for OpenUSD 24.05"),
    ("no device", "ERROR", "no such device"), ("small budget", "ERROR", "geometryMemory"),
    ("bad size", "WARNING", "textureMemory"), ("missing texture", "WARNING", "missing.png")])
def test_what_is_wrong_is_one_line_and_blender_lives_on(found, case, kind, words):
    messages = found("Messages")[case]
    assert len(messages["reports"]) == 1, messages
    assert messages["reports"][0][0] == kind and words in messages["reports"][0][1], messages
    assert "\n" not in messages["reports"][0][1]
    assert messages["after"] == [] and messages["afterMean"] > 0.1


def test_what_does_not_come_is_told_in_one_line_a_kind(found):
    left = found("LeftOut")
    assert left["plain"] == []
    assert {kind for kind, _ in left["reports"]} == {"WARNING"}
    lines = sorted(line.removeprefix("Stream: ") for _, line in left["reports"])
    assert lines == [
        "Blender does not hand over all nodes of materials: Voronoi Texture of Rock 0, Voronoi Texture of Rock 1, "
        "Voronoi Texture of Rock 2",
        "Blender does not hand over nodes of lights: Area",
        "Blender does not hand over the spread of area lights: Area",
        "Blender hands over all blends of colours as Mix: Rock 0",
        "a panoramic camera is drawn as perspective: Camera",
        "holdouts and shadow catchers are drawn as other objects: Cube",
        "motion blur is not drawn: Blender hands over one moment",
        "of a world Blender hands over a colour or an image alone: Sky Texture",
        "the camera sees objects that it is not to see: Sphere",
        "volumes of materials are not drawn: Rock 0"]


def test_a_scene_is_drawn_though_what_it_lacks_cannot_be_told(found):
    left = found("LeftOut")
    assert [kind for kind, _ in left["failed"]] == ["WARNING"] and left["drawn"] > 0.1
    assert left["failed"][0][1].startswith("Stream: cannot tell what Blender does not hand over: AttributeError: ")


def test_nodes_that_are_left_out_are_those_of_blenders_exporter(blenders, tmp_path):
    """The exporter itself is the judge of the list."""
    result = RunProgram([blenders.python, HERE / "blenderNodesScript.py", tmp_path], blenders.Environment())
    assert result.code == 0, result.output[-4000:]
    sys.path.insert(0, str(HERE.parents[1] / "packaging" / "blender"))
    import leftOut

    assert set(json.loads((tmp_path / "nodes.json").read_text())) == leftOut._NODES


def test_settings_reach_the_plug_in(found):
    settings = found("Settings")
    assert settings["isSame"] and settings["isOther"]
    assert settings["noise"] > 0.01  # of one sample


def test_edits_arrive_and_memory_stays(found):
    life = found("Life")
    dark, bright = life["means"][0::2], life["means"][1::2]
    assert max(dark) < min(bright)
    # From the fifth render on, when caches are filled: less than 2 MB a render.
    growth = (life["sizes"][-1] - life["sizes"][4]) / (len(life["sizes"]) - 5)
    assert growth < 2 << 20, life["sizes"]


def test_blenders_panels_are_shown_and_given_back(found):
    panels = found("Panels")
    for name in ("DATA_PT_lens", "DATA_PT_camera_dof", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface", "DATA_PT_context_light",
                 "STREAM_LIGHT_PT_light", "STREAM_RENDER_PT_quality", "STREAM_VIEW_LAYER_PT_passes", "OBJECT_PT_visibility"):
        assert name in panels["shown"], name
    assert panels["left"] == [] and not panels["propertiesLeft"]
