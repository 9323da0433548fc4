# SPDX-License-Identifier: Apache-2.0
"""Large arrays of a stage that the core need not keep: it gets them with a way to read them again when it needs them.

Files of crate format are mapped by OpenUSD, and other layers are in its memory, so reading again is cheap. A file that was
deleted, or replaced by another of its name, stays mapped as it was; one that was written into is found out.
"""

import os
import threading
import weakref

from pxr import Sdf, Usd

from hdstream import _core

SMALLEST = 1 << 16  # bytes; smaller arrays are kept

_readers = weakref.WeakSet()  # of all stages
_readersLock = threading.Lock()  # one may come while another thread walks them


def IsKept(numBytes):
    """Whether an array of that size stays in memory as it is."""
    return numBytes < SMALLEST


def Again(attribute, timeCode, values, read):
    """`values`, read by `read(attribute)`, which keeps nothing of the stage; where they are large as an array that the core may
    read again."""
    if values is None or IsKept(values.nbytes):
        return values
    return _core.StageArray(attribute.GetPath().pathString, values, _Reader(attribute, timeCode, read))


def MoveToPart(stage):
    """Arrays of `stage` are read again from another stage, which is returned: of the same layers, of which the same are muted,
    with only the prims that have such arrays, and what is below these. What is not in it goes with the last user of `stage`.
    Call it while nothing is rendered."""
    with _readersLock:
        readers = [reader for reader in _readers if reader.IsOf(stage)]
    mask = Usd.StagePopulationMask([reader.PrimPath() for reader in readers])
    part = Usd.Stage.OpenMasked(stage.GetRootLayer(), stage.GetSessionLayer(), stage.GetPathResolverContext(), mask)
    if stage.GetMutedLayers():
        part.MuteAndUnmuteLayers(stage.GetMutedLayers(), [])
    if stage.GetLoadRules() != part.GetLoadRules():
        part.SetLoadRules(stage.GetLoadRules())
    part.SetInterpolationType(stage.GetInterpolationType())
    for reader in readers:
        reader.MoveTo(part)
    return part


class MappedLayers:
    """Layers that hold arrays which the core keeps as they are mapped. OpenUSD makes copies of those when it closes a file."""

    def __init__(self):
        self._identifiers = set()

    def AddOf(self, prim):
        """Those that say something of a prim."""
        self._identifiers.update(spec.layer.identifier for spec in prim.GetPrimStack())

    def Held(self):
        """The layers, which stay open as long as what is returned. Call it while the stage is there."""
        return [Sdf.Layer.FindOrOpen(identifier) for identifier in sorted(self._identifiers)]


class _Reader:
    """Reads an array again. Keeps the stage open."""

    __slots__ = ("_stage", "_attribute", "_read", "_files", "__weakref__")

    @property
    def files(self):
        return [path for path, _ in self._files]

    def __init__(self, attribute, timeCode, read):
        self._stage = attribute.GetStage()
        self._attribute = attribute
        self._read = read
        specs = attribute.GetPropertyStack(Usd.TimeCode(timeCode))
        paths = {spec.layer.realPath.split("[")[0] for spec in specs}  # of packages the package
        self._files = [(path, _IdentityOf(path)) for path in sorted(paths) if path]
        with _readersLock:
            _readers.add(self)

    def IsOf(self, stage):
        return self._stage == stage

    def PrimPath(self):
        return self._attribute.GetPrimPath()

    def MoveTo(self, stage):
        """Reads from the attribute of the same path there, if there is one."""
        attribute = stage.GetAttributeAtPath(self._attribute.GetPath())
        if attribute:
            self._stage, self._attribute = stage, attribute

    def __call__(self):
        if not self._attribute:
            raise RuntimeError("the stage has it no more")
        for path, identity in self._files:
            now = _IdentityOf(path)
            if now and identity and now[0] == identity[0] and now != identity:
                raise RuntimeError(f"{path} has been written into")
        values = self._read(self._attribute)
        if values is None:
            raise RuntimeError("it has no value")
        return values


def _IdentityOf(path):
    """(what the file is, size, time of the last change); None where there is no such file."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return (found.st_dev, found.st_ino), found.st_size, found.st_mtime_ns
