# SPDX-License-Identifier: Apache-2.0
"""Points of skinned meshes at a time code: blend shapes, then joints, by UsdSkel itself.

The order of steps and the spaces are UsdSkelImaging's, so that Hydra's points are the same but for
rounding. One prim's points are held at a time. Explained in docs/materials.md, "Skinning".
"""

import numpy as np
from pxr import Gf, Usd, UsdSkel, Vt

_PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)


class Skinning:
    """Skins the meshes of a stage at one time code. `xforms`: UsdGeom.XformCache of that time."""

    def __init__(self, timeCode, xforms, warn):
        self._timeCode = timeCode
        self._xforms = xforms
        self._warn = warn
        self._cache = UsdSkel.Cache()
        self._targets = {}  # path of a SkelRoot -> {path of a prim: (skeleton, skinning query)}

    def PointsOf(self, prim, points, rootPrim):
        """The skinned points [count][3] of a mesh below a SkelRoot; None when it is not skinned."""
        path = rootPrim.GetPath()
        if path not in self._targets:
            self._targets[path] = self._FindTargets(UsdSkel.Root(rootPrim))
        target = self._targets[path].get(prim.GetPath())
        if target is None:
            return None
        skeleton, query = target
        skelQuery = self._cache.GetSkelQuery(skeleton)
        skinned = Vt.Vec3fArray.FromNumpy(np.array(points, np.float32))
        if query.HasBlendShapes():
            skinned = self._ApplyBlendShapes(prim, query, skelQuery, skinned)
        if query.HasJointInfluences():
            skinned = self._ApplyJoints(prim, skeleton, query, skelQuery, skinned)
        return skinned

    def TimesOf(self, prim, rootPrim, motion):
        """When a mesh is to be skinned while the shutter is open: at its ends, and where its animation has samples."""
        path = rootPrim.GetPath()
        if path not in self._targets:
            self._targets[path] = self._FindTargets(UsdSkel.Root(rootPrim))
        target = self._targets[path].get(prim.GetPath())
        animation = self._cache.GetSkelQuery(target[0]).GetAnimQuery() if target else None
        names = ("translations", "rotations", "scales", "blendShapeWeights")
        return motion.TimesOf(animation.GetPrim() if animation else prim, names)

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
            toLocal = Gf.Matrix4d(query.ComputeSkinnedTransform(transforms, self._timeCode)) * toLocal
            return _Transformed(points, toLocal)
        moved = Vt.Vec3fArray(points)  # where it fails some points are moved
        if not query.ComputeSkinnedPoints(transforms, moved, self._timeCode):
            self._warn(prim, "its joint influences do not fit; drawn unskinned")
            return points
        return _Transformed(moved, toLocal)


def _Transformed(points, matrix):
    """The points, mapped in double precision and rounded once."""
    if matrix == Gf.Matrix4d(1.0):
        return points
    rows = np.array(matrix)
    with np.errstate(all="ignore"):  # what is not finite the core counts and names
        return (np.asarray(points, np.float64) @ rows[:3, :3] + rows[3, :3]).astype(np.float32)
