# SPDX-License-Identifier: Apache-2.0
"""Arrays of instances: of a group of native instances, and of a point instancer."""

import numpy as np
from pxr import Gf, UsdGeom, Vt

from hdstream import _core
from hdstream.translate import valueClips


class InstanceGroup:
    """Native instances that share an instancer, in the order of their paths as UsdImaging has them."""

    def __init__(self, firstPrim, state):
        self.firstPrim = firstPrim
        self.passByInstance = frozenset()  # as of Context
        self.state = state      # of the first instance, for what its prototype inherits
        # (Sdf.Path, Gf.Matrix4d: context space from instance, is drawn, matrices as State's, inherited primvars)
        self._instances = []
        self._isSorted = False

    def Add(self, prim, state):
        self._instances.append((prim.GetPath(), state.matrix, state.visible, state.matrices, state.primvars))

    def Split(self, keyOf):
        """A group for each key of the instances; keyOf: of the prim of an instance."""
        stage = self.firstPrim.GetStage()
        groups = {}
        for instance in self._instances:
            prim = stage.GetPrimAtPath(instance[0])
            group = groups.setdefault(keyOf(prim), InstanceGroup(prim, self.state))
            group.passByInstance = self.passByInstance
            group._instances.append(instance)
        return list(groups.values())

    def _Sorted(self):
        if not self._isSorted:
            self._instances.sort(key=lambda instance: instance[0])
            self._isSorted = True
        return self._instances

    def Transforms(self):
        return np.asarray(Vt.Matrix4dArray([matrix for _, matrix, _, _, _ in self._Sorted()]))

    def Samples(self, motion):
        """(time, arrays) while the shutter is open; empty when no instance moves."""
        instances = self._Sorted()
        if all(matrices is None for _, _, _, matrices, _ in instances):
            return []
        return motion.InstanceSamplesOf([matrices or [matrix] * len(motion.times)
                                         for _, matrix, _, matrices, _ in instances])

    def VisibleIndices(self):
        return np.array([index for index, (_, _, isVisible, _, _) in enumerate(self._Sorted()) if isVisible],
                        np.int32)


    def FirstPrimvars(self):
        """Inherited primvars of the first instance."""
        return self._Sorted()[0][4]

    def DifferentPrimvars(self):
        """Inherited primvars that differ between the instances: name -> float32 [numInstances][components]."""
        instances = self._Sorted()
        first = instances[0][4]
        if all(inherited is first for _, _, _, _, inherited in instances):
            return {}
        rowsByName = {}
        for name, entry in first.items():
            if _IsRow(entry.primvar) and any(inherited[name].key != entry.key for _, _, _, _, inherited in instances):
                rowsByName[name] = np.concatenate([_RowOf(inherited[name].primvar) for _, _, _, _, inherited in instances])
        return rowsByName


def _IsRow(primvar):
    """Whether an inherited primvar may differ between instances that share an instancer."""
    return (not _core.IsReadByPrim(primvar.name) and not primvar.colorSpace
            and (primvar.indices.size == 1 or len(_RowsOf(primvar)) == 1 and not primvar.indices.size))


def _RowsOf(primvar):
    return primvar.values.reshape(-1, primvar.numComponents)


def _RowOf(primvar):
    """The one value of a primvar, [1][components]; 0 where its index is wrong."""
    rows = _RowsOf(primvar)
    index = int(primvar.indices[0]) if primvar.indices.size else 0
    return rows[index:index + 1] if 0 <= index < len(rows) else np.zeros((1, primvar.numComponents), np.float32)


def RelativeTo(root, path):
    """A path that is the same for all instances of a prototype where it lies inside of it: `root` is the instance's."""
    return "." + path[len(root):] if path.startswith(root + "/") else path


def BindingsKey(state, root):
    """Equal for instances, at `root`, that inherit equal bindings of materials."""
    return tuple(sorted((purpose, RelativeTo(root, path), strength) for purpose, (path, strength) in state.bindings.items()))


def InheritedKey(state, root, boundPaths, isFlat):
    """Equal for instances, at `root`, whose prototypes look the same but for primvars of one value; `boundPaths` when
    collections bind. Who sees them may differ where their prototype is flat."""
    primvars = tuple(sorted(
        (entry.primvar.name, entry.primvar.numComponents)
        if _IsRow(entry.primvar) and (isFlat or not _core.SaysRayVisibility(entry.primvar.name)) else entry.key
        for entry in state.primvars.values()))
    bindings = boundPaths or BindingsKey(state, root)
    skelBindings = tuple(sorted((name, tuple(RelativeTo(root, path) for path in paths))
                                for name, paths in state.skelBindings.items()))
    return state.purpose, state.isPurposeAuthored, primvars, bindings, skelBindings


def _OrientationsAttr(instancer):
    """Those in single precision win, where this version of USD has them."""
    if hasattr(instancer, "GetOrientationsfAttr") and instancer.GetOrientationsfAttr().HasAuthoredValue():
        return instancer.GetOrientationsfAttr()
    return instancer.GetOrientationsAttr()


def _HasVelocities(instancer):
    moving = (instancer.GetVelocitiesAttr(), instancer.GetAccelerationsAttr(), instancer.GetAngularVelocitiesAttr())
    return any(attribute.HasAuthoredValue() for attribute in moving)


def _AtRest(index, positions, orientations, scales):
    """The matrix of an instance without velocities, with the arithmetic of UsdGeom."""
    matrix = Gf.Matrix4d(1.0)
    if index < len(scales):
        matrix.SetScale(Gf.Vec3d(scales[index]))
    if index < len(orientations):
        matrix *= Gf.Matrix4d(1.0).SetRotate(Gf.Quatd(orientations[index]))
    return np.asarray(matrix.SetTranslateOnly(Gf.Vec3d(positions[index])))


def InstancesWhereFinite(instancer, matrices, timeCode):
    """(what velocities make of instances, whether some stand still): those that they take, or turn, nowhere finite do."""
    matrices = np.asarray(matrices)
    if not _HasVelocities(instancer):
        return matrices, False
    broken = np.flatnonzero(~np.isfinite(matrices).all(axis=(1, 2)))
    if not len(broken):
        return matrices, False
    parts = [attribute.Get(timeCode) or () for attribute in (
        instancer.GetPositionsAttr(), _OrientationsAttr(instancer), instancer.GetScalesAttr())]
    matrices, isStanding = matrices.copy(), False
    for index in broken.tolist():
        rest = _AtRest(index, *parts)
        for rows in (slice(0, 3), slice(3, 4)):  # the turn, the way
            if not np.isfinite(matrices[index, rows]).all() and np.isfinite(rest[rows]).all():
                matrices[index, rows], isStanding = rest[rows], True
    return matrices, isStanding


def _IsAtRest(instancer):
    """Whether the instances' arrays are the same at all times, so that the core may compose them itself."""
    arrays = (instancer.GetPositionsAttr(), _OrientationsAttr(instancer), instancer.GetScalesAttr())
    return (not _HasVelocities(instancer)
            and not any(valueClips.Varies(attribute) for attribute in arrays))


def _Rows(attribute, timeCode):
    """The values of an attribute, shared with the stage where it can be; None when there are none."""
    values = attribute.Get(timeCode)
    return np.asarray(values) if values else None


class PointInstances:
    """Arrays of a UsdGeomPointInstancer at a time. transforms: matrices, or the core's tuple of parts."""

    def __init__(self, prim, timeCode):
        instancer = UsdGeom.PointInstancer(prim)
        self.prototypePaths = instancer.GetPrototypesRel().GetForwardedTargets()
        self.problem = ""
        indices = instancer.GetProtoIndicesAttr().Get(timeCode)
        positions = instancer.GetPositionsAttr().Get(timeCode)
        self.numInstances = len(indices) if indices is not None else 0
        self.transforms = None
        if not self.numInstances:
            return
        if positions is None or len(positions) != self.numInstances:
            self.problem = (f"{self.numInstances} protoIndices but "
                            f"{len(positions) if positions is not None else 0} positions")
            return
        # The prototype's own transform is part of what it contains.
        self.isAtRest = _IsAtRest(instancer)
        if self.isAtRest:
            parts = (np.asarray(positions), *(_Rows(attribute, timeCode) for attribute in (
                _OrientationsAttr(instancer), instancer.GetScalesAttr())))
            self.transforms = parts
            matches = all(part is None or len(part) == self.numInstances for part in parts)
        else:
            self.transforms = np.asarray(instancer.ComputeInstanceTransformsAtTime(
                timeCode, timeCode, UsdGeom.PointInstancer.ExcludeProtoXform,
                UsdGeom.PointInstancer.IgnoreMask))
            matches = len(self.transforms) == self.numInstances
        if not matches:
            self.problem = "orientations, scales or velocities do not match its positions"
            return
        if not self.isAtRest:
            self.transforms, _ = InstancesWhereFinite(instancer, self.transforms, timeCode)
        self._indices = np.asarray(indices)
        mask = np.array(instancer.ComputeMaskAtTime(timeCode), bool)
        self.numMasked = len(mask)  # one an id; 0: none is hidden
        self._mask = None
        if self.numMasked:  # instances without an id cannot be hidden by it
            self._mask = np.ones(self.numInstances, bool)
            self._mask[:self.numMasked] = mask[:self.numInstances]
        outside = (self._indices < 0) | (self._indices >= len(self.prototypePaths))
        self.numOutside = int(np.count_nonzero(outside))
        # Instances by prototype: one stable sort, however many prototypes there are.
        self._order = np.argsort(self._indices, kind="stable").astype(np.int32)
        self._bounds = np.searchsorted(self._indices[self._order],
                                       np.arange(len(self.prototypePaths) + 1))

    def InstancesOf(self, prototypeIndex):
        """Indices (int32, ascending) of the drawn instances of a prototype."""
        order = self._order[self._bounds[prototypeIndex]:self._bounds[prototypeIndex + 1]]
        return order if self._mask is None else np.ascontiguousarray(order[self._mask[order]])
