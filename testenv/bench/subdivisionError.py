# SPDX-License-Identifier: Apache-2.0
"""Picture error of adaptive subdivision over uniform levels: subdivisionError.py STAGE CAMERA FOLDER [--levels 0,1,2,3,4] [--autobump]

Renders the stage with its cages, at uniform levels and adaptively, streamed, one process each. The reference is the highest level;
error is relMSE of the converged pictures, the mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels: each surface is rendered with
two seeds, and the product of the two differences has no bias by noise. Beside it the mean angle between the normals of first hits, in
degrees. Bar for adaptive: 1e-4 at a tenth of the triangles. The charts have error against triangles and against seconds of
rendering, preparation included, of the first seed; CPU seconds are of its whole process. With --autobump uniform levels are drawn
once more where displacement is not added to shading, and the reference has none of it in its shading.
"""

import argparse
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import FreshCache, Record  # noqa: E402
from stages import imageFile  # noqa: E402
from support.svgChart import Chart  # noqa: E402


def _Render(args, stage=None, **options):
    """Colours of two seeds, unit normals, statistics of the first. \\param stage other than that of the arguments."""
    cache = FreshCache(args.folder / "cache", args.folder / "kernels")
    colors, normals, runs = [], [], []
    for seed in (1, 2):
        run = Record(stage or args.stage, cache, camera=args.camera, imageWidth=args.width, imageHeight=args.height,
                     samples=args.samples, maxDepth=args.maxDepth, aovs="color,normal", residency="stream",
                     geometryMemory=args.geometryMemory, seed=seed, **options)
        picture = args.folder / "picture.exr"
        picture.write_bytes(run["pictureBytes"])
        channels = imageFile.ReadExr(picture)
        colors.append(np.stack([channels[name] for name in "RGB"], axis=-1).astype(float))
        normals.append(np.stack([channels[f"normal.{name}"] for name in "XYZ"], axis=-1).astype(float))
        runs.append(run)
    return np.stack(colors), normals[0], runs[0]


def _Refusing(stage, folder):
    """A stage with the same prims, whose shading adds nothing to displacement."""
    from pxr import Sdf, Usd, UsdGeom
    path = str(folder / "refusing.usda")
    layer = Sdf.Layer.FindOrOpen(path) or Sdf.Layer.CreateNew(path)
    layer.Clear()
    layer.subLayerPaths.append(str(pathlib.Path(stage).resolve()))
    refusing = Usd.Stage.Open(layer)
    for prim in refusing.GetPseudoRoot().GetChildren():
        UsdGeom.PrimvarsAPI(prim).CreatePrimvar("hdstream:autobump", Sdf.ValueTypeNames.Bool, "constant").Set(False)
    layer.Save()
    return path


def _RelMse(colors, reference) -> float:
    """\param colors, reference [2][height][width][3], of the same two seeds."""
    differences = colors - reference
    return float(np.mean(differences[0] * differences[1] / (reference.mean(axis=0) ** 2 + 0.01)))


def _Angle(normal, reference) -> float:
    cross = np.linalg.norm(np.cross(normal, reference), axis=-1)
    dot = (normal * reference).sum(axis=-1)
    isHit = (np.linalg.norm(normal, axis=-1) > 0.5) & (np.linalg.norm(reference, axis=-1) > 0.5)
    return float(np.degrees(np.arctan2(cross, dot)[isHit].mean()))


def Measure(args) -> list:
    """Rows, from the coarsest level to the reference."""
    args.folder.mkdir(parents=True, exist_ok=True)
    FreshCache(args.folder / "kernels")
    Record(args.stage, args.folder / "kernels", camera=args.camera, imageWidth=64, samples=1, aovs="color,normal",
           residency="stream")
    levels = sorted(args.levels, reverse=True)
    refusing = _Refusing(args.stage, args.folder) if args.autobump else None
    reference = _Render(args, refusing, subdivision="complexity", complexity=levels[0])
    runs = {f"uniform {level}": _Render(args, subdivision="complexity", complexity=level) for level in reversed(levels[1:])}
    if refusing:
        runs.update({f"triangles alone {level}": _Render(args, refusing, subdivision="complexity", complexity=level)
                     for level in reversed(levels[1:])})
    runs["cage"] = _Render(args, subdivision="cage")
    runs["adaptive"] = _Render(args)
    runs[f"uniform {levels[0]}"] = reference
    rows = []
    for name, (colors, normal, run) in runs.items():
        geometry, time = run["geometry"], run["time"]
        rows.append(dict(name=name, triangles=geometry["triangles"], built=geometry["chunksBuilt"] / max(1, geometry["chunks"]),
                         share=geometry["triangles"] / reference[2]["geometry"]["triangles"], prepare=time["prepare"],
                         render=time["render"], cpu=run["cpuSeconds"], error=_RelMse(colors, reference[0]), angle=_Angle(normal, reference[1])))
    return rows


def ErrorChart(rows: list, key: str, label: str) -> Chart:
    """Error of all but the reference, which is the last row."""
    chart = Chart("error of subdivided surfaces", label, "relMSE")
    series = {"uniform": "uniform levels", "triangles": "uniform levels, triangles alone"}
    for start, label in series.items():
        uniform = [row for row in rows[:-1] if row["name"].startswith(start)]
        if uniform:
            chart.Add(label, [row[key] for row in uniform], [row["error"] for row in uniform])
    for row in rows[:-1]:
        if not row["name"].startswith(tuple(series)):
            chart.Add(row["name"], [row[key]], [row["error"]])
    return chart


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("camera")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--levels", type=lambda text: [int(word) for word in text.split(",")], default=[0, 1, 2, 3, 4])
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--maxDepth", type=int, default=2)
    parser.add_argument("--geometryMemory", default="8G")
    parser.add_argument("--autobump", action="store_true", help="uniform levels also without displacement in the shading")
    parser.add_argument("--out", help="stem of the charts")
    args = parser.parse_args()
    rows = Measure(args)
    print("| surfaces | triangles | of the reference's | built | prepare s | render s | CPU s | relMSE | normal, degrees |")
    print("|---" * 9 + "|")
    for row in rows:
        print(f"| {row['name']} | {row['triangles']:,} | {row['share']:.2g} | {row['built']:.2f} | {row['prepare']:.2f} | "
              f"{row['render']:.2f} | {row['cpu']:.1f} | {row['error']:.2g} | {row['angle']:.2g} |")
    if args.out:
        ErrorChart(rows, "triangles", "triangles").Save(f"{args.out}-triangles")
        ErrorChart(rows, "render", "seconds").Save(f"{args.out}-seconds")


if __name__ == "__main__":
    main()
