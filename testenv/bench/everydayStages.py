# SPDX-License-Identifier: Apache-2.0
"""Stages of ordinary kinds (stages/everyday.py, stages/rooms.py): relMSE times CPU seconds of hdStream, with one folder of kernels or
two, and of Mitsuba's llvm variant.

    everydayStages.py [--stages corridor,curtains,kitchen,bathroom,product,foliage] [--before KERNELS] [--mitsuba llvm,preview] [--samples 64]

Every renderer stays in a process of its own, and one renders at a time, in turns, after a picture that compiles what is to be compiled;
each with the settings that it has by itself, Russian roulette too. Errors are against a reference of the renderer's own, in two
halves (rivalsLadder.py), so that neither what differs between formulas nor the reference's noise counts. Printed for each: CPU seconds,
relMSE, the same without the 0.1 % of pixels that are furthest off, and hdStream's figures over those. `preview` is Mitsuba with
UsdPreviewSurface's own formula (rivalsMitsuba.py). --mitsuba needs the Python module and an LLVM that it can use, by
DRJIT_LIBLLVM_PATH (rivals.py).
"""

import argparse
import json
import os
import pathlib
import sys
import tempfile
import time

_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent), str(_HERE.parent / "render")]

import numpy as np  # noqa: E402

import inTurns  # noqa: E402
from stages import everyday, rooms  # noqa: E402

_KERNELS = _HERE.parents[1] / "kernels"
_ROULETTE = 5  # Mitsuba's default
_ROOMS = {"skyRoom": rooms.WriteSkyRoom, "sunRoom": rooms.WriteSunRoom, "panelRoom": rooms.WritePanelRoom}
_WRITERS = {**everyday.WRITERS, **_ROOMS}


def _BuildHdStream(job: dict):
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(job["stage"]), session, Usd.TimeCode.Default())
    options = _core.Settings()
    settings = dict(camera=job.get("camera", "/World/Camera"), imageWidth=job["width"], imageHeight=job["height"],
                    maxDepth=job["maxDepth"], pixelFilter="box", pixelFilterWidth=1.0)
    for name, value in settings.items():
        setattr(options, name, value)

    def Render(samples: int, seed: int) -> np.ndarray:
        options.samples, options.seed = samples, seed
        session.Render(options)
        return np.array(session.Layers()[0].pixels[..., :3], np.float32)

    return Render


def _BuildMitsuba(job: dict):
    import rivalsMitsuba
    import rivalsScene

    scene = rivalsScene.Read(job["stage"], "/World/Camera")
    render, _ = rivalsMitsuba.Build(scene, dict(job, rouletteDepth=_ROULETTE))
    import drjit
    drjit.set_thread_count(job["threads"])  # loading may have set it
    return lambda samples, seed: np.array(render(samples, seed), np.float32)


def Work(job: dict) -> None:
    """Renders what lines of the input ask for, and tells the CPU seconds."""
    render = (_BuildHdStream if job["renderer"] == "hdstream" else _BuildMitsuba)(job)
    for line in sys.stdin:
        wanted = json.loads(line)
        begin = time.process_time()
        picture = render(wanted["samples"], wanted["seed"])
        seconds = time.process_time() - begin
        np.save(wanted["out"], picture)
        print(f"SECONDS {seconds}", flush=True)
    os._exit(0)


def _Compare(name: str, args, folder: pathlib.Path) -> None:
    from smoothSurfaces import Renderer

    path = folder / f"{name}.usdc"
    _WRITERS[name](str(path))
    aspect = 4 / 3
    job = dict(stage=str(path), width=args.width, height=round(args.width / aspect), threads=args.threads,
               maxDepth=everyday.MAX_DEPTH.get(name, rooms.MAX_DEPTH))
    new = lambda renderer, kernels: Renderer(__file__, dict(job, renderer=renderer), kernels, folder)
    renderers = {"here": new("hdstream", args.kernels)}
    if args.before:
        renderers["before"] = new("hdstream", args.before)
    for kind in filter(None, args.mitsuba.split(",")):
        renderers[kind] = new(f"mitsuba {kind}", None)
    inTurns.Compare(name, renderers, job, args)



def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stages", default=",".join(everyday.WRITERS), help=f"of {', '.join(_WRITERS)}")
    parser.add_argument("--kernels", default=str(_KERNELS), help="folder of the kernels; default: those here")
    parser.add_argument("--before", help="folder of other kernels")
    parser.add_argument("--mitsuba", default="", help="llvm, preview or both")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--reference", type=int, default=2048)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--work", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.work:
        Work(json.loads(args.work))
    with tempfile.TemporaryDirectory() as folder:
        for name in args.stages.split(","):
            _Compare(name, args, pathlib.Path(folder))


if __name__ == "__main__":
    Main()
