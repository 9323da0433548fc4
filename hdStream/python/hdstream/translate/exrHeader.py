# SPDX-License-Identifier: Apache-2.0
"""Matrices in the headers of OpenEXR files; pixels are the core's. Format: openexr.com, "OpenEXR File Layout"."""

import struct

from pxr import Gf

_MAGIC = b"\x76\x2f\x31\x01"
_NAME_BYTES = 256  # the longest name of an attribute or a type, with its end
_MATRICES = {"m44f": "<16f", "m44d": "<16d"}


def ReadMatrices(asset):
    """{name: Gf.Matrix4d} of a file's first part; empty for what is no OpenEXR file or is cut off.

    `asset` is an AssetReference, so that files in packages count too.
    """
    try:
        with open(asset.file, "rb") as stream:
            stream.seek(asset.offset)
            return _ReadMatrices(stream) if stream.read(8)[:4] == _MAGIC else {}
    except (OSError, struct.error, ValueError):
        return {}


def _ReadMatrices(stream):
    matrices = {}
    while True:
        name = _ReadName(stream)
        if not name:
            return matrices
        kind = _ReadName(stream)
        size, = struct.unpack("<i", stream.read(4))
        layout = _MATRICES.get(kind)
        if layout:
            matrices[name] = Gf.Matrix4d(*struct.unpack(layout, stream.read(size)))
        elif size < 0:
            raise ValueError(f"attribute {name} of {size} bytes")
        else:
            stream.seek(size, 1)


def _ReadName(stream):
    start = stream.tell()
    name, end, _ = stream.read(_NAME_BYTES).partition(b"\0")
    if not end:
        raise ValueError("a name without an end")
    stream.seek(start + len(name) + 1)
    return name.decode("latin-1")
