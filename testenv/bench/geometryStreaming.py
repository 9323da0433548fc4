# SPDX-License-Identifier: Apache-2.0
"""Time of streamed geometry over resident: geometryStreaming.py [STAGE...] [options]

For each stage (default: those of testenv/stages/streaming.py, in sizes of some 100 MB), in one run: resident geometry at
its best wave size, then pools of several percentages of all bytes with either eviction, and the report's own design
(whole meshes as units, flush, first request). Prints a table in Markdown a stage. `ratio` is time.render over that of
resident without the flat hierarchy, which takes memory that streaming is there to save: that is what streaming costs. The row
"resident, flat" is what resident geometry does by default. Medians of --repeats runs that take turns; every picture must have
the bits of the resident one.
Stages are USD files with their camera after a colon: scene.usda:/World/Camera. `--inTurn` compares with resident geometry at its
default wave, which takes its turns with the pools; kernels of all forms are there, also those that a pool of 100 % changes to.
"""

import argparse
import pathlib
import sys
import tempfile

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTENV)]

from bench.sceneRun import Scene  # noqa: E402
from hdstream import _core  # noqa: E402
from stages import bench, streaming  # noqa: E402

_POOLS = (100, 79, 50, 30, 15, 5, 2)
_REPORT_POOLS = (100, 79, 30)
_RESIDENT_WAVES = (1 << 14, 1 << 15, 1 << 16, 1 << 17, 0)  # 0: the default
_MESH_CHUNK = next(int(row.maximum) for row in _core.SettingTable() if row.name == "chunkBytes")
GENERATED = {
    "hugeMesh": lambda path: bench.WriteTerrain(path, cells=1000),
    "manyMeshes": lambda path: bench.WriteMeshes(path, meshes=60_000),
    "manyInstances": lambda path: bench.WriteForest(path, instances=300_000),
    "overlap": lambda path: streaming.WriteOverlap(path, meshes=24, rings=220),
    "nested": lambda path: streaming.WriteNested(path, rings=400),
}


_HEAD = ("| pool | s | ratio | device memory | trace, shade, requests, transfer | loaded / unique | iterations a cast: mean / max | "
         "relaunched, M | refetches | wave |\n|---|---|---|---|---|---|---|---|---|---|")


def OpenScene(path: str, camera: str, args) -> Scene:
    return Scene(path, camera, imageWidth=args.width, imageHeight=args.width * 9 // 16, chunkBytes=args.chunkSize)


def Measure(scene: Scene, variants: dict, repeats: int, samples: int) -> dict:
    """{name: statistics of the median run} of variants that take turns; a first short render of each warms kernels."""
    runs = {name: [] for name in variants}
    pictures = set()
    for turn in range(repeats + 1):
        for name, settings in variants.items():
            if name not in runs:
                continue
            try:
                picture, figures = scene.Render(1 if turn == 0 else samples, **settings)
            except _core.Error as error:
                print(f"<!-- {name}: {error} -->")
                del runs[name]
                continue
            if turn > 0:
                pictures.add(picture.tobytes())
                runs[name].append(figures)
    assert len(pictures) == 1, "the pictures differ"
    return {name: sorted(found, key=lambda run: run["time"]["render"])[len(found) // 2] for name, found in runs.items()}


def DeviceBytes(run: dict) -> int:
    """Pool, path state and tables."""
    return run["geometry"]["budget"] + run["memory"]["pathState"] + run["memory"]["tables"]


def Row(name: str, run: dict, resident: dict, residentBytes: int) -> str:
    """`residentBytes`: of the device, with the wave that resident geometry has by default."""
    time, geometry = run["time"], run["geometry"]
    cells = [name, f"{time['render']:.2f}", f"{time['render'] / resident['time']['render']:.2f}",
             f"{DeviceBytes(run) / residentBytes:.2f}",
             " ".join(f"{time[key]:.2f}" for key in ("trace", "shade", "requests", "transfer")),
             f"{geometry['uploadedBytes'] / max(1, geometry['uniqueBytesLoaded']):.1f}",
             f"{geometry['iterations'] / max(1, geometry['rayBatches']):.1f} / {geometry['maxIterationsPerBatch']}",
             f"{geometry['raysRelaunched'] / 1e6:.2f}", f"{geometry['shadingRefetches']}", f"{run['wave']['size']}"]
    return "| " + " | ".join(cells) + " |"


def RunInTurn(name: str, path: str, camera: str, args) -> None:
    scene = OpenScene(path, camera, args)
    scene.Render(1, residency="auto", prepare="eager")
    streams = {f"{pool} %": dict(residency="stream", geometryMemory=f"{pool}%", waveSize=args.waveSize) for pool in args.pools}
    runs = Measure(scene, {"resident": dict(residency="resident", traversal="simd8"), "resident, flat": dict(residency="resident"), **streams}, args.repeats, args.samples)
    resident = runs["resident"]
    print(f"\n### {name}\n\n{resident['geometry']['chunks']} chunks, {resident['geometry']['bytesTotal'] / 1e6:.1f} MB; {args.width} "
          f"pixels wide, {args.samples} samples\n")
    print(_HEAD)
    for label, run in runs.items():
        print(Row(label, run, resident, DeviceBytes(resident)))
    sys.stdout.flush()


def RunStage(name: str, path: str, camera: str, args) -> None:
    scene = OpenScene(path, camera, args)
    waves = {f"{wave}": dict(residency="resident", traversal="simd8", waveSize=wave) for wave in _RESIDENT_WAVES}
    residents = Measure(scene, waves, 1, args.samples)
    best = min(residents.items(), key=lambda item: item[1]["time"]["render"])[0]
    variants = {"resident": dict(residency="resident", traversal="simd8", waveSize=int(best))}
    resident = Measure(scene, variants, args.repeats, args.samples)["resident"]
    streams = {"resident, flat": dict(residency="resident")}
    for pool in args.pools:
        for eviction in ("lru", "flush") if args.flush else ("lru",):
            streams[f"{pool} % {eviction}"] = dict(
                residency="stream", geometryMemory=f"{pool}%", geometryEviction=eviction, waveSize=args.waveSize)
    runs = Measure(scene, streams, args.repeats, args.samples)
    again = Measure(scene, variants, args.repeats, args.samples)["resident"]
    resident = min(resident, again, key=lambda run: run["time"]["render"])
    geometry = resident["geometry"]
    touched = max(run["geometry"]["chunksTouched"] for run in runs.values()) / geometry["chunks"]
    print(f"\n### {name}\n\n{geometry['triangles']} triangles, {geometry['instances']} instances, {geometry['chunks']} chunks, "
          f"{geometry['bytesTotal'] / 1e6:.1f} MB, always resident {geometry['alwaysResidentBytes'] / 1e6:.2f} MB, "
          f"{100 * touched:.0f} % of the chunks touched; {args.width} pixels wide, {args.samples} samples, "
          f"resident wave {residents[best]['wave']['size']}\n")
    print(_HEAD)
    for label, run in {"resident": resident, **runs}.items():
        print(Row(label, run, resident, DeviceBytes(residents["0"])))
    if args.report:
        report = OpenScene(path, camera, args)
        common = dict(residency="stream", chunkBytes=_MESH_CHUNK, geometryEviction="flush", request="first", waveSize=args.waveSize)
        found = Measure(report, {f"{pool} % report's design": dict(common, geometryMemory=f"{pool}%") for pool in _REPORT_POOLS}, 1,
                        args.samples)
        for label, run in found.items():
            print(Row(label, run, resident, DeviceBytes(residents["0"])))
    sys.stdout.flush()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", nargs="*", default=list(GENERATED), help="FILE:CAMERA, or the name of a generated one")
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--chunkSize", type=int, default=_core.Settings().chunkBytes, help="bytes")
    parser.add_argument("--waveSize", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--pools", type=lambda text: [int(word) for word in text.split(",")], default=_POOLS)
    parser.add_argument("--inTurn", action="store_true", help="resident geometry takes turns with the pools")
    parser.add_argument("--flush", action="store_true", help="also with flush eviction")
    parser.add_argument("--report", action="store_true", help="also the report's design")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for stage in args.stages:
            path, _, camera = stage.partition(":")
            if stage in GENERATED:
                path, camera = f"{folder}/{stage}.usdc", "/World/Camera"
                GENERATED[stage](path)
            (RunInTurn if args.inTurn else RunStage)(stage, path, camera, args)


if __name__ == "__main__":
    main()
