# SPDX-License-Identifier: Apache-2.0
"""References and ladders of one stage: runs workers, keeps references, and turns pictures into numbers.

A renderer's reference is two independent halves. The error of a picture x against the halves a, b is the mean of
(x - a)(x - b) / (r^2 + 0.01), r = (a + b) / 2, over pixels and channels: relMSE (docs/film.md) without the
reference's own noise, so that it need not have many more samples than the pictures. The difference of two renderers,
(a1 - a2)(b1 - b2) / (r2^2 + 0.01), is free of both noises too.
"""

import hashlib
import importlib.util
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field

import numpy as np

_HERE = pathlib.Path(__file__).resolve().parent
_LONGER, _MOST_CLIMBS = 4, 3
_TRIMMED = 0.001  # part of the pixels that the trimmed error leaves out


class RunFailed(RuntimeError):
    """The worker's own last line."""


@dataclass
class Result:
    """One renderer on one stage."""

    renderer: str
    pixels: int
    reference: tuple  # two halves
    samples: list
    seconds: list  # of each rung, as measured
    errors: list
    trimmed: list
    worker: dict = field(default_factory=dict)  # importSeconds, buildSeconds, firstSeconds, peakBytes

    def __post_init__(self):
        self.fixed, self.perSample = FitSeconds(self.samples, self.seconds)
        self.factor, self.power = FitError(self.samples, self.errors)

    def SecondsTo(self, error: float) -> float:
        """Rendering seconds until the relMSE is `error`, by the fits; what a render costs whatever its samples left out."""
        return self.perSample * (self.factor / error) ** (1 / self.power)

    def IsFarFrom(self, error: float) -> bool:
        """True where `error` lies more than a factor of 4 outside of what was measured."""
        return not min(self.errors) / 4 <= error <= max(self.errors) * 4

    def FirstPixelSeconds(self) -> float:
        return self.worker["buildSeconds"] + self.worker["firstSeconds"]


def FitSeconds(samples: list, seconds: list) -> tuple[float, float]:
    """(fixed, a sample) of seconds = fixed + samples * a sample, by least squares of relative errors; fixed >= 0."""
    n, t = np.array(samples, float), np.array(seconds, float)
    if len(n) > 1:
        fixed, slope = np.linalg.lstsq(np.stack([1 / t, n / t], 1), np.ones(len(n)), rcond=None)[0]
        if fixed >= 0 and slope > 0:
            return float(fixed), float(slope)
    return 0.0, float(np.sum(n / t) / np.sum((n / t) ** 2))


def FitError(samples: list, errors: list) -> tuple[float, float]:
    """(factor, power) of error = factor * samples^-power, by least squares of logarithms; power within 0.5 and 2."""
    n, e = np.log(samples), np.log(np.maximum(errors, 1e-12))
    power = -np.polyfit(n, e, 1)[0] if len(n) > 1 else 1.0
    power = min(max(float(power), 0.5), 2.0)
    return math.exp(float(np.mean(e + power * n))), power


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


def IsInstalled(renderer: str) -> bool:
    module = {"mitsuba": "mitsuba", "cycles": "bpy"}.get(renderer.split()[0], "hdstream")
    return importlib.util.find_spec(module) is not None


def _Run(job: dict, cache: pathlib.Path) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "job.json"
        path.write_text(json.dumps(job))
        environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": str(job["threads"]), "HDSTREAM_CACHE_DIR": str(cache / "hdstream")}
        try:
            run = subprocess.run([sys.executable, str(_HERE / "rivalsWorker.py"), str(path)], capture_output=True, text=True,
                                 env=environment, timeout=job["limit"])
        except subprocess.TimeoutExpired as error:
            raise RunFailed(f"{job['renderer']}: not done after {job['limit']} s") from error
    for line in reversed(run.stdout.splitlines()):
        if line.startswith("RESULT "):
            return json.loads(line[7:])
    last = (run.stderr.strip() or run.stdout.strip() or "no output").splitlines()[-1]
    raise RunFailed(f"{job['renderer']}: exit code {run.returncode}: {last}")


def _Digest(job: dict) -> str:
    """Of what the reference depends on: the job, the stage file, and the code that translates it."""
    stage = pathlib.Path(job["stage"]).stat()
    kept = {name: value for name, value in job.items() if name not in ("scene", "limit")}
    digest = hashlib.sha256(json.dumps([kept, stage.st_size, stage.st_mtime_ns], sort_keys=True).encode())
    if job["renderer"] == "hdstream":
        files = [next(pathlib.Path(importlib.util.find_spec("hdstream").origin).parent.glob("_core*.so")), _HERE / "rivalsWorker.py"]
    else:
        files = [_HERE / "rivalsScene.py", _HERE / ("rivalsCycles.py" if job["renderer"] == "cycles" else "rivalsMitsuba.py"),
                 _HERE.parent / "render/stageReader.py", _HERE.parent / "render/mitsubaScene.py", _HERE.parent / "render/previewBsdf.py"]
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def Reference(job: dict, samples: int, cache: pathlib.Path) -> tuple:
    """The two halves, of `samples` together; rendered unless they are kept. Modes of hdStream share theirs."""
    renderer = "hdstream" if job["renderer"].startswith("hdstream") else job["renderer"]
    job = dict(job, renderer=renderer, renders=[(samples // 2, 101), (samples // 2, 102)])
    stem = cache / f"reference-{pathlib.Path(job['stage']).stem}-{renderer.replace(' ', '-')}-{_Digest(job)}-"
    paths = [pathlib.Path(f"{stem}{i}.npy") for i in range(2)]
    if not all(path.exists() for path in paths):
        _Run(dict(job, out=str(stem)), cache)
    return tuple(np.load(path).astype(np.float64) for path in paths)


def IsLongEnough(samples: list, seconds: list) -> bool:
    """Whether what a sample costs is more than the noise of what a render costs by itself: Dr.Jit traces each instance anew, which
    takes 20 seconds of a forest whatever the samples."""
    fixed, perSample = FitSeconds(samples, seconds)
    return fixed <= perSample * samples[-1]


def Measure(job: dict, ladder: list, repeat: int, referenceSamples: int, cache: pathlib.Path) -> Result:
    """Renders the ladder `repeat` times with different seeds: errors are means, seconds the least. A ladder that is not long
    enough is rendered again with _LONGER times the samples, at most _MOST_CLIMBS times."""
    halves = Reference(job, referenceSamples, cache)
    result = _Climb(job, ladder, repeat, halves, cache)
    for _ in range(_MOST_CLIMBS):
        if IsLongEnough(result.samples, result.seconds):
            break
        result = _Climb(job, [_LONGER * samples for samples in result.samples], repeat, halves, cache)
    return result


def _Climb(job: dict, ladder: list, repeat: int, halves: tuple, cache: pathlib.Path) -> Result:
    renders = [(samples, 1 + i) for i in range(repeat) for samples in ladder]
    with tempfile.TemporaryDirectory() as folder:
        worker = _Run(dict(job, renders=renders, out=f"{folder}/picture"), cache)
        errors = np.array([Errors(np.load(f"{folder}/picture{i}.npy").astype(np.float64), halves) for i in range(len(renders))])
    errors = errors.reshape(repeat, len(ladder), 2).mean(0)
    seconds = np.array(worker["seconds"]).reshape(repeat, len(ladder)).min(0)
    return Result(job["renderer"], job["width"] * job["height"], halves, list(ladder), seconds.tolist(), errors[:, 0].tolist(),
                  errors[:, 1].tolist(), worker)
