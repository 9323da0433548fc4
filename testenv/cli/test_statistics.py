# SPDX-License-Identifier: Apache-2.0
"""--stats: the keys are API (docs/statistics.md), and the figures agree with the render."""

import json

import pytest

from cliCase import SCENE, SMALL, Run, WriteStage

_KEYS = {
    "device": "name memory",
    "image": "width height samples",
    "time": "load translate prepare compile trace requests transfer shade firstPixel render total",
    "memory": "pathState film tables devicePeak hostPeak",
    "geometry": "mode streamedSamples streamedPaths meshes curves points instances triangles chunks bytesTotal budget peakBytes pinnedBytes alwaysResidentBytes "
    "uniqueBytesLoaded uploadedBytes uploads evictions requestsDropped rayBatches briefBatches primsMended iterations maxIterationsPerBatch raysRelaunched "
    "shadingRefetches chunksTouched chunksBuilt chunksFromCache chunksAhead estimated",
    "texture": "mode textures bytesSource bytesTotal budget peakBytes linesTotal linesLoaded uniqueBytesLoaded "
    "uploadedBytes evictions tableBytes alwaysResidentBytes lookups misses shadePasses shadeIterations fallbackTexels "
    "setConflicts",
    "rays": "camera indirect shadow perSecond",
    "accuracy": "nanSamples meanRelativeError",
}


@pytest.fixture(scope="module")
def Statistics(tmp_path_factory):
    folder = tmp_path_factory.mktemp("statistics")
    stage = WriteStage(folder)
    file = folder / "stats.json"
    done = Run("record", stage, folder / "out.exr", *SMALL, "--stats", file)
    assert done.code == 0, done.text
    return json.loads(file.read_text())


def test_every_key_is_there(Statistics):
    for section, names in _KEYS.items():
        assert set(names.split()) <= set(Statistics[section]), section
    assert isinstance(Statistics["version"], str) and isinstance(Statistics["warnings"], list)


def test_figures_agree_with_the_render(Statistics):
    image, rays, time = Statistics["image"], Statistics["rays"], Statistics["time"]
    assert rays["camera"] == image["width"] * image["height"] * image["samples"]
    assert Statistics["geometry"]["triangles"] == 1 and Statistics["geometry"]["instances"] == 1
    assert Statistics["geometry"]["mode"] == "resident"
    assert Statistics["memory"]["devicePeak"] >= Statistics["memory"]["pathState"] + Statistics["memory"]["film"]
    assert time["trace"] + time["shade"] <= time["render"] <= time["total"]
    assert time["firstPixel"] <= time["total"]
    assert Statistics["accuracy"]["nanSamples"] == 0


@pytest.mark.parametrize("level, triangles", [("low", 2), ("0", 2), ("medium", 8), ("high", 32), ("4", 512)])
def test_refine_levels_have_names_and_numbers(tmp_path, level, triangles):
    """A quad is cut into 4^level quads of two triangles."""
    stage = tmp_path / "quad.usda"
    stage.write_text('#usda 1.0\n' + SCENE.replace("[3]", "[4]").replace("[0, 1, 2]", "[0, 1, 2, 3]").replace(
        "(0, 1, 0)]", "(1, 1, 0), (-1, 1, 0)]").replace('"none"', '"catmullClark"'))
    done = Run("record", stage, tmp_path / "out.exr", *SMALL, "--camera", "main_cam", "--subdivision", "complexity",
               "--complexity", level, "--stats", tmp_path / "stats.json")
    assert done.code == 0, done.text
    assert json.loads((tmp_path / "stats.json").read_text())["geometry"]["triangles"] == triangles
