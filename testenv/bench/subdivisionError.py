# SPDX-License-Identifier: Apache-2.0
"""Picture error of adaptive subdivision over uniform levels: subdivisionError.py STAGE CAMERA FOLDER [--levels 0,1,2,3,4]

Renders the stage with its cages, at uniform levels and adaptively, streamed, one process each. The reference is the highest level;
error is relMSE of the converged pictures, the mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels: each surface is rendered with
two seeds, and the product of the two differences has no bias by noise. Beside it the mean angle between the normals of first hits, in
degrees. Bar for adaptive: 1e-4 at a tenth of the triangles. The charts have error against triangles and against seconds of
rendering, preparation included, of the first seed.
"""

import argparse
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import FreshCache, Record  # noqa: E402
from stages import imageFile  # noqa: E402
from support.svgChart import Chart  # noqa: E402


def _Render(args, **options):
    """Colours of two seeds, unit normals, statistics of the first."""
    cache = FreshCache(args.folder / "cache", args.folder / "kernels")
    colors, normals, runs = [], [], []
    for seed in (1, 2):
        run = Record(args.stage, cache, camera=args.camera, imageWidth=args.width, imageHeight=args.height,
                     samples=args.samples, maxDepth=args.maxDepth, aovs="color,normal", residency="stream",
                     geometryMemory=args.geometryMemory, seed=seed, **options)
        picture = args.folder / "picture.exr"
        picture.write_bytes(run["pictureBytes"])
        channels = imageFile.ReadExr(picture)
        colors.append(np.stack([channels[name] for name in "RGB"], axis=-1).astype(float))
        normals.append(np.stack([channels[f"normal.{name}"] for name in "XYZ"], axis=-1).astype(float))
        runs.append(run)
    return np.stack(colors), normals[0], runs[0]


def _RelMse(colors, reference) -> float:
    """\param colors, reference [2][height][width][3], of the same two seeds."""
    differences = colors - reference
    return float(np.mean(differences[0] * differences[1] / (reference.mean(axis=0) ** 2 + 0.01)))


def _Angle(normal, reference) -> float:
    cross = np.linalg.norm(np.cross(normal, reference), axis=-1)
    dot = (normal * reference).sum(axis=-1)
    isHit = (np.linalg.norm(normal, axis=-1) > 0.5) & (np.linalg.norm(reference, axis=-1) > 0.5)
    return float(np.degrees(np.arctan2(cross, dot)[isHit].mean()))


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
    parser.add_argument("--out", help="stem of the charts")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    FreshCache(args.folder / "kernels")
    Record(args.stage, args.folder / "kernels", camera=args.camera, imageWidth=64, samples=1, aovs="color,normal",
           residency="stream")
    levels = sorted(args.levels, reverse=True)
    reference = _Render(args, subdivision="complexity", complexity=levels[0])
    runs = {f"uniform {level}": _Render(args, subdivision="complexity", complexity=level) for level in levels[1:]}
    runs["cage"] = _Render(args, subdivision="cage")
    runs["adaptive"] = _Render(args)
    runs[f"uniform {levels[0]}"] = reference
    print("| surfaces | triangles | of the reference's | built | prepare s | render s | relMSE | normal, degrees |")
    print("|---" * 8 + "|")
    points = {}
    for name, (colors, normal, run) in runs.items():
        geometry, time = run["geometry"], run["time"]
        error = _RelMse(colors, reference[0])
        points[name] = (geometry["triangles"], time["render"], error)
        print(f"| {name} | {geometry['triangles']:,} | {geometry['triangles'] / reference[2]['geometry']['triangles']:.2g} | "
              f"{geometry['chunksBuilt'] / max(1, geometry['chunks']):.2f} | {time['prepare']:.2f} | {time['render']:.2f} | "
              f"{error:.2g} | {_Angle(normal, reference[1]):.2g} |")
    if args.out:
        uniform = [points[f"uniform {level}"] for level in sorted(levels)[:-1]]
        for index, label in enumerate(("triangles", "seconds")):
            chart = Chart("error of subdivided surfaces", label, "relMSE")
            chart.Add("uniform levels", [point[index] for point in uniform], [point[2] for point in uniform])
            for name in ("cage", "adaptive"):
                chart.Add(name, [points[name][index]], [points[name][2]])
            chart.Save(f"{args.out}-{label}")


if __name__ == "__main__":
    main()
