# SPDX-License-Identifier: Apache-2.0
"""Runs a wrapped stage through both front ends, usdrecord with the plug-in and `hdstream record`, and
compares their scenes (dumps) and pictures. Used by the tests and by testenv/bench/hydraScenes.py.
"""

import collections
import contextlib
import functools
import io
import os
import pathlib
import re
import sys
from dataclasses import dataclass, field

import numpy as np

from dumpStage import DumpStage
from openUsd import OpenUsd, Result, RunProgram
from stages.imageFile import ReadExr
from wrapperStage import Wrapper

HERE = pathlib.Path(__file__).resolve().parent
# UsdImagingGLEngine adds a camera of its own, used or not.
_HOST_PRIMS = "camera /_UsdImaging_"
PICTURE = "picture"  # the difference of pictures that are not equal to the bit
MODES = ("legacy", "sceneIndex")  # how UsdImagingGLEngine hands a stage over


@dataclass
class FrontEnds:
    """The two programs. plugin: the plug-in's resources; None for a renderer of OpenUSD's own."""

    openUsd: OpenUsd
    plugin: pathlib.Path | None
    renderer: str = "Stream"
    mode: str = "legacy"
    windowed: list = field(default_factory=list)  # words that give a program a screen: uses the GPU path

    def RunUsdrecord(self, wrapper: Wrapper, picture, dump=None, seconds=600, **environment) -> Result:
        """Renders with usdrecord. dump: the plug-in writes its scene there."""
        if self.mode == "sceneIndex":
            environment["USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX"] = "1"
        if dump:
            environment["HDSTREAM_DUMP_SCENE"] = str(dump)
        command = [*self.windowed, *self.openUsd.Program("usdrecord"), "--renderer", self.renderer,
                   *wrapper.UsdrecordOptions(usesGpu=bool(self.windowed)), wrapper.path, picture]
        return RunProgram(command, self.openUsd.Environment(self.plugin, **environment), seconds)

    @staticmethod
    def RunRecord(wrapper: Wrapper, picture, seconds=600, options=()) -> Result:
        command = [sys.executable, "-m", "hdstream", "record", wrapper.path, picture, *wrapper.RecordOptions(), *options]
        return RunProgram(command, _OwnEnvironment(), seconds)

    @staticmethod
    def RecordHere(wrapper: Wrapper, picture) -> Result:
        """As RunRecord, in this process, which has loaded its modules."""
        from hdstream.cli import Main

        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            code = Main(["record", str(wrapper.path), str(picture), *wrapper.RecordOptions()])
        return Result(code, output.getvalue())

    @staticmethod
    def RunDump(wrapper: Wrapper, dump, seconds=600) -> Result:
        """Writes usd-core's scene dump, and its warnings to DUMP.warnings."""
        return RunProgram([sys.executable, HERE / "dumpStage.py", wrapper.path, dump], _OwnEnvironment(), seconds)


def _OwnEnvironment() -> dict:
    """Child processes find the hdstream that this one found."""
    return dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path), PYTHONFAULTHANDLER="1")


# --- Pictures --------------------------------------------------------------------------------------


def ReadColor(path) -> np.ndarray:
    """[height][width][RGBA] of an EXR file, with its own bits."""
    channels = ReadExr(path)
    return np.stack([channels[name] for name in "RGBA"], -1)


@dataclass
class Difference:
    """How two pictures differ."""

    numPixels: int
    numUnlike: int  # pixels with any other bits
    maxAbs: float
    problem: str = ""  # sizes that differ; a channel that is not finite on one side

    @property
    def isEqual(self) -> bool:
        return self.numUnlike == 0 and not self.problem

    def __str__(self):
        return self.problem or f"{self.numUnlike} of {self.numPixels} pixels unlike, max abs {self.maxAbs:.3g}"


def ComparePictures(first, second) -> Difference:
    a, b = ReadColor(first), ReadColor(second)
    if a.shape != b.shape:
        return Difference(0, 0, 0.0, f"{a.shape[1]}x{a.shape[0]} against {b.shape[1]}x{b.shape[0]} pixels")
    unlike = (a.view(np.uint32) != b.view(np.uint32)).any(-1)
    with np.errstate(invalid="ignore"):
        maxAbs = float(np.nanmax(np.abs(a - b), initial=0.0))
    return Difference(unlike.size, int(unlike.sum()), maxAbs)


# --- Both ------------------------------------------------------------------------------------------


def CompareFrontEnds(frontEnds: FrontEnds, wrapper: Wrapper, folder: pathlib.Path, hasDump=True) -> tuple[list[str], str]:
    """Runs both, `hdstream record` in this process. Pictures are FOLDER/record.exr and FOLDER/hydra.exr.

    Returns all differences: lines of ListDifferences, and PICTURE; and what both programs said. hasDump: the renderer
    writes its scene.
    """
    ours, theirs, dump = folder / "record.exr", folder / "hydra.exr", folder / "hydra.txt"
    record = frontEnds.RecordHere(wrapper, ours)
    assert record.code == 0, record.output
    hydra = frontEnds.RunUsdrecord(wrapper, theirs, dump if hasDump else None)
    assert hydra.code == 0, hydra.output
    differences = []
    if hasDump:
        differences = ListDifferences(DumpStage(wrapper.path)[0], dump.read_text(), wrapper.purposes)
    if not ComparePictures(ours, theirs).isEqual:
        differences.append(PICTURE)
    return differences, record.output + hydra.output


@functools.cache
def _KnownDifferences() -> dict[tuple, list]:
    """(version of OpenUSD, mode, case) -> lines, from differences.txt."""
    known = collections.defaultdict(list)
    for line in (HERE / "differences.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            stage, _, difference = line.partition(": ")
            version, mode, case = stage.split()
            known[int(version), mode, case].append(difference)
    return known


def CheckDifferences(found: list[str], version: int, mode: str, case: str) -> None:
    """Asserts that these are the differences that are known with this OpenUSD, or with the last listed one before it.

    "*" stands for what was not listed one by one: as a path for all prims of a kind, alone for all of the scene, as
    "picture: *" for a picture that may be equal.
    """
    known = _KnownDifferences()
    listed = max(listed for listed, *_ in known if listed <= version)
    expected = known.get((listed, mode, case), [])

    def Relaxed(line):
        kind = f"{line.partition(': ')[0]}: *"
        return kind if kind in expected else "*" if "*" in expected and line != PICTURE else line

    found = [Relaxed(line) for line in found]
    found = [line for index, line in enumerate(found) if not line.endswith("*") or line not in found[:index]]
    assert sorted(found) == sorted(line for line in expected if line != f"{PICTURE}: *" or line in found)


# --- Scenes ----------------------------------------------------------------------------------------


def ParseDump(text: str) -> dict:
    """{"mesh /Path": {"points": "..."}}; parameters of material nodes belong to their node's line."""
    prims, prim, outer = {}, None, ""
    for line in text.splitlines():
        if not line.startswith(" "):
            prim = prims.setdefault(line, {})
            continue
        name, _, value = line.lstrip().partition(": ")
        if not line.startswith("    "):
            outer = name
        else:
            name = f"{outer} {name}"
        prim[name] = value
    return prims


# What differs between two runs in OpenUSD's names: numbers of prototypes, hashes of what instances have in common.
_UNSTABLE = re.compile(r"(?<=/__Prototype_)\d+|[0-9a-f]{12,16}(?=[_/])")
_PROTOTYPE = re.compile(r"/__Prototype_\d+(?=/)")
# Legacy mode's name of the cards that stand in for a native instance (draw modes): the instance's is meant.
_STAND_IN = re.compile(r"(?<=\{)(/[^{}]*)/proto___Prototype_\d+_id\d+(?=\})")


def _PrototypePrefixes(record: dict, hydra: dict) -> dict[str, str]:
    """Prototype of native instances -> path of the instance whose prims `hdstream record` names.

    UsdImaging's legacy mode calls the materials inside native instances by their prototype, which is no prim
    of the stage (`/__Prototype_1/Looks/wood`), the meshes by an instance. What binds them tells which is which;
    a prototype that would need two names gets none.
    """
    prefixes = {}
    for name in record.keys() & hydra.keys():
        for key, path in hydra[name].items():
            found = _PROTOTYPE.search(path)  # a subset's material comes after its faces
            own = record[name].get(key, "")
            if found and own.startswith(path[:found.start()]) and own.endswith(path[found.end():]):
                prefix = own[found.start():len(own) - len(path) + found.end()]
                if prefixes.setdefault(found[0], prefix) != prefix:
                    prefixes[found[0]] = found[0]
    return {prototype: prefix for prototype, prefix in prefixes.items() if prefix != prototype}


def CompareDumps(record: str, hydra: str, purposes=("render", "proxy", "guide")) -> list[str]:
    """Readable differences, the same kind of difference of many prims as one line; empty: equal.

    purposes: those drawn. Hydra never shows a renderer the others' meshes, `hdstream record` reads all.
    """
    found = FindDifferences(record, hydra, purposes)
    return [f"{kind}, {len(examples)}: {min(examples.values())}" if examples else kind
            for kind, examples in sorted(found.items())]


def ListDifferences(record: str, hydra: str, purposes=("render", "proxy", "guide")) -> list[str]:
    """Every difference as "KIND: PATH", sorted; a prim whose lines of one kind differ more than once is there so often."""
    found = FindDifferences(record, hydra, purposes)
    lines = (f"{kind}: {path}" if path else kind for kind, examples in found.items() for path, _ in examples or [("", "")])
    return sorted(_UNSTABLE.sub("N", line) for line in lines)


def FindDifferences(record: str, hydra: str, purposes) -> dict[str, dict]:
    """Kind of difference -> {(path of the prim, name of the line) -> readable difference}; empty: equal."""
    if record == hydra:
        return {}
    hydra = _STAND_IN.sub(r"\1", hydra)
    first, second = ParseDump(record), ParseDump(hydra)
    prefixes = _PrototypePrefixes(first, second)
    if prefixes:
        hydra = _PROTOTYPE.sub(lambda found: prefixes.get(found[0], found[0]), hydra)
        second = ParseDump(hydra)
        first, second = (dict(sorted(scene.items())) for scene in (first, second))
    first = {name: prim for name, prim in first.items()
             if name in second or prim.get("purpose", "default") in ("default", *purposes)}
    second = {name: prim for name, prim in second.items() if not name.startswith(_HOST_PRIMS)}
    if list(first.items()) == list(second.items()):
        return {}
    found = collections.defaultdict(dict)
    for names, place in ((first.keys() - second.keys(), "hdstream record"), (second.keys() - first.keys(), "Hydra")):
        for name in names:
            kind, path = name.split(" ", 1)
            found[f"{kind} only in {place}"][path, ""] = path
    for name in first.keys() & second.keys():
        kind, path = name.split(" ", 1)
        for key in first[name].keys() | second[name].keys():
            values = first[name].get(key, "(none)"), second[name].get(key, "(none)")
            if values[0] != values[1]:
                found[f"{kind}.{_KeyKind(key)}"][path, key] = f"{path} {key}: {_Clip(values[0])} != {_Clip(values[1])}"
    return found or {"the order of lines differs": {}}


def _KeyKind(key: str) -> str:
    """A line's name without what differs from prim to prim: node and subset paths."""
    words = key.split()
    if words[0] in ("node", "subset"):
        return " ".join([words[0], *words[2:]])
    return key


def _Clip(text: str, length: int = 120) -> str:
    return text if len(text) <= length else text[:length] + "..."
