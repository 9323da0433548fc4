# SPDX-License-Identifier: Apache-2.0
"""What a ladder of sample counts says of a renderer: errors, and the samples and seconds to a stated error. Arithmetic alone.

A renderer's reference is two independent halves. The error of a picture x against the halves a, b is the mean of
(x - a)(x - b) / (r^2 + 0.01), r = (a + b) / 2, over pixels and channels: relMSE (docs/film.md) without the
reference's own noise, so that it need not have many more samples than the pictures. The difference of two renderers,
(a1 - a2)(b1 - b2) / (r2^2 + 0.01), is free of both noises too.
"""

import math
from dataclasses import dataclass

import numpy as np

_TRIMMED = 0.001  # part of the pixels that the trimmed error leaves out
_FARTHEST = 2  # times the samples of the highest rung: nothing is said beyond


def Errors(picture, halves) -> tuple[float, float]:
    """(relMSE, relMSE without the 0.1 % of pixels that are furthest off)."""
    a, b = halves
    reference = (a + b) / 2
    weight = 1 / (reference**2 + 0.01)
    pixels = np.mean((picture - a) * (picture - b) * weight, -1).ravel()
    rank = np.argsort(np.mean((picture - reference) ** 2 * weight, -1).ravel())
    return float(pixels.mean()), float(pixels[rank[: len(rank) - round(_TRIMMED * len(rank))]].mean())


def Bias(mine: tuple, theirs: tuple) -> tuple[float, float]:
    """(ratio of mean radiance mine / theirs, relMSE of mine against theirs without their noise)."""
    weight = 1 / (((theirs[0] + theirs[1]) / 2) ** 2 + 0.01)
    square = (mine[0] - theirs[0]) * (mine[1] - theirs[1]) * weight
    return float((mine[0] + mine[1]).mean() / (theirs[0] + theirs[1]).mean()), float(square.mean())


def IsHighEnough(seconds: list, error: float, goal: float, longest: float) -> bool:
    """Whether a ladder may end at its last rung: the goal is reached, and samples take most of the time, not what a render costs
    by itself (Dr.Jit traces each instance anew, which takes 20 seconds of a forest). Or the next rung would take too long."""
    isMostlySamples = seconds[-1] >= 2 * seconds[0]
    return (error <= goal and isMostlySamples) or 2 * seconds[-1] > longest


def FitSeconds(samples: list, seconds: list) -> tuple[float, float]:
    """(fixed, a sample) of seconds = fixed + samples * a sample, by least squares of relative errors; fixed >= 0."""
    n, t = np.array(samples, float), np.array(seconds, float)
    if len(n) > 1:
        fixed, slope = np.linalg.lstsq(np.stack([1 / t, n / t], 1), np.ones(len(n)), rcond=None)[0]
        if fixed >= 0 and slope > 0:
            return float(fixed), float(slope)
    return 0.0, float(np.sum(n / t) / np.sum((n / t) ** 2))


@dataclass
class Ladder:
    """Rungs of one renderer on one stage: samples ascend; errors are means over the repeats; seconds[repeat][rung] as measured."""

    samples: list
    errors: list
    seconds: list

    def __post_init__(self):
        fits = [FitSeconds(self.samples, row) for row in self.seconds]
        self.fixed, self.perSample = ([fit[i] for fit in fits] for i in (0, 1))  # of each repeat

    def SamplesTo(self, error: float) -> float | None:
        """Between rungs by the logarithms of both; the lowest rung if that is good enough; None where it would be more than
        twice the highest."""
        n, e = np.log(self.samples), np.log(np.maximum(self.errors, 1e-12))
        goal = math.log(error)
        reached = np.flatnonzero(e <= goal)
        if len(reached) == 0:
            power = max(-np.polyfit(n[-3:], e[-3:], 1)[0], 0.25) if len(n) > 1 else 1.0
            beyond = (e[-1] - goal) / power
            return math.exp(n[-1] + beyond) if beyond <= math.log(_FARTHEST) else None
        i = int(reached[0])
        if i == 0:
            return float(self.samples[0])
        return math.exp(n[i - 1] + (n[i] - n[i - 1]) * (e[i - 1] - goal) / (e[i - 1] - e[i]))

    def SecondsTo(self, error: float) -> list | None:
        """Of each repeat, as measured: linear between rungs."""
        count = self.SamplesTo(error)
        if count is None:
            return None
        more = max(count - self.samples[-1], 0.0)
        return [float(np.interp(count, self.samples, row)) + more * each for row, each in zip(self.seconds, self.perSample)]

    def SamplingSecondsTo(self, error: float) -> list | None:
        """Of each repeat, without what a render costs whatever its samples."""
        count = self.SamplesTo(error)
        return None if count is None else [count * each for each in self.perSample]


def Ratio(mine: list | None, theirs: list | None) -> tuple | None:
    """(median, least, largest) of mine / theirs, repeat by repeat: the repeats of all renderers took turns."""
    if mine is None or theirs is None:
        return None
    ratios = [a / b for a, b in zip(mine, theirs)]
    return float(np.median(ratios)), min(ratios), max(ratios)
