# SPDX-License-Identifier: Apache-2.0
"""Noise and time against the number of lights: manyLights.py FOLDER [--counts 10,100,1000,10000,100000] [--samples 16]

Small spheres of three powers, spread evenly at random over streets between blocks, so that neither the power of all nor the
lit ground changes with their number. Error is relMSE at equal samples: the mean of (x - a)(x - b) / (r^2 + 0.01) with two
references a, b of other seeds and their mean r, which is free of the references' noise; means of `--seeds` pictures. Time is
seconds a sample, the least of the pictures. Prints a Markdown table; manyLights.svg and .csv go to FOLDER. Both columns flat
is the bar.
"""

import argparse
import pathlib
import sys

import numpy as np
from pxr import Gf, UsdGeom, Vt

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.sceneRun import Scene  # noqa: E402
from stages import author, shapes  # noqa: E402
from support.svgChart import Chart  # noqa: E402

SIZE = 40.0  # of the ground
POWERS = (1.0, 4.0, 16.0)
RADIUS = 0.02
TOTAL = 4.0e5  # sum of intensities


def WriteStage(path: pathlib.Path, count: int) -> pathlib.Path:
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Ground", shapes.Plane(SIZE, SIZE), color=(0.6, 0.6, 0.6))
    random = np.random.default_rng(1)
    for i, (x, z) in enumerate((x, z) for x in range(-16, 17, 8) for z in range(-16, 17, 8)):
        author.AddMesh(stage, f"/World/Block{i}", shapes.Box(4, float(random.uniform(2, 6)), 4), color=(0.5, 0.45, 0.4),
                       translate=(x, 0, z))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Lights")
    for i, power in enumerate(POWERS):
        author.AddLight(stage, f"/World/Lights/Lamp{i}", "Sphere", radius=RADIUS,
                        intensity=power * TOTAL / (count * np.mean(POWERS)))
        instancer.CreatePrototypesRel().AddTarget(f"/World/Lights/Lamp{i}")
    places = []
    while len(places) < count:  # on the streets: within 2 of no block's middle
        x, z = random.uniform(-SIZE / 2, SIZE / 2, 2)
        if max(abs((x + 4) % 8 - 4), abs((z + 4) % 8 - 4)) > 2.2:
            places.append((x, random.uniform(0.3, 4.0), z))
    instancer.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, place)) for place in places]))
    instancer.CreateProtoIndicesAttr(Vt.IntArray([i % len(POWERS) for i in range(count)]))
    # Below the lamps, which would be specks of few samples each in the picture.
    author.AddCamera(stage, eye=(0, 0.25, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    stage.GetRootLayer().Save()
    return path


def Measure(args, count: int) -> dict:
    scene = Scene(WriteStage(args.folder / f"lights{count}.usdc", count), "/World/Camera", imageWidth=args.width,
                  maxDepth=args.maxDepth)
    scene.Render(1)  # compiles
    references = [scene.Render(args.referenceSamples, seed=1000 + i)[0] for i in range(2)]
    middle = (references[0] + references[1]) / 2
    errors, seconds = [], []
    for seed in range(args.seeds):
        picture, statistics = scene.Render(args.samples, seed=seed)
        errors.append(np.mean((picture - references[0]) * (picture - references[1]) / (middle**2 + 0.01)))
        seconds.append(statistics["time"]["render"] / args.samples)
    return dict(count=count, error=float(np.mean(errors)), seconds=min(seconds))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--counts", type=lambda text: [int(word) for word in text.split(",")],
                        default=[10, 100, 1000, 10000, 100000])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--referenceSamples", type=int, default=1024)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--maxDepth", type=int, default=0)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    rows = []
    print("| lights | relMSE | over the first | ms a sample | over the first |")
    print("|---|---|---|---|---|")
    for count in args.counts:
        rows.append(Measure(args, count))
        row, first = rows[-1], rows[0]
        print(f"| {count} | {row['error']:.3g} | {row['error'] / first['error']:.2f} | {1000 * row['seconds']:.2f} | "
              f"{row['seconds'] / first['seconds']:.2f} |", flush=True)
    chart = Chart("many lights, over the least number of them", "lights", "over the first")
    for name in ("error", "seconds"):
        chart.Add("relMSE" if name == "error" else "time", [row["count"] for row in rows],
                  [row[name] / rows[0][name] for row in rows])
    chart.Save(str(args.folder / "manyLights"))


if __name__ == "__main__":
    main()
