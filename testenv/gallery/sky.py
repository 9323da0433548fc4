# SPDX-License-Identifier: Apache-2.0
"""A clear sky as an image for a dome light, and the sun that belongs to it.

Light that the air scatters once, by Rayleigh's molecules and Mie's haze, integrated along each direction.
Source: Nishita et al. 1993, "Display of the Earth Taking into Account Atmospheric Scattering".
"""

import numpy as np

from stages import author, imageFile

_EARTH, _TOP = 6.36e6, 6.42e6  # radii in metres
_RAYLEIGH, _RAYLEIGH_HEIGHT = np.array([5.8e-6, 13.5e-6, 33.1e-6]), 7994.0  # 1 / m at sea level; m
_MIE, _MIE_HEIGHT, _MIE_FORWARD = 8e-6, 1200.0, 0.76
_STEPS, _SUN_STEPS = 16, 8


def _Reach(origins, directions):
    """Metres from points inside of the air to its top."""
    b = (origins * directions).sum(-1)
    return -b + np.sqrt(np.maximum(b * b - (origins * origins).sum(-1) + _TOP**2, 0))


def _Depths(points, directions, steps):
    """Optical depths (Rayleigh, Mie) from points to the top of the air; infinite where the earth is in the way."""
    step = _Reach(points, directions) / steps
    depths = np.zeros((2,) + step.shape)
    for i in range(steps):
        height = np.linalg.norm(points + directions * ((i + 0.5) * step)[..., None], axis=-1) - _EARTH
        depths += np.exp(-height / np.array([_RAYLEIGH_HEIGHT, _MIE_HEIGHT]).reshape(2, *[1] * height.ndim)) * step
        depths[:, height < 0] = np.inf
    return depths


def _Through(depths):
    return np.exp(-(depths[0][..., None] * _RAYLEIGH + depths[1][..., None] * 1.1 * _MIE))


def SunDirection(elevation: float, azimuth: float):
    """Towards the sun, y up, in degrees; azimuth 0 is -z, 90 is +x."""
    e, a = np.radians([elevation, azimuth])
    return np.array([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)])


def SkyRadiance(directions, sun):
    """[...][3] of unit directions; the sun's irradiance above the air is 1."""
    eye = np.array([0, _EARTH + 50.0, 0])
    view = directions.copy()
    view[..., 1] = np.maximum(view[..., 1], 0.004)
    view /= np.linalg.norm(view, axis=-1, keepdims=True)
    step = _Reach(np.broadcast_to(eye, view.shape), view) / _STEPS
    seen = np.zeros((2,) + step.shape)
    sums = np.zeros((2,) + view.shape)
    for i in range(_STEPS):
        points = eye + view * ((i + 0.5) * step)[..., None]
        height = np.linalg.norm(points, axis=-1) - _EARTH
        density = np.stack([np.exp(-height / _RAYLEIGH_HEIGHT), np.exp(-height / _MIE_HEIGHT)]) * step
        seen += density
        light = _Through(seen + _Depths(points, np.broadcast_to(sun, points.shape), _SUN_STEPS))
        sums += density[..., None] * light
    cosine = (view @ sun)[..., None]
    g = _MIE_FORWARD
    rayleigh = 3 / (16 * np.pi) * (1 + cosine**2)
    mie = 3 / (8 * np.pi) * (1 - g * g) * (1 + cosine**2) / ((2 + g * g) * (1 + g * g - 2 * g * cosine) ** 1.5)
    return sums[0] * _RAYLEIGH * rayleigh + sums[1] * _MIE * mie


def AddSky(stage, folder, width: int, elevation: float, azimuth: float, strength: float, ground) -> None:
    """A dome with the sky's image, `width` texels wide, in `folder`, and a distant light for the sun, of `strength` above the air."""
    sun = SunDirection(elevation, azimuth)
    row, column = np.meshgrid((np.arange(width // 2) + 0.5) / (width // 2), (np.arange(width) + 0.5) / width, indexing="ij")
    up, around = np.pi * (0.5 - row), np.pi * (1 - 2 * column)  # column 0 at longitude +pi, +z in the middle
    directions = np.stack([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)], -1)
    radiance = strength * SkyRadiance(directions, sun)
    below = directions[..., 1] < 0
    radiance[below] = np.asarray(ground) * radiance[~below].mean(0) * np.pi / 2
    imageFile.WriteExr(folder / "sky.exr", {channel: radiance[..., i].astype(np.float32) for i, channel in enumerate("RGB")})
    author.AddLight(stage, "/World/Sky", "Dome", textureFile="./sky.exr")
    through = _Through(_Depths(np.array([0, _EARTH + 50.0, 0]), sun, 64))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-elevation, -azimuth + 180, 0)), angle=0.53,
                    normalize=True, intensity=float(strength * through.max()), color=through / through.max())
