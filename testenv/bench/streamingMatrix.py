# SPDX-License-Identifier: Apache-2.0
"""Is every streamed picture the resident one, bit for bit? streamingMatrix.py [SCENE...] [--large FILE:CAMERA ...]

Small scenes (at most 200 000 triangles, so small chunks that there are at least 1000 of them): every combination of pool (100 to
2 % of all pages), eviction, preparation (lazy, eager) and cache (cold, warm). Large ones, generated or given: a covering
array of 30 combinations, in which each pair of values of any two of them occurs. Prints a table; exit code 1 when a
picture differs. Percentages are turned into bytes, so that lazy stays lazy. With --instanceChunks instances stream too; those
of the resident picture lie in tables all the same.
"""

import argparse
import itertools
import json
import pathlib
import shutil
import sys
import tempfile
import time

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from hdstream import _core  # noqa: E402
from hdstream.translate import TranslateStage  # noqa: E402
from pxr import Usd  # noqa: E402
from stages import bench, grove, streaming  # noqa: E402

_POOLS = (100, 79, 50, 30, 15, 5, 2)
_FACTORS = {"pool": _POOLS, "eviction": ("lru", "flush"), "prepare": ("lazy", "eager"), "cache": ("cold", "warm"),
            "request": ("list", "first"), "traversal": ("simd8", "scalar"), "hostMemory": (0, 1 << 22)}
_NUM_LARGE = 30
SMALL = {
    "hugeMesh": lambda path: bench.WriteTerrain(path, cells=270),
    "manyMeshes": lambda path: bench.WriteMeshes(path, meshes=12_000),
    "manyInstances": lambda path: bench.WriteForest(path, instances=20_000, species=66),
    "overlap": lambda path: streaming.WriteOverlap(path, meshes=24, rings=45),
    "nested": lambda path: streaming.WriteNested(path, rings=212),
    "grove": lambda path: grove.WriteGrove(path, 165_000, 18_000),
    "gardens": lambda path: grove.WriteGrove(path, 85_000, 4_000, gardens=3),
}
LARGE = {
    "grove20M": lambda path: grove.WriteGrove(path),
    "millionInstances": lambda path: bench.WriteForest(path, instances=1_000_000, species=5),
}


def CoveringArray(factors: dict, least: int) -> list:
    """Combinations, at least so many, in which each pair of values of two factors occurs: greedy, deterministic."""
    rng = np.random.default_rng(1)
    names = list(factors)

    def Pairs(row):
        return {(a, row[a], b, row[b]) for a, b in itertools.combinations(names, 2)}

    missing = {(a, x, b, y) for a, b in itertools.combinations(names, 2) for x in factors[a] for y in factors[b]}
    rows = []
    while missing or len(rows) < least:
        tries = [{name: values[rng.integers(len(values))] for name, values in factors.items()} for _ in range(60)]
        rows.append(max(tries, key=lambda row: len(Pairs(row) & missing)))
        missing -= Pairs(rows[-1])
    return rows


class Scene:
    """A stage and its resident picture."""

    def __init__(self, path: str, camera: str, chunkBytes: int, args):
        self.stage, self.camera, self.chunkBytes, self.args = Usd.Stage.Open(path), camera, chunkBytes, args
        self.session = None
        self.expected, statistics = self.Render(residency="resident", instanceChunks=0)  # which fills the warm cache
        self.geometry = statistics["geometry"]

    def Renew(self):
        """A session that has prepared nothing."""
        self.session = _core.Session()
        TranslateStage(self.stage, self.session, Usd.TimeCode.Default())

    def Render(self, **settings):
        if self.session is None or settings.get("prepare"):
            self.Renew()
        options = _core.Settings()
        options.camera = self.camera
        options.imageWidth, options.imageHeight = self.args.width, self.args.width * 9 // 16
        options.samples, options.chunkBytes = self.args.samples, self.chunkBytes
        options.aovs = ["color", "depth", "normal", "primId", "instanceId", "elementId"]
        options.cacheDirectory = str(self.args.warm)
        options.instanceChunks = self.args.instanceChunks
        for name, value in settings.items():
            setattr(options, name, value)
        self.session.Render(options)
        picture = b"".join(np.array(layer.pixels).tobytes() for layer in self.session.Layers())
        return picture, json.loads(self.session.Statistics())

    def Run(self, row: dict, leastPool: int) -> tuple:
        """('equal' | 'DIFFERENT' | the error, statistics)"""
        pool = max(leastPool, int(row["pool"] / 100 * self.geometry["bytesTotal"]))
        settings = dict(residency="stream", geometryMemory=str(pool), geometryEviction=row["eviction"], prepare=row["prepare"],
                        request=row.get("request", "list"), traversal=row.get("traversal", "auto"),
                        hostMemory=row.get("hostMemory", 0))
        if row["cache"] == "cold":
            settings["cacheDirectory"] = str(self.args.ColdCache())
        try:
            picture, statistics = self.Render(**settings)
        except _core.Error as error:
            return str(error), None
        geometry = statistics["geometry"]
        assert geometry["peakBytes"] <= pool, "the budget was exceeded"
        assert row["cache"] == "cold" or geometry["chunksBuilt"] == 0, "the cache was not warm"
        return "equal" if picture == self.expected else "DIFFERENT", statistics


def LeastPool(scene: Scene) -> int:
    """Bytes of the largest chunk."""
    try:
        scene.Render(residency="stream", geometryMemory="16", prepare="eager")
    except _core.Error as error:
        return int(str(error).split("which takes ")[1].split()[0])
    return 16


def RunScene(name: str, path: str, camera: str, chunkBytes: int, rows: list, args) -> int:
    """Prints a row of the table; returns how many pictures differ."""
    start = time.monotonic()
    scene = Scene(path, camera, chunkBytes, args)
    leastPool = LeastPool(scene)
    results = {}
    for row in rows:
        results.setdefault(row["pool"], []).append(scene.Run(row, leastPool)[0])
        print(f"{name} {row}: {results[row['pool']][-1]}", file=sys.stderr, flush=True)
    cells = [name, f"{scene.geometry['triangles']:,}", f"{scene.geometry['instances']:,}", f"{scene.geometry['chunks']:,}"]
    for pool in _POOLS:
        found = results.get(pool, [])
        cells.append(f"{found.count('equal')} of {len(found)}")
    cells.append(f"{time.monotonic() - start:.0f}")
    print("| " + " | ".join(cells) + " |", flush=True)
    return sum(found.count("equal") != len(found) for found in results.values())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=[*SMALL, *LARGE], metavar="SCENE", help="of the generated ones; none: -")
    parser.add_argument("--large", action="append", default=[], metavar="FILE:CAMERA", help="further large scenes")
    parser.add_argument("--width", type=int, default=96)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--instanceChunks", type=int, default=1 << 16, help="as of hdstream record")
    parser.add_argument("--chunkSize", type=int, default=12 << 10)
    parser.add_argument("--largeChunkSize", type=int, default=1 << 18)
    args = parser.parse_args()
    small = [dict(zip(("pool", "eviction", "prepare", "cache"), values)) for values in
             itertools.product(_POOLS, *(_FACTORS[name] for name in ("eviction", "prepare", "cache")))]
    print("| scene | triangles | instances | chunks | " + " | ".join(f"{pool} %" for pool in _POOLS) + " | s |")
    print("|---" * (5 + len(_POOLS)) + "|", flush=True)
    numBad = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        args.warm = folder / "warm"

        def ColdCache():
            shutil.rmtree(folder / "cold", ignore_errors=True)
            (folder / "cold").mkdir()
            for kernel in args.warm.glob("kernel-*.hdsc"):
                shutil.copy(kernel, folder / "cold")
            return folder / "cold"

        args.ColdCache = ColdCache
        stages = [(scene, None, SMALL.get(scene) or LARGE[scene], "/World/Camera") for scene in args.scenes if scene != "-"]
        stages += [(pathlib.Path(large.rpartition(":")[0]).stem, large.rpartition(":")[0], None, large.rpartition(":")[2])
                   for large in args.large]
        for scene, path, write, camera in stages:
            if write:
                path = f"{folder}/{scene}.usdc"
                write(path)
            chunkBytes, rows = (args.chunkSize, small) if scene in SMALL else (args.largeChunkSize, CoveringArray(_FACTORS, _NUM_LARGE))
            numBad += RunScene(scene, path, camera, chunkBytes, rows, args)
            shutil.rmtree(args.warm)
    print("all pictures are equal" if numBad == 0 else f"{numBad} POOLS WITH OTHER PICTURES")
    return min(numBad, 1)


if __name__ == "__main__":
    sys.exit(main())
