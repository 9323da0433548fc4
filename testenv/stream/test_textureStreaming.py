# SPDX-License-Identifier: Apache-2.0
"""Streamed textures give the bits of resident textures at every budget that holds what one point needs.

The oracle is the resident mode, whose pictures testenv/render compares with definitions.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from stages import imageFile, textured
from streamCase import Case, ColdCache


def _LeastMemory(case) -> int:
    with pytest.raises(case.core.Error, match="--textureMemory: 512 bytes cannot hold") as error:
        case.Fresh().Render(residency="stream", textureMemory="512")
    return int(re.search(r"that takes (\d+) bytes", str(error.value)).group(1))


@pytest.mark.parametrize("memory", ["100%", "30%", "5%", "2%", "40K"])
def test_any_budget_gives_the_same_bits(Textured, memory):
    texture = Textured.Fresh().AssertStreamsTextures(textureMemory=memory)
    if memory.endswith("%"):
        assert texture["budget"] <= float(memory[:-1]) / 100 * texture["bytesTotal"] + 1


def test_what_one_point_needs_is_enough(Textured):
    """And less is an error that says what is needed."""
    least = _LeastMemory(Textured)
    texture = Textured.Fresh().AssertStreamsTextures(textureMemory=str(least))
    assert texture["budget"] == least
    assert texture["evictions"] > 0 and texture["setConflicts"] > 0, "the pool is far too small for all at once"
    with pytest.raises(Textured.core.Error, match=f"that takes {least} bytes"):
        Textured.Fresh().Render(residency="stream", textureMemory=str(least - 1))


@pytest.mark.parametrize("settings", [
    dict(traversal="scalar"),
    dict(waveSize=1000),
    dict(geometryMemory="20%"),
    dict(geometryMemory="20%", request="first"),
    dict(geometryMemory="20%", waveSize=999, geometryEviction="flush"),
], ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()))
def test_other_ways_give_the_same_bits(Textured, settings):
    Textured.Fresh().AssertStreamsTextures(textureMemory="20K", **settings)


def test_what_fits_is_loaded_once_and_stays(Textured):
    case = Textured.Fresh()
    first = case.AssertStreamsTextures()
    assert first["evictions"] == 0 and first["setConflicts"] == 0
    second = case.AssertStreamsTextures(seed=0, cullStyle="nothing")
    assert first["uploadedBytes"] > 0 == second["uploadedBytes"] == second["misses"] == second["linesLoaded"]
    assert second["lookups"] > 0


@pytest.mark.parametrize("settings", [dict(), dict(geometryMemory="20%")], ids=["in step", "with lists"])
def test_cancelled_while_texels_are_loaded(Textured, tmp_path, settings):
    """Whenever it is: the render stops, nothing of the wave is seen, and the next one has the same bits."""
    case, cache = Textured.Fresh(), ColdCache(tmp_path / "cache")
    numAsked, stopsAt = 0, 1

    def IsCancelled():
        nonlocal numAsked
        numAsked += 1
        return numAsked == stopsAt

    fractions = []
    while stopsAt < 2000:
        numAsked = 0
        told = []
        result = case.Start(lambda progress: told.append(progress.fraction) or True, IsCancelled, residency="stream",
                            textureMemory="40K", waveSize=3000, cacheDirectory=cache, **settings)
        if result == case.core.RenderResult.Complete:
            break
        assert result == case.core.RenderResult.Stopped and numAsked == stopsAt, "it is not asked again"
        fractions.append(told[-1] if told else 0.0)
        stopsAt += 1 + stopsAt // 3
    assert fractions[0] == 0.0 < fractions[-1] < 1.0
    assert len(fractions) > 8 and fractions == sorted(fractions)
    case.AssertStreamsTextures(textureMemory="40K", waveSize=3000, cacheDirectory=cache, **settings)


def test_device_memory_is_what_was_asked_for(Textured):
    """By the allocator's own account: what is neither the pool nor its tables does not depend on the pool."""
    others = []
    for memory in (16 << 10, 64 << 10):
        _, statistics = Textured.Fresh().Render(residency="stream", textureMemory=str(memory))
        texture = statistics["texture"]
        assert texture["peakBytes"] <= memory == texture["budget"]
        others.append(statistics["memory"]["devicePeak"] - texture["budget"] - texture["tableBytes"])
    assert others[0] == others[1]


@pytest.mark.parametrize("iterations", [1, 2])
def test_interactive_pictures_are_blurred_at_worst(Textured, iterations):
    # Of many samples: a blurred roughness turns the rays of a path, which of few is noise of its own.
    layers, statistics = Textured.Fresh().Render(residency="stream", shadeIterations=iterations, textureMemory="64K", samples=64)
    texture = statistics["texture"]
    color, exact = layers["color"], Textured.Fresh().Render(residency="resident", samples=64)[0]["color"]
    assert texture["fallbackTexels"] > 0 or color.tobytes() == exact.tobytes()
    assert np.isfinite(color).all()
    assert np.abs(color - exact).mean() < 0.02 * exact[..., :3].mean()


def test_interactive_pictures_become_exact(Textured):
    """Once all that is seen has been loaded nothing is missing any more."""
    case = Textured.Fresh()
    case.Render(residency="stream", shadeIterations=1)
    case.Render(residency="stream", shadeIterations=1, maxDepth=7)  # asks for what came too late for the first one
    layers, statistics = case.Render(residency="stream", shadeIterations=1)
    assert statistics["texture"]["fallbackTexels"] == 0
    case.AssertBits(layers)


def test_threads_do_not_matter(Textured, tmp_path):
    pictures = []
    for threads in ("1", "3"):
        picture = tmp_path / f"{threads}.exr"
        environment = dict(os.environ, POCL_MAX_PTHREAD_COUNT=threads, POCL_CPU_MAX_CU_COUNT=threads)
        done = subprocess.run(
            [sys.executable, "-m", "hdstream", "record", Textured.path, str(picture), "--quiet", "--camera", Textured.camera,
             "--imageWidth", "61", "--samples", "3", "--residency", "stream", "--textureMemory", "24K"],
            env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        pictures.append(imageFile.ReadExr(picture))
    for name, plane in pictures[0].items():
        assert plane.tobytes() == pictures[1][name].tobytes(), name


# --- Images of lights ---------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=[False, True], ids=["imagesOfLightsAlone", "besideTextures"])
def ImageLights(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("imageLights") / "stage.usda"
    textured.WriteImageLights(str(path), request.param)
    textured.WriteImageLights(str(path.with_name("precise.usda")), request.param, isPrecise=True)
    return Case(path).RenderResident()


@pytest.mark.parametrize("settings", [
    dict(textureMemory="100%"),
    dict(textureMemory="30%"),
    dict(textureMemory="40K"),
    dict(textureMemory="40K", traversal="scalar", waveSize=1000),
    dict(textureMemory="40K", geometryMemory="20%"),
    dict(textureMemory="40K", geometryMemory="20%", request="first"),
], ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()))
def test_lights_with_images_stream_the_same_bits(ImageLights, settings):
    texture = ImageLights.Fresh().AssertStreamsTextures(**settings)
    assert texture["textures"] >= 2 and texture["linesLoaded"] > 0


def test_what_one_point_needs_of_lights_is_enough(ImageLights):
    """All lights along a ray, one that is sampled, and the surface's textures."""
    least = _LeastMemory(ImageLights)
    texture = ImageLights.Fresh().AssertStreamsTextures(textureMemory=str(least))
    assert texture["budget"] == least and texture["evictions"] > 0


def test_mapped_lights_have_the_same_bits(ImageLights, tmp_path):
    layers, _ = ImageLights.Fresh().Render(residency="mapped", cacheDirectory=ColdCache(tmp_path / "cache"))
    ImageLights.AssertBits(layers)


def test_lights_with_float_images_look_the_same(ImageLights):
    """Of floats the codec loses next to nothing, and their lines have other shapes."""
    layers, _ = Case(pathlib.Path(ImageLights.path).with_name("precise.usda")).Render(residency="resident")
    color, precise = ImageLights.layers["color"], layers["color"]
    assert color.tobytes() != precise.tobytes(), "the codec loses something"
    assert np.abs(color - precise).mean() < 0.01 * precise.mean()


# --- Images that are not what they seem --------------------------------------------------------------


def _Damage(path) -> None:
    """Its header stays, its texels cannot be read."""
    data = bytearray(path.read_bytes())
    data[len(data) // 3 : len(data) // 2] = bytes(len(data) // 2 - len(data) // 3)
    path.write_bytes(data)


def test_textures_nobody_sees_are_not_opened(Textured, tmp_path):
    """An image that is damaged is no news as long as nobody looks at it."""
    case = Textured.Copy(tmp_path)
    from pxr import Usd
    from hdstream.translate import TranslateStage

    from stages import author, shapes
    images = pathlib.Path(case.path).parent / "images"
    shutil.copy(images / "photo0.png", images / "unseen.png")
    _Damage(images / "unseen.png")
    stage = Usd.Stage.Open(case.path)
    look = textured.AddTexturedMaterial(stage, "/World/Looks/Unseen", dict(diffuseColor=("./images/unseen.png", "rgb")))
    author.AddMesh(stage, "/World/Unseen", shapes.Plane(0.1, 0.1), material=look, translate=(0, -50, 0))
    warnings = []
    case.session = case.core.Session(warnings.append)
    TranslateStage(stage, case.session, Usd.TimeCode.Default())
    case.Render(residency="stream")
    assert warnings == []
    case.Render(residency="resident")
    assert len(warnings) == 1 and "unseen.png" in warnings[0]


def test_a_file_that_cannot_be_read_is_reported_once(Textured, tmp_path):
    """The render goes on with the fallback; the file is not read again and again."""
    case = Textured.Copy(tmp_path)
    _Damage(pathlib.Path(case.path).parent / "images" / "photo1.png")
    warnings = []
    from pxr import Usd
    from hdstream.translate import TranslateStage
    case.session = case.core.Session(warnings.append)
    TranslateStage(Usd.Stage.Open(case.path), case.session, Usd.TimeCode.Default())
    layers, statistics = case.Render(residency="stream", textureMemory="24K")
    assert len(warnings) == 1 and "photo1.png" in warnings[0]
    assert np.isfinite(layers["color"]).all()
    assert layers["color"].tobytes() != Textured.layers["color"].tobytes()
    again, _ = case.Render(residency="resident")
    assert again["color"].tobytes() == layers["color"].tobytes()
    assert len(warnings) == 1


@pytest.mark.parametrize("noCache", [False, True])
def test_a_file_replaced_during_the_render_changes_nothing(Textured, tmp_path, noCache):
    """What was opened stays as it was, also lines that come later."""
    case = Textured.Copy(tmp_path)
    images = pathlib.Path(case.path).parent / "images"
    replaced = []

    def Replace(progress):
        if progress.samplesDone >= 1 and not replaced:
            replaced.append(True)
            for path in sorted(images.glob("photo*.png")):
                imageFile.WritePng(path, np.zeros((8, 8, 3), np.uint8))
        return True

    case.AssertStreamsTextures(Replace, textureMemory="24K", noCache=noCache, cacheDirectory=ColdCache(tmp_path / "cache"))
    assert replaced


def test_a_damaged_cache_is_mended_from_the_file(Textured, tmp_path):
    case = Textured.Copy(tmp_path)
    cache = ColdCache(tmp_path / "cache")
    case.AssertStreamsTextures(textureMemory="24K", cacheDirectory=cache)
    for path in sorted(pathlib.Path(cache).glob("pages-*.hdsp")):
        data = bytearray(path.read_bytes())
        data[len(data) // 2 :: 997] = bytes(len(data[len(data) // 2 :: 997]))
        path.write_bytes(data)
    case.Fresh().AssertStreamsTextures(textureMemory="24K", cacheDirectory=cache)
