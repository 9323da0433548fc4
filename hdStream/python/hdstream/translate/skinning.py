# SPDX-License-Identifier: Apache-2.0
"""Points of skinned meshes, curves and points at a time code: blend shapes, then joints, by UsdSkel itself.

The order of steps and the spaces are UsdSkelImaging's, so that Hydra's points are the same but for
rounding. One prim's points are held at a time. Explained in docs/materials.md, "Skinning".
"""

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

from hdstream.translate import valueClips

_PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
_JOINT_ANIMATION = ("translations", "rotations", "scales")
# What prims that are to be skinned have of their own.
_INFLUENCES = frozenset(("primvars:skel:jointIndices", "skel:blendShapes"))


def ReasonAtRest(prim, names):
    """Why a prim that has joint influences or blend shapes is not skinned, to be counted; None for prims without, where the
    arrays are empty too."""
    if _INFLUENCES.isdisjoint(names):
        return None
    if not any(prim.GetAttribute(name).Get(Usd.TimeCode.EarliestTime()) for name in _INFLUENCES.intersection(names)):
        return None
    if not UsdSkel.Root.Find(prim):
        reason = "is below no SkelRoot"
    elif not prim.HasAPI(UsdSkel.BindingAPI):
        reason = "has no SkelBindingAPI"
    else:
        reason = "has no skeleton that they fit"
    return f"has joint influences or blend shapes but {reason}; drawn at rest: {{count}}"


class Skins:
    """Skinning of a stage at a frame, and while the shutter of a Motion is open around it. `xforms`: UsdGeom.XformCache of the
    frame."""

    def __init__(self, timeCode, xforms, motion, warn):
        self._motion = motion
        self._warn = warn
        self._atFrame = _Skinning(timeCode, xforms, warn)
        self._byTime = {}  # while the shutter is open

    def Of(self, prim, rootPrim, motion):
        """The Skin of a prim that moves by a Motion, below a SkelRoot (None: there is none above it); None when nothing skins
        it."""
        if rootPrim is None or not self._atFrame.IsSkinned(prim, rootPrim):
            return None
        return Skin(self, prim, rootPrim, motion)

    def AreBelow(self, prim, rootPrim):
        """Whether something below a prim is skinned by a skeleton of a SkelRoot above (None: there is none). Where an instance
        is does not move what is skinned in it."""
        return rootPrim is not None and self._atFrame.IsAboveSkinned(prim, rootPrim)

    def AtFrame(self):
        return self._atFrame

    def At(self, time):
        """Skinning at an offset in frames from the frame."""
        if time not in self._byTime:
            timeCode = self._motion.At(time)
            self._byTime[time] = _Skinning(timeCode, UsdGeom.XformCache(timeCode), self._warn)
        return self._byTime[time]


class Skin:
    """What skins one prim."""

    def __init__(self, skins, prim, rootPrim, motion):
        self._skins = skins
        self._prim = prim
        self._rootPrim = rootPrim
        self._motion = motion

    def PointsOf(self, points):
        """Points at rest [count][3] where the skeleton carries them at the frame."""
        return np.asarray(self._skins.AtFrame().PointsOf(self._prim, points, self._rootPrim))

    def SamplesOf(self, points):
        """(time, points) while the shutter is open; empty when they stay."""
        if not self._motion.isOn:
            return []
        times = self._skins.AtFrame().TimesOf(self._prim, self._rootPrim, self._motion)
        return self._motion.SkinnedSamplesOf(
            times, [self._skins.At(time).PointsOf(self._prim, points, self._rootPrim) for time in times], len(points))


class _Skinning:
    """Skins the prims of a stage at one time code. `xforms`: UsdGeom.XformCache of that time."""

    def __init__(self, timeCode, xforms, warn):
        self._timeCode = timeCode
        self._xforms = xforms
        self._warn = warn
        self._cache = UsdSkel.Cache()
        self._targets = {}  # path of a SkelRoot -> {path of a prim: (skeleton, skinning query)}
        self._pathsAbove = {}  # path of a SkelRoot -> paths of these prims and of all above them

    def IsSkinned(self, prim, rootPrim):
        return self._TargetOf(prim, rootPrim) is not None

    def IsAboveSkinned(self, prim, rootPrim):
        path = rootPrim.GetPath()
        if path not in self._pathsAbove:
            self._pathsAbove[path] = {above for target in self._TargetsOf(rootPrim) for above in target.GetPrefixes()}
        return prim.GetPath() in self._pathsAbove[path]

    def PointsOf(self, prim, points, rootPrim):
        """The skinned points [count][3] of a prim below a SkelRoot that IsSkinned."""
        skeleton, query = self._TargetOf(prim, rootPrim)
        skelQuery = self._cache.GetSkelQuery(skeleton)
        skinned = Vt.Vec3fArray.FromNumpy(np.array(points, np.float32))
        if query.HasBlendShapes():
            skinned = self._ApplyBlendShapes(prim, query, skelQuery, skinned)
        if query.HasJointInfluences():
            skinned = self._ApplyJoints(prim, skeleton, query, skelQuery, skinned)
        return skinned

    def TimesOf(self, prim, rootPrim, motion):
        """When a prim is to be skinned while the shutter is open: at its ends and where its animation has samples, and where
        joints or skeletons move, which may turn, as often as transforms are sampled."""
        skeleton, query = self._TargetOf(prim, rootPrim)
        animation = self._cache.GetSkelQuery(skeleton).GetAnimQuery()
        animationPrim = animation.GetPrim() if animation else prim
        times = motion.TimesOf(animationPrim, (*_JOINT_ANIMATION, "blendShapeWeights"))
        if query.HasJointInfluences() and (_VariesAny(animationPrim, _JOINT_ANIMATION) or
                                           any(_MovesBelow(rootPrim, one) for one in (skeleton.GetPrim(), prim))):
            times = sorted({*times, *motion.times})
        return times

    def _TargetOf(self, prim, rootPrim):
        """(skeleton, skinning query) of a prim; None when nothing skins it."""
        return self._TargetsOf(rootPrim).get(prim.GetPath())

    def _TargetsOf(self, rootPrim):
        path = rootPrim.GetPath()
        if path not in self._targets:
            self._targets[path] = self._FindTargets(UsdSkel.Root(rootPrim))
        return self._targets[path]

    def _FindTargets(self, root):
        self._cache.Populate(root, _PREDICATE)
        targets = {}
        for binding in self._cache.ComputeSkelBindings(root, _PREDICATE):
            for query in binding.GetSkinningTargets():
                if query.HasBlendShapes() or query.HasJointInfluences():
                    targets[query.GetPrim().GetPath()] = (binding.GetSkeleton(), query)
        return targets

    def _ApplyBlendShapes(self, prim, query, skelQuery, points):
        animation = skelQuery.GetAnimQuery()
        weights = animation.ComputeBlendShapeWeights(self._timeCode) if animation else None
        mapper = query.GetBlendShapeMapper()
        if not weights or mapper is None:
            return points
        shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        subWeights, shapeIndices, subIndices = shapes.ComputeSubShapeWeights(mapper.Remap(weights))
        if not shapes.ComputeDeformedPoints(subWeights, shapeIndices, subIndices,
                                            shapes.ComputeBlendShapePointIndices(),
                                            shapes.ComputeSubShapePointOffsets(), points):
            self._warn(prim, "its blend shapes cannot be applied")
        return points

    def _ApplyJoints(self, prim, skeleton, query, skelQuery, points):
        transforms = skelQuery.ComputeSkinningTransforms(self._timeCode)
        if not transforms:
            self._warn(prim, f"its skeleton {skeleton.GetPath()} has no joint transforms; drawn unskinned")
            return points
        toLocal = (self._xforms.GetLocalToWorldTransform(skeleton.GetPrim())
                   * self._xforms.GetLocalToWorldTransform(prim).GetInverse())
        if query.IsRigidlyDeformed():
            influences = query.ComputeJointInfluences(self._timeCode)
            numJoints = len(query.GetJointOrder() or transforms)  # the prim may have an order of its own
            if influences is None or not all(0 <= joint < numJoints for joint in influences[0]):
                self._warn(prim, "its joint influences do not fit; drawn unskinned")
                return points
            toLocal = Gf.Matrix4d(query.ComputeSkinnedTransform(transforms, self._timeCode)) * toLocal
            return _Transformed(points, toLocal)
        moved = Vt.Vec3fArray(points)  # where it fails some points are moved
        if not query.ComputeSkinnedPoints(transforms, moved, self._timeCode):
            self._warn(prim, "its joint influences do not fit; drawn unskinned")
            return points
        return _Transformed(moved, toLocal)


def _VariesAny(prim, names):
    return any(attribute and valueClips.Varies(attribute) for attribute in (prim.GetAttribute(name) for name in names))


def _MovesBelow(ancestor, prim):
    """Whether a prim moves against one above it."""
    while prim and prim != ancestor:
        if prim.IsA(UsdGeom.Xformable) and valueClips.TransformVaries(prim):
            return True
        prim = prim.GetParent()
    return False


def _Transformed(points, matrix):
    """The points, mapped in double precision and rounded once."""
    if matrix == Gf.Matrix4d(1.0):
        return points
    rows = np.array(matrix)
    with np.errstate(all="ignore"):  # what is not finite the core counts and names
        return (np.asarray(points, np.float64) @ rows[:3, :3] + rows[3, :3]).astype(np.float32)
