# SPDX-License-Identifier: Apache-2.0
"""Transforms and points while the shutter is open (docs/motionBlur.md).

Times are offsets in frames from the frame, as the core and Hydra have them.
"""

import math

import numpy as np
from pxr import Usd, UsdGeom, Vt

# Transforms are sampled at so many equal steps: they may turn by half a circle in each.
_NUM_STEPS = 8


def ReadShutter(prim, timeCode):
    """(open, close) of a UsdGeomCamera prim, in frames from the frame; what is no finite number counts as 0."""
    values = [prim.GetAttribute(name).Get(timeCode) for name in ("shutter:open", "shutter:close")]
    return tuple(float(value) if isinstance(value, (int, float)) and math.isfinite(value) else 0.0 for value in values)


class Motion:
    """Samples around one frame. Without an open shutter, or at no frame at all, nothing moves."""

    def __init__(self, timeCode, shutter=(0.0, 0.0)):
        timeCode = Usd.TimeCode(timeCode)
        self.isOn = timeCode.IsNumeric() and shutter[1] > shutter[0]
        if not self.isOn:
            return
        self.timeCode = timeCode
        self.ends = shutter
        self.times = [float(time) for time in np.linspace(*shutter, _NUM_STEPS + 1)]
        self._xforms = [UsdGeom.XformCache(self.At(time)) for time in self.times]

    def At(self, time):
        return Usd.TimeCode(self.timeCode.GetValue() + time)

    def AtEnds(self, make):
        """What make(timeCode) gives at the shutter's ends."""
        return [make(self.At(time)) for time in self.ends] if self.isOn else []

    def MatricesOf(self, prim, local, resets, inheritedMatrix, inheritedMatrices):
        """The matrices of a prim at `times`, composed with the inherited ones; None when they are all the same."""
        isVarying = self.isOn and UsdGeom.Xformable(prim).TransformMightBeTimeVarying()
        if not isVarying and (resets or inheritedMatrices is None):
            return None
        own = [xforms.GetLocalTransformation(prim)[0] for xforms in self._xforms] if isVarying else [local] * len(self.times)
        if not resets:
            inherited = inheritedMatrices or [inheritedMatrix] * len(self.times)
            own = [matrix * above for matrix, above in zip(own, inherited)]
        return own if any(matrix != own[0] for matrix in own) else None

    def SamplesOf(self, matrices):
        """(time, array) of matrices at `times`, as the core takes them."""
        return [] if matrices is None else [(time, np.array(matrix)) for time, matrix in zip(self.times, matrices)]

    def InstanceSamplesOf(self, matrices):
        """(time, arrays) of lists of matrices at `times`, one for each instance."""
        return [(time, np.asarray(Vt.Matrix4dArray([own[i] for own in matrices]))) for i, time in enumerate(self.times)]

    def PointInstanceSamplesOf(self, instancer, count):
        """(time, arrays) of a UsdGeomPointInstancer at the shutter's ends; velocities count."""
        if not self.isOn:
            return []
        arrays = instancer.ComputeInstanceTransformsAtTimes(
            [self.At(time) for time in self.ends], self.timeCode, UsdGeom.PointInstancer.ExcludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask)
        arrays = [np.asarray(array) for array in arrays]
        if len(arrays) != 2 or any(len(array) != count for array in arrays) or np.array_equal(*arrays):
            return []
        return list(zip(self.ends, arrays))

    def PointSamplesOf(self, prim, names, count):
        """(time, points) of a PointBased prim at the shutter's ends; velocities count."""
        isVarying = self.isOn and ("velocities" in names or prim.GetAttribute("points").ValueMightBeTimeVarying())
        if not isVarying:
            return []
        return self._Ends(UsdGeom.PointBased(prim).ComputePointsAtTimes(
            [self.At(time) for time in self.ends], self.timeCode), count)

    def SkinnedSamplesOf(self, prim, points, endSkins):
        """The same of a skinned mesh; `endSkins`: functions that skin it at the shutter's ends."""
        return self._Ends([skin(prim, points) for skin in endSkins], len(points)) if self.isOn else []

    def _Ends(self, arrays, count):
        """(time, array) at the shutter's ends; empty when the arrays do not fit or are the same."""
        arrays = [np.ascontiguousarray(array, np.float32) for array in arrays if array is not None]
        if len(arrays) != 2 or any(len(array) != count for array in arrays) or np.array_equal(*arrays):
            return []
        return list(zip(self.ends, arrays))

    def CameraSamplesOf(self, camera):
        """(time, array) of a UsdGeomCamera's pose."""
        if not self.isOn:
            return []
        matrices = [camera.GetCamera(self.At(time)).transform for time in self.times]
        return self.SamplesOf(matrices if any(matrix != matrices[0] for matrix in matrices) else None)
