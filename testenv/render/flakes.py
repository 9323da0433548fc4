# SPDX-License-Identifier: Apache-2.0
"""MaterialX 1.39's flakes by its GLSL text (mx_flake.glsl, mx_noise.glsl), in double precision."""

import itertools

import numpy as np

_MASK = 0xFFFFFFFF


def _Rotate(x, bits):
    return (x << bits | x >> (32 - bits)) & _MASK


def _Hash(*numbers):
    """Bob Jenkins' lookup3 of three to five integers."""
    start = (0xDEADBEEF + (len(numbers) << 2) + 13) & _MASK
    a, b, c = ((start + int(n)) & _MASK for n in numbers[:3])
    if len(numbers) > 3:
        for bits in ((4, 6, 8), (16, 19, 4)):
            a = ((a - c) & _MASK) ^ _Rotate(c, bits[0])
            c = (c + b) & _MASK
            b = ((b - a) & _MASK) ^ _Rotate(a, bits[1])
            a = (a + c) & _MASK
            c = ((c - b) & _MASK) ^ _Rotate(b, bits[2])
            b = (b + a) & _MASK
        a = (a + int(numbers[3])) & _MASK
        b = (b + (int(numbers[4]) if len(numbers) > 4 else 0)) & _MASK
    v = [a, b, c]
    for k, bits in zip((2, 0, 1, 2, 0, 1, 2), (14, 11, 25, 16, 4, 14, 24)):
        other = v[k - 1]
        v[k] = ((v[k] ^ other) - _Rotate(other, bits)) & _MASK
    return v[2] / _MASK


def _IsInside(place, random):
    theta, phi, z = 2 * np.pi * random[0], 2 * np.pi * random[1], 2 * random[2]
    v = np.array([np.sin(phi) * np.sqrt(z), np.cos(phi) * np.sqrt(z), np.sqrt(2 - z)])
    sine, cosine = np.sin(theta), np.cos(theta)
    sx, sy = v[0] * cosine - v[1] * sine, v[0] * sine + v[1] * cosine
    columns = np.array([[v[0] * sx - cosine, v[0] * sy - sine, v[0] * v[2]],
                        [v[1] * sx + sine, v[1] * sy - cosine, v[1] * v[2]],
                        [v[2] * sx, v[2] * sy, 1 - z]])
    return bool((np.abs(place @ columns) <= 1.5 / np.sqrt(3)).all())


def Flake(position, size, roughness, coverage):
    """{"presence", "rand", "id", "flakenormal" (in tangent space)} at a place."""
    x = min(max(coverage, 0.0), 1.0)
    probability = (-26.19771808 * x * x + 26.39663835 * x) / (85.53857017 * x**3 - 102.35069432 * x * x - 101.42634862 * x + 118.45082288)
    place = np.asarray(position, float) / size
    presence, cell = 0.0, None
    for offset in itertools.product((-1, 0, 1), repeat=3):
        corner = np.floor(place) + offset
        within = place - corner - 0.5
        if within @ within >= 2.25 or _Hash(*corner) > probability:
            continue
        priority = _Hash(*corner, 3)
        if priority >= presence and _IsInside(within, [_Hash(*corner, k) for k in range(3)]):
            presence, cell = priority, corner
    if cell is None:
        return dict(presence=0.0, rand=0.0, id=0, flakenormal=np.array([0.0, 0.0, 1.0]))
    u, v, rand = (_Hash(*cell, 2, k) for k in range(3))
    slope = roughness * roughness * np.sqrt(v) / np.sqrt(1 - v)
    normal = np.array([slope * np.cos(2 * np.pi * u), slope * np.sin(2 * np.pi * u), 1.0])
    return dict(presence=presence, rand=rand, id=int(rand * 16777215), flakenormal=normal / np.linalg.norm(normal))
