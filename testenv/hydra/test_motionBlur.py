# SPDX-License-Identifier: Apache-2.0
"""What moves while the shutter is open, through Hydra, against many still pictures of Hydra: a shape, an instancer and a light in
one stage, by a z-test of each block of pixels. And what changes besides, against `hdstream record`, to the bit.

The stills are of the stage at random times in equal parts of the interval, without motion blur: what the delegate samples, the
device's keys and their interpolation take no part in them.
"""

import json
import pathlib

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from frontEnds import MODES, CompareFrontEnds, FrontEnds, ReadColor
from openUsd import RunProgram
from stages import motion
from wrapperStage import SETTINGS_PATH, WriteWrapper

_SCRIPT = pathlib.Path(__file__).resolve().parent / "shutterScript.py"
WIDTH, HEIGHT, BLOCK = 48, 36, 6
GROUPS, STILLS_OF_GROUP, STILL_SAMPLES = 8, 16, 8
# A light, an instancer and a box. Legacy scene delegates tell transforms at the shutter's ends and at authored samples alone: a
# box that turns by 250 degrees in between comes the shorter way there (docs/motionBlur.md).
SCENES = {"legacy": ("lamp", "swarm", "way"), "sceneIndex": ("lamp", "swarm", "turn")}


def _Blocks(path):
    picture = ReadColor(path)[..., :3].astype(np.float64)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    return picture.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3).mean((1, 3))


def _Pictures(folder):
    """(jobs of blurred pictures by group, of stills by group and time, of one still)"""
    rng = np.random.default_rng(9)
    count = GROUPS * STILLS_OF_GROUP
    parts = np.arange(count).reshape(STILLS_OF_GROUP, GROUPS).T  # every group has a time in each of its parts
    times = motion.FRAME + motion.SHUTTER[0] + (parts + rng.random(parts.shape)) / count * (motion.SHUTTER[1] - motion.SHUTTER[0])

    def Job(name, time, samples, seed, motionBlur):
        return dict(file=str(folder / f"{name}.exr"), time=float(time),
                    settings=dict(samples=samples, seed=seed, motionBlur=motionBlur))
    blurred = [Job(f"blurred{group}", motion.FRAME, STILLS_OF_GROUP * STILL_SAMPLES, 1 + group, "on") for group in range(GROUPS)]
    stills = [[Job(f"still{group}_{i}", time, STILL_SAMPLES, 100 + group * STILLS_OF_GROUP + i, "off")
               for i, time in enumerate(row)] for group, row in enumerate(times)]
    return blurred, stills, Job("one", motion.FRAME, 512, 1000, "off")


def _Scores(a, b):
    """The differences of means over their standard errors; Welch 1947."""
    error = np.sqrt(a.var(0, ddof=1) / len(a) + b.var(0, ddof=1) / len(b))
    return (a.mean(0) - b.mean(0)) / np.maximum(error, 1e-5)


@pytest.mark.parametrize("mode", MODES)
def test_blur_is_the_average_of_stills(mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("another renderer has no such settings")
    motion.Write(tmp_path / "moving.usda", *SCENES[mode])
    wrapper = WriteWrapper(tmp_path / "moving.usda", tmp_path / "wrapper.usda", WIDTH, mode=mode, samples=1, seed=1, maxDepth=1,
                           motionBlur="on", pixelFilter="box", pixelFilterWidth=1.0, noCache=True)
    blurred, stills, one = _Pictures(tmp_path)
    job = dict(stage=str(wrapper.path), camera=wrapper.camera, settings=SETTINGS_PATH, renderer="HdStreamRendererPlugin",
               width=WIDTH, pictures=[*blurred, *sum(stills, []), one])
    (tmp_path / "job.json").write_text(json.dumps(job))
    environment = {"USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX": "1"} if mode == "sceneIndex" else {}
    result = RunProgram(openUsd.Script(_SCRIPT, tmp_path / "job.json"), openUsd.Environment(plugin, **environment))
    assert result.code == 0, result.output
    a = np.array([_Blocks(picture["file"]) for picture in blurred])
    b = np.array([np.mean([_Blocks(picture["file"]) for picture in group], 0) for group in stills])
    scores = _Scores(a, b)
    # Of about 14 degrees of freedom: a score above 6.5 has a chance of 1e-5, and there are 144.
    assert np.abs(scores).max() < 6.5, scores
    assert np.sqrt((scores ** 2).mean()) < 1.35, scores
    still = np.abs(_Scores(a, np.repeat(_Blocks(one["file"])[None], 2, 0)))
    assert (still > 8).mean() > 0.05, "the test would show little"


def _Differences(mode, openUsd, plugin, folder):
    """Of scenes and pictures; and the scene that Hydra gave, and what both programs said."""
    wrapper = WriteWrapper(folder / "moving.usda", folder / "wrapper.usda", WIDTH, mode=mode, samples=4, seed=3, maxDepth=2,
                           noCache=True)
    differences, said = CompareFrontEnds(FrontEnds(openUsd, plugin, mode=mode), wrapper, folder)
    return differences, (folder / "hydra.txt").read_text(), said


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ["growingLights", "flicker"])
def test_lights_that_change_are_those_of_hdstream_record(name, mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("only Stream writes dumps")
    motion.Write(tmp_path / "moving.usda", name)
    differences, scene, _ = _Differences(mode, openUsd, plugin, tmp_path)
    assert differences == []
    assert name != "flicker" or scene.count("  light at ") >= 9, "the test would show little"


@pytest.mark.parametrize("mode", MODES)
def test_velocities_that_are_not_finite_are_those_of_hdstream_record(mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("only Stream writes dumps")
    motion.Write(tmp_path / "moving.usda", "points")
    stage = Usd.Stage.Open(str(tmp_path / "moving.usda"))
    velocities = UsdGeom.Points(stage.GetPrimAtPath("/World/Dust")).GetVelocitiesAttr()
    values = list(velocities.Get(motion.FRAME))
    values[3], values[40] = (float("nan"), 0.0, 0.0), (0.0, float("inf"), 1.0)
    velocities.Set(values, motion.FRAME)
    stage.GetRootLayer().Save()
    differences, scene, said = _Differences(mode, openUsd, plugin, tmp_path)
    assert differences == []
    assert "points at " in scene and said.count("velocities are not finite: points that have these stand still") == 2


@pytest.mark.parametrize("mode", MODES)
def test_instances_whose_velocities_are_not_finite_are_those_of_hdstream_record(mode, openUsd, plugin, isStream, tmp_path):
    if not isStream:
        pytest.skip("only Stream writes dumps")
    motion.Write(tmp_path / "moving.usda")
    stage = Usd.Stage.Open(str(tmp_path / "moving.usda"))
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Swarm")
    UsdGeom.Cube.Define(stage, "/World/Swarm/Box").CreateSizeAttr(0.6)
    swarm.CreatePrototypesRel().SetTargets(["/World/Swarm/Box"])
    swarm.CreateProtoIndicesAttr([0, 0, 0])
    swarm.CreatePositionsAttr().Set([(-1.2, 0, 0), (0, 0, 0), (1.2, 0, 0)], motion.FRAME)
    swarm.CreateOrientationsAttr().Set([Gf.Quath(0.5, 0.5, 0.5, 0.5)] * 3, motion.FRAME)
    swarm.CreateVelocitiesAttr().Set([(0, 12, 0), (float("nan"), 0, 0), (0, 12, 0)], motion.FRAME)
    swarm.CreateAngularVelocitiesAttr().Set([(0, 0, 240), (0, 240, 0), (0, float("inf"), 0)], motion.FRAME)
    stage.GetRootLayer().Save()
    differences, scene, said = _Differences(mode, openUsd, plugin, tmp_path)
    assert differences == []
    assert said.count("velocities are not finite: instances that have these stand still") == 2
