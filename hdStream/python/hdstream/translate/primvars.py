# SPDX-License-Identifier: Apache-2.0
"""Primvars of a prim, its own and the constant ones it inherits.

The rules are UsdGeomPrimvarsAPI's (FindPrimvarsWithInheritance): constant primvars with a value are
inherited along namespace, an own primvar of the same name wins, and a non-constant one on an
ancestor ends the inheritance of its name.
"""

import numpy as np
from pxr import Tf, Vt

from hdstream import _core
from hdstream.translate import valueClips
from hdstream.translate.colorSpaces import ColorSpaceOfColor
from hdstream.translate.rereading import Again
from hdstream.translate.usdCalls import GetAttribute, GetMetadata, GetValue

PREFIX = "primvars:"
_INDICES = ":indices"
_FLOAT_ROWS = frozenset((Vt.Vec2fArray, Vt.Vec3fArray, Vt.Vec4fArray))
_KARMA_VISIBILITY = PREFIX + _core.KARMA_VISIBILITY  # a text
# Read by systems that the renderer does not have; large and of no use to it.
_SKIPPED = ("primvars:skel:",)
# USD's: "instance" is Hydra's alone.
INTERPOLATIONS = {text: value for text, value in _core.InterpolationByText.items() if text != "instance"}


class InheritedPrimvar:
    """A constant primvar and a key that is equal for equal values."""

    __slots__ = ("primvar", "key")

    def __init__(self, primvar, key):
        self.primvar = primvar
        self.key = key


def FloatRows(value, attribute):
    """A value as a float32 array [count] or [count][2..4]; None when it is no such tuple.

    Arrays that hold floats already are passed on without a copy.
    """
    if type(value) in _FLOAT_ROWS:  # the usual case
        return np.asarray(value) if value else None
    if value is None or isinstance(value, str):
        return None
    if isinstance(value, (bool, int, float)):
        return np.array([value], np.float32)
    try:
        rows = np.asarray(value)
    except (TypeError, ValueError):
        return None
    if rows.dtype.kind not in "fiub" or rows.size == 0:
        return None
    if type(value).__module__ != "pxr.Vt":  # a single Gf value; matrices are no tuples
        if rows.ndim != 1:
            return None
        rows = rows.reshape(1, -1)
    elif rows.ndim == 1:
        elementSize = attribute.GetMetadata("elementSize") or 1
        if elementSize > 1 and rows.size % elementSize == 0:
            rows = rows.reshape(-1, elementSize)
    if rows.ndim > 2 or (rows.ndim == 2 and rows.shape[1] > 4):
        return None
    return np.ascontiguousarray(rows, np.float32)


def _PrimvarsAmong(names):
    return [name for name in names if name.startswith(PREFIX) and not name.endswith(_INDICES) and not name.startswith(_SKIPPED)]


def ReadPrimvar(prim, name, names, timeCode):
    """The primvar of attribute `name`, or None when it has no value of a usable type."""
    attribute = GetAttribute(prim, name)
    if not attribute:
        return None
    value = GetValue(attribute, timeCode)
    if name == _KARMA_VISIBILITY and isinstance(value, str):
        value = _core.KarmaVisibilityNumber(value)
    rows = FloatRows(value, attribute)
    interpolation = _InterpolationOf(attribute, "constant")
    if rows is None or interpolation is None:
        return None
    # Constant ones are looked at in many places, and a prim of which one is read again stays with all that inherits it.
    isKept = interpolation == _core.Interpolation.Constant
    indices = None
    if name + _INDICES in names:
        indices = _Indices(GetAttribute(prim, name + _INDICES), timeCode, isKept)
    space = ColorSpaceOfColor(attribute, prim) if rows.ndim == 2 and rows.shape[1] >= 3 else ""
    if not isKept:
        rows = _RowsAgain(attribute, timeCode, rows)
    return _core.Primvar(name[len(PREFIX):], interpolation, rows, indices, space)


def _InterpolationOf(attribute, fallback):
    """The interpolation of an attribute; None, and a warning, for one that USD does not have."""
    text = GetMetadata(attribute, "interpolation") or fallback
    interpolation = INTERPOLATIONS.get(text)
    if interpolation is None:
        Tf.Warn(f"In <{attribute.GetPrim().GetPath()}>: {attribute.GetName()} has the unknown interpolation {text}; left out")
    return interpolation


def _RowsAgain(attribute, timeCode, rows):
    """What FloatRows gave, in a form that the core may read again where it is large."""
    return Again(attribute, timeCode, rows, lambda own: FloatRows(own.Get(timeCode), own))


def _Indices(attribute, timeCode, isKept):
    """Indices as they are, or in such a form too."""
    indices = GetValue(attribute, timeCode)
    if isKept or not isinstance(indices, Vt.IntArray):
        return indices
    return Again(attribute, timeCode, np.asarray(indices), lambda own: np.asarray(own.Get(timeCode)))


def InheritFrom(prim, names, inherited, timeCode):
    """The primvars that children of `prim` inherit; `inherited` itself when nothing changes."""
    result = inherited
    for name in _PrimvarsAmong(names):
        primvar = ReadPrimvar(prim, name, names, timeCode)
        if primvar is None:
            continue
        if result is inherited:
            result = dict(inherited)
        if primvar.interpolation == _core.Interpolation.Constant:
            key = (primvar.name, primvar.values.tobytes(), primvar.indices.tobytes(), primvar.colorSpace)
            result[primvar.name] = InheritedPrimvar(primvar, key)
        else:
            result.pop(primvar.name, None)
    return result


def InheritableAbove(prim, timeCode, endsByPath):
    """The primvars that `prim` inherits from its namespace ancestors, for a traversal from it; endsByPath: names
    that are not inherited from ancestors of a path and the prim there."""
    ancestors = []
    parent = prim.GetParent()
    while parent and not parent.IsPseudoRoot():
        ancestors.append(parent)
        parent = parent.GetParent()
    inherited = {}
    hasClips = False
    for ancestor in reversed(ancestors):
        hasClips = hasClips or valueClips.AreOn(ancestor)
        inherited = InheritFrom(ancestor, valueClips.NamesOf(ancestor, hasClips), inherited, timeCode)
        ended = endsByPath.get(ancestor.GetPath())
        if ended:
            inherited = {name: entry for name, entry in inherited.items() if name not in ended}
    return inherited


def PrimvarsOf(prim, names, inherited, timeCode):
    """All primvars of a gprim, its own first, with `normals` as the primvar of that name."""
    primvars = []
    own = set()
    for name in _PrimvarsAmong(names):
        primvar = ReadPrimvar(prim, name, names, timeCode)
        if primvar is not None:
            own.add(name[len(PREFIX):])
            primvars.append(primvar)
    # UsdGeomPointBased: primvars:normals has precedence over the attribute.
    if "normals" in names and "normals" not in own:
        normals = _ReadNormals(prim, timeCode)
        if normals is not None:
            own.add("normals")
            primvars.append(normals)
    primvars.extend(entry.primvar for name, entry in inherited.items() if name not in own)
    return primvars


def _ReadNormals(prim, timeCode):
    attribute = GetAttribute(prim, "normals")
    value = GetValue(attribute, timeCode)
    if not isinstance(value, Vt.Vec3fArray):
        return None  # as UsdImaging: UsdGeomPointBased has normal3f[] normals
    rows = FloatRows(value, attribute)
    interpolation = _InterpolationOf(attribute, "vertex")
    if rows is None or interpolation is None:
        return None
    return _core.Primvar("normals", interpolation, _RowsAgain(attribute, timeCode, rows))
