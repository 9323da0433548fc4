# SPDX-License-Identifier: Apache-2.0
"""Sums of films packed to travel and to be kept: words that all pixels share are stored once.

Of finished blocks of 16 samples that leaves 6 of the 12 words of a pixel.
"""

import io
import os
import tempfile

import numpy as np

from hdstream import _core
from hdstream.errors import CommandError

_VERSION = 1


def Pack(sums):
    """A dict of plain values and arrays; equal sums give equal dicts."""
    words = np.ascontiguousarray(sums.words)
    planes = {}
    for index in range(words.shape[2]):
        plane = words[:, :, index]
        isShared = plane.size > 0 and (plane == plane.flat[0]).all()
        planes[f"word{index}"] = np.array(plane[:1, :1] if isShared else plane)
    mattes = {} if sums.mattes is None else {"mattes": np.array(sums.mattes)}
    lightPaths = {"lightPaths": np.array(sums.lightPaths), **_PackLightPaths(sums.lightPathWords)} if sums.lightPaths else {}
    return {"shape": (sums.width, sums.height, sums.firstSample, sums.endSample, words.shape[0], words.shape[2]),
            **planes, **mattes, **lightPaths}


def _PackLightPaths(words):
    """Of all expressions: the words of pixels by their place in them."""
    planes = {"lightPathShape": np.array(words.shape)}
    for index in range(words.shape[3]):
        plane = words[..., index]
        isShared = plane.size > 0 and (plane == plane.flat[0]).all()
        planes[f"lightPathWord{index}"] = np.array(plane[:1, :1, :1] if isShared else plane)
    return planes


def Unpack(packed):
    """The inverse of Pack."""
    width, height, firstSample, endSample, rows, numWords = (int(value) for value in packed["shape"])
    words = np.empty((rows, width, numWords), np.uint32)
    for index in range(numWords):
        words[:, :, index] = packed[f"word{index}"]
    mattes = np.ascontiguousarray(packed["mattes"], np.uint32) if "mattes" in packed else None
    sums = _core.FilmSums(width, height, firstSample, endSample, words, mattes)
    if "lightPaths" in packed:
        lightPathWords = np.empty(packed["lightPathShape"], np.uint32)
        for index in range(lightPathWords.shape[3]):
            lightPathWords[..., index] = packed[f"lightPathWord{index}"]
        sums.SetLightPaths([str(name) for name in packed["lightPaths"]], lightPathWords)
    return sums


def BlackSums(width, height, sample, numWords=12):
    """A film that begins at a sample, a multiple of _core.SAMPLE_BLOCK."""
    return _core.FilmSums(width, height, sample, sample, np.zeros((0, width, numWords), np.uint32))


def FileOf(output):
    """Where the sums of an image lie."""
    return f"{output}.sums"


def Save(file, sums, key, device):
    """Writes a sidecar, whole or not at all. The format is numpy's .npz, not compressed: noise hardly gets smaller."""
    stream = io.BytesIO()
    np.savez(stream, version=_VERSION, key=key, device=device, **Pack(sums))
    folder = os.path.dirname(file) or "."
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{os.path.basename(file)}.", dir=folder)
        try:
            with os.fdopen(handle, "wb") as target:
                target.write(stream.getbuffer())
                target.flush()
                os.fsync(target.fileno())
            os.chmod(temporary, 0o666 & ~_Umask())
            os.replace(temporary, file)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise CommandError(f"{file}: {error.strerror}") from None


def Load(file, key):
    """(sums, device name) of a sidecar with that key; (None, "") when there is none that is of use."""
    try:
        with np.load(file, allow_pickle=False) as data:
            if int(data["version"]) != _VERSION or str(data["key"]) != key:
                return None, ""
            return Unpack(data), str(data["device"])
    except Exception:  # pylint: disable=broad-except
        return None, ""  # missing, of another version, or damaged, for which numpy and zipfile raise anything


def _Umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
