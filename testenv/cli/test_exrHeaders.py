# SPDX-License-Identifier: Apache-2.0
"""What EXR files say beside their pixels: tiles, frame rates and time codes, matrices of the camera. Read by the bytes and, where it
is installed, by OpenImageIO's tool.
"""

import re
import shutil
import struct
import subprocess

import exrFile
import numpy as np
import pytest

from hdstream import _core

from cliCase import ANIMATED, RunHere, WriteStage

_PRODUCT = """    def RenderProduct "%s" {
        token productName = "%s.exr"
        rel orderedVars = [</Render/Color>, </Render/Id>]
        %s
    }
"""
_TILES = {
    "Lines": "",
    "Square": "custom int driver:parameters:OpenEXR:tileSize = 16",
    "Oblong": 'custom int2 driver:parameters:OpenEXR:tileSize = (32, 7)\n'
              'custom token driver:parameters:OpenEXR:compression = "piz"\n'
              'uniform float4 dataWindowNDC = (0.25, 0.25, 0.75, 1.25)',
    "Wrong": "custom int driver:parameters:OpenEXR:tileSize = 0",
}


def _Attributes(file):
    with open(file, "rb") as stream:
        data = stream.read()
    return exrFile.Attributes(data, 8)[0], struct.unpack_from("<i", data, 4)[0]


def _Info(file):
    if not shutil.which("oiiotool"):
        pytest.skip("openimageio-tools is not installed")
    return subprocess.run(["oiiotool", "--info", "-v", str(file)], capture_output=True, text=True, check=True).stdout


@pytest.fixture(name="tiled")
def RenderTiled(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = "".join(_PRODUCT % (name, name, text) for name, text in _TILES.items())
    rel = ", ".join(f"</Render/{name}>" for name in _TILES)
    text = ANIMATED + f"""def Scope "Render" {{
    def RenderSettings "Settings" {{
        rel products = [{rel}]
        uniform int2 resolution = (40, 30)
        custom int hdstream:samples = 2
        custom int hdstream:maxDepth = 1
    }}
    def RenderVar "Color" {{ string sourceName = "Ci" }}
    def RenderVar "Id" {{ string sourceName = "primId" }}
{body}}}
"""
    result = RunHere("record", WriteStage(tmp_path, text), "-rs", "/Render/Settings")
    assert result.code == 0, result.text
    return result


def test_products_choose_tiles_or_scan_lines(tiled):
    assert "/Render/Wrong: driver:parameters:OpenEXR:tileSize 0 is no size of 1 to 65536 pixels; scan lines are written" in tiled.text
    for name, size in (("Lines", None), ("Wrong", None), ("Square", (16, 16)), ("Oblong", (32, 7))):
        attributes, version = _Attributes(f"{name}.exr")
        assert bool(version & 0x200) == (size is not None) == ("tiles" in attributes)
        if size:
            assert attributes["tiles"][0] == "tiledesc" and struct.unpack("<IIB", attributes["tiles"][1]) == (*size, 0)
        assert "tileSize" not in attributes
    same = _core.CompareImages("Square.exr", "Lines.exr")
    assert not same.error and len(same.layers) == 2 and all(layer.maxAbs == 0 for layer in same.layers)


def test_a_foreign_reader_sees_the_tiles(tiled):
    assert tiled.code == 0
    assert re.search(r"tile size: 16 x 16", _Info("Square.exr"))
    assert "tile size" not in _Info("Lines.exr")
    oblong = _Info("Oblong.exr")
    assert re.search(r"tile size: 32 x 7", oblong) and re.search(r'compression: "piz"', oblong)
    assert re.search(r"origin: 10, -8|x=10, y=-8|pixel data origin: x=10, y=-8", oblong), oblong
    # Pixels of the part, cut out of the whole by that reader.
    subprocess.run(["oiiotool", "Oblong.exr", "--crop", "20x22+10+0", "-o", "a.exr"], check=True)
    subprocess.run(["oiiotool", "Lines.exr", "--crop", "20x22+10+0", "-o", "b.exr"], check=True)
    same = _core.CompareImages("a.exr", "b.exr")
    assert not same.error and all(layer.maxAbs == 0 for layer in same.layers)


@pytest.mark.parametrize("metadata, frame, rate, code", [
    ("framesPerSecond = 24\n timeCodesPerSecond = 24", (37 * 3600 + 25 * 60 + 42) * 24 + 17, (24, 1), "13:25:42:17"),
    ("framesPerSecond = 25\n timeCodesPerSecond = 50", 151, (25, 1), "00:00:03:00"),  # at time 151 its frame is 75
    ("framesPerSecond = 23.976\n timeCodesPerSecond = 23.976", 49, (24000, 1001), "00:00:02:01"),
    ("framesPerSecond = 29.97\n timeCodesPerSecond = 29.97", 30, (30000, 1001), "00:00:01:00"),
    ("framesPerSecond = 12.5\n timeCodesPerSecond = 12.5", 14, (25, 2), "00:00:01:01"),
    ("framesPerSecond = 60\n timeCodesPerSecond = 60", 61, (60, 1), None),  # has no SMPTE code of its own
    ("framesPerSecond = 24\n timeCodesPerSecond = 24", -1, (24, 1), None),
    ("framesPerSecond = 24\n timeCodesPerSecond = 24", None, (24, 1), None),
    ("", 5, None, None),
])
def test_frame_rates_and_time_codes(metadata, frame, rate, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stage = WriteStage(tmp_path, ANIMATED, header=f"(\n {metadata}\n)" if metadata else "")
    when = ["--defaultTime"] if frame is None else [f"--frames={frame}"]
    result = RunHere("record", stage, "a.exr", "-w", "8", "--samples", "1", "--maxDepth", "0", *when)
    assert result.code == 0, result.text
    attributes, _ = _Attributes("a.exr")
    if rate is None:
        assert "framesPerSecond" not in attributes and "timeCode" not in attributes
        return
    assert attributes["framesPerSecond"] == ("rational", struct.pack("<iI", *rate))
    assert ("timeCode" in attributes) == (code is not None)
    if code:
        digits = code.split(":")
        packed = sum(int(pair, 16) << 8 * at for at, pair in enumerate(reversed(digits)))
        assert attributes["timeCode"] == ("timecode", struct.pack("<II", packed, 0))
        information = _Info("a.exr")
        assert f"smpte:TimeCode: {code}" in information and f"framesPerSecond: {rate[0]}/{rate[1]}" in information


def test_matrices_take_points_to_where_they_are_seen(tmp_path, monkeypatch):
    """Positions of what pixels show, by the matrices as a foreign reader says them."""
    monkeypatch.chdir(tmp_path)
    text = ANIMATED.replace("double3 xformOp:translate = (0, 0, 8)\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]",
                            "float horizontalApertureOffset = 3\n    float verticalApertureOffset = -2\n"
                            "    double3 xformOp:rotateXYZ = (10, 20, 5)\n    double3 xformOp:translate = (2.5, -1, 7)\n"
                            "    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateXYZ\"]")
    assert text != ANIMATED
    result = RunHere("record", WriteStage(tmp_path, text), "a.exr", "-w", "40", "--samples", "1", "--maxDepth", "0", "--frames", "12",
                     "--aovs", "color,position,cameraDepth,depth")
    assert result.code == 0, result.text
    information = _Info("a.exr")
    world, ndc = (np.array([float(x) for x in re.search(rf"{name}: (.*)", information).group(1).split(",")]).reshape(4, 4)
                  for name in ("worldToCamera", "worldToNDC"))
    attributes, _ = _Attributes("a.exr")
    for name, matrix in (("worldToCamera", world), ("worldToNDC", ndc)):
        assert attributes[name][0] == "m44f"
        assert np.allclose(np.frombuffer(attributes[name][1], "<f4").reshape(4, 4), matrix, rtol=1e-4, atol=1e-5)
    _, channels = exrFile.Read("a.exr")
    height, width = channels["R"].shape
    rows, columns = np.nonzero(np.isfinite(channels["cameraDepth.Z"]))
    assert len(rows) > 50
    points = np.stack([channels[f"position.{axis}"][rows, columns] for axis in "XYZ"] + [np.ones(len(rows))], -1)
    assert np.allclose(-(points @ world)[:, 2], channels["cameraDepth.Z"][rows, columns], rtol=1e-4)
    projected = points @ ndc
    x, y, z = (projected[:, axis] / projected[:, 3] for axis in range(3))
    assert np.abs((0.5 + 0.5 * x) * width - columns - 0.5).max() < 0.02
    assert np.abs((0.5 - 0.5 * y) * height - rows - 0.5).max() < 0.02
    assert np.allclose(0.5 + 0.5 * z, channels["depth.Z"][rows, columns], atol=1e-4)
