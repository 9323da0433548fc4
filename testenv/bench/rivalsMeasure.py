# SPDX-License-Identifier: Apache-2.0
"""References and ladders of one stage: runs a worker for each renderer and repeat, in turns, and keeps references."""

import hashlib
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field

import numpy as np

from rivalsLadder import Ladder

_HERE = pathlib.Path(__file__).resolve().parent


class RunFailed(RuntimeError):
    """The worker's own last line."""


@dataclass
class Result:
    """One renderer on one stage."""

    renderer: str
    pixels: int
    reference: tuple  # two halves
    ladder: Ladder
    trimmed: list  # errors of each rung without the worst pixels
    worker: dict = field(default_factory=dict)  # buildSeconds, firstSeconds, peakBytes: the least of all repeats

    def FirstPixelSeconds(self) -> float:
        return self.worker["buildSeconds"] + self.worker["firstSeconds"]


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
    kept = {name: value for name, value in job.items() if name not in ("scene", "limit", "goal", "longest", "clock")}
    digest = hashlib.sha256(json.dumps([kept, stage.st_size, stage.st_mtime_ns], sort_keys=True).encode())
    if job["renderer"] == "hdstream":
        files = [next(pathlib.Path(importlib.util.find_spec("hdstream").origin).parent.glob("_core*.so")), _HERE / "rivalsWorker.py"]
    else:
        files = [_HERE / "rivalsScene.py", _HERE / ("rivalsCycles.py" if job["renderer"] == "cycles" else "rivalsMitsuba.py"),
                 _HERE.parent / "render/stageReader.py", _HERE.parent / "render/mitsubaScene.py", _HERE.parent / "render/previewBsdf.py"]
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def Reference(job: dict, samples: int, cache: pathlib.Path) -> list:
    """The files of the two halves, of `samples` together; rendered unless they are kept. Modes of hdStream share theirs."""
    renderer = "hdstream" if job["renderer"].startswith("hdstream") else job["renderer"]
    job = dict(job, renderer=renderer, renders=[(samples // 2, 101), (samples // 2, 102)])
    stem = cache / f"reference-{pathlib.Path(job['stage']).stem}-{renderer.replace(' ', '-')}-{_Digest(job)}-"
    paths = [f"{stem}{i}.npy" for i in range(2)]
    if not all(os.path.exists(path) for path in paths):
        _Run(dict(job, out=str(stem)), cache)
    return paths


def Measure(jobs: list, repeat: int, referenceSamples: int, cache: pathlib.Path) -> tuple[list, list]:
    """(results, lines of what failed) of jobs of one stage, a renderer each. The first repeat climbs until job["goal"]; the others
    take the same rungs with other seeds. Each repeat runs all renderers before the next does."""
    halves, climbs, failures = {}, {}, []
    for number in range(repeat):
        for job in jobs:
            name = job["renderer"]
            print(f"{pathlib.Path(job['stage']).stem}: {name}, repeat {number + 1} of {repeat} ...", file=sys.stderr, flush=True)
            try:
                if number == 0:
                    halves[name], climbs[name] = Reference(job, referenceSamples, cache), []
                elif name not in climbs:
                    continue
                rungs = climbs[name][0]["samples"] if number else None
                climbs[name].append(_Run(dict(job, halves=halves[name], ladder=rungs, seed=1 + number), cache))
            except RunFailed as error:
                failures.append(str(error))
                climbs.pop(name, None)
    return [_Result(job, halves[job["renderer"]], climbs[job["renderer"]]) for job in jobs if job["renderer"] in climbs], failures


def _Result(job: dict, halves: list, climbs: list) -> Result:
    errors = np.mean([climb["errors"] for climb in climbs], 0)
    ladder = Ladder(climbs[0]["samples"], errors[:, 0].tolist(), [climb["seconds"] for climb in climbs])
    least = {name: min(climb[name] for climb in climbs) for name in ("buildSeconds", "firstSeconds", "peakBytes")}
    reference = tuple(np.load(path).astype(np.float64) for path in halves)
    return Result(job["renderer"], job["width"] * job["height"], reference, ladder, errors[:, 1].tolist(), least)
