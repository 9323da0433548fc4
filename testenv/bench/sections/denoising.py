# SPDX-License-Identifier: Apache-2.0
"""Denoising by Open Image Denoise (`--denoise`) on and off: error against time, and what bias remains."""

import time

import numpy as np
from bench.curves import CurveChart
from bench.performancePage import LeftOut, Table
from bench.sceneRun import REFERENCE_SEED, Point, RelMse, Scene, SecondsAt
from hdstream import _core
from hdstream.denoiser import FindDenoiser
from stages.verify import CASES


def _Render(scene: Scene, samples: int, seed: int, **settings) -> tuple:
    """(picture, seconds with the denoising)."""
    _, statistics = scene.Render(samples, seed=seed, **settings)
    start = time.perf_counter()
    picture = scene.Layer("color")[..., :3]
    return picture, statistics["time"]["render"] + time.perf_counter() - start


def _Bias(pictures, reference) -> float:
    """The error of the mean of pictures of different seeds without the noise that is left in it (relMSE): what more samples of
    the same count do not take away. Estimated from two halves, whose noise is independent."""
    halves = [np.mean(pictures[i::2], axis=0, dtype=np.float64) for i in (0, 1)]
    return float(np.mean((halves[0] - reference) * (halves[1] - reference) / (reference.astype(np.float64) ** 2 + 0.01)))


def Run(bench) -> list:
    FindDenoiser()
    try:
        _core.CheckDenoiser()
    except _core.Error as error:
        raise LeftOut(str(error)) from None
    stages = {"fiveLights": (bench.Stage("fiveLights", CASES["fiveLights"].Write), "/World/Camera"), **bench.Real("chess", "bookstore")}
    rows, charts = [], []
    for name, (path, camera) in stages.items():
        width = bench.Pick(160, 32)
        scene = Scene(path, camera, imageWidth=width, imageHeight=width * 2 // 3)
        reference, _ = scene.Render(bench.Pick(1024, 32), seed=REFERENCE_SEED)
        curves = {}
        for label, settings in (("samples", {}), ("denoised", {"denoise": True})):
            _Render(scene, 1, 1, **settings)
            curves[label] = []
            for samples in bench.Pick((1, 4, 16, 64), (1, 2)):
                runs = [_Render(scene, samples, seed, **settings) for seed in range(1, bench.Pick(4, 2) + 1)]
                pictures = [picture for picture, _ in runs]
                point = Point(samples, float(np.mean([seconds for _, seconds in runs])),
                              float(np.mean([RelMse(picture, reference) for picture in pictures])), {})
                curves[label].append(point)
                if label == "denoised":
                    plain = SecondsAt(curves["samples"], point.error)
                    rows.append([name, samples, curves["samples"][len(curves[label]) - 1].error, point.error,
                                 _Bias(pictures, reference), point.seconds, plain / point.seconds if plain else None])
        charts.append((f"denoising-{name}", CurveChart(f"denoising, {name}", curves)))
    return [*charts,
            Table("denoising", ["stage", "samples", "relMSE", "denoised", "of that bias", "s", "s of samples for equal error, over that"],
                  rows)]
