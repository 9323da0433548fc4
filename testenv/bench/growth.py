# SPDX-License-Identifier: Apache-2.0
"""Time and memory against the number of triangles, and of instances: growth.py [triangles] [instances] [options]

Unique trees (testenv/stages/grove.py) with a budget of 512 MiB, and instances of five trees, one process a render.
Prints a table, and writes charts (SVG) with their numbers (CSV) to --out. What is asked: traversal grows like the
logarithm, preparation linearly, the pool not at all. `resident` renders, from the cache that the streamed one has
filled, give the time of a ray without streaming; they are left out above --residentLimit.
"""

import argparse
import gc
import json
import pathlib
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import AnonymousPeak, FreshCache, Record, RunFailed  # noqa: E402
from stages import bench, grove  # noqa: E402
from support.svgChart import Chart  # noqa: E402

_INSIDE = "/World/Inside"
_SPECIES = 5


def WriteTriangles(path: str, size: int) -> str:
    grove.WriteGrove(path, size)
    return _INSIDE


def WriteInstances(path: str, size: int) -> str:
    bench.WriteForest(path, instances=size, species=_SPECIES)
    return "/World/Camera"


_KINDS = {"triangles": (WriteTriangles, (1_000_000, 5_000_000, 20_000_000, 80_000_000)),
          "instances": (WriteInstances, (10**3, 10**4, 10**5, 10**6, 10**7))}


def Figures(run: dict, size: int, anonymousPeak: int, resident=None) -> dict:
    """A row."""
    time, memory, geometry, rays = run["time"], run["memory"], run["geometry"], run["rays"]

    def MicrosecondsPerRay(stats):
        return 1e6 * stats["time"]["trace"] / sum(stats["rays"][kind] for kind in ("camera", "indirect", "shadow"))

    return {"size": size, "triangles": geometry["triangles"], "instances": geometry["instances"], "chunks": geometry["chunks"],
            "bytes": geometry["bytesTotal"], "translate": time["load"] + time["translate"], "prepare": time["prepare"],
            "render": time["render"], "perRay": MicrosecondsPerRay(run),
            "perRayResident": MicrosecondsPerRay(resident) if resident else None,
            "pool": geometry["budget"], "alwaysResident": geometry["alwaysResidentBytes"], "pathState": memory["pathState"],
            "tables": memory["tables"], "devicePeak": memory["devicePeak"], "hostPeak": memory["hostPeak"],
            "anonymousPeak": anonymousPeak,
            "touched": geometry["chunksTouched"], "built": geometry["chunksBuilt"], "uploaded": geometry["uploadedBytes"],
            "cpu": run["cpuSeconds"]}


def Row(row: dict) -> str:
    allowed = 0.005 * row["bytes"] + 100 * row["instances"]
    resident = f"{row['perRayResident']:.2f}" if row["perRayResident"] else "-"
    cells = [f"{row['size']:,}", f"{row['triangles']:,}", f"{row['chunks']:,}", f"{row['bytes'] / 1e6:.1f}", f"{row['translate']:.2f}",
             f"{row['prepare']:.2f}", f"{row['render']:.2f}", f"{row['cpu']:.1f}", f"{row['perRay']:.2f}", resident,
             *(f"{row[name] / 1e6:.1f}" for name in ("pool", "alwaysResident")), f"{row['alwaysResident'] / allowed:.2f}",
             *(f"{row[name] / 1e6:.1f}" for name in ("tables", "pathState", "devicePeak", "hostPeak", "anonymousPeak"))]
    return "| " + " | ".join(cells) + " |"


HEAD = ("| size | triangles | chunks | page MB | read USD s | prepare s | render s | CPU s of the process | us a ray | resident | pool MB | always "
        "resident MB | of what is allowed | tables MB | path state MB | device peak MB | host peak MB | without pages of files MB |\n" + "|---" * 18 + "|")


def Measure(kind: str, sizes, args) -> list:
    write = _KINDS[kind][0]
    rows = []
    print(f"\n### {kind}\n\n{HEAD}", flush=True)
    for size in sizes:
        with tempfile.TemporaryDirectory(dir=args.scratch) as folder:
            try:
                stage = f"{folder}/stage.usdc"
                options = dict(camera=write(stage, size), imageWidth=args.width, samples=args.samples)
                gc.collect()
                cache = FreshCache(f"{folder}/cache")
                anonymous = AnonymousPeak()
                run = Record(stage, cache, args.limit, onPoll=anonymous, residency="stream", geometryMemory="512M", prepare=args.prepare, **options)
                resident = Record(stage, cache, args.limit, residency="resident", **options) if size <= args.residentLimit else None
            except (RunFailed, MemoryError) as error:
                print(f"<!-- {size:,}: {error} -->", flush=True)
                break
        rows.append(Figures(run, size, anonymous.bytes, resident))
        print(Row(rows[-1]), flush=True)
    return rows


def Charts(kind: str, rows: list) -> dict:
    """By the end of their file names."""
    sizes = [row["size"] for row in rows]
    time = Chart(f"Time against {kind}", kind, "seconds")
    for name in ("translate", "prepare", "render"):
        time.Add("read USD" if name == "translate" else name, sizes, [row[name] for row in rows])
    trace = Chart(f"Tracing against {kind}", kind, "microseconds a ray")
    trace.Add("512 MiB pool", sizes, [row["perRay"] for row in rows])
    trace.Add("resident", sizes, [row["perRayResident"] for row in rows])
    memory = Chart(f"Memory against {kind}", kind, "bytes")
    for label, name in (("all pages", "bytes"), ("pool", "pool"), ("always resident", "alwaysResident"),
                        ("path state", "pathState"), ("host, peak", "hostPeak")):
        memory.Add(label, sizes, [row[name] for row in rows])
    return {"time": time, "trace": trace, "memory": memory}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(_KINDS))
    parser.add_argument("--sizes", type=lambda text: [int(float(word)) for word in text.split(",")])
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--prepare", default="eager", help="eager: all triangles are prepared, whatever rays meet")
    parser.add_argument("--residentLimit", type=float, default=2.5e7, help="largest size that is also rendered resident")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one render")
    parser.add_argument("--out", type=pathlib.Path, help="folder of the charts")
    parser.add_argument("--rows", type=pathlib.Path, help="JSON file that keeps rows, so that sizes can be measured apart")
    parser.add_argument("--scratch", help="folder for stages and caches")
    args = parser.parse_args()
    for kind in args.kinds:
        kept = json.loads(args.rows.read_text()) if args.rows and args.rows.exists() else {}
        rows = {row["size"]: row for row in kept.get(kind, []) + Measure(kind, args.sizes or _KINDS[kind][1], args)}
        rows = sorted(rows.values(), key=lambda row: row["size"])
        if args.rows:
            args.rows.write_text(json.dumps({**kept, kind: rows}))
        if args.out and len(rows) > 1:
            args.out.mkdir(parents=True, exist_ok=True)
            for name, chart in Charts(kind, rows).items():
                chart.Save(args.out / f"growth-{kind}-{name}")


if __name__ == "__main__":
    main()
