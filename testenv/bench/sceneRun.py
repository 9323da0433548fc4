# SPDX-License-Identifier: Apache-2.0
"""Renders of one stage in this process, for benches that compare settings: translated once, kernels and prepared pages stay,
so that what differs is the settings. Error against time of them as curves."""

import dataclasses
import json
import math

import numpy as np
from hdstream import _core
from hdstream.translate import TranslateStage
from pxr import Usd

REFERENCE_SEED = 7777  # no sample of the reference is one of what is compared with it


class Scene:
    """A stage in a session. `settings`: of all renders, by their names in hdstream's Settings."""

    def __init__(self, path, camera: str, timeCode=Usd.TimeCode.Default(), shutter=(0.0, 0.0), **settings):
        self.session = _core.Session()
        self.settings = dict(camera=camera, **settings)
        TranslateStage(Usd.Stage.Open(str(path)), self.session, timeCode, shutter)

    def Render(self, samples: int, **settings):
        """(color [height][width][3] floats, statistics)."""
        options = _core.Settings()
        for name, value in {**self.settings, "samples": samples, **settings}.items():
            setattr(options, name, value)
        self.session.Render(options)
        return self.Layer("color")[..., :3], json.loads(self.session.Statistics())

    def Layer(self, name: str) -> np.ndarray:
        """Of the last render."""
        return next(np.array(layer.pixels) for layer in self.session.Layers() if layer.name == name)


def TracingSeconds(statistics: dict) -> float:
    """Without what preparing and compiling take, which `time.render` of a first render holds."""
    return sum(statistics["time"][key] for key in ("trace", "shade", "requests", "transfer"))


def RelMse(picture, reference) -> float:
    """docs/film.md: the mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels."""
    picture, reference = picture.astype(np.float64), reference.astype(np.float64)
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01)))


@dataclasses.dataclass
class Point:
    """Of a curve: a render."""

    samples: int
    seconds: float  # time.render
    error: float  # relMSE
    statistics: dict


def Curve(scene: Scene, reference, sampleCounts, seeds=(0,), **settings) -> list:
    """Points of one setting, means over the seeds. A short render before them builds kernels and prepares geometry."""
    scene.Render(1, **settings)
    points = []
    for samples in sampleCounts:
        runs = [scene.Render(samples, seed=seed, **settings) for seed in seeds]
        points.append(Point(samples, float(np.mean([run["time"]["render"] for _, run in runs])),
                            float(np.mean([RelMse(picture, reference) for picture, _ in runs])), runs[0][1]))
    return points


def SecondsAt(points: list, error: float):
    """Seconds that a curve takes to come down to an error, by lines between its points in logarithms; None beyond its ends."""
    for a, b in zip(points, points[1:]):
        if a.error >= error >= b.error and a.error > b.error:
            share = math.log(a.error / error) / math.log(a.error / b.error)
            return a.seconds * (b.seconds / a.seconds) ** share
    return None
