# SPDX-License-Identifier: Apache-2.0
"""Whole-path samples per second: hdStream against Mitsuba 3 (scalar, llvm) and Cycles on the CPU.

Same stage, size, bounces and threads; box filter, no roulette, no denoiser. Each renderer runs in a
process of its own, renders twice (few and many samples) and is rated by the difference, so that
loading, building and compiling cancel. The mean radiance is printed next to the rate: a rival that
renders something else is not a rival. Needs, in this Python: hdstream on the path, usd-core, and for
the rivals mitsuba and bpy (`pip install mitsuba==3.9.1 "bpy==4.5.*"`); a missing one is left out.

    python testenv/bench/rivals.py [--stages lambertRoom,terrain] [--width 480] [--threads 2]
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

RENDERERS = ("hdstream", "mitsuba scalar", "mitsuba llvm", "cycles")
_EXTRA = {"hdstream": (8, 72), "mitsuba scalar": (2, 18), "mitsuba llvm": (16, 144), "cycles": (8, 72)}


def _Rate(pixels: int, low: int, high: int, render) -> dict:
    """Calls render(samples) -> mean at both counts after a warm-up and rates the difference."""
    render(low)
    seconds = []
    for samples in (low, high):
        start = time.perf_counter()
        mean = render(samples)
        seconds.append(time.perf_counter() - start)
    return dict(msamples=pixels * (high - low) / max(seconds[1] - seconds[0], 1e-9) / 1e6, mean=mean, seconds=seconds)


def _WorkHdStream(job: dict) -> dict:
    import ours

    def Render(samples):
        return float(ours.Render(job["stage"], job["width"], job["height"], samples=samples, maxDepth=job["maxDepth"]).rgb.mean())

    return _Rate(job["width"] * job["height"], *job["samples"], Render)


def _WorkMitsuba(job: dict) -> dict:
    import numpy as np

    import mitsubaScene
    from stageReader import ReadStage

    mitsubaScene.UseVariant("scalar_rgb" if "scalar" in job["renderer"] else "llvm_ad_rgb")
    mitsubaScene.mi.set_log_level(mitsubaScene.mi.LogLevel.Error)
    import drjit

    drjit.set_thread_count(job["threads"])
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsubaScene.Load(ReadStage(job["stage"]), job["width"], job["height"], job["maxDepth"] + 2, folder)
    seed = iter(range(1000))

    def Render(samples):
        return float(np.array(mitsubaScene.mi.render(scene, spp=samples, seed=next(seed))).mean())

    return _Rate(job["width"] * job["height"], *job["samples"], Render)


def _WorkCycles(job: dict) -> dict:
    import rivalsCycles
    from stageReader import ReadStage

    rivalsCycles.Build(ReadStage(job["stage"]), job["width"], job["height"], job["maxDepth"], job["threads"])
    with tempfile.TemporaryDirectory() as folder:
        return _Rate(job["width"] * job["height"], *job["samples"], lambda n: rivalsCycles.Render(n, f"{folder}/out.exr")[1])


def _Work(job: dict) -> dict:
    return {"hdstream": _WorkHdStream, "cycles": _WorkCycles}.get(job["renderer"], _WorkMitsuba)(job)


def _Measure(job: dict) -> dict | None:
    """The worker's result; None when the renderer is missing or fails (its last line is printed)."""
    environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": str(job["threads"])}
    run = subprocess.run([sys.executable, __file__, "--worker", json.dumps(job)], capture_output=True, text=True, env=environment)
    for line in reversed(run.stdout.splitlines()):
        if line.startswith("RESULT "):
            return json.loads(line[7:])
    print(f"  {job['renderer']}: not measured ({(run.stderr.strip() or 'no output').splitlines()[-1]})")
    return None


def _WriteStage(name: str, folder: str) -> tuple[str, int]:
    """(path, max depth) of a verification case or of the bench terrain."""
    from stages import bench
    from stages.verify import CASES

    path = f"{folder}/{name}.usdc"
    if name in CASES:
        return CASES[name].Write(path), CASES[name].maxDepth
    bench.WriteTerrain(path)
    return path, 4


def main() -> None:
    parser = argparse.ArgumentParser(description="samples per second against other renderers")
    parser.add_argument("--stages", default="lambertRoom,rectLight,terrain")
    parser.add_argument("--renderers", default=",".join(RENDERERS))
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        print("RESULT " + json.dumps(_Work(json.loads(options.worker))), flush=True)
        return
    print(f"{options.threads} threads, width {options.width}; Msamples/s, ratio = hdstream / rival")
    with tempfile.TemporaryDirectory() as folder:
        for name in options.stages.split(","):
            stage, maxDepth = _WriteStage(name, folder)
            height = options.width * 9 // 16 if name == "terrain" else options.width * 3 // 4
            rows = {}
            for renderer in options.renderers.split(","):
                rows[renderer] = _Measure(dict(renderer=renderer, stage=stage, width=options.width, height=height, maxDepth=maxDepth,
                                               threads=options.threads, samples=_EXTRA[renderer]))
            mine = rows.get("hdstream")
            for renderer, row in rows.items():
                if row:
                    ratio = f"{mine['msamples'] / row['msamples']:6.2f}" if mine else "     -"
                    print(f"{name:16s} {renderer:16s} {row['msamples']:8.3f} Msamples/s  ratio {ratio}  mean {row['mean']:.5f}", flush=True)


if __name__ == "__main__":
    main()
