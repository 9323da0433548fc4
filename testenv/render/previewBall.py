# SPDX-License-Identifier: Apache-2.0
"""A ball of UsdPreviewSurface below an even sky and a wide sun, in double precision, by the formula of docs/shading.md.

Nothing is behind or beside the ball, so what it shows is one integral over the directions above each point: no path is traced.
Each lobe is integrated apart, over directions or half vectors that are distributed as the lobe is, in strata.
"""

import numpy as np


def _Strata(rng, shape, side):
    """(u, v) [*shape][side * side], one in each cell of a grid."""
    cells = np.arange(side * side)
    random = rng.random((2, *shape, side * side))
    return (cells // side + random[0]) / side, (cells % side + random[1]) / side


def _Around(cosine, turn):
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    return np.stack([sine * np.cos(2 * np.pi * turn), sine * np.sin(2 * np.pi * turn), cosine], -1)


def _Dot(a, b):
    return (a * b).sum(-1)


class _Surface:
    def __init__(self, diffuseColor=(0.18,) * 3, useSpecularWorkflow=0, specularColor=(0.0,) * 3, metallic=0.0, roughness=0.5,
                 clearcoat=0.0, clearcoatRoughness=0.01, ior=1.5, emissiveColor=(0.0,) * 3):
        color, self.r = np.array(diffuseColor, float), ((1 - ior) / (1 + ior)) ** 2
        tint = 1 - metallic + metallic * color
        if useSpecularWorkflow:
            self.f0, self.f90, self.diffuse = np.array(specularColor, float), np.ones(3), color
        else:
            self.f0, self.f90, self.diffuse = (1 - metallic) * self.r * tint + metallic * tint, tint, color * (1 - metallic)
        self.clearcoat, self.emission = clearcoat, np.array(emissiveColor, float)
        self.alpha, self.coatAlpha = max(roughness**2, 1e-4), max(clearcoatRoughness**2, 1e-4)

    def Fresnels(self, cosine):
        """(of the base [...][3], of the coat times its weight [...][1])"""
        schlick = (1 - np.clip(cosine, 0, 1))[..., None] ** 5
        return self.f0 + (self.f90 - self.f0) * schlick, self.clearcoat * (self.r + (1 - self.r) * schlick)

    def Diffuse(self, view, u, v, radiance):
        light = _Around(np.sqrt(u), v)
        half = light + view
        fresnel, coat = self.Fresnels(_Dot(half, view) / np.linalg.norm(half, axis=-1))
        return (self.diffuse * (1 - fresnel) * (1 - coat) * radiance(light)).mean(-2)

    def Glossy(self, alpha, weigh, view, u, v, radiance):
        """Half vectors have GGX's density D cos; the light's is that over 4 times their cosine to the viewer."""
        half = _Around(np.sqrt((1 - u) / (1 + (alpha**2 - 1) * u)), v)
        facing = _Dot(half, view)
        light = 2 * facing[..., None] * half - view
        isSeen = (facing > 0) & (light[..., 2] > 0)
        smith = lambda c: (np.sqrt(1 + alpha**2 * (1 / c**2 - 1)) - 1) / 2
        g2 = 1 / (1 + smith(view[..., 2]) + smith(np.where(isSeen, light[..., 2], 1.0)))
        weight = np.where(isSeen, g2 * facing / (view[..., 2] * half[..., 2]), 0.0)
        return (weight[..., None] * weigh(*self.Fresnels(facing)) * radiance(light)).mean(-2)


def Picture(size, inputs, sky, sun, toSun, halfAngle, seed=0, side=24):
    """[size][size][3] of a ball of radius 1 that fills the picture, seen along -z from far away; black beside it. sky, sun: radiance;
    toSun: unit; halfAngle: of the sun's cone, in radians. side: its square is how many directions a pixel has of each lobe."""
    surface, rng = _Surface(**inputs), np.random.default_rng(seed)
    x, y = np.meshgrid((np.arange(size) + 0.5) * 2 / size - 1, 1 - (np.arange(size) + 0.5) * 2 / size)
    isBall = x**2 + y**2 < 1 - 1e-6
    x, y = x[isBall], y[isBall]
    normal = np.stack([x, y, np.sqrt(1 - x**2 - y**2)], -1)
    across = np.cross(normal, (0.6, 0.8, 0.0))
    across /= np.linalg.norm(across, axis=-1)[:, None]
    frame = np.stack([across, np.cross(normal, across), normal], 1)  # rows: world from local
    view = frame @ np.array([0.0, 0.0, 1.0])
    sunThere = (frame @ np.asarray(toSun, float))[:, None]

    def Radiance(light):
        return (sky + sun * (_Dot(light, sunThere) > np.cos(halfAngle)))[..., None]

    samples = lambda: _Strata(rng, (len(x),), side)
    total = surface.emission + surface.Diffuse(view[:, None], *samples(), Radiance)
    total = total + surface.Glossy(surface.alpha, lambda fresnel, coat: fresnel * (1 - coat), view[:, None], *samples(), Radiance)
    if surface.clearcoat > 0:
        total = total + surface.Glossy(surface.coatAlpha, lambda fresnel, coat: coat + 0 * fresnel, view[:, None], *samples(), Radiance)
    picture = np.zeros((size, size, 3))
    picture[isBall] = total
    return picture
