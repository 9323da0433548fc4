# SPDX-License-Identifier: Apache-2.0
"""A small OpenEXR writer and reader (scan lines; uncompressed, ZIPS, ZIP; half, float, uint), and a PNG writer.

Independent of hdStream's image code, so that tests read its pictures with other eyes. Source of the
format: "OpenEXR File Layout", openexr.com. Not handled: tiles, deep data, several parts, sub-sampling.
"""

import struct
import zlib

import numpy as np

_MAGIC = 20000630
_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_ROWS_PER_BLOCK = {0: 1, 2: 1, 3: 16}


def _Predict(raw: bytes) -> bytes:
    """The byte reordering and differencing that EXR's ZIP applies before deflate."""
    data = np.frombuffer(raw, np.uint8)
    data = np.concatenate([data[0::2], data[1::2]])
    delta = data.astype(np.int32)
    delta[1:] = (delta[1:] - delta[:-1] + 128) & 255
    return delta.astype(np.uint8).tobytes()


def _Unpredict(packed: bytes) -> bytes:
    delta = np.frombuffer(packed, np.uint8).astype(np.int64)
    delta[1:] -= 128
    data = (np.cumsum(delta) & 255).astype(np.uint8)
    half = (len(data) + 1) // 2
    out = np.empty_like(data)
    out[0::2], out[1::2] = data[:half], data[half:]
    return out.tobytes()


def WriteExr(path, channels: dict, half: bool = True, texts: dict | None = None) -> None:
    """Writes {name: [height][width]} as ZIP-compressed scan lines; half or float for all channels. `texts`: string
    attributes of the header."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    dtype = _TYPES[1 if half else 2]
    attribute = lambda name, kind, data: name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data
    channelList = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 1 if half else 2, 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", _MAGIC, 2) + b"".join([
        attribute("channels", "chlist", channelList), attribute("compression", "compression", b"\3"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
        *(attribute(key, "string", text.encode()) for key, text in (texts or {}).items())]) + b"\0"
    planes = np.stack([np.asarray(channels[n]).astype(dtype) for n in names], 1)  # [height][channel][width]
    blocks = []
    for row in range(0, height, 16):
        raw = planes[row : row + 16].tobytes()
        packed = zlib.compress(_Predict(raw), 9)
        data = packed if len(packed) < len(raw) else raw
        blocks.append(struct.pack("<ii", row, len(data)) + data)
    offset = len(header) + 8 * len(blocks)
    with open(path, "wb") as stream:
        stream.write(header)
        for block in blocks:
            stream.write(struct.pack("<Q", offset))
            offset += len(block)
        stream.write(b"".join(blocks))


def WritePng(path, pixels: np.ndarray, level: int = 9, gamma: float | None = None, texts: dict | None = None) -> None:
    """Writes [height][width][1 to 4] of uint8 or uint16: gray, gray and alpha, RGB, RGBA. `level` of
    deflate: 0 stores. `gamma`: of encoding, 1 or 1 / 2.2. `texts`: by keyword. Source: PNG specification, W3C 2003
    (ISO/IEC 15948)."""
    height, width, channels = pixels.shape
    bits = 8 * pixels.dtype.itemsize
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(height, -1)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    colorType = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    with open(path, "wb") as stream:
        stream.write(b"\x89PNG\r\n\x1a\n")
        stream.write(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, colorType, 0, 0, 0)))
        if gamma is not None:
            stream.write(chunk(b"gAMA", struct.pack(">I", round(gamma * 100000))))
        for key, text in (texts or {}).items():
            stream.write(chunk(b"tEXt", key.encode() + b"\0" + text.encode()))
        stream.write(chunk(b"IDAT", zlib.compress(raw, level)) + chunk(b"IEND", b""))


def _ReadHeader(data: bytes) -> tuple[dict, int]:
    if struct.unpack_from("<i", data)[0] != _MAGIC:
        raise ValueError("not an OpenEXR file")
    position, attributes = 8, {}
    while data[position] != 0:
        nameEnd = data.index(b"\0", position)
        kindEnd = data.index(b"\0", nameEnd + 1)
        size = struct.unpack_from("<i", data, kindEnd + 1)[0]
        attributes[data[position:nameEnd].decode()] = data[kindEnd + 5 : kindEnd + 5 + size]
        position = kindEnd + 5 + size
    return attributes, position + 1


def ReadExr(path) -> dict:
    """Reads every channel: {name: [height][width] float32 (uint32 for uint channels)}."""
    data = open(path, "rb").read()
    attributes, position = _ReadHeader(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    listing, at, channels = attributes["channels"], 0, []
    while listing[at] != 0:
        end = listing.index(b"\0", at)
        channels.append((listing[at:end].decode(), _TYPES[struct.unpack_from("<i", listing, end + 1)[0]]))
        at = end + 17
    compression = attributes["compression"][0]
    if compression not in _ROWS_PER_BLOCK:
        raise ValueError(f"EXR compression {compression} is not handled")
    rows = _ROWS_PER_BLOCK[compression]
    numBlocks = (height + rows - 1) // rows
    out = {name: np.empty((height, width), kind) for name, kind in channels}
    rowBytes = width * sum(kind.itemsize for _, kind in channels)
    for offset in struct.unpack_from(f"<{numBlocks}Q", data, position):
        y, size = struct.unpack_from("<ii", data, offset)
        block, numRows = data[offset + 8 : offset + 8 + size], min(rows, height - (y - y0))
        if compression and size < numRows * rowBytes:
            block = _Unpredict(zlib.decompress(block))
        at = 0
        for row in range(y - y0, y - y0 + numRows):
            for name, kind in channels:
                out[name][row] = np.frombuffer(block, kind, width, at)
                at += width * kind.itemsize
    return {name: plane.astype(np.float32) if plane.dtype != np.dtype("<u4") else plane for name, plane in out.items()}
