# SPDX-License-Identifier: Apache-2.0
"""Two builds of hdStream by turns on the stages of rivals.py: CPU seconds of rendering, and pixels that differ.

    buildsInTurns.py BEFORE [--stages chess,grove] [--scenes FOLDER] [--samples 64] [--repeats 5]

BEFORE is the folder of the other build that PYTHONPATH would name (build/release/python); the one here is that which this Python
imports. Each build stays in a process of its own with its own kernels, after a picture that compiles and prepares what is needed, and
one of them renders at a time. The seconds are those of the process, so that of preparation only what each render does again counts.
"""

import argparse
import json
import os
import pathlib
import sys
import tempfile

_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent), str(_HERE.parent / "render")]

import numpy as np  # noqa: E402

import everydayStages  # noqa: E402
import rivalsStages  # noqa: E402
from smoothSurfaces import Renderer  # noqa: E402


def _Compare(name: str, args, folder: pathlib.Path) -> None:
    stage = rivalsStages.Make(name, args.scenes, folder)
    job = dict(stage=stage.path, camera=stage.camera, width=args.width, height=round(args.width * 0.75), maxDepth=stage.maxDepth,
               threads=args.threads, renderer="hdstream")
    renderers = {"here": Renderer(__file__, job, None, folder), "before": Renderer(__file__, job, None, folder, args.before)}
    seconds = {who: [] for who in renderers}
    differ = 0
    for repeat in range(args.repeats + 1):
        pictures = []
        for who, renderer in renderers.items():
            picture, took = renderer.Render(args.samples, 1 + repeat)
            pictures.append(picture)
            if repeat:
                seconds[who].append(took)
        differ += int(np.any(pictures[0] != pictures[1], axis=-1).sum())
    for renderer in renderers.values():
        renderer.Close()
    here, before = np.array(seconds["here"]), np.array(seconds["before"])
    ratios = here / before
    print(f"{name}: {np.median(here):.2f} s here, {np.median(before):.2f} s before, ratio {np.median(ratios):.3f} ({ratios.min():.3f} to "
          f"{ratios.max():.3f}), {differ} pixels unlike, load {os.getloadavg()[0]:.1f}", flush=True)


def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", metavar="BEFORE")
    parser.add_argument("--stages", help="of rivals.py; default: as there")
    parser.add_argument("--scenes", help="the folder of real scenes")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()
    names = args.stages.split(",") if args.stages else rivalsStages.Default(args.scenes)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            _Compare(name, args, pathlib.Path(folder))


if __name__ == "__main__":
    if "--work" in sys.argv:
        everydayStages.Work(json.loads(sys.argv[sys.argv.index("--work") + 1]))
    Main()
