# SPDX-License-Identifier: Apache-2.0
"""Adaptive sampling (`--noise`) against plain sample counts on stages of uneven noise: what equal error takes, and whether a
pixel's own estimate of its error is honest."""

import dataclasses

import numpy as np
from bench.curves import CurveChart
from bench.performancePage import Table
from bench.sceneRun import REFERENCE_SEED, Point, RelMse, Scene, SecondsAt
from stages import unevenNoise

_FLOOR = 0.01  # below the square of the luminance, as film_relativeError has it
_LUMINANCE = (0.2126, 0.7152, 0.0722)
_TAIL = 95  # percentile


@dataclasses.dataclass
class Picture:
    """Of one seed and threshold."""

    color: np.ndarray
    counts: np.ndarray
    seconds: float


def Render(scene: Scene, noise: float, maxSamples: int, seed: int) -> Picture:
    color, statistics = scene.Render(maxSamples, noise=noise, seed=seed, aovs=["color", "sampleCount"])
    return Picture(color, scene.Layer("sampleCount").reshape(color.shape[:2]), statistics["time"]["render"])


def TailError(picture, reference) -> float:
    """What relMSE is the mean of: the value that the worst 5 % of the pixels exceed."""
    return float(np.percentile(((picture - reference) ** 2 / (reference**2 + 0.01)).mean(axis=-1), _TAIL))


def Points(pictures: list, reference) -> list:
    """[error against seconds, error against samples, the tail's error against samples], means over the pictures."""
    mean, seconds = (float(np.mean([value(picture) for picture in pictures])) for value in
                     (lambda picture: picture.counts.mean(), lambda picture: picture.seconds))
    error, tail = (float(np.mean([measure(picture.color, reference) for picture in pictures])) for measure in (RelMse, TailError))
    return [Point(round(mean), seconds, error, {}), Point(round(mean), mean, error, {}), Point(round(mean), mean, tail, {})]


def Honesty(pictures: list, reference, noise: float, maxSamples: int) -> list:
    """How the errors of pixels that stopped compare with the threshold that they claim to meet: their percentage, root mean
    square error over the threshold, percentage of errors beyond three thresholds, bias of whole pictures in percent."""
    truth = reference @ _LUMINANCE
    errors, biases, isStopped = [], [], np.stack([picture.counts < maxSamples for picture in pictures])
    for picture in pictures:
        difference = picture.color @ _LUMINANCE - truth
        errors.append(difference / np.sqrt(truth**2 + _FLOOR))
        biases.append(difference.mean() / truth.mean())
    ofStopped = np.stack(errors)[isStopped]
    ofThem = [None, None]
    if ofStopped.size:
        ofThem = [float(np.sqrt(np.mean(ofStopped**2)) / noise), 100 * float(np.mean(np.abs(ofStopped) > 3 * noise))]
    return [100 * float(isStopped.mean()), *ofThem, 100 * float(np.mean(biases))]


def _Stage(bench, name: str, path: str, camera: str, rows: list, honesty: list) -> list:
    width, maxSamples = bench.Pick((96, 1024), (32, 64))
    seeds = range(1, bench.Pick(2, 1) + 1)
    scene = Scene(path, camera, imageWidth=width, imageHeight=width * 9 // 16)
    reference, _ = scene.Render(bench.Pick(2048, 64), seed=REFERENCE_SEED)
    scene.Render(1)
    plain = [Points([Render(scene, 0.0, samples, seed) for seed in seeds], reference)
             for samples in bench.Pick((16, 32, 64, 128, 256, 512), (16, 32, 48))]
    adaptive = []
    for noise in bench.Pick((0.2, 0.1, 0.05), (0.5, 0.2)):
        pictures = [Render(scene, noise, maxSamples, seed) for seed in seeds]
        points = Points(pictures, reference)
        adaptive.append(points[0])
        equal = [SecondsAt(list(curve), point.error) for curve, point in zip(zip(*plain), points)]
        ratios = [value / point.seconds if value else None for value, point in zip(equal, points)]
        most = int(max(picture.counts.max() for picture in pictures))
        rows.append([name, noise, points[1].seconds, most, points[0].seconds, points[0].error, *ratios])
        honesty.append([name, noise, *Honesty(pictures, reference, noise, maxSamples)])
    return [(f"adaptive-{name}", CurveChart(f"adaptive sampling, {name}", {"plain": [points[0] for points in plain], "--noise": adaptive}))]


def Run(bench) -> list:
    rows, honesty, charts = [], [], []
    stages = {name: (bench.Stage(name, write), "/World/Camera") for name, write in unevenNoise.STAGES.items()}
    for name, (path, camera) in {**stages, **bench.Real("chess")}.items():
        charts += _Stage(bench, name, path, camera, rows, honesty)
    return ["What plain sample counts take for equal error, over what adaptive sampling takes (over 1: adaptive is better):",
            Table("adaptive", ["stage", "--noise", "samples, mean", "most", "s", "relMSE", "seconds ratio", "samples ratio",
                               "samples ratio for the worst 5 %"], rows),
            *charts,
            "Pixels that stopped: the error of their luminance over the threshold that they claim to meet (honest: at most 1); how "
            "many miss it by a factor of three (honest: 0.3 %); the bias of the whole picture:",
            Table("adaptive-honesty", ["stage", "--noise", "stopped, %", "root mean square error over the threshold",
                                       "beyond three thresholds, %", "bias of the mean, %"], honesty)]
