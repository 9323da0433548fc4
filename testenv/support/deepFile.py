# SPDX-License-Identifier: Apache-2.0
"""Deep OpenEXR files read with numpy and zlib alone, for tests that must not trust the library that wrote them, and laid over
each other.

Of the format ("OpenEXR File Layout", "Interpreting OpenEXR Deep Pixels", openexr.com) what hdStream writes: one part of deep scan
lines, each compressed for itself or not at all.
"""

import struct
from collections import namedtuple

import numpy as np

import exrFile

_ROW_HEADER = struct.Struct("<iQQQ")  # y, bytes of the packed counts, of the packed samples, of the samples

# counts [height][width]; channels by name, pixel by pixel from front to back; texts of the header
Deep = namedtuple("Deep", "counts channels texts")


def Read(file):
    """A Deep of a file."""
    with open(file, "rb") as stream:
        data = stream.read()
    magic, version = struct.unpack_from("<ii", data)
    assert magic == 20000630 and version & 0x800 and version & 0x1200 == 0, "not one part of deep data"
    attributes, offset = exrFile.Attributes(data, 8)
    assert attributes["type"][1] == b"deepscanline" and attributes["compression"][1][0] in (0, 2)
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = right - left + 1, bottom - top + 1
    kinds = exrFile.Channels(attributes["channels"][1])
    counts = np.zeros((height, width), np.int64)
    parts = {name: [None] * height for name, _ in kinds}
    for start in struct.unpack_from(f"<{height}Q", data, offset):
        row, countBytes, packedBytes, bytesOfRow = _ROW_HEADER.unpack_from(data, start)
        start += _ROW_HEADER.size
        ends = np.frombuffer(exrFile.Unpack(data[start:start + countBytes], 4 * width), "<u4").astype(np.int64)
        counts[row - top] = np.diff(ends, prepend=0)
        raw = exrFile.Unpack(data[start + countBytes:start + countBytes + packedBytes], bytesOfRow)
        at = 0
        for name, kind in kinds:
            parts[name][row - top] = np.frombuffer(raw, kind, ends[-1], at)
            at += kind.itemsize * int(ends[-1])
        assert at == bytesOfRow
    texts = {name: value.decode("utf-8") for name, (kind, value) in attributes.items() if kind == "string"}
    return Deep(counts, {name: np.concatenate(rows) for name, rows in parts.items()}, texts)


def Starts(counts):
    """Where the samples of each pixel begin, and the end of all."""
    return np.concatenate([[0], np.cumsum(counts.ravel())]).astype(int)


def Flatten(counts, colors):
    """Samples [n][4], R, G, B, A, laid over each other: [height][width][4]."""
    starts = Starts(counts)
    flat = np.zeros((counts.size, 4))
    for depth in range(int(counts.max(initial=0))):
        has = counts.ravel() > depth
        flat[has] += (1.0 - flat[has, 3:]) * colors[starts[:-1][has] + depth]
    return flat.reshape(*counts.shape, 4)
