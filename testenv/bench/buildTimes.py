# SPDX-License-Identifier: Apache-2.0
"""What a change costs: two builds render the same stages in turns. buildTimes.py --before BUILD --after BUILD --scenes FOLDER

Chess, coffee and ycb from the rivals' cameras and the generated grove, resident and streamed from 30 %. Each build has one
process; a first render of each stage builds kernels and pages and is not counted. Prints medians of the CPU seconds of
rendering, which other work disturbs less than it does times, of the seconds, and the ratio after / before with its interval
over the repeats. Exit code 1 when a median ratio of CPU seconds is above --bar.
"""

import argparse
import pathlib
import statistics
import sys
import tempfile

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTENV))


def Jobs(names: list, scenes: pathlib.Path, folder: pathlib.Path, samples: int) -> list:
    """(name, stage, settings) as identity.py's."""
    from bench import rivalsStages
    jobs = []
    for name in names:
        stage = rivalsStages.Make(name, str(scenes), folder)
        size = dict(camera=stage.camera, imageWidth=480, imageHeight=270, samples=samples, maxDepth=stage.maxDepth, aovs=["color"])
        jobs.append((f"{name}, resident", stage.path, dict(size, residency=["choice", 1])))
        jobs.append((f"{name}, 30 %", stage.path, dict(size, residency=["choice", 2], geometryMemory="30%", chunkBytes=1 << 18)))
    return jobs


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=pathlib.Path, metavar="BUILD", required=True)
    parser.add_argument("--after", type=pathlib.Path, metavar="BUILD", required=True)
    parser.add_argument("--scenes", type=pathlib.Path, metavar="FOLDER", required=True, help="of real stages")
    parser.add_argument("--stages", nargs="*", default=["chess", "coffee", "ycb", "grove"])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--bar", type=float, default=1.02)
    args = parser.parse_args()
    from bench.identity import Worker
    isAbove = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        workers = [Worker(build.resolve(), folder / side) for build, side in ((args.before, "before"), (args.after, "after"))]
        print("| stage | CPU s before | after | ratio (least to most) | s before | after | ratio |\n|---|---|---|---|---|---|---|", flush=True)
        for number, (title, stage, settings) in enumerate(Jobs(args.stages, args.scenes.resolve(), folder, args.samples)):
            job = dict(number=number, name=title, stage=stage, settings=settings)
            runs = ([], [])
            for repeat in range(args.repeats + 1):
                for worker, run in zip(workers if repeat % 2 else workers[::-1], runs if repeat % 2 else runs[::-1]):
                    if "error" in worker.Render(job):
                        raise SystemExit(f"{title}: {worker.reply['error']}")
                    if repeat > 0:
                        run.append((worker.reply["cpuSeconds"], worker.reply["seconds"]))
            ratios = sorted(after[0] / before[0] for before, after in zip(*runs))
            (cpuBefore, before), (cpuAfter, after) = ([statistics.median(values) for values in zip(*run)] for run in runs)
            isAbove |= statistics.median(ratios) > args.bar
            print(f"| {title} | {cpuBefore:.2f} | {cpuAfter:.2f} | {statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f}) "
                  f"| {before:.2f} | {after:.2f} | {after / before:.3f} |", flush=True)
        for worker in workers:
            worker.End()
    return int(isAbove)


if __name__ == "__main__":
    sys.exit(main())
