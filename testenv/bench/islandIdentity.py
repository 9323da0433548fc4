# SPDX-License-Identifier: Apache-2.0
"""Has a generated island (testenv/stages/island.py) the same picture whatever happens? islandIdentity.py [--size 0.1] [options]

The picture of `hdstream record` with resident geometry, all instances in tables and no cache is compared with others, all
layers of the file, byte by byte:

pools      each eviction with a cold cache, then each pool with the warm one
processes  two at once, of a cold cache and of a warm one, with other evictions and pools
killed     kill -9 in every phase of preparation; the cache goes from one run to the next, and is whole at the end
disk       a cache on a small tmpfs, in a mount namespace of its own, that runs full among summaries and among pages
deleted    the cache is deleted in every phase

What small sizes do in testenv/stream/test_island.py, for large ones: what the phases are is learned from a run that nothing
disturbs. Pools are parts of all pages, those of the hierarchy among them. Stages are kept in --scratch. Exit code 1 when
a picture differs, or a cache has a page that is wrong.
"""

import concurrent.futures
import contextlib
import pathlib
import shutil
import struct
import subprocess
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench import islandRun  # noqa: E402
from bench.recordRun import AnonymousPeak, FreshCache, Record, RunFailed, Segments  # noqa: E402

_LAYERS = "color,depth,normal,primId,instanceId,elementId"
_BLOCK_BYTES, _SLOT_BYTES, _REJECTED, _LINK = 1 << 16, 64, 2, 3  # of a segment's index (docs/cache-format.md)
_PARTS = ("pools", "processes", "killed", "disk", "deleted")


class Killed(Exception):
    """Raised while a run is polled: it is ended with SIGKILL."""


def PageBytes(cache) -> int:
    total = 0
    for segment in Segments(cache):
        with contextlib.suppress(FileNotFoundError):
            total += segment.stat().st_size
    return total


def RejectedPages(cache) -> int:
    """Pages that a process has found to be wrong. It marks them in the index."""
    rejected = 0
    for segment in Segments(cache):
        with open(segment, "rb") as file:
            at = 0
            while at is not None:
                file.seek(at)
                block, at = file.read(_BLOCK_BYTES), None
                for slot in range(0, len(block) - _SLOT_BYTES + 1, _SLOT_BYTES):
                    _, offset, _, _, kind = struct.unpack_from("<16sQQQI", block, slot)
                    rejected += kind == _REJECTED
                    at = offset if kind == _LINK and slot else at
    return rejected


def _Maps(process, part: str) -> bool:
    """Whether a process has mapped a file with this in its path."""
    with contextlib.suppress(OSError):
        return part in pathlib.Path(f"/proc/{process}/maps").read_text()
    return False


class Phases:
    """The phases of preparation, learned from a run that nothing disturbs. The cache grows while prims are planned, then not
    while instances are shared out, then with the pages that rays ask for. Rays need kernels, whose files PoCL maps then."""

    def __init__(self):
        self.planned = self.all = 0  # bytes of the cache: before the first kernel, at the end
        self._hasTraced = False

    def Watch(self, process, cache) -> None:
        """Of the run that nothing disturbs."""
        self._hasTraced = self._hasTraced or self._IsTracing(process)
        if self._hasTraced:
            self.all = PageBytes(cache)
        else:
            self.planned = PageBytes(cache)

    @staticmethod
    def _IsTracing(process) -> bool:
        return _Maps(process, "/kcache/")

    def Among(self, part: float) -> int:
        """Bytes of the cache when so much of all pages is there."""
        return self.planned + int(part * (self.all - self.planned))

    def Reached(self) -> dict:
        """name -> whether it has come, of (process, cache)"""
        return {
            "while the stage is read": lambda process, cache: _Maps(process, "Scattered"),
            "before the first summary": lambda process, cache: bool(Segments(cache)),
            "among summaries": lambda process, cache: PageBytes(cache) > self.planned / 2,
            "while instances are shared out":
                lambda process, cache: PageBytes(cache) > 0.99 * self.planned and not self._IsTracing(process),
            "at the first pages": lambda process, cache: PageBytes(cache) > self.Among(0.02),
            "among pages": lambda process, cache: PageBytes(cache) > self.Among(0.5),
        }


class FullDisk:
    """A cache folder that is a tmpfs of so many bytes beside the kernels, for who is called `through`. `with` ends it."""

    def __init__(self, cache: pathlib.Path, kernels: pathlib.Path, room: int):
        cache.mkdir(parents=True, exist_ok=True)
        files = list(kernels.glob("kernel-*.hdsc"))
        room += sum(-(-file.stat().st_size // 4096) * 4096 for file in files) + 4096 * (len(files) + 8)
        script = 'mount -t tmpfs -o size="$1" tmpfs "$2" && cp "$3"/kernel-*.hdsc "$2" && echo mounted && read -r end'
        command = ["unshare", "--map-root-user", "--mount", "sh", "-c", script, "sh", str(room), str(cache), str(kernels)]
        self._holder = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self._holder.stdout.readline().strip() != "mounted":
            raise RunFailed("no tmpfs in a namespace of its own here")
        self.through = ["nsenter", "--target", str(self._holder.pid), "--user", "--mount", "--preserve-credentials"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._holder.communicate("\n")


class Bench:
    def __init__(self, args, folder: pathlib.Path):
        self.args, self.folder = args, folder
        self.stage, _ = islandRun.Stage(folder, args.size)
        self.kernels = folder / "kernels"
        self.kernels.mkdir(exist_ok=True)
        self.bad = 0
        self.table = islandRun.Table()
        self.phases = Phases()
        anonymous = AnonymousPeak()
        self.expected = self.Run(None, anonymous, noCache=None, residency="resident", instanceChunks=0)
        self.geometry = self.expected["geometry"]
        self.roomy = self.geometry["bytesTotal"]  # of a pool: without a cache small ones have pages made again and again
        self.Tell("resident", "no cache", self.expected, f"{anonymous.bytes / 1e6:.0f} MB without pages of files, "
                                                         f"{self.geometry['bytesTotal'] / 1e6:.0f} MB of pages")

    def Cache(self, name: str) -> pathlib.Path:
        return FreshCache(self.folder / f"identity-{name}", self.kernels)

    def Run(self, cache, onPoll=None, **options) -> dict:
        args = self.args
        settings = dict(camera=f"/World/{args.cameras[0]}", imageWidth=args.width, samples=args.samples, aovs=_LAYERS,
                        residency="stream", geometryMemory=args.geometryMemory, hostMemory=args.hostMemory)
        run = Record(self.stage, cache or self.kernels, args.limit, onPoll=onPoll, **{**settings, **options})
        if cache and cache.exists():
            for kernel in cache.glob("kernel-*.hdsc"):
                if not (self.kernels / kernel.name).exists():
                    shutil.copy(kernel, self.kernels)
        return run

    def Tell(self, what: str, when: str, run: dict, note="", isGood=True) -> None:
        """A row; `isGood` is what else must hold."""
        isEqual = run["pictureBytes"] == self.expected["pictureBytes"]
        self.bad += not (isEqual and isGood)
        geometry = run["geometry"]
        self.table.Add({"what": what, "when": when, "picture": "equal" if isEqual else "DIFFERENT",
                        "evictions": str(geometry["evictions"]), "chunks built": str(geometry["chunksBuilt"]),
                        "from the cache": str(geometry["chunksFromCache"]),
                        "CPU s": f"{run['cpuSeconds']:.1f}", "": note if isGood else f"WRONG: {note}"})

    def TellCache(self, what: str, cache: pathlib.Path) -> None:
        """Renders with all pages, twice: what is missing is made, then nothing is missing, and nothing was found wrong."""
        for when in ("then, all pages", "again, all pages"):
            run = self.Run(cache, prepare="eager")
            rejected = RejectedPages(cache)
            isWhole = run["geometry"]["chunksBuilt"] == 0 or when.startswith("then")
            self.Tell(what, when, run, f"{rejected} pages wrong", rejected == 0 and isWhole)

    # --- parts ---

    def Pools(self) -> None:
        for eviction in ("lru", "flush"):
            cache = self.Cache("pools")
            for kind, pools in (("cold", self.args.pools[-1:]), ("warm", self.args.pools)):
                for pool in pools:
                    size = int(pool / 100 * self.geometry["bytesTotal"])
                    run = self.Run(cache, geometryEviction=eviction, geometryMemory=size)
                    self.Tell(f"{eviction}, {pool:g} %", kind, run, f"{size / 1e6:.0f} MB", run["geometry"]["peakBytes"] <= size)

    def Processes(self) -> None:
        cache = self.Cache("processes")
        small, large = (int(part * self.geometry["bytesTotal"]) for part in (0.02, 0.15))
        ways = {"lru, 2 %": dict(geometryMemory=small), "flush, 15 %": dict(geometryEviction="flush", geometryMemory=large)}
        for kind in ("cold", "warm"):
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                runs = {name: pool.submit(self.Run, cache, **way) for name, way in ways.items()}
            for name, run in runs.items():
                self.Tell(f"two processes: {name}", kind, run.result(), f"{RejectedPages(cache)} pages wrong; CPU s of both",
                          RejectedPages(cache) == 0)

    def Killed(self) -> None:
        cache = self.Cache("killed")
        for name, isReached in self.phases.Reached().items():
            def Kill(process, isReached=isReached):
                if isReached(process, cache):
                    raise Killed

            try:
                run = self.Run(cache, Kill)
                self.Tell("killed", name, run, "it was done before", False)
            except Killed:
                print(f"killed {name}: {PageBytes(cache) / 1e6:.1f} MB in the cache", file=sys.stderr, flush=True)
        self.TellCache(f"killed in {len(self.phases.Reached())} phases", cache)

    def Disk(self) -> None:
        for name, size in (("among summaries", self.phases.planned // 2), ("among pages", self.phases.Among(0.5))):
            cache, kept = self.Cache("disk"), self.Cache("disk-kept")
            with FullDisk(cache, self.kernels, size) as disk:
                for when in ("", ", once more"):
                    run = self.Run(cache, through=disk.through, geometryMemory=self.roomy)
                    lines = [line for line in run["warnings"] if "no more pages are kept" in line]
                    self.Tell("full disk", name + when, run, "; ".join(lines), bool(when) or len(lines) == 1)
                subprocess.run([*disk.through, "sh", "-c", 'cp "$1"/pages-* "$2"', "sh", str(cache), str(kept)], check=True)
            run = self.Run(kept)
            rejected = RejectedPages(kept)
            self.Tell("full disk", f"{name}, its pages in a roomy folder", run, f"{rejected} pages wrong", rejected == 0)

    def Deleted(self) -> None:
        for name, isReached in list(self.phases.Reached().items())[1:]:
            cache = self.Cache("deleted")
            isDone = []

            def Delete(process, isReached=isReached, cache=cache, isDone=isDone):
                if not isDone and isReached(process, cache):
                    while cache.exists():
                        shutil.rmtree(cache, ignore_errors=True)
                    isDone.append(True)

            run = self.Run(cache, Delete, geometryMemory=self.roomy)
            self.Tell("cache deleted", name, run, "; ".join(run["warnings"]), bool(isDone))

    def LearnPhases(self) -> None:
        cache = self.Cache("undisturbed")
        run = self.Run(cache, lambda process: self.phases.Watch(process, cache))
        if not self.phases.all:
            raise RunFailed("when rays begin is seen with PoCL only")
        self.Tell("undisturbed", "cold", run, f"cache: {self.phases.planned / 1e6:.1f} MB when planned, "
                                              f"{self.phases.all / 1e6:.1f} MB in all")
        shutil.rmtree(cache)


def main() -> int:
    parser = islandRun.Parser(__doc__)
    parser.set_defaults(cameras=["Camera"], width=256, geometryMemory="128M", hostMemory="1G")
    parser.add_argument("--size", type=float, default=0.1)
    parser.add_argument("--pools", type=lambda text: [float(word) for word in text.split(",")],
                        default=[100, 79, 50, 30, 15, 5, 2], help="percent of all pages")
    parser.add_argument("--parts", type=lambda text: text.split(","), default=list(_PARTS), help=f"of {','.join(_PARTS)}")
    args = parser.parse_args()
    if unknown := set(args.parts) - set(_PARTS):
        parser.error(f"no part {', '.join(sorted(unknown))}; there are: {', '.join(_PARTS)}")
    with islandRun.Scratch(args) as folder:
        bench = Bench(args, folder)
        if set(args.parts) & {"killed", "disk", "deleted"}:
            bench.LearnPhases()
        for part in args.parts:
            getattr(bench, part.capitalize())()
    print("\nall pictures are equal" if not bench.bad else f"\n{bench.bad} ROWS ARE WRONG", flush=True)
    return min(bench.bad, 1)


if __name__ == "__main__":
    sys.exit(main())
