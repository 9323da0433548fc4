# SPDX-License-Identifier: Apache-2.0
"""`--resume`: which frames are there already, judged by what they were made of and never by dates of files.

The key of a frame is a hash of the translated scene, of the bytes of the images, profiles and volumes it reads, of the
settings that decide its bits, of the colour configuration, and of the program's version and kernels. It is in the sidecar
with the frame's sums. Hashed together with what decides the bits of a file alone it says that the file is finished: in the
header of an .exr, and beside a file of another format, with a hash of that file's bytes.
"""

import glob
import hashlib
import json
import os

from pxr import Ar

from hdstream import _core
from hdstream.textFile import WriteText
from hdstream.translate.exrHeader import ReadTexts

KEY_NAME = "hdStream:key"
SAMPLES_NAME = "hdStream:samplesDone"
_PIECE = 1 << 20
_MISSING = "missing"  # for a hash


class AssetHashes:
    """Hashes of files' bytes; a file is read once."""

    def __init__(self):
        self._hashes = {}

    def Of(self, file):
        if file not in self._hashes:
            self._hashes[file] = "".join(_HashOf(part) for part in _PartsOf(file))
        return self._hashes[file]


def _PartsOf(file):
    """The tiles of a UDIM, or the package that they are in; else the file itself."""
    if "<UDIM>" not in file:
        return [file]
    if Ar.IsPackageRelativePath(file):
        return [Ar.SplitPackageRelativePathOuter(file)[0]]
    before, _, after = file.partition("<UDIM>")
    return sorted(glob.glob(f"{glob.escape(before)}[0-9][0-9][0-9][0-9]{glob.escape(after)}"))


def _HashOf(file):
    if not os.path.isfile(file):  # pipes and devices need have no end
        return _MISSING
    digest = hashlib.blake2b(digest_size=16)
    try:
        with open(file, "rb") as stream:
            while piece := stream.read(_PIECE):
                digest.update(piece)
    except OSError:
        return _MISSING
    return digest.hexdigest()


def _WithoutBits():
    """Names of the settings without influence on the bits of a picture: where and how it is computed, and how long."""
    groups = (_core.SettingGroup.Memory, _core.SettingGroup.Machine)
    return {"samples", *(info.name for info in _core.SettingTable() if info.group in groups)}


def ColorsOf(assetHashes):
    """What says which colour configuration is in force: by contents, wherever its files are."""
    try:
        files, words = _core.FindColorConfigSources()
    except _core.Error:  # a scene without named spaces needs none
        return f"unreadable {os.environ.get('OCIO', '')}"
    return json.dumps([words, [assetHashes.Of(file) for file in files]])


def KeyOf(renderer, assetHashes):
    """The key of the frame that is prepared."""
    withoutBits = _WithoutBits()
    values = {name: value for name, value in renderer.settings.items() if name not in withoutBits}
    digest = hashlib.blake2b(digest_size=16)
    for text in (_core.VERSION, _core.KernelSourceHash(), ColorsOf(assetHashes), renderer.SceneText(),
                 json.dumps(values, sort_keys=True)):
        digest.update(text.encode() + b"\0")
    for file in renderer.AssetFiles():
        digest.update(f"{file}\0{assetHashes.Of(file)}\0".encode())
    return digest.hexdigest()


def SamplesInFile(file, key):
    """Samples that the .exr of that key was asked for; 0: it has another key, or is none."""
    texts = ReadTexts(file)
    if texts.get(KEY_NAME) == key:
        try:
            return int(texts.get(SAMPLES_NAME, "0"))
        except ValueError:
            return 0
    return 0


def TextsOf(key, samples):
    """What the header of a finished frame says."""
    return {KEY_NAME: key, SAMPLES_NAME: str(samples)}


def DoneFileOf(file):
    """Where it is said of a file that has no header for it that it is finished."""
    return f"{file}.done"


def SayDone(file, key, samples):
    """Of a file that has just been written. What a process that dies leaves of it says nothing."""
    WriteText("--resume", DoneFileOf(file), json.dumps({"key": key, "samples": samples, "bytes": _HashOf(file)}) + "\n")


def SamplesSaid(file, key):
    """Samples that the file of that key was asked for; 0: nothing is said of it, or it is not what was written."""
    try:
        with open(DoneFileOf(file), encoding="utf-8") as stream:
            said = json.load(stream)
        if said["key"] == key and said["bytes"] == _HashOf(file) != _MISSING:
            return int(said["samples"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return 0
