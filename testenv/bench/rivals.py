# SPDX-License-Identifier: Apache-2.0
"""Equal-error time: hdStream against Mitsuba 3 (scalar, llvm) and Blender's Cycles on the CPU, on real stages.

All renderers draw one scene (rivalsScene.py) at equal size, bounces and threads, with a box filter, no roulette, no clamping, no
denoiser; each with its best sampler, in a process of its own. Against a converged reference of its own, each renders 1, 2, 4,
... samples until its relMSE is below the smallest of --errors. All renderers do so once before any does it again, with other
seeds. Seconds to a stated relMSE lie between two rungs; nothing is said beyond twice the highest. The ratio of two renderers is
the median of the repeats, with the least and the largest. Beside it: how far the renderers' references are from each other,
since a rival that renders something else is not a rival; the time to the first pixel; peak memory of the process.

    python testenv/bench/rivals.py --scenes FOLDER --cache KEPT --out OUT     # FOLDER has chess/, bookstore/, coffee/, ycb/
    python testenv/bench/rivals.py --stages terrain,lambertRoom,rectLight     # small generated stages
    python testenv/bench/rivals.py --stages skyRoom,sunRoom,panelRoom         # interiors (stages/rooms.py)
    python testenv/bench/rivals.py --stages cloud,ink,jade,wax                 # light inside matter (rivalsMatter.py)
    python testenv/bench/rivals.py --short

Needs, in this Python: hdstream on the path, usd-core, and for the rivals mitsuba and bpy (`pip install mitsuba==3.9.1
"bpy==4.5.*"`); a missing one is left out, and said. Mitsuba's llvm variant aborts (exit code -6) with LLVM 14 to 16, which
PoCL brings: let DRJIT_LIBLLVM_PATH name a newer libLLVM.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

import rivalsMeasure  # noqa: E402
import rivalsReport  # noqa: E402
import rivalsStages  # noqa: E402
from rivalsWorker import RENDERERS  # noqa: E402


def _Split(text: str) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()]


def _PlainScene(stage, folder: pathlib.Path) -> tuple[str, float]:
    """(the plain scene as a file, aspect ratio of its camera), read by a process of its own, so that this one stays small."""
    path = folder / f"{stage.name}.plain"
    code = "import json, sys; sys.path[:0] = json.loads(sys.argv[4]); import rivalsScene; scene = rivalsScene.Read(*sys.argv[1:3]); " \
           "rivalsScene.Save(scene, sys.argv[3]); print(*scene.NumTriangles(), scene.camera['width'] / scene.camera['height'])"
    run = subprocess.run([sys.executable, "-c", code, stage.path, stage.camera, str(path), json.dumps(sys.path[:3])],
                         capture_output=True, text=True)
    if run.returncode != 0:
        raise ValueError(run.stderr.strip().splitlines()[-1])
    unique, placed, aspect = run.stdout.split()
    print(f"\n## {stage.name}\n\n{int(unique):,} triangles, {int(placed):,} with instances; {stage.maxDepth} bounces", flush=True)
    return str(path), float(aspect)


def _Size(aspect: float, width: int) -> tuple[int, int]:
    """The longer side is `width`."""
    return (width, round(width / aspect)) if aspect >= 1 else (round(width * aspect), width)


def _Compare(stage, options, cache: pathlib.Path, scratch: pathlib.Path) -> list:
    scene, aspect = _PlainScene(stage, scratch)
    width, height = _Size(aspect, options.width)
    jobs = [dict(renderer=renderer, stage=stage.path, scene=scene, camera=stage.camera, width=width, height=height,
                 maxDepth=stage.maxDepth, threads=options.threads, limit=options.limit, goal=min(options.errors),
                 longest=options.longest, clock=options.clock) for renderer in options.renderers]
    results, failures = rivalsMeasure.Measure(jobs, options.repeat, options.reference, cache)
    for failure in failures:
        print(f"not measured: {failure}")
    if results:
        rivalsReport.PrintStage(stage.name, results, options.errors)
        if options.out:
            rivalsReport.Save(stage.name, results, options.out)
    return results


def _Options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default=os.environ.get("HDSTREAM_SCENES"), help="folder of the real stages (HDSTREAM_SCENES)")
    parser.add_argument("--stages", type=_Split, help="default: all real ones, large ones and rooms; an unknown name lists all")
    parser.add_argument("--renderers", type=_Split, default=list(RENDERERS),
                        help=f"of {', '.join(RENDERERS)}; the first is compared with".replace("%", "%%"))
    parser.add_argument("--width", type=int, default=480, help="of the picture's longer side")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall",
                        help="cpu: seconds of all threads, for machines that others load")
    parser.add_argument("--longest", type=float, default=60, help="seconds of a rung; a ladder that would take longer ends below")
    parser.add_argument("--repeat", type=int, default=3, help="ladders of each renderer, with other seeds, in turns")
    parser.add_argument("--reference", type=int, default=256, help="samples of the references")
    parser.add_argument("--errors", type=lambda text: [float(e) for e in _Split(text)], default=[1e-2, 1e-3],
                        help="relMSE to compare times at")
    parser.add_argument("--limit", type=int, default=3600, help="seconds of a process; a renderer that takes longer is left out")
    parser.add_argument("--cache", type=pathlib.Path, help="folder that keeps references, generated stages and kernels")
    parser.add_argument("--out", type=pathlib.Path, help="folder for CSV, SVG and PNG")
    parser.add_argument("--short", action="store_true", help="one small stage, small pictures: is everything in place?")
    options = parser.parse_args()
    if options.short:
        options.stages, options.width, options.reference, options.repeat = rivalsStages.SHORT, 96, 64, 1
        options.errors = [2e-2, 5e-3]
    unknown = [name for name in options.renderers if name not in RENDERERS]
    if unknown:
        parser.error(f"no renderer {unknown[0]}; there are {', '.join(RENDERERS)}")
    return options


def main() -> int:
    options = _Options()
    missing = [name for name in options.renderers if not rivalsMeasure.IsInstalled(name)]
    options.renderers = [name for name in options.renderers if name not in missing]
    for name in missing:
        print(f"not installed: {name}")
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        cache = (options.cache or pathlib.Path(scratch) / "cache").resolve()
        cache.mkdir(parents=True, exist_ok=True)
        print(f"{options.threads} threads, {options.width} pixels, references of {options.reference} samples")
        for name in options.stages or rivalsStages.Default(options.scenes):
            try:
                stage = rivalsStages.Make(name, options.scenes, cache)
                rows += [(name, result) for result in _Compare(stage, options, cache, pathlib.Path(scratch))]
            except ValueError as error:
                print(f"rivals.py: {error}", file=sys.stderr)
                return 2
    for error in options.errors if rows else ():
        rivalsReport.PrintSummary(rows, error)
    if options.out:
        rivalsReport.SaveTable(rows, options.out / "rivals.csv")
    return 0 if rows else 1


if __name__ == "__main__":
    sys.exit(main())
