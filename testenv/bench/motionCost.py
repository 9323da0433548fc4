# SPDX-License-Identifier: Apache-2.0
"""What motion blur costs (docs/motionBlur.md, "Boxes"): CPU seconds of renders of spheres on a floor, over those at rest.

    motionCost.py [--kinds slide,turn,grow,camera] [--width 320] [--samples 16] [--repeats 3] [--short]

Each repeat renders the stage at rest and every kind once, interleaved, in this process; ratios are those within a repeat. The stage
at rest has the same shutter and nothing that moves; `--traversal simd8` walks it level by level, as what moves is walked. Run with
PYTHONPATH=build/release/python."""

import argparse
import pathlib
import resource
import statistics
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

import numpy as np  # noqa: E402
from bench.sceneRun import Scene  # noqa: E402
from pxr import Gf, UsdGeom  # noqa: E402
from stages import author, motion, shapes  # noqa: E402

KINDS = ("slide", "turn", "grow", "camera")


def WriteStage(path, kind: str, number: int) -> str:
    """`number`^2 spheres on a floor below a sky. All, or the camera, go a tenth to a half of a sphere's radius in the open shutter."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(60, 60), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    rng = np.random.default_rng(7)
    ball = shapes.Sphere(0.4, 24, 48)
    for i in range(number * number):
        way = rng.uniform(-0.2, 0.2, 3) * (1.0, 0.0, 1.0)
        place = np.array([i % number - 0.5 * number, 0.45, i // number - 0.5 * number])
        mesh = author.AddMesh(stage, f"/World/Ball{i}", ball, color=tuple(rng.uniform(0.2, 0.8, 3)))
        isMoved = kind in ("slide", "turn", "grow")
        motion.AddWay(mesh, place - way * isMoved, place + way * isMoved, degrees=40.0 if kind == "turn" else 0.0)
        if kind == "grow":
            scale = UsdGeom.Xformable(mesh).AddScaleOp()
            scale.Set(Gf.Vec3f(0.9), 0.0)
            scale.Set(Gf.Vec3f(1.1, 1.0, 1.1), 2.0)
    camera = author.AddCamera(stage, eye=(0, 8, 14), target=(0, 0, 0), focalLength=30.0)
    camera.CreateShutterOpenAttr(motion.SHUTTER[0])
    camera.CreateShutterCloseAttr(motion.SHUTTER[1])
    if kind == "camera":
        slide = UsdGeom.Xformable(camera).AddTranslateOp(opSuffix="way")
        slide.Set(Gf.Vec3d(-0.2, 0, 0), 0.0)
        slide.Set(Gf.Vec3d(0.2, 0, 0), 2.0)
    stage.GetRootLayer().Save()
    return str(path)


def CpuSeconds(scene: Scene, samples: int) -> float:
    before = resource.getrusage(resource.RUSAGE_SELF)
    scene.Render(samples)
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", type=lambda text: text.split(","), default=list(KINDS))
    parser.add_argument("--number", type=int, default=20, help="spheres along an edge of the square")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--traversal", default="auto", help="of all renders")
    parser.add_argument("--short", action="store_true")
    args = parser.parse_args()
    if args.short:
        args.number, args.width, args.samples, args.repeats = 2, 32, 1, 1
    with tempfile.TemporaryDirectory() as folder:
        settings = dict(cacheDirectory=f"{folder}/cache", imageWidth=args.width, imageHeight=args.width * 9 // 16, residency="resident",
                        traversal=args.traversal, timeCode=motion.FRAME, shutter=motion.SHUTTER)
        scenes = {kind: Scene(WriteStage(pathlib.Path(folder) / f"{kind}.usda", kind, args.number), "/World/Camera", **settings)
                  for kind in ("rest", *args.kinds)}
        pictures = {kind: scene.Render(args.samples)[0] for kind, scene in scenes.items()}  # kernels and pages are there then
        still = [kind for kind in args.kinds if np.array_equal(pictures[kind], pictures["rest"])]
        assert not still, f"nothing is blurred: {still}"
        seconds = [{kind: CpuSeconds(scene, args.samples) for kind, scene in scenes.items()} for _ in range(args.repeats)]
    print("| what moves | CPU seconds | over rest |")
    print("|---|---|---|")
    for kind in scenes:
        ratios = [row[kind] / row["rest"] for row in seconds]
        print(f"| {kind} | {statistics.median(row[kind] for row in seconds):.2f} | {statistics.median(ratios):.2f} "
              f"({min(ratios):.2f} to {max(ratios):.2f}) |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
