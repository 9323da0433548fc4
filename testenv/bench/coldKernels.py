# SPDX-License-Identifier: Apache-2.0
"""What a first render pays for its kernels: coldKernels.py BUILD [BUILD] --scenes FOLDER

Renders the rivals' stages, 480 pixels wide, with prepared pages in the cache: with all kernels removed from it and from PoCL's
own cache; then once more; then with general kernels there and none of the stage's own. Builds take turns. Prints medians, and the least and the largest of the repeats: the
seconds of the whole process, its CPU seconds and those of what it starts, and the seconds to the first picture.
"""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTENV))

COLUMNS = ("process s", "CPU s", "first picture s")


def Measure(build: pathlib.Path, stage, folder: pathlib.Path, samples: int) -> tuple:
    """A value for each column."""
    from bench.recordRun import Record
    start = time.monotonic()
    values = Record(stage.path, folder / "store", camera=stage.camera, imageWidth=480, samples=samples,
                    environment=dict(PYTHONPATH=str(build / "python"), POCL_CACHE_DIR=str(folder / "pocl")))
    return time.monotonic() - start, values["cpuSeconds"], values["time"]["firstPixel"]


def ForgetKernels(folder: pathlib.Path) -> None:
    shutil.rmtree(folder / "pocl")
    (folder / "pocl").mkdir()
    kernels = list((folder / "store").rglob("kernel-*"))
    if not kernels:
        raise SystemExit("the cache holds no kernels that could be forgotten: is it another cache?")
    for kernel in kernels:
        kernel.unlink()


def MakeGeneralKernels(build: pathlib.Path, folder: pathlib.Path) -> None:
    subprocess.run([sys.executable, "-m", "hdstream", "cache", "--kernels"], check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, PYTHONPATH=str(build / "python"), HDSTREAM_CACHE_DIR=str(folder / "general")))


def UseGeneralKernels(folder: pathlib.Path) -> None:
    ForgetKernels(folder)
    for kernel in (folder / "general").glob("kernel-*"):
        shutil.copy(kernel, folder / "store")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", type=pathlib.Path, metavar="BUILD", nargs="+")
    parser.add_argument("--scenes", type=pathlib.Path, metavar="FOLDER", required=True, help="of real stages")
    parser.add_argument("--stages", nargs="*", default=["chess", "coffee", "ycb", "bookstore"])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--samples", type=int, default=1)
    args = parser.parse_args()
    from bench import rivalsStages
    print(f"| stage | build | kernels | {' | '.join(COLUMNS)} |\n|---|---|---|{'---|' * len(COLUMNS)}", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folders = []
        for number, _ in enumerate(args.builds):
            folders.append(pathlib.Path(name) / str(number))
            (folders[-1] / "pocl").mkdir(parents=True)
            MakeGeneralKernels(args.builds[number].resolve(), folders[-1])
        for stageName in args.stages:
            stage = rivalsStages.Make(stageName, str(args.scenes.resolve()), pathlib.Path(name))
            builds = list(zip([build.resolve() for build in args.builds], folders))
            runs = {(folder, kind): [] for folder in folders for kind in ("cold", "there", "general")}
            for build, folder in builds:
                Measure(build, stage, folder, args.samples)
            for _ in range(args.repeats):
                for build, folder in builds:
                    ForgetKernels(folder)
                    runs[folder, "cold"].append(Measure(build, stage, folder, args.samples))
                    runs[folder, "there"].append(Measure(build, stage, folder, args.samples))
                for build, folder in builds:
                    UseGeneralKernels(folder)
                    runs[folder, "general"].append(Measure(build, stage, folder, args.samples))
            for (folder, kind), values in runs.items():
                cells = [f"{statistics.median(c):.2f} ({min(c):.2f} to {max(c):.2f})" for c in zip(*values)]
                print(f"| {stageName} | {args.builds[folders.index(folder)]} | {kind} | {' | '.join(cells)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
