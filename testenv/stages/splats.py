# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats: a prim of arrays, and random clouds of anisotropic ones."""

import numpy as np
from pxr import Gf, Sdf, Vt

from . import author

HARMONICS = "radiance:sphericalHarmonicsCoefficients"


def AddSplats(stage, path, cloud, isHalf=False, **placement):
    """A ParticleField3DGaussianSplat of what RandomCloud returns; a member that is None is not authored. `isHalf`: by
    the attributes of half precision."""
    prim = stage.DefinePrim(path, "ParticleField3DGaussianSplat")
    types, suffix = Sdf.ValueTypeNames, "h" if isHalf else ""
    rows = Vt.Vec3hArray if isHalf else Vt.Vec3fArray
    quaternion = Gf.Quath if isHalf else Gf.Quatf
    values = dict(
        positions=(types.Point3hArray if isHalf else types.Point3fArray, lambda a: rows.FromNumpy(a)),
        scales=(types.Half3Array if isHalf else types.Float3Array, lambda a: rows.FromNumpy(a)),
        opacities=(types.HalfArray if isHalf else types.FloatArray, lambda a: (Vt.HalfArray if isHalf else Vt.FloatArray)(a.tolist())),
        orientations=(types.QuathArray if isHalf else types.QuatfArray,
                      lambda a: (Vt.QuathArray if isHalf else Vt.QuatfArray)([quaternion(*map(float, q)) for q in a])),
        coefficients=(types.Half3Array if isHalf else types.Float3Array, lambda a: rows.FromNumpy(a.reshape(-1, 3))))
    for name, (valueType, convert) in values.items():
        if cloud.get(name) is not None:
            attribute = HARMONICS if name == "coefficients" else name
            array = np.ascontiguousarray(cloud[name], np.float16 if isHalf else np.float32)
            prim.CreateAttribute(attribute + suffix, valueType).Set(convert(array))
    if cloud.get("coefficients") is not None:
        degree = int(round(np.sqrt(len(cloud["coefficients"][0])))) - 1
        prim.CreateAttribute("radiance:sphericalHarmonicsDegree", types.Int).Set(degree)
    if placement:
        author.Place(author.UsdGeom.Xformable(prim), **placement)
    return prim


def RandomCloud(count, degree, seed, reach=1.0, size=(0.08, 0.5), opacity=(0.02, 1.0)):
    """Arrays by name: positions, scales [count][3], orientations [count][4] (real first), opacities [count],
    coefficients [count][(degree + 1)^2][3]."""
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(count, (degree + 1) ** 2, 3)) * 0.5
    return dict(positions=rng.uniform(-reach, reach, (count, 3)), scales=np.exp(rng.uniform(*np.log(size), (count, 3))),
                orientations=rng.normal(size=(count, 4)), opacities=rng.uniform(*opacity, count), coefficients=coefficients)
