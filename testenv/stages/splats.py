# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats: a prim of arrays, and random clouds of anisotropic ones."""

import numpy as np
from pxr import Gf, Sdf, Usd, Vt

from . import author

HARMONICS = "radiance:sphericalHarmonicsCoefficients"


def _Converters(isHalf):
    """(type, conversion of an array of floats) of each array of a cloud."""
    types = Sdf.ValueTypeNames
    rows = Vt.Vec3hArray if isHalf else Vt.Vec3fArray
    quaternion = Gf.Quath if isHalf else Gf.Quatf
    return dict(
        positions=(types.Point3hArray if isHalf else types.Point3fArray, lambda a: rows.FromNumpy(a)),
        scales=(types.Half3Array if isHalf else types.Float3Array, lambda a: rows.FromNumpy(a)),
        opacities=(types.HalfArray if isHalf else types.FloatArray, lambda a: (Vt.HalfArray if isHalf else Vt.FloatArray)(a.tolist())),
        orientations=(types.QuathArray if isHalf else types.QuatfArray,
                      lambda a: (Vt.QuathArray if isHalf else Vt.QuatfArray)([quaternion(*map(float, q)) for q in a])),
        coefficients=(types.Half3Array if isHalf else types.Float3Array, lambda a: rows.FromNumpy(a.reshape(-1, 3))))


def SetArrays(prim, cloud, isHalf=False, timeCode=Usd.TimeCode.Default()):
    """Authors the members of a cloud, as RandomCloud returns them, that are not None. `isHalf`: by the attributes of half
    precision."""
    for name, (valueType, convert) in _Converters(isHalf).items():
        if cloud.get(name) is not None:
            attribute = (HARMONICS if name == "coefficients" else name) + ("h" if isHalf else "")
            array = np.ascontiguousarray(cloud[name], np.float16 if isHalf else np.float32)
            prim.CreateAttribute(attribute, valueType).Set(convert(array), timeCode)


def AddSplats(stage, path, cloud, isHalf=False, **placement):
    """A ParticleField3DGaussianSplat of what RandomCloud returns."""
    prim = stage.DefinePrim(path, "ParticleField3DGaussianSplat")
    SetArrays(prim, cloud, isHalf)
    if cloud.get("coefficients") is not None:
        degree = int(round(np.sqrt(len(cloud["coefficients"][0])))) - 1
        prim.CreateAttribute("radiance:sphericalHarmonicsDegree", Sdf.ValueTypeNames.Int).Set(degree)
    if placement:
        author.Place(author.UsdGeom.Xformable(prim), **placement)
    return prim


def OtherShapes(cloud, seed, degrees=120.0):
    """A cloud's orientations, scales and opacities after a while: each is turned by so many degrees about an axis of its own
    and grows or shrinks along its axes, and every fourth is gone."""
    rng = np.random.default_rng(seed)
    count = len(cloud["opacities"])
    w, x, y, z = (cloud["orientations"] / np.linalg.norm(cloud["orientations"], axis=1, keepdims=True)).T
    axes = rng.normal(size=(count, 3))
    half = np.radians(degrees) / 2
    turns = np.column_stack([np.full(count, np.cos(half)), np.sin(half) * axes / np.linalg.norm(axes, axis=1, keepdims=True)])
    a, b, c, d = turns.T
    turned = np.stack([a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x,
                       a * z + b * y - c * x + d * w], -1)
    opacities = rng.uniform(0.05, 1.0, count)
    opacities[::4] = 0.0
    return dict(orientations=turned, scales=cloud["scales"] * rng.uniform(0.5, 2.0, (count, 3)), opacities=opacities)


def RandomCloud(count, degree, seed, reach=1.0, size=(0.08, 0.5), opacity=(0.02, 1.0)):
    """Arrays by name: positions, scales [count][3], orientations [count][4] (real first), opacities [count],
    coefficients [count][(degree + 1)^2][3]."""
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(count, (degree + 1) ** 2, 3)) * 0.5
    return dict(positions=rng.uniform(-reach, reach, (count, 3)), scales=np.exp(rng.uniform(*np.log(size), (count, 3))),
                orientations=rng.normal(size=(count, 4)), opacities=rng.uniform(*opacity, count), coefficients=coefficients)
