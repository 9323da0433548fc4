# SPDX-License-Identifier: Apache-2.0
"""UsdVolParticleField3DGaussianSplat, by the names of its attributes: an OpenUSD before 26.03 has no such schema."""

import numpy as np

from hdstream import _core
from hdstream.translate.motion import CHANGES_IN_NUMBER
from hdstream.translate.primvars import PrimvarsOf
from hdstream.translate.rereading import Again

TYPE = "ParticleField3DGaussianSplat"
_SHAPES = ("orientations", "scales", "opacities", "radiance:sphericalHarmonicsCoefficients")
_MOVING = ("orientations", "scales", "opacities")
_DEGREE = "radiance:sphericalHarmonicsDegree"


def ReadSplats(prim, names, inherited, timeCode):
    """The description of the splats; None where there are none."""
    positions = _NameOf(prim, "positions", timeCode)
    points = _Read(prim, positions, timeCode)
    if points is None or points.ndim != 2 or points.shape[1] != 3:
        return None
    splats = _core.GeometryDescription()
    splats.primitives = _core.PrimitiveKind.Splats
    splats.points = _ReadAgain(prim, positions, timeCode, points)
    splats.primvars = PrimvarsOf(prim, names, inherited, timeCode)
    vertex, constant = _core.Interpolation.Vertex, _core.Interpolation.Constant
    for name in _SHAPES:
        attribute = _NameOf(prim, name, timeCode)
        values = _Read(prim, attribute, timeCode)
        if values is not None:
            splats.primvars = splats.primvars + [_core.Primvar(name, vertex, _ReadAgain(prim, attribute, timeCode, values))]
    degree = _Value(prim, _DEGREE, timeCode)
    if degree is not None:
        splats.primvars = splats.primvars + [_core.Primvar(_DEGREE, constant, np.array([degree], np.float32))]
    return splats


def AddSamples(prim, splats, motion, timeCode, warn):
    """What of the splats moves while the shutter is open."""
    counts = {primvar.name: primvar.values.size // primvar.numComponents for primvar in splats.primvars}
    counts["positions"] = len(splats.points)
    samples = {name: motion.ArraySamplesOf(prim, _NameOf(prim, name, timeCode), counts[name])
               for name in ("positions", *_MOVING) if name in counts}
    if None in samples.values():
        warn(prim, CHANGES_IN_NUMBER)
        return
    splats.samples = samples.pop("positions")
    if any(samples.values()):
        shapes = _core.SplatSamples()
        for name, own in samples.items():
            setattr(shapes, name, own)
        splats.splatSamples = shapes


def _NameOf(prim, name, timeCode):
    """The attribute of floats or, where that has no value, of halfs."""
    return name if _Value(prim, name, timeCode) else name + "h"


def _Value(prim, name, timeCode):
    attribute = prim.GetAttribute(name)
    return attribute.Get(timeCode) if attribute else None


def _Read(prim, name, timeCode):
    """[count] or [count][components] floats, of quaternions i, j, k, real; None where there are none."""
    value = _Value(prim, name, timeCode)
    rows = np.asarray(value) if value else None
    return None if rows is None or rows.dtype.kind != "f" else np.ascontiguousarray(rows, np.float32)


def _ReadAgain(prim, name, timeCode, values):
    return Again(prim.GetAttribute(name), timeCode, values, lambda own: _Read(own.GetPrim(), name, timeCode))
