# SPDX-License-Identifier: Apache-2.0
"""Matrices and texts in the headers of OpenEXR files; pixels are the core's. Format: openexr.com, "OpenEXR File Layout"."""

import os
import struct

from pxr import Gf

_MAGIC = b"\x76\x2f\x31\x01"
_NAME_BYTES = 256  # the longest name of an attribute or a type, with its end
_MATRICES = {"m44f": "<16f", "m44d": "<16d"}


def ReadMatrices(asset):
    """{name: Gf.Matrix4d} of a file's first part; empty for what is no OpenEXR file or is cut off.

    `asset` is an AssetReference, so that files in packages count too.
    """
    def Convert(kind, data):
        return Gf.Matrix4d(*struct.unpack(_MATRICES[kind], data))

    return _ReadHeader(asset.file, asset.offset, _MATRICES, Convert)


def ReadTexts(file):
    """{name: text} of a file's first part; empty for what is no OpenEXR file or is cut off."""
    return _ReadHeader(file, 0, ("string",), lambda _, data: data.decode("utf-8", "replace"))


def _ReadHeader(file, offset, kinds, convert):
    if not os.path.isfile(file):  # of a pipe a reader waits for the writer
        return {}
    try:
        with open(file, "rb") as stream:
            stream.seek(offset)
            return _ReadAttributes(stream, kinds, convert) if stream.read(8)[:4] == _MAGIC else {}
    except (OSError, struct.error, ValueError):
        return {}


def _ReadAttributes(stream, kinds, convert):
    values = {}
    while True:
        name = _ReadName(stream)
        if not name:
            return values
        kind = _ReadName(stream)
        size, = struct.unpack("<i", stream.read(4))
        if size < 0:
            raise ValueError(f"attribute {name} of {size} bytes")
        if kind in kinds:
            values[name] = convert(kind, stream.read(size))
        else:
            stream.seek(size, 1)


def _ReadName(stream):
    start = stream.tell()
    name, end, _ = stream.read(_NAME_BYTES).partition(b"\0")
    if not end:
        raise ValueError("a name without an end")
    stream.seek(start + len(name) + 1)
    return name.decode("latin-1")
