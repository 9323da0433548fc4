# SPDX-License-Identifier: Apache-2.0
"""Walks below the surface of a ball, in double precision: an oracle of subsurface scattering that shares no code with the renderer."""

import numpy as np


def AlbedoOf(color):
    """Of one event, for a half-space that reflects `color`. Source: Kulla and Conty 2017."""
    return 1 - np.exp(-5.09406 * color + 2.61188 * color**2 - 4.31805 * color**3)


def BallAlbedo(albedo: float, radius: float, count=200000, mostEvents=None) -> float:
    """What a ball of radius 1 gives back of the light that enters it by Lambert's law. \\param albedo of one event. \\param radius mean
    free path. Events scatter alike in all directions and end walks by chance. \\param mostEvents walks of more end too; None: none."""
    random = np.random.default_rng(3)

    def Directions(count, z):
        phi, r = 2 * np.pi * random.random(count), np.sqrt(1 - z * z)
        return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)

    at, to = np.tile([0.0, 0.0, 1.0], (count, 1)), Directions(count, -np.sqrt(random.random(count)))
    escaped, events = 0, 0
    while len(at):
        b = np.sum(at * to, -1)
        exits = -b + np.sqrt(np.maximum(b * b + 1 - np.sum(at * at, -1), 0))
        way = -np.log(1 - random.random(len(at))) * radius
        escaped += np.sum(way >= exits)
        events += 1
        if mostEvents is not None and events > mostEvents:
            break
        goesOn = (way < exits) & (random.random(len(at)) < albedo)
        at = at[goesOn] + way[goesOn, None] * to[goesOn]
        to = Directions(len(at), 2 * random.random(len(at)) - 1)
    return escaped / count
