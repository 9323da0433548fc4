# SPDX-License-Identifier: Apache-2.0
"""All benches that belong on one page: run.py --out FOLDER [--short] [--sections a,b,...] [--scenes FOLDER]

Writes FOLDER/performance.md, and tables (CSV) and charts (SVG) below FOLDER/images/performance. `--out docs` renews
docs/performance.md. Prose stays as it is; blocks between markers are those of the sections, which are run in the order of
the page. A page that is not there yet begins as docs/performance.md without figures. A section that lacks a program or
another renderer is left out with a line that says so. The full form takes about an hour on two cores; the short one, which
only shows that all of it works, takes a minute. Stages are generated; --scenes adds real ones that are found in a folder.
"""

import argparse
import datetime
import importlib
import importlib.util
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import traceback

TESTENV = pathlib.Path(__file__).resolve().parents[1]
ROOT = TESTENV.parent
sys.path[:0] = [str(TESTENV)]

from bench import performancePage  # noqa: E402
from bench.rivalsStages import REAL  # noqa: E402

SECTIONS = ("machine", "traversal", "rays", "geometryKnobs", "textureKnobs", "tessellation", "adaptive", "denoising", "economies",
            "memory", "firstPixel", "rivals", "hydra")
_IMAGES = "images/performance"


class Bench:
    """What sections share: sizes, stages, folders."""

    def __init__(self, args, folder: pathlib.Path):
        self.isShort, self.build, self.rivalsPython, self.scenes = args.short, args.build, args.rivalsPython, args.scenes
        self.folder = folder
        self.cache = folder / "cache"
        self.images = args.out / _IMAGES
        self._stages = {}
        self.real = {}
        for name, (path, camera) in REAL.items() if args.scenes else ():
            if (args.scenes / path).exists():
                self.real[name] = (str(args.scenes / path), camera)

    def Pick(self, full, short):
        return short if self.isShort else full

    def Stage(self, name: str, write) -> str:
        """Path of a stage that write(path) makes once; its name holds its size."""
        if name not in self._stages:
            path = self.folder / "stages" / name / "stage.usdc"
            path.parent.mkdir(parents=True)
            write(str(path))
            self._stages[name] = str(path)
        return self._stages[name]

    def Real(self, *names) -> dict:
        """Those of the real stages that are there: where all would take too long."""
        return {name: self.real[name] for name in names if name in self.real}

    def Program(self, path: str) -> pathlib.Path:
        """A program of the build. Raises LeftOut without it."""
        program = self.build / path
        if not program.exists():
            raise performancePage.LeftOut(f"{program.name} was not built")
        return program


class _OtherWork:
    """The share of the machine's time that other processes take."""

    def __init__(self):
        self._start = self._Now()

    @staticmethod
    def _Now() -> tuple:
        """Seconds of all cores: in all, busy, of this process and its children."""
        usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        own = sum(usage.ru_utime + usage.ru_stime for usage in usages)
        try:
            ticks = [int(word) for word in pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
        except OSError:
            return None
        return tuple(value / os.sysconf("SC_CLK_TCK") for value in (sum(ticks), sum(ticks) - ticks[3] - ticks[4])) + (own,)

    def Text(self) -> str:
        now = self._Now()
        if not now or not self._start:
            return "time of other work unknown"
        total, busy, own = (b - a for a, b in zip(self._start, now))
        return f"{own:.0f} s of CPU time, other work took {max(0.0, 100 * (busy - own) / max(total, 0.01)):.0f} % of the cores"


def _FindBuild() -> pathlib.Path:
    """The build folder of the hdstream that is imported, else of a build of this tree."""
    found = importlib.util.find_spec("hdstream")
    if found is None:
        for python in sorted((ROOT / "build").glob("*/python")):
            if list(python.glob("hdstream/_core*")):
                sys.path.insert(0, str(python))
                os.environ["PYTHONPATH"] = os.pathsep.join([str(python), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
                return python.parent
        sys.exit("run.py: hdstream is not built; set PYTHONPATH to the folder `python` of a build")
    return pathlib.Path(found.origin).absolute().parents[2]


def _UseCache(cache: pathlib.Path) -> None:
    """A persistent cache of this run, with the kernels that the user's own has."""
    from bench.recordRun import FreshCache
    from hdstream import _core

    FreshCache(cache, _core.InspectCache("").directory)
    os.environ["HDSTREAM_CACHE_DIR"] = str(cache)


def _RunSection(name: str, bench: Bench, out: pathlib.Path) -> str:
    """The block."""
    print(f"{name} ...", flush=True)
    load, start = _OtherWork(), time.monotonic()
    try:
        items = importlib.import_module(f"bench.sections.{name}").Run(bench)
    except performancePage.LeftOut as error:
        print(f"LEFT OUT: {name}: {error}", flush=True)
        return f"Left out: {error}.\n"
    commit = subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty"], capture_output=True,
                            text=True).stdout.strip()
    took = f"{time.monotonic() - start:.0f} s, {load.Text()}"
    print(f"{name}: {took}", flush=True)
    form = "short form, which measures nothing" if bench.isShort else "full form"
    items.append(f"*{datetime.date.today()}, commit {commit or 'unknown'}, {form}: {took}.*")
    return performancePage.Block(items, out / _IMAGES, _IMAGES)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--short", action="store_true", help="tiny sizes: shows that all of it works, measures nothing")
    parser.add_argument("--sections", type=lambda text: text.split(","), default=SECTIONS, help=",".join(SECTIONS))
    parser.add_argument("--scenes", type=pathlib.Path, help="folder with real scenes: " + ", ".join(path for path, _ in REAL.values()))
    parser.add_argument("--build", type=pathlib.Path, help="build folder with the benchmark programs; default: that of hdstream")
    parser.add_argument("--rivalsPython", default=sys.executable, help="a Python with Mitsuba and Blender (bpy)")
    parser.add_argument("--scratch", help="folder for stages and caches")
    args = parser.parse_args()
    unknown = [name for name in args.sections if name not in SECTIONS]
    if unknown:
        parser.error(f"argument --sections: there is no {', '.join(unknown)}; there are {', '.join(SECTIONS)}")
    if args.scenes and not args.scenes.is_dir():
        parser.error(f"argument --scenes: {args.scenes} is no folder")
    build = _FindBuild()
    args.build = args.build or build
    args.out.mkdir(parents=True, exist_ok=True)
    page = args.out / "performance.md"
    text = page.read_text() if page.exists() else performancePage.Emptied((ROOT / "docs" / "performance.md").read_text())
    folder, failed = pathlib.Path(tempfile.mkdtemp(dir=args.scratch)), []
    try:
        bench = Bench(args, folder)
        _UseCache(bench.cache)
        for name in (name for name in SECTIONS if name in args.sections):
            try:
                text = performancePage.Replaced(text, name, _RunSection(name, bench, args.out))
            except Exception:  # what the other sections measure in an hour is not lost
                failed.append(name)
                traceback.print_exc()
                print(f"FAILED: {name}; its block stays as it was", flush=True)
            page.write_text(text)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"{page}" + (f"; FAILED: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
