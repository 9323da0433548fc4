# SPDX-License-Identifier: Apache-2.0
"""OpenEXR files read with numpy and zlib alone, for tests that must not trust the library that wrote them.

Of the format ("OpenEXR File Layout", openexr.com) what hdStream writes: one part, scan lines, ZIP compression.
"""

import struct
import zlib

import numpy as np

_MAGIC = 20000630
_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_ZIP, _ZIP_LINES = 3, 16


def Read(file):
    """(header, channels): texts by name, and arrays [height][width] by name."""
    data, attributes, offset = _Open(file)
    texts = {name: value.decode("utf-8") for name, (kind, value) in attributes.items() if kind == "string"}
    assert attributes["compression"][1][0] == _ZIP
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"][1])
    channels = Channels(attributes["channels"][1])
    width, height = right - left + 1, bottom - top + 1
    rowBytes = width * sum(kind.itemsize for _, kind in channels)
    images = {name: np.empty((height, width), kind) for name, kind in channels}
    numBlocks = (height + _ZIP_LINES - 1) // _ZIP_LINES
    for start in struct.unpack_from(f"<{numBlocks}Q", data, offset):
        row, size = struct.unpack_from("<ii", data, start)
        first, last = row - top, min(row - top + _ZIP_LINES, height)
        raw = Unpack(data[start + 8:start + 8 + size], rowBytes * (last - first))
        at = 0
        for y in range(first, last):
            for name, kind in channels:
                images[name][y] = np.frombuffer(raw, kind, width, at)
                at += kind.itemsize * width
    return texts, images


def Compression(file):
    """The number of the compression: 0 none, 1 RLE, 2 ZIPS, 3 ZIP, 4 PIZ, 5 PXR24, 6 B44, 7 B44A, 8 DWAA, 9 DWAB; and the texts."""
    _, attributes, _ = _Open(file)
    return attributes["compression"][1][0], {name: value.decode("utf-8") for name, (kind, value) in attributes.items()
                                             if kind == "string"}


def Windows(file):
    """(data window, display window) as (left, top, right, bottom), all inclusive."""
    _, attributes, _ = _Open(file)
    return tuple(struct.unpack("<4i", attributes[name][1]) for name in ("dataWindow", "displayWindow"))


def _Open(file):
    with open(file, "rb") as stream:
        data = stream.read()
    magic, version = struct.unpack_from("<ii", data)
    assert magic == _MAGIC and version & 0x1a00 == 0, "not one part of scan lines"  # long names may be there
    return (data, *Attributes(data, 8))


def Attributes(data, offset):
    attributes = {}
    while data[offset]:
        name, offset = _Text(data, offset)
        kind, offset = _Text(data, offset)
        size, = struct.unpack_from("<i", data, offset)
        attributes[name] = kind, data[offset + 4:offset + 4 + size]
        offset += 4 + size
    return attributes, offset + 1


def Channels(data):
    channels, offset = [], 0
    while data[offset]:
        name, offset = _Text(data, offset)
        channels.append((name, _TYPES[struct.unpack_from("<i", data, offset)[0]]))
        offset += 16
    return channels


def _Text(data, offset):
    end = data.index(0, offset)
    return data[offset:end].decode("utf-8"), end + 1


def Unpack(packed, size):
    """A block as it was: differences of neighbours are added up, and the two halves take turns."""
    if len(packed) == size:
        return packed
    deltas = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    deltas[1:] -= 128
    halves = np.cumsum(deltas).astype(np.uint8)
    raw = np.empty(size, np.uint8)
    raw[0::2] = halves[:(size + 1) // 2]
    raw[1::2] = halves[(size + 1) // 2:]
    return raw.tobytes()
