# SPDX-License-Identifier: Apache-2.0
"""What the gallery's stages share: noise as periodic images, placing instances, writing the stage."""

import numpy as np
from pxr import Sdf, UsdGeom, Vt

from stages import author, shapes


def Noise(seed: int, size: int, slope: float = 2.0, lowest: float = 1.0) -> np.ndarray:
    """[size][size], periodic, mean 0 and deviation 1; amplitudes fall with frequency^-slope and are 0 below `lowest`."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]) * size
    weight = np.where(frequency < lowest, 0, np.maximum(frequency, 1) ** -slope)
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, size))) * weight, (size, size))
    return field / field.std()


def Sample(field: np.ndarray, x, z, period: float):
    """Values of a periodic field at places, linear between its samples."""
    size = len(field)
    row, column = np.asarray(z) / period * size, np.asarray(x) / period * size
    i, j = np.floor(row).astype(int), np.floor(column).astype(int)
    v, u = row - i, column - j
    at = lambda a, b: field[a % size, b % size]
    return (at(i, j) * (1 - u) + at(i, j + 1) * u) * (1 - v) + (at(i + 1, j) * (1 - u) + at(i + 1, j + 1) * u) * v


def Smooth(low, high, value):
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def AddInstances(stage, path: str, targets: list, kinds, positions, scales=None, quaternions=None) -> UsdGeom.PointInstancer:
    """A PointInstancer; quaternions [n][4] are x, y, z, w."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(target) for target in targets])
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(kinds, np.int32)))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(positions, np.float32)))
    if scales is not None:
        scales = np.asarray(scales, np.float32)
        scales = np.repeat(scales[:, None], 3, 1) if scales.ndim == 1 else scales
        instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(scales)))
    if quaternions is not None:
        instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(np.ascontiguousarray(quaternions, np.float16)))
    return instancer


def TurnedUp(rng, count: int, lean: float = 0.0) -> np.ndarray:
    """Quaternions of random turns about y, tipped over by `lean` radians at most."""
    turn, tip = rng.uniform(0, np.pi, count), rng.normal(0, lean / 2, (2, count)) / 2
    turned = np.stack([0 * turn, np.sin(turn), 0 * turn, np.cos(turn)], 1)
    turned[:, 0], turned[:, 2] = tip[0], tip[1]
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


def Towards(directions: np.ndarray, spin) -> np.ndarray:
    """Quaternions [n][4] that turn +y to unit directions, after a spin about y in radians."""
    w = 1 + directions[:, 1]
    swing = np.stack([directions[:, 2], 0 * w, -directions[:, 0], np.maximum(w, 1e-4)], 1)
    swing /= np.linalg.norm(swing, axis=1, keepdims=True)
    s, c = np.sin(spin / 2), np.cos(spin / 2)
    x, y, z, w = swing.T
    return np.stack([x * c - z * s, w * s + y * c, z * c + x * s, w * c - y * s], 1)


def AddSweep(stage, material) -> None:
    """A sheet of paper that runs from below the camera up the wall in one curve."""
    bend = np.linspace(0, np.pi / 2, 24)
    z = np.concatenate([[20.0], -4 - 4 * np.sin(bend), [-8.0]])
    y = np.concatenate([[0.0], 4 - 4 * np.cos(bend), [22.0]])
    sheet = np.concatenate([np.stack([np.full_like(z, x), y, z], 1) for x in (-30.0, 30.0)])
    count = len(z)
    quads = np.array([[k, count + k, count + k + 1, k + 1] for k in range(count - 1)])
    normals = np.concatenate([[[0, 1, 0]], np.stack([0 * bend, np.cos(bend), np.sin(bend)], 1), [[0, 0, 1]]] * 2)
    author.AddMesh(stage, "/World/Paper", shapes.Shape(sheet, np.full(count - 1, 4), quads.ravel(), normals), material=material)


def NewStage(folder):
    """An empty stage.usdc in the folder, replacing one that is there."""
    path = folder / "stage.usdc"
    path.unlink(missing_ok=True)
    return author.NewStage(str(path))
