# SPDX-License-Identifier: Apache-2.0
"""Assets as (file, offset, size), resolved while translating so that the core needs no resolver.

Files inside a usdz package (a zip whose entries are stored, never compressed) are byte ranges of
the package; packages nest.
"""

import os
import struct
import zipfile

from hdstream import _core

_LOCAL_HEADER_BYTES = 30  # fixed part of a zip local file header (PKZIP APPNOTE 4.3.7)


class _Slice:
    """A byte range of a file as a read-only file object, for zipfile on a nested package."""

    def __init__(self, stream, offset, size):
        self._stream, self._offset, self._size, self._position = stream, offset, size, 0

    def seekable(self):
        return True

    def tell(self):
        return self._position

    def seek(self, offset, whence=os.SEEK_SET):
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}[whence]
        self._position = base + offset
        return self._position

    def read(self, count=-1):
        left = max(0, self._size - self._position)
        count = left if count is None or count < 0 else min(count, left)
        self._stream.seek(self._offset + self._position)
        data = self._stream.read(count)
        self._position += len(data)
        return data


def FindInPackage(package, innerPath):
    """(offset, size) of an entry of a usdz file; `innerPath` may be nested: "a.usdz[b.png]".

    Raises OSError when the package or the entry cannot be read.
    """
    try:
        with open(package, "rb") as stream:
            offset, size = 0, os.path.getsize(package)
            while innerPath:
                name, _, rest = innerPath.partition("[")
                innerPath = rest[:-1]
                offset, size = _FindEntry(stream, offset, size, name)
    except (zipfile.BadZipFile, KeyError, struct.error) as error:
        raise OSError(f"{innerPath or package}: not found in the package") from error
    return offset, size


def _FindEntry(stream, offset, size, name):
    with zipfile.ZipFile(_Slice(stream, offset, size)) as package:
        entry = package.getinfo(name)
    if entry.compress_type != zipfile.ZIP_STORED:
        raise zipfile.BadZipFile("compressed entry")
    # The lengths in the local header count: its extra field holds the alignment padding.
    stream.seek(offset + entry.header_offset)
    header = stream.read(_LOCAL_HEADER_BYTES)
    nameBytes, extraBytes = struct.unpack_from("<HH", header, 26)
    start = offset + entry.header_offset + _LOCAL_HEADER_BYTES + nameBytes + extraBytes
    return start, entry.file_size


class AssetResolver:
    """Turns Sdf.AssetPath values into AssetReferences; packages are read once an entry."""

    def __init__(self):
        self._entries = {}

    def Resolve(self, attribute, assetPath):
        """The reference of an attribute's asset value; its `file` is empty when it is not found."""
        authored = assetPath.path
        resolved = assetPath.resolvedPath
        if not resolved and "<UDIM>" in authored:
            resolved = _ResolveUdim(attribute, authored)
        if resolved.endswith("]"):
            return self._InPackage(authored, resolved)
        return _core.AssetReference(authored, resolved)

    def _InPackage(self, authored, resolved):
        package, _, inner = resolved.partition("[")
        inner = inner[:-1]
        if resolved not in self._entries:
            try:
                self._entries[resolved] = FindInPackage(package, inner)
            except OSError:
                self._entries[resolved] = None
        entry = self._entries[resolved]
        if entry is None:
            return _core.AssetReference(authored)
        return _core.AssetReference(authored, package, entry[0], entry[1])


def _ResolveUdim(attribute, authored):
    from pxr import UsdShade
    for spec in attribute.GetPropertyStack():
        pattern = UsdShade.UdimUtils.ResolveUdimPath(authored, spec.layer)
        if pattern:
            return pattern
    return ""
