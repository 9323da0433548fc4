# SPDX-License-Identifier: Apache-2.0
"""One renderer in a process of its own: rivalsWorker.py JOB.json. Builds the scene and renders what the job asks for: each
(samples, seed) of `renders`, or a ladder of doubled samples up to `goal`; prints seconds, errors and peak memory as JSON.

hdStream reads the stage; rivals are handed the plain scene. A job's first picture is not timed with the others: it builds
acceleration structures and compiles what is not in the renderer's own cache of kernels. It counts for the time to the first pixel.
"""

import itertools
import json
import os
import pathlib
import resource
import sys
import time

_START = time.perf_counter()
_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent), str(_HERE.parent / "render")]

import numpy as np  # noqa: E402

import rivalsLadder  # noqa: E402

_CHUNK_BYTES = 1 << 16  # small, because the stages are: 30 % of the bookstore is 300 KB
MODES = {
    "hdstream": dict(residency="resident"),
    "hdstream 100%": dict(residency="stream", geometryMemory="100%", chunkBytes=_CHUNK_BYTES),
    "hdstream 30%": dict(residency="stream", geometryMemory="30%", chunkBytes=_CHUNK_BYTES),
}
RENDERERS = (*MODES, "mitsuba scalar", "mitsuba llvm", "mitsuba preview", "cycles")


def _PeakBytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _BuildHdStream(job: dict):
    """render(samples, seed), as testenv/render/ours.py renders, of a session that stays; and no counts to warm up."""
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(job["stage"]), session, Usd.TimeCode.Default())
    options = _core.Settings()
    settings = dict(camera=job["camera"], imageWidth=job["width"], imageHeight=job["height"], maxDepth=job["maxDepth"],
                    subdivision="cage", pixelFilter="box", pixelFilterWidth=1.0, russianRoulette=False, **MODES[job["renderer"]])
    for name, value in settings.items():
        setattr(options, name, value)

    def Render(samples: int, seed: int) -> np.ndarray:
        options.samples, options.seed = samples, seed
        session.Render(options)
        return np.array(session.Layers()[0].pixels[..., :3], np.float64)

    return Render, lambda samples: []


def Fit(camera: dict, width: int, height: int) -> None:
    """Expands the aperture to the picture's aspect ratio, as hdStream does."""
    if camera["width"] * height < camera["height"] * width:
        camera["width"] = camera["height"] * width / height
    else:
        camera["height"] = camera["width"] * height / width


def _BuildRival(job: dict):
    import rivalsScene

    if job["renderer"] == "cycles":
        import rivalsCycles as rival
    else:
        import rivalsMitsuba as rival
    scene = rivalsScene.Load(job["scene"])
    Fit(scene.camera, job["width"], job["height"])
    exposure = scene.camera["exposure"]
    render, warmUp = rival.Build(scene, job)
    return lambda samples, seed: exposure * render(samples, seed), warmUp


class _Timer:
    """Renders with the clock running, once what a count of samples needs is warm."""

    def __init__(self, render, warmUp, clock):
        self._render, self._warmUp, self._warm = render, warmUp, set()
        self._clock = time.process_time if clock == "cpu" else time.perf_counter

    def Render(self, samples: int, seed: int) -> tuple[np.ndarray, float]:
        for count in self._warmUp(samples):
            if count not in self._warm:
                self._render(count, 998)
                self._warm.add(count)
        begin = self._clock()
        picture = self._render(samples, seed)
        return picture, self._clock() - begin


def _Climb(timer: _Timer, job: dict) -> dict:
    """The rungs of job["ladder"], or, where there is none yet, 1, 2, 4, ... samples until rivalsLadder.IsHighEnough."""
    halves = [np.load(path).astype(np.float64) for path in job["halves"]]
    rungs = iter(job["ladder"]) if job["ladder"] else (1 << i for i in itertools.count())
    climb = dict(samples=[], seconds=[], errors=[])
    for samples in rungs:
        picture, seconds = timer.Render(samples, job["seed"])
        climb["samples"].append(samples)
        climb["seconds"].append(seconds)
        climb["errors"].append(rivalsLadder.Errors(picture, halves))
        if not job["ladder"] and rivalsLadder.IsHighEnough(climb["seconds"], climb["errors"][-1][0], job["goal"], job["longest"]):
            break
    return climb


def _Save(timer: _Timer, job: dict) -> dict:
    for number, (samples, seed) in enumerate(job["renders"]):
        np.save(f"{job['out']}{number}.npy", timer.Render(samples, seed)[0].astype(np.float32))
    return {}


def Work(job: dict) -> dict:
    start = time.perf_counter()
    render, warmUp = _BuildHdStream(job) if job["renderer"] in MODES else _BuildRival(job)
    built = time.perf_counter()
    render(1, 999)
    first = time.perf_counter()
    done = (_Save if "renders" in job else _Climb)(_Timer(render, warmUp, job["clock"]), job)
    return dict(done, importSeconds=start - _START, buildSeconds=built - start, firstSeconds=first - built, peakBytes=_PeakBytes())


if __name__ == "__main__":
    _job = json.loads(pathlib.Path(sys.argv[1]).read_text())
    print("RESULT " + json.dumps(Work(_job)), flush=True)
    sys.stdout.flush()
    os._exit(0)  # Blender and Dr.Jit may take long to take themselves down, or fail at it
