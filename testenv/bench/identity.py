# SPDX-License-Identifier: Apache-2.0
"""Do two builds of hdStream give the same pictures, bit for bit? identity.py --before BUILD --after BUILD [--scenes FOLDER]

Renders in one process of each build, and compares every value of every AOV: the demo; every stage below FOLDER; the gallery in its
short forms; the generated stages of testenv/stages; the small scenes of streamingMatrix.py over a covering array of pools,
evictions, requests, preparations, traversals and host budgets; and resident pictures of wave sizes. A stage that cannot be
rendered must fail with the same message in both. Prints a line for each group with the number of pictures and of pixels
that differ, and a line for each picture that does. Exit code 1 when anything differs. `--short` takes a few of each group.

`--kernels FOLDER` keeps built kernels from run to run, which saves most of the time of a second one; prepared geometry is always
made anew, so that a change of it is seen.

BUILD is a build folder that has python/hdstream in it. Option values are taken from each build's own settings table by their
place in it, so that builds that spell a value differently can be compared.
"""

import argparse
import importlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time

TESTENV = pathlib.Path(__file__).resolve().parents[1]
_EXTENSIONS = {".usd", ".usda", ".usdc", ".usdz"}
_SHORT_EVERY = 12  # of each group one in so many
_LIMIT_SECONDS = 900  # of one picture


# ---- which pictures: (name, stage, settings); a setting's value ["choice", i] is the i-th choice of its row ----

def RealJobs(scenes: pathlib.Path) -> list:
    stages = sorted(path for path in scenes.rglob("*") if path.suffix in _EXTENSIONS)
    return [(str(path.relative_to(scenes)), str(path), dict(imageWidth=128, imageHeight=96, samples=2)) for path in stages]


def CameraJobs(scenes: pathlib.Path) -> list:
    """The real stages from the cameras that the rivals are compared on, larger, resident and streamed."""
    from bench.rivalsStages import REAL
    streamed = dict(residency=["choice", 2], geometryMemory="30%", textureMemory="10%")
    jobs = []
    for name, (file, camera) in REAL.items():
        size = dict(camera=camera, imageWidth=320, imageHeight=180, samples=4)
        jobs.append((f"{name}, resident", str(scenes / file), dict(size, residency=["choice", 1])))
        jobs.append((f"{name}, streamed", str(scenes / file), dict(size, **streamed)))
        jobs.append((f"{name}, the report's design", str(scenes / file),
                     dict(size, **streamed, geometryEviction=["choice", 1], request=["choice", 1])))
    return jobs


def DemoJobs(folder: pathlib.Path) -> list:
    from stages import demo
    demo.WriteDemo(str(folder / "demo.usda"))
    return [("demo", str(folder / "demo.usda"), dict(imageWidth=480, imageHeight=270, samples=8))]


def GalleryJobs(folder: pathlib.Path) -> list:
    from gallery.__main__ import PICTURES, WriteStage
    jobs = []
    for name, options in PICTURES.items():
        depth = int(options[options.index("--maxDepth") + 1])
        stage = WriteStage(name, folder / "gallery" / name, 0.02)
        jobs.append((name, str(stage), dict(camera="/World/Camera", imageWidth=128, imageHeight=72, samples=4, maxDepth=depth)))
    return jobs


def GeneratedJobs(folder: pathlib.Path) -> list:
    from stages import curves, materialX
    from stages.verify import CASES
    writers = {"materialBalls": materialX.WriteMaterialBalls, "curveShapes": curves.WriteShapes,
               **{name: case.Write for name, case in CASES.items()}}
    jobs = []
    for name, write in writers.items():
        path = str(folder / f"{name}.usdc")
        write(path)
        jobs.append((name, path, dict(imageWidth=96, imageHeight=72, samples=4)))
    return jobs


def StreamingJobs(folder: pathlib.Path) -> list:
    from bench.streamingMatrix import SMALL, CoveringArray
    # Places in the table's choices: eviction (ours, the report's), request (ours, the report's), prepare (lazy, eager), traversal.
    factors = {"geometryMemory": ("100%", "79%", "50%", "30%", "15%", "5%"), "geometryEviction": (0, 1), "request": (0, 1),
               "prepare": (0, 1), "traversal": (1, 2), "hostMemory": (0, 1 << 22), "waveSize": (0, 4096)}
    jobs = []
    for scene, write in SMALL.items():
        path = str(folder / f"{scene}.usdc")
        write(path)
        base = dict(camera="/World/Camera", imageWidth=96, imageHeight=54, samples=2, chunkBytes=12 << 10)
        jobs.append((f"{scene}, resident", path, dict(base, residency=["choice", 1])))
        for number, row in enumerate(CoveringArray(factors, 12)):
            settings = {name: ["choice", value] if name in ("geometryEviction", "request", "prepare", "traversal") else value
                        for name, value in row.items()}
            jobs.append((f"{scene}, streamed {number}", path, dict(base, residency=["choice", 2], **settings)))
        jobs.append((f"{scene}, mapped", path, dict(base, residency=["choice", 3])))
    return jobs


# ---- one build's process: a job a line on its input, a reply a line on its output ----

def Work(folder: pathlib.Path) -> int:
    import warnings

    import numpy as np
    import hdstream
    from hdstream import _core

    warnings.simplefilter("ignore")
    rows = {row.name: row for row in _core.SettingTable()}
    aovs = [info.name for info in _core.AovTable() if info.name != "noisy"]  # which is there with --denoise only
    for line in sys.stdin:
        job = json.loads(line)
        settings = {name: rows[name].choices[value[1]] if isinstance(value, list) and value[0] == "choice" else value
                    for name, value in job["settings"].items()}
        reply = {"number": job["number"]}
        try:
            settings.setdefault("aovs", aovs)
            renderer = hdstream.Renderer(job["stage"])
            renderer.Prepare(cacheDirectory=str(folder / "cache"), **settings)
            cpu = time.process_time()
            image = renderer.RenderPrepared()
            reply.update(cpuSeconds=time.process_time() - cpu, seconds=image.statistics["time"]["render"])
            np.savez(folder / f"{job['number']}.npz", **image.aovs)
        except (hdstream.Error, hdstream.UsageError) as error:
            reply["error"] = str(error)
        print(json.dumps(reply), flush=True)
    return 0


class Worker:
    """A process of one build. One thread at a time."""

    def __init__(self, build: pathlib.Path, folder: pathlib.Path):
        folder.mkdir()
        self.folder = folder
        environment = dict(os.environ, PYTHONPATH=str(build / "python"), PYTHONDONTWRITEBYTECODE="1")
        self._process = subprocess.Popen([sys.executable, __file__, "--work", str(folder)], stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        self._said = []
        threading.Thread(target=lambda: self._said.extend(self._process.stderr), daemon=True).start()

    def Render(self, job: dict) -> dict:
        """AOV name -> array; or {"error": text}. What the process said of it stays in `reply`."""
        import numpy as np
        watch = threading.Timer(_LIMIT_SECONDS, self._process.kill)
        watch.start()
        try:
            self._process.stdin.write(json.dumps(job) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except OSError:
            line = ""
        finally:
            watch.cancel()
        if not line:
            raise SystemExit(f"{job['name']}: the process of {self.folder.name} ended: {''.join(self._said[-5:])}")
        self.reply = reply = json.loads(line)
        if "error" in reply:
            return reply
        file = self.folder / f"{job['number']}.npz"
        with np.load(file) as arrays:
            layers = dict(arrays)
        file.unlink()
        return layers

    def End(self) -> None:
        self._process.stdin.close()
        self._process.wait(60)


def CopyKernels(source: pathlib.Path, target: pathlib.Path) -> None:
    """The kernels of a cache folder; they are named by all that they depend on."""
    target.mkdir(parents=True, exist_ok=True)
    for kernel in source.glob("kernel-*.hdsc"):
        if not (target / kernel.name).exists():
            shutil.copy(kernel, target)


def PixelsUnlike(before: dict, after: dict) -> int:
    """Of all layers; a pixel counts once. Layers that only one has, or of other sizes, differ in every pixel."""
    import numpy as np
    if "error" in before or "error" in after:
        return 0 if before.get("error") == after.get("error") else 1
    unlike = np.zeros(before["color"].shape[:2], bool)
    if set(before) != set(after) or before["color"].shape != after["color"].shape:
        return unlike.size
    for name, layer in before.items():
        bits, others = (np.ascontiguousarray(image).view(np.uint32) for image in (layer, after[name]))
        unlike |= (bits != others).reshape(*unlike.shape, -1).any(axis=2)
    return int(unlike.sum())


def CompareGroup(name: str, jobs: list, before: Worker, after: Worker, firstNumber: int) -> tuple:
    """(pictures, of them not rendered by either, pictures that differ, pixels that differ)."""
    numErrors = numUnlike = numPixels = 0
    for number, (title, stage, settings) in enumerate(jobs, firstNumber):
        job = dict(number=number, name=title, stage=stage, settings=settings)
        replies = {}
        threads = [threading.Thread(target=lambda worker=worker: replies.update({worker: worker.Render(job)}))
                   for worker in (before, after)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if len(replies) < 2:
            raise SystemExit(1)  # the thread has said why
        pixels = PixelsUnlike(replies[before], replies[after])
        numErrors += "error" in replies[before]
        if pixels:
            numUnlike += 1
            numPixels += pixels
            said = [reply.get("error", "rendered") for reply in (replies[before], replies[after])]
            print(f"  {name}: {title}: {pixels} pixels differ" + (f" ({said[0]} | {said[1]})" if any("error" in r for r in replies.values()) else ""),
                  flush=True)
    return len(jobs), numErrors, numUnlike, numPixels


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=pathlib.Path, metavar="BUILD")
    parser.add_argument("--after", type=pathlib.Path, metavar="BUILD")
    parser.add_argument("--scenes", type=pathlib.Path, metavar="FOLDER", help="of real stages")
    parser.add_argument("--groups", nargs="*", metavar="GROUP", help="only these")
    parser.add_argument("--kernels", type=pathlib.Path, metavar="FOLDER", help="keep built kernels here")
    parser.add_argument("--short", action="store_true", help=f"one picture in {_SHORT_EVERY} of each group")
    parser.add_argument("--work", type=pathlib.Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.work:
        return Work(args.work)
    for build in (args.before, args.after):
        if not build or not (build / "python" / "hdstream").is_dir():
            parser.error(f"no build with python/hdstream: {build}")
    sys.path.insert(0, str(TESTENV))
    importlib.import_module("numpy")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        groups = {"demo": lambda: DemoJobs(folder), "gallery": lambda: GalleryJobs(folder), "generated": lambda: GeneratedJobs(folder),
                  "streaming": lambda: StreamingJobs(folder)}
        if args.scenes:
            scenes = args.scenes.resolve()
            groups.update({"real stages": lambda: RealJobs(scenes), "real cameras": lambda: CameraJobs(scenes)})
        unknown = set(args.groups or ()) - set(groups)
        if unknown:
            parser.error(f"no group {', '.join(sorted(unknown))}; there are: {', '.join(groups)}")
        before, after = (Worker(build.resolve(), folder / side) for build, side in ((args.before, "before"), (args.after, "after")))
        for worker in (before, after) if args.kernels else ():
            CopyKernels(args.kernels, worker.folder / "cache")
        totals = [0, 0, 0, 0]
        print("| group | pictures | not drawable in both | pictures that differ | pixels that differ |\n|---|---|---|---|---|", flush=True)
        for group, make in groups.items():
            if args.groups and group not in args.groups:
                continue
            jobs = make()
            counts = CompareGroup(group, jobs[::_SHORT_EVERY] if args.short else jobs, before, after, totals[0])
            totals = [total + count for total, count in zip(totals, counts)]
            print(f"| {group} | " + " | ".join(map(str, counts)) + " |", flush=True)
        for worker in (before, after):
            worker.End()
            if args.kernels:
                CopyKernels(worker.folder / "cache", args.kernels)
    print("| all | " + " | ".join(map(str, totals)) + " |")
    return min(totals[2], 1)


if __name__ == "__main__":
    sys.exit(main())
