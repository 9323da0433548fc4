# SPDX-License-Identifier: Apache-2.0
"""Transforms and points while the shutter is open (docs/motionBlur.md).

Times are offsets in frames from the frame, as the core and Hydra have them.
"""

import bisect
import math

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from hdstream.translate import valueClips
from hdstream.translate.instanceArrays import InstancesWhereFinite
from hdstream.translate.primvars import FloatRows

# Transforms are sampled at so many equal steps: they may turn by half a circle in each.
_NUM_STEPS = 8
# And what accelerations or angular velocities move.
_NUM_CURVED_STEPS = 16

# The core leaves out what keys lack of the longest way where that is this part of it or less (scene/geometryMotion).
_STRAIGHT = 256

_SHUTTER = ("shutter:open", "shutter:close")

CHANGES_IN_NUMBER = "its points change in number while the shutter is open: drawn without motion blur"
INSTANCES_CHANGE_IN_NUMBER = "its instances change in number while the shutter is open: drawn without motion blur"


def ReadBlurScale(prim, timeCode, warn):
    """The motion:blurScale that holds for a prim, its own or inherited."""
    scale = UsdGeom.MotionAPI(prim).ComputeMotionBlurScale(timeCode)
    if not (math.isfinite(scale) and scale >= 0.0):
        warn(prim, f"motion:blurScale is {scale}, and no finite number of at least 0; 1 is used")
        return 1.0
    return float(scale)


def ReadShutter(prim, timeCode):
    """(open, close) of a UsdGeomCamera prim, in frames from the frame; what is no finite number counts as 0."""
    values = [prim.GetAttribute(name).Get(timeCode) for name in _SHUTTER]
    return tuple(float(value) if _IsFinite(value) else 0.0 for value in values)


def ShutterProblems(prim, timeCode):
    """What is wrong with a camera's shutter, a line each."""
    texts = []
    for name in _SHUTTER:
        value = prim.GetAttribute(name).Get(timeCode)
        if value is not None and not _IsFinite(value):
            texts.append(f"{name} is {value}, and no finite number; 0 is used")
    opened, closed = ReadShutter(prim, timeCode)
    if closed < opened:
        texts.append(f"its shutter closes at {closed:g} before it opens at {opened:g}; nothing moves")
    return texts


def _IsFinite(value):
    return isinstance(value, (int, float)) and math.isfinite(value)


class Motion:
    """Samples around one frame. Without an open shutter, or at no frame at all, nothing moves.

    `scale` is a prim's motion:blurScale: at a time of the shutter the prim is as at `scale` times that, so samples are of an
    interval that much as long, and the core gets them at the shutter's times.
    """

    def __init__(self, timeCode, shutter=(0.0, 0.0), scale=1.0):
        timeCode = Usd.TimeCode(timeCode)
        self.isOn = timeCode.IsNumeric() and shutter[1] > shutter[0] and scale > 0.0
        if not self.isOn:
            return
        self.timeCode = timeCode
        self.ends = tuple(scale * end for end in shutter)
        self.times = [float(time) for time in np.linspace(*self.ends, _NUM_STEPS + 1)]
        self._xforms = [UsdGeom.XformCache(self.At(time)) for time in self.times]
        self._shutter, self._scale, self._scaled = shutter, scale, {}

    def Scaled(self, scale):
        """The Motion of prims with a blurScale. Of one whose own is 1, and that is on."""
        if scale == 1.0:
            return self
        if scale not in self._scaled:
            self._scaled[scale] = Motion(self.timeCode, self._shutter, scale)
        return self._scaled[scale]

    def _Told(self, times):
        """Times of samples as the core takes them."""
        return [time / self._scale for time in times]

    def ToldTimes(self):
        """`times` as the core takes them."""
        return self._Told(self.times)

    def At(self, time):
        return Usd.TimeCode(self.timeCode.GetValue() + time)

    def TimesOf(self, prim, names, isCurved=False):
        """When to sample what attributes of a prim say: at the shutter's ends and where they have samples in between, as
        the floats that Hydra tells; where they tell of a curved way at equal steps too."""
        within = Gf.Interval(*(self.timeCode.GetValue() + end for end in self.ends), False, False)
        frame = self.timeCode.GetValue()
        times = set(np.linspace(*self.ends, _NUM_CURVED_STEPS + 1).tolist() if isCurved else self.ends)
        for name in names:
            attribute = prim.GetAttribute(name)
            if attribute and attribute.GetNumTimeSamples() > 1:
                times.update(float(np.float32(time - frame)) for time in attribute.GetTimeSamplesInInterval(within))
        return sorted(time for time in times if self.ends[0] <= time <= self.ends[1])

    def MatricesOf(self, prim, local, resets, inheritedMatrix, inheritedMatrices):
        """The matrices of a prim at `times`, composed with the inherited ones; None when they are all the same."""
        isVarying = self.isOn and valueClips.TransformVaries(prim)
        if not isVarying and (resets or inheritedMatrices is None):
            return None
        own = [xforms.GetLocalTransformation(prim)[0] for xforms in self._xforms] if isVarying else [local] * len(self.times)
        if not resets:
            inherited = inheritedMatrices or [inheritedMatrix] * len(self.times)
            own = [matrix * above for matrix, above in zip(own, inherited)]
        return own if any(matrix != own[0] for matrix in own) else None

    def MatricesAlong(self, way):
        """The same of the last of nested prims with transforms, the outermost first."""
        matrix, matrices = Gf.Matrix4d(1.0), None
        for prim in way if self.isOn else ():
            xformable = UsdGeom.Xformable(prim)
            local, resets = xformable.GetLocalTransformation(self.timeCode), xformable.GetResetXformStack()
            matrices = self.MatricesOf(prim, local, resets, matrix, matrices)
            matrix = local if resets else local * matrix
        return matrices

    def SamplesOf(self, matrices):
        """(time, array) of matrices at `times`, as the core takes them."""
        return [] if matrices is None else [(time, np.array(matrix)) for time, matrix in zip(self._Told(self.times), matrices)]

    def InstanceSamplesOf(self, matrices):
        """(time, arrays) of lists of matrices at `times`, one for each instance."""
        return [(time, np.asarray(Vt.Matrix4dArray([own[i] for own in matrices]))) for i, time in enumerate(self._Told(self.times))]

    def PointInstanceSamplesOf(self, instancer, count, warn):
        """(time, arrays) of a UsdGeomPointInstancer; velocities count."""
        if not self.isOn:
            return []
        curving = (instancer.GetAccelerationsAttr(), instancer.GetAngularVelocitiesAttr())
        names = ("positions", "orientations", "orientationsf", "scales")
        times = self.TimesOf(instancer.GetPrim(), names,
                             isCurved=any(attribute.HasAuthoredValue() for attribute in curving))
        arrays = instancer.ComputeInstanceTransformsAtTimes(
            [self.At(time) for time in times], self.timeCode, UsdGeom.PointInstancer.ExcludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask)
        prim = instancer.GetPrim()
        if all(len(array) == count for array in arrays):
            arrays, areStanding = zip(*(InstancesWhereFinite(instancer, array, self.timeCode) for array in arrays))
            if any(areStanding):
                warn(prim, "velocities are not finite: instances that have these stand still")
        samples = _Samples(self._Told(times), [np.asarray(array) for array in arrays], count)
        if not samples and not self._HasVelocities(prim, count, "positions") and any(
                self._ChangesInNumber(prim.GetAttribute(name), times) for name in names):
            warn(prim, INSTANCES_CHANGE_IN_NUMBER)  # UsdGeom gives those of the frame for all times
        return samples

    def _ChangesInNumber(self, attribute, times):
        if not attribute or not valueClips.Varies(attribute):
            return False
        return len({len(attribute.Get(self.At(time)) or ()) for time in (0.0, *times)}) > 1

    def PointSamplesOf(self, prim, names, count, warn, topology=()):
        """(time, points) of a PointBased prim; velocities count. `topology`: names of what must not change; where it
        does, velocities alone tell how the points of the frame move."""
        if not self.isOn or not ("velocities" in names or valueClips.Varies(prim.GetAttribute("points"))):
            return []
        hasVelocities = "velocities" in names and self._HasVelocities(prim, count)
        if hasVelocities:
            times = self.TimesOf(prim, (), isCurved="accelerations" in names)
        else:
            times = self.TimesOf(prim, ("points",))
            if any(self._Changes(prim.GetAttribute(name)) for name in topology):
                warn(prim, "its topology changes while the shutter is open: drawn without motion blur")
                return []
        arrays = UsdGeom.PointBased(prim).ComputePointsAtTimes([self.At(time) for time in times], self.timeCode)
        if hasVelocities and all(len(array) == count for array in arrays):
            atRest = prim.GetAttribute("points").Get(self.timeCode)
            moved, arrays = arrays, [WhereFinite(array, atRest) for array in arrays]
            if any(array is not own for array, own in zip(arrays, moved)):
                warn(prim, "velocities are not finite: points that have these stand still")
        return _SamplesOrWarning(prim, self._Told(times), arrays, count, warn)

    def ShapeSamplesOf(self, prim, names, count, pointsAt):
        """(time, points) of a gprim that attributes of those names give its shape; pointsAt(timeCode) are its points."""
        if not self.isOn or not any(valueClips.Varies(prim.GetAttribute(name)) for name in names):
            return []
        times = self.TimesOf(prim, names)
        return _Samples(self._Told(times), [pointsAt(self.At(time)).reshape(-1, 3) for time in times], count)

    def ArraySamplesOf(self, prim, name, count):
        """(time, values) of an attribute that has `count` of them; None where it has other numbers at some time."""
        attribute = prim.GetAttribute(name)
        if not self.isOn or not attribute or not valueClips.Varies(attribute):
            return []
        times = self.TimesOf(prim, (name,))
        arrays = [attribute.Get(self.At(time)) for time in times]
        return _Samples(self._Told(times), arrays, count) if all(len(array or ()) == count for array in arrays) else None

    def _HasVelocities(self, prim, count, points="points"):
        """Whether UsdGeom moves the points by them: they have a sample where the points have that before the frame."""
        velocities = prim.GetAttribute("velocities")
        if not velocities:
            return False
        frame = self.timeCode.GetValue()
        samples = [attribute.GetBracketingTimeSamples(frame)[:1] for attribute in (prim.GetAttribute(points), velocities)]
        return len(velocities.Get(self.timeCode) or ()) == count and bool(samples[0]) and samples[0] == samples[1]

    def _Changes(self, attribute):
        if not attribute or not valueClips.Varies(attribute):
            return False
        values = [attribute.Get(self.At(time)) for time in (0.0, *self.TimesOf(attribute.GetPrim(), (attribute.GetName(),)))]
        return any(value != values[0] for value in values)

    def SkinnedSamplesOf(self, times, arrays, count):
        """The same of a skinned prim, of its points at `times`; those at the ends alone where the way is straight."""
        samples = _Samples(self._Told(times), arrays, count) if self.isOn else []
        return [samples[0], samples[-1]] if samples and _IsStraight(samples) else samples

    def PrimvarSamplesOf(self, prim, name, names, primvars):
        """(time, values) of the primvar `name` of a gprim, or the attribute; empty where its indices change."""
        if not self.isOn:
            return []
        primvar = next((primvar for primvar in primvars if primvar.name == name), None)
        attributeName = next((text for text in (f"primvars:{name}", name) if text in names), None)
        if primvar is None or attributeName is None:
            return []
        attribute = prim.GetAttribute(attributeName)
        indices = prim.GetAttribute(attributeName + ":indices")
        if not valueClips.Varies(attribute) or (indices and valueClips.Varies(indices)):
            return []
        times = self.TimesOf(prim, (attributeName,))
        arrays = [FloatRows(attribute.Get(self.At(time)), attribute) for time in times]
        return _Samples(self._Told(times), arrays, primvar.values.size // primvar.numComponents)

    def CameraSamplesOf(self, camera):
        """(time, array) of a UsdGeomCamera's pose."""
        if not self.isOn:
            return []
        matrices = [camera.GetCamera(self.At(time)).transform for time in self.times]
        return self.SamplesOf(matrices if any(matrix != matrices[0] for matrix in matrices) else None)


def _IsStraight(samples):
    """Whether points of (time, points) go straight and evenly from the first to the last, but for what the core leaves out."""
    (opened, first), (closed, last) = samples[0], samples[-1]
    with np.errstate(all="ignore"):  # of what is not finite no comparison holds
        way = max(float(np.abs(points - first).max()) for _, points in samples[1:])
        return all(np.abs(points - first - (time - opened) / (closed - opened) * (last - first)).max() <= way / _STRAIGHT
                   for time, points in samples[1:-1])


def SampleAt(samples, time, still):
    """The values at a time of (time, array), linear in between; `still` where there are none."""
    if not samples:
        return still
    times = [own for own, _ in samples]
    after = min(bisect.bisect_left(times, time), len(times) - 1)
    before = after if times[after] <= time else max(after - 1, 0)
    share = (time - times[before]) / (times[after] - times[before]) if after > before else 0.0
    return (1 - share) * np.asarray(samples[before][1], float) + share * np.asarray(samples[after][1], float)


def WhereFinite(moved, points):
    """What velocities make of points; those that they take from somewhere finite to nowhere finite stand still."""
    isFinite = np.isfinite(np.asarray(moved)).all(axis=1) | ~np.isfinite(np.asarray(points)).all(axis=1)
    return moved if isFinite.all() else Vt.Vec3fArray.FromNumpy(np.where(isFinite[:, None], moved, points))


def _SamplesOrWarning(prim, times, arrays, count, warn):
    """_Samples of points, whose number has to stay."""
    samples = _Samples(times, arrays, count)
    if not samples and any(array is None or len(array) != count for array in arrays):
        warn(prim, CHANGES_IN_NUMBER)
    return samples


def _Samples(times, arrays, count):
    """(time, array) at times; empty when the arrays do not fit or are all the same."""
    arrays = [array if array is None or np.asarray(array).dtype == np.float64 else np.ascontiguousarray(array, np.float32) for array in arrays]
    if len(arrays) != len(times) or any(array is None or len(array) != count for array in arrays):
        return []
    if all(np.array_equal(array, arrays[0]) for array in arrays[1:]):
        return []
    return list(zip(times, arrays))
