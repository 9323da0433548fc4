# SPDX-License-Identifier: Apache-2.0
"""Primvars per instance, of point instancers and of native instances that inherit different values.

The core has them as primvars of its instancers. What it reads once a prim (visibility, widths, normals)
it cannot have by instance: a gprim whose instances differ there is added once for each combination of
values, with constant primvars, as hdStream/hydra/instancePrimvars.cpp and geometryVariants.cpp do.
"""

import numpy as np

from hdstream import _core
from hdstream.translate import primvars

MAX_GROUPS = 64  # each is planned as a prim of its own
# UsdGeomPointInstancer: these have an element an instance, constant and uniform ones have a single one.
_INSTANCE_RATE = (_core.Interpolation.Varying, _core.Interpolation.Vertex, _core.Interpolation.FaceVarying)
_NOT_READ = ("primvars:points", "primvars:velocities", "primvars:angularVelocities", "primvars:accelerations",
             "primvars:nonlinearSampleCount", "primvars:blurScale")


class InstanceLevel:
    """What an instancer knows of its instances."""

    def __init__(self, parent, placements, rowsByName=None):
        self.parent = parent          # scene path of the instancer above; empty: none
        self.placements = placements  # int32: instances of the parent that place the instancer
        self.rowsByName = rowsByName or {}  # float32 [numInstances][components]


def ReadInstancePrimvars(prim, names, numInstances, timeCode, warn):
    """Primvars of a point instancer that have a value an instance: name -> rows."""
    rowsByName = {}
    for name in names:
        if (not name.startswith(primvars.PREFIX) or name.endswith(":indices")
                or name.startswith("primvars:skel:") or name in _NOT_READ):
            continue
        primvar = primvars.ReadPrimvar(prim, name, names, timeCode)
        if primvar is None or primvar.interpolation not in _INSTANCE_RATE:
            continue
        rows = primvar.values.reshape(-1, primvar.numComponents)
        if primvar.indices.size:
            if primvar.indices.min() < 0 or primvar.indices.max() >= len(rows):
                warn(prim, f"primvar {primvar.name} has indices out of range; ignored")
                continue
            rows = rows[primvar.indices]
        if primvar.colorSpace:
            warn(prim, f"primvar {primvar.name}: the colour space of values by instance is not supported; they are taken as "
                       "they are")
        if len(rows) == numInstances:
            rowsByName[primvar.name] = np.ascontiguousarray(rows)
        else:
            warn(prim, f"primvar {primvar.name} has {len(rows)} values for {numInstances} instances; ignored")
    return rowsByName


_FEW = 16


def AreEqual(rows):
    """Whether all rows have the same bits."""
    bits = np.ascontiguousarray(rows).view(np.uint32)
    return not len(bits) or bool((bits[:_FEW] == bits[0]).all() and (bits == bits[0]).all())


def _AreEqualAt(rows, indices):
    """The same of some rows; mostly a few tell."""
    return AreEqual(rows[indices[:_FEW]]) and AreEqual(rows[indices])


class InstanceGroups:
    """The instances of a gprim by the bits of those values that the core reads once a prim, in the order
    of first instances.

    groups: (constant primvars, int32 instances) each. The instances of other groups are -1: a rank in
    the list is what instanceId counts. Constant are also those primvars whose values are equal for all
    instances. All others are left to the core, which has them by instance.
    """

    def __init__(self, levels, instances, ownNames):
        self.hasTooMany = False
        self.variesAbove = False
        taken = set(ownNames)
        shared = []
        splitting = {}
        for depth, level in enumerate(levels):
            placements = levels[depth - 1].placements if depth else instances
            for name, rows in level.rowsByName.items():
                if name in taken or not len(placements):
                    continue
                taken.add(name)
                first = _Constant(name, rows[placements[0]])
                if _AreEqualAt(rows, placements):
                    shared.append(first)
                elif _core.IsReadByPrim(name):
                    if depth == 0:
                        splitting[name] = rows
                    else:
                        shared.append(first)
                        self.variesAbove = True
        self.groups = [(shared, instances)]
        if splitting:
            self._Split(splitting, shared, instances)

    def _Split(self, splitting, shared, instances):
        bits = np.ascontiguousarray(np.concatenate([rows[instances] for rows in splitting.values()], 1)).view(np.uint32)
        _, firsts, groupByRank = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        if len(firsts) > MAX_GROUPS:
            self.hasTooMany = True
            return
        self.groups = []
        for group in np.argsort(firsts):
            constants = [_Constant(name, rows[instances[firsts[group]]]) for name, rows in splitting.items()]
            members = np.where(groupByRank.reshape(-1) == group, instances, np.int32(-1)).astype(np.int32)
            self.groups.append((constants + shared, members))


def _Constant(name, row):
    return _core.Primvar(name, _core.Interpolation.Constant, np.array(row, np.float32).reshape(1, -1))


class InstanceLevels:
    """All instancers of a translation; adds what their prims have as constant primvars."""

    def __init__(self, translator, session):
        self._translator = translator
        self._session = session
        self._levelByPath = {}
        self._hasValues = False

    def Add(self, path, level):
        self._levelByPath[path] = level
        self._hasValues |= bool(level.rowsByName)

    def PrimvarsOf(self, path):
        """What the core is told of an instancer: primvars that differ between its instances."""
        return [_core.Primvar(name, _core.Interpolation.Instance, rows)
                for name, rows in self._levelByPath[path].rowsByName.items()
                if not _core.IsReadByPrim(name) and not AreEqual(rows)]

    def Split(self, path, prim, geometryPrim):
        """(path, GeometryPrim) for each group of instances of a gprim that have equal values."""
        where = geometryPrim.placement
        levels = self._LevelsOf(where.instancerPath) if self._hasValues else []
        if not any(level.rowsByName for level in levels) or not len(where.instances):
            return [(path, geometryPrim)]
        own = {primvar.name for primvar in geometryPrim.geometry.primvars}
        split = InstanceGroups(levels, where.instances, own)
        if split.hasTooMany:
            self._session.Warn(where.instancerPath, "more than 64 different values by instance of primvars that are "
                                                    "read once a prim are not supported")
        if split.variesAbove:
            self._session.Warn(path, "primvars that are read once a prim differ between instances of an outer "
                                     "instancer; those of the first are used")
        result = []
        for index, (constants, instances) in enumerate(split.groups):
            name = self._translator.ReservePath(prim, _FixedPath(f"{path}{{{index}}}")) if index else path
            result.append((name, geometryPrim.WithConstants(constants, instances) if constants else geometryPrim))
        return result

    def _LevelsOf(self, instancerPath):
        """The levels of an instancer and those above, the innermost first."""
        levels = []
        while instancerPath:
            level = self._levelByPath[instancerPath]
            levels.append(level)
            instancerPath = level.parent
        return levels


class _FixedPath:
    """A context of one path."""

    def __init__(self, path):
        self._path = self.instancerPath = path

    def ScenePath(self, prim):
        return self._path
