# SPDX-License-Identifier: Apache-2.0
"""A spiral galaxy of glowing points: old stars in the middle, young ones along the arms."""

import numpy as np

from stages import author, curves

from . import landscape

_ARMS = 2


def _Stars(rng, count: int):
    """(points, widths, radiances) of disk, arms and bulge."""
    bulge = count // 5
    radius = np.concatenate([abs(rng.normal(0, 0.9, bulge)) + 0.02, rng.gamma(2.6, 1.5, count - bulge)])
    isBulge = np.arange(count) < bulge
    turn = rng.uniform(0, 2 * np.pi, count)
    inArm = ~isBulge & (rng.random(count) < 0.72)
    arm = 2.35 * np.log1p(radius * 1.25) + np.pi * 2 / _ARMS * rng.integers(0, _ARMS, count)
    turn = np.where(inArm, arm + rng.normal(0, 0.26, count) * (1 + 0.6 * rng.random(count)), turn)
    clump = landscape.Noise(5, 512, 1.3)
    x, z = radius * np.cos(turn), radius * np.sin(turn)
    x, z = x + 0.22 * landscape.Sample(clump, x, z, 14.0), z + 0.22 * landscape.Sample(clump, z + 5, x, 14.0)
    thick = np.where(isBulge, 0.55 * np.exp(-radius / 1.2), 0.05 + 0.01 * radius)
    points = np.stack([x, rng.normal(0, 1, count) * thick, z], 1)
    heat = np.clip(np.where(inArm, 0.75, 0.25) + rng.normal(0, 0.2, count) - 0.35 * np.exp(-radius / 1.4), 0, 1)[:, None]
    colour = np.array([1.0, 0.52, 0.22]) * (1 - heat) ** 2 + np.array([1.0, 0.85, 0.75]) * 2 * heat * (1 - heat) \
        + np.array([0.3, 0.5, 1.0]) * heat**2
    nursery = inArm & (landscape.Sample(clump, 2 * x, 2 * z + 3, 14.0) > 1.15) & (rng.random(count) < 0.5)
    colour[nursery] = (1.0, 0.16, 0.3)
    bright = rng.pareto(2.6, count) + 0.25
    return points, 0.011 * np.minimum(bright, 5) ** 0.5, colour * np.minimum(bright, 8)[:, None] * 0.6


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(2)
    stage = landscape.NewStage(folder)
    points, widths, radiances = _Stars(rng, max(2000, int(2_000_000 * size)))
    stars = curves.AddPoints(stage, "/World/Stars", points, widths, color=radiances)
    far = rng.normal(size=(max(200, int(6000 * size)), 3))
    far *= rng.uniform(60, 90, len(far))[:, None] / np.linalg.norm(far, axis=1, keepdims=True)
    sky = curves.AddPoints(stage, "/World/Far", far, 0.035 * (rng.pareto(3, len(far)) + 0.6),
                           color=np.array([0.8, 0.85, 1.0]) * rng.uniform(0.2, 1.6, (len(far), 1)))
    glow = author.AddMaterial(stage, "/World/Looks/Glow", readers={"emissiveColor": ("displayColor", "float3", (1.0, 1.0, 1.0))},
                              diffuseColor=(0.0, 0.0, 0.0), roughness=1.0, ior=1.0)
    for prim in (stars, sky):
        author.Bind(prim, glow)
    author.AddLight(stage, "/World/Dark", "Dome", intensity=0.0015, color=(0.4, 0.55, 1.0))
    author.AddCamera(stage, "/World/Camera", eye=(2.0, 11.5, 17.5), target=(0.0, -0.4, 0), up=(0.24, 1, 0), focalLength=34.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
