# SPDX-License-Identifier: Apache-2.0
"""A cluster of processes beside one process: bits, losses, time, and what a worker loads (docs/farm.md).

    PYTHONPATH=build/release/python python testenv/bench/farm.py [--workers 4] [--width 160] [--samples 64] [--seed 1]
    PYTHONPATH=build/release/python python testenv/bench/farm.py --island 0.1 [--scratch FOLDER]

Renders 24 frames of an animated stage and one frame split by samples and by tiles, with two workers killed at random
while frames are rendered; compares every picture with one process's, to the bit.
Workers share the machine's cores, so a speed-up above 1 needs more cores than the driver of one process uses.

With --island it is a generated island (testenv/stages/island.py) instead, and nothing but what workers load: one with an empty
cache, two that start at once with an empty one, and one with what each of these left.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "testenv" / "support"), str(ROOT / "testenv")]
from bench import islandRun  # noqa: E402
from bench.recordRun import AnonymousPeak, FreshCache, Record, Segments  # noqa: E402
from farmCluster import Cluster  # noqa: E402

NUM_FRAMES = 24
NUM_KILLED = 2


def WriteStage(path, rows):
    """A field of balls around one that moves; the camera turns. About 1500 triangles a ball after dicing."""
    from pxr import Gf, Usd, UsdGeom, UsdLux
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(NUM_FRAMES)
    for x in range(rows):
        for z in range(rows):
            ball = UsdGeom.Sphere.Define(stage, f"/World/Ball{x}_{z}")
            ball.CreateRadiusAttr(0.4)
            ball.CreateDisplayColorAttr([(0.2 + 0.6 * x / rows, 0.5, 0.2 + 0.6 * z / rows)])
            UsdGeom.XformCommonAPI(ball).SetTranslate(Gf.Vec3d(x - rows / 2, 0, -z))
    moving = UsdGeom.Sphere.Define(stage, "/World/Moving").AddTranslateOp()
    camera = UsdGeom.Camera.Define(stage, "/main_cam").AddTranslateOp()
    for frame in (1, NUM_FRAMES):
        moving.Set(Gf.Vec3d(frame / 6 - 2, 1.5, -3), frame)
        camera.Set(Gf.Vec3d(frame / 24, 2, 10), frame)
    UsdLux.DomeLight.Define(stage, "/Sky").CreateIntensityAttr(0.5)
    UsdLux.DistantLight.Define(stage, "/Sun").CreateIntensityAttr(2)
    stage.Save()


class Bench:
    """One stage, one set of options, one folder."""

    def __init__(self, folder, options):
        self._folder = folder
        self._stage = folder / "stage.usdc"
        self._common = ["--maxDepth", "4", "--aovs", "color,depth,primId", "--quiet"]
        self._samples, self._width = options.samples, options.width
        WriteStage(self._stage, options.rows)

    def Record(self, name, *options, samples=None, width=None):
        """Seconds of a command that must succeed."""
        start = time.perf_counter()
        subprocess.run([sys.executable, "-m", "hdstream", "record", str(self._stage), str(self._folder / name),
                        *self._common, "-w", str(width or self._width), "--samples", str(samples or self._samples),
                        *map(str, options)], check=True)
        return time.perf_counter() - start

    def Differences(self, name, reference):
        """Pixels of all layers that are not equal to the bit."""
        from hdstream import _core
        result = _core.CompareImages(str(self._folder / name), str(self._folder / reference))
        if result.error:
            raise RuntimeError(result.error)
        return sum(layer.numDifferingPixels for layer in result.layers)

    def Loads(self, cacheDirectory):
        """A worker's costs before the first ray, from a process of its own: seconds and bytes."""
        file = self._folder / "stats.json"
        self.Record("load.exr", "--frames", 1, "--stats", file, "--cacheDir", cacheDirectory, samples=1)
        values = json.loads(file.read_text())
        return {**{key: values["time"][key] for key in ("load", "translate", "prepare", "compile", "firstPixel")},
                "uploaded": values["geometry"]["uploadedBytes"], "chunksBuilt": values["geometry"]["chunksBuilt"]}


def KillSome(processes, done, generator, killed):
    """Kills workers at random moments until `done`; NUM_KILLED at most."""
    victims = generator.sample([name for name in processes if name.startswith("worker")], NUM_KILLED)
    for name in victims:
        if done.wait(generator.uniform(1.0, 4.0)):
            return
        processes[name].send_signal(signal.SIGKILL)
        killed.append(name)


def _IslandWorker(stage, cache, options):
    """The figures of a worker's first frame. CPU seconds are those of workers that run at once together."""
    anonymous = AnonymousPeak()
    run = Record(stage, cache, onPoll=anonymous, camera="/World/Inside", imageWidth=options.width, samples=1, residency="stream",
                 geometryMemory="512M", hostMemory="4G")
    time, geometry = run["time"], run["geometry"]
    return {"CPU s": f"{run['cpuSeconds']:.1f}", "read USD s": f"{time['load'] + time['translate']:.1f}",
            "first pixel s": f"{time['firstPixel']:.1f}", "process MB": f"{anonymous.bytes / 1e6:.0f}",
            "chunks made": str(geometry["chunksBuilt"]), "chunks from the cache": str(geometry["chunksFromCache"]),
            "loaded MB": f"{geometry['uploadedBytes'] / 1e6:.0f}"}


def Island(options, scratch):
    """Rows of workers on an island, of which those of a cache share a folder."""
    stage, _ = islandRun.Stage(scratch, options.island)
    table = islandRun.Table()
    for together in (1, 2):
        cache = FreshCache(scratch / "farm-cache", scratch / "kernels")
        for when, count in (("empty", together), (f"filled by {together}", 1)):
            with concurrent.futures.ThreadPoolExecutor(count) as pool:
                runs = list(pool.map(lambda _: _IslandWorker(stage, cache, options), range(count)))
            megabytes = sum(segment.stat().st_size for segment in Segments(cache)) / 1e6
            for run in runs:
                table.Add({"workers at once": str(count), "cache": when, **run, "cache MB afterwards": f"{megabytes:.0f}"})


def Main():
    parser = argparse.ArgumentParser(description="A farm beside one process.")
    parser.add_argument("--workers", type=int, default=4, help="more than the two that are killed (4)")
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--singleWidth", type=int, help="of the frame that is split (--width)")
    parser.add_argument("--singleSamples", type=int, help="of that frame (8 times --samples)")
    parser.add_argument("--rows", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1, help="of who is killed when")
    parser.add_argument("--island", type=float, help="size of an island: only what its workers load")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder that keeps the island")
    options = parser.parse_args()
    if options.island:
        with islandRun.Scratch(options) as scratch:
            Island(options, scratch)
        return 0
    single = dict(samples=options.singleSamples or 8 * options.samples, width=options.singleWidth or options.width)
    generator = random.Random(options.seed)
    share = str(max(1, (os.cpu_count() or 1) // options.workers))
    environment = {"POCL_CPU_MAX_CU_COUNT": share, "POCL_MAX_PTHREAD_COUNT": share}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        bench = Bench(folder, options)
        cold, warm = bench.Loads(folder / "cold"), bench.Loads(folder / "cold")
        for label, loads in (("cold cache", cold), ("warm cache", warm)):
            print(f"a worker's first frame, {label}: " + ", ".join(f"{key} {value:.2f}" if isinstance(value, float) else
                                                                   f"{key} {value}" for key, value in loads.items()))
        frames = f"1:{NUM_FRAMES}"
        alone = bench.Record("one.####.exr", "--frames", frames)
        singleAlone = bench.Record("single.exr", "--frames", 1, **single)
        clusterFolder = folder / "cluster"
        clusterFolder.mkdir()
        with Cluster(clusterFolder, options.workers, environment) as (address, processes):
            done, killed = threading.Event(), []
            killer = threading.Thread(target=KillSome, args=(processes, done, generator, killed))
            killer.start()
            together = bench.Record("farm.####.exr", "--frames", frames, "--scheduler", address)
            done.set()
            killer.join()
            splits = {split: bench.Record(f"{split}.exr", "--frames", 1, "--scheduler", address, "--split", split,
                                          "--parts", options.workers, **single)
                      for split in ("samples", "tiles")}
        different = sum(bench.Differences(f"farm.{frame:04}.exr", f"one.{frame:04}.exr")
                        for frame in range(1, NUM_FRAMES + 1))
        print(f"{NUM_FRAMES} frames: one process {alone:.1f} s, {options.workers} workers of which {len(killed)} were killed "
              f"{together:.1f} s ({alone / together:.2f} times as fast); {different} pixels differ")
        total = different
        for split, seconds in splits.items():
            different = bench.Differences(f"{split}.exr", "single.exr")
            total += different
            print(f"one frame, {single['width']} pixels wide, {single['samples']} samples, by {split}: one process "
                  f"{singleAlone:.1f} s, {options.workers - len(killed)} workers "
                  f"{seconds:.1f} s ({singleAlone / seconds:.2f} times as fast); {different} pixels differ")
        return 0 if total == 0 else 1


if __name__ == "__main__":
    sys.exit(Main())
