# SPDX-License-Identifier: Apache-2.0
"""Noise and time against the number of lights: manyLights.py FOLDER [--stages streets,panels] [--counts 10,100,1000,10000,100000]

Two stages over streets between blocks:

  streets  small spheres of three powers at random, so that neither the power of all nor the lit ground changes with their
           number; but what each point sees of them does: one lamp among ten, a cloud among 10^5
  panels   three panels of different radiance, a ceiling and two that stand upright, cut into as many rects as there are
           lights: the picture is the same whatever the number, and so would be the noise of a perfect choice

Error is relMSE at equal samples: the mean of (x - a)(x - b) / (r^2 + 0.01) with two references a, b of other seeds and their
mean r, which is free of the references' noise; means of `--seeds` pictures. Time is seconds a sample, the least of the
pictures. Error times time is what the error would be after one second. Prints a Markdown table; manyLights.svg and .csv go to
FOLDER, each line over its first point. Flat is the bar.

With HDSTREAM_KERNEL_DIR naming a copy of kernels/ in which HDS_LIGHT_LOOP_MAX is 1024, counts up to 1000 are weighed one by
one: the error that a tree cannot beat.
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
# Of a panel: its middle, rotation (rects emit towards -z), size, radiance, and in how many rects it is cut, by count.
PANELS = (
    ((0, 8, 0), (-90, 0, 0), (32, 32), 1.0, {10: (2, 2), 100: (8, 5), 1000: (20, 20), 10000: (80, 50), 100000: (200, 200)}),
    ((-19, 3, 0), (0, -90, 0), (20, 5), 8.0, {10: (3, 1), 100: (6, 5), 1000: (20, 15), 10000: (60, 50), 100000: (200, 150)}),
    ((0, 3, 19), (0, 0, 0), (20, 5), 16.0, {10: (3, 1), 100: (6, 5), 1000: (20, 15), 10000: (60, 50), 100000: (200, 150)}),
)


def AddInstancer(stage, path: str, numPrototypes: int, places) -> None:
    """Lamp0, Lamp1, ... below `path`, in turn, at the places."""
    instancer = UsdGeom.PointInstancer.Get(stage, path)
    for i in range(numPrototypes):
        instancer.CreatePrototypesRel().AddTarget(f"{path}/Lamp{i}")
    instancer.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, place)) for place in places]))
    instancer.CreateProtoIndicesAttr(Vt.IntArray([i % numPrototypes for i in range(len(places))]))


def AddLamps(stage, random, count: int) -> None:
    """Spheres on the streets: not within 2.2 of a block's middle."""
    UsdGeom.PointInstancer.Define(stage, "/World/Lights")
    for i, power in enumerate(POWERS):
        author.AddLight(stage, f"/World/Lights/Lamp{i}", "Sphere", radius=RADIUS,
                        intensity=power * TOTAL / (count * np.mean(POWERS)))
    places = []
    while len(places) < count:
        x, z = random.uniform(-SIZE / 2, SIZE / 2, 2)
        if max(abs((x + 4) % 8 - 4), abs((z + 4) % 8 - 4)) > 2.2:
            places.append((x, random.uniform(0.3, 4.0), z))
    AddInstancer(stage, "/World/Lights", len(POWERS), places)


def AddPanels(stage, random, count: int) -> None:
    for i, (middle, rotate, size, radiance, cuts) in enumerate(PANELS):
        columns, rows = cuts[count]
        width, height = size[0] / columns, size[1] / rows
        path = f"/World/Panel{i}"
        author.Place(UsdGeom.PointInstancer.Define(stage, path), translate=middle, rotate=rotate)
        author.AddLight(stage, f"{path}/Lamp0", "Rect", width=width, height=height, intensity=radiance)
        AddInstancer(stage, path, 1, [((x + 0.5) * width - size[0] / 2, (y + 0.5) * height - size[1] / 2, 0)
                                      for y in range(rows) for x in range(columns)])


STAGES = {"streets": AddLamps, "panels": AddPanels}


def WriteStage(path: pathlib.Path, name: str, count: int) -> pathlib.Path:
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Ground", shapes.Plane(SIZE, SIZE), color=(0.6, 0.6, 0.6))
    random = np.random.default_rng(1)
    for i, (x, z) in enumerate((x, z) for x in range(-16, 17, 8) for z in range(-16, 17, 8)):
        author.AddMesh(stage, f"/World/Block{i}", shapes.Box(4, float(random.uniform(2, 6)), 4), color=(0.5, 0.45, 0.4),
                       translate=(x, 0, z))
    STAGES[name](stage, random, count)
    # Below the lamps, which would be specks of few samples each in the picture.
    author.AddCamera(stage, eye=(0, 0.25, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    stage.GetRootLayer().Save()
    return path


def Measure(args, name: str, count: int) -> dict:
    scene = Scene(WriteStage(args.folder / f"{name}{count}.usdc", name, count), "/World/Camera", imageWidth=args.width,
                  maxDepth=args.maxDepth)
    scene.Render(1)  # compiles
    references = [scene.Render(args.referenceSamples, seed=1000 + i)[0] for i in range(2)]
    middle = (references[0] + references[1]) / 2
    errors, seconds = [], []
    for seed in range(args.seeds):
        picture, statistics = scene.Render(args.samples, seed=seed)
        errors.append(np.mean((picture - references[0]) * (picture - references[1]) / (middle**2 + 0.01)))
        seconds.append(statistics["time"]["render"] / args.samples)
    row = dict(error=float(np.mean(errors)), seconds=min(seconds))
    return dict(row, effort=row["error"] * args.samples * row["seconds"])


def Bench(args, name: str, chart: Chart) -> None:
    print(f"\n{name}\n\n| lights | relMSE | over the first | ms a sample | over the first | relMSE after 1 s | over the first |")
    print("|---|---|---|---|---|---|---|")
    rows = []
    for count in args.counts:
        rows.append(Measure(args, name, count))
        row, first = rows[-1], rows[0]
        ratios = {key: row[key] / first[key] for key in row}
        print(f"| {count} | {row['error']:.3g} | {ratios['error']:.2f} | {1000 * row['seconds']:.2f} | "
              f"{ratios['seconds']:.2f} | {row['effort']:.3g} | {ratios['effort']:.2f} |", flush=True)
    for key, label in (("error", "relMSE"), ("effort", "relMSE x time")):
        chart.Add(f"{name}: {label}", args.counts, [row[key] / rows[0][key] for row in rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--stages", type=lambda text: text.split(","), default=list(STAGES))
    parser.add_argument("--counts", type=lambda text: [int(word) for word in text.split(",")],
                        default=[10, 100, 1000, 10000, 100000])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--referenceSamples", type=int, default=1024)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--maxDepth", type=int, default=0)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    chart = Chart("Many lights: error over that of the least number", "lights", "over the first")
    for name in args.stages:
        Bench(args, name, chart)
    chart.Save(str(args.folder / "manyLights"))


if __name__ == "__main__":
    main()
