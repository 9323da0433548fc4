# SPDX-License-Identifier: Apache-2.0
"""One small picture as files of many formats: by hdStream's writer, by the tests' own, and by OpenImageIO's tool where it is
installed."""

import pathlib
import shutil
import struct
import subprocess

import numpy as np

from stages import imageFile

# Arguments of oiiotool's output by file name.
_BY_TOOL = {
    "rgb.jpg": [], "gray.jpg": ["--ch", "R"], "rgb.tga": ["--compression", "rle"], "rgb8.tif": ["-d", "uint8"],
    "tiled.tif": ["-d", "uint16", "--tile", "16", "16", "--compression", "lzw"], "float.tif": ["-d", "float", "--compression", "zip"],
    "rle.hdr": [], "piz.exr": ["-d", "half", "--compression", "piz"], "b44.exr": ["-d", "half", "--compression", "b44"],
    "pxr24.exr": ["-d", "float", "--compression", "pxr24"], "dwaa.exr": ["-d", "half", "--compression", "dwaa"],
    "rle.exr": ["-d", "half", "--compression", "rle"], "tiled.exr": ["-d", "half", "--tile", "16", "16"], "rgb.png": ["-d", "uint16"],
    "rgb.bmp": [], "rgb.dpx": [], "rgb.gif": [], "rgb.sgi": [], "rgb.ppm": [], "rgb.rla": [],
    "rgb.webp": [],
}


def _Picture():
    y, x = np.mgrid[0:24, 0:37].astype(np.float32)
    return np.stack([x / 37, y / 24, 0.5 + 0.5 * np.sin(x * y), 0.5 + 0.5 * np.cos(x)], -1)


def _WriteTga(path, pixels) -> None:
    """True colour, not compressed, from the top."""
    height, width, _ = pixels.shape
    header = struct.pack("<3B5x4H2B", 0, 0, 2, 0, 0, width, height, 24, 0x20)
    path.write_bytes(header + pixels[..., 2::-1].tobytes())


def _RunTool(folder, names, arguments=()) -> None:
    """Its 260 libraries take longer to load than pictures to write."""
    outputs = [word for name in names for word in ("-o", str(folder / name))]
    subprocess.run(["oiiotool", str(folder / "half.exr"), "--ch", "R,G,B", *arguments, *outputs], capture_output=True, check=False)


def WriteFormats(folder) -> list:
    """The files, in a fixed order."""
    from hdstream import _core

    folder = pathlib.Path(folder)
    folder.mkdir(exist_ok=True)
    pixels = _Picture()
    eight = (pixels * 255 + 0.5).astype(np.uint8)
    imageFile.WritePng(folder / "own.png", eight[..., :3])
    imageFile.WritePng(folder / "alpha.png", (pixels * 65535).astype(np.uint16))
    imageFile.WriteExr(folder / "half.exr", {c: pixels[..., k] for k, c in enumerate("RGBA")})
    imageFile.WriteExr(folder / "float.exr", {"Y": pixels[..., 2]}, half=False)
    _WriteTga(folder / "own.tga", eight)
    layer = _core.ImageLayer("color", list("RGBA"), pixels)
    for name in ("ours.exr", "ours.png", "ours.jpg", "ours.tif", "ours.hdr"):
        _core.WriteImage(str(folder / name), [layer])
    if shutil.which("oiiotool"):
        _RunTool(folder, [name for name, arguments in _BY_TOOL.items() if not arguments])
        for name, arguments in _BY_TOOL.items():
            if not (folder / name).exists():  # a tool without one format writes none of those after it
                _RunTool(folder, [name], arguments)
    return sorted(path for path in folder.iterdir() if path.stat().st_size > 0)
