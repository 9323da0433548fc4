# SPDX-License-Identifier: Apache-2.0
"""Peak memory of render delegates: hydraMemory.py SCENES OUT [--renderers Stream,Embree].

Runs OpenUSD's usdrecord once a renderer and stage, takes the peak resident set of the process, subtracts that
of a stage with a camera only, and prints a table in Markdown with the ratio of the first renderer to the last.
SCENES has chess/chess_preview.usda and bookstore/bookstore.usda. Needs usdrecord and pxr (OpenUSD with imaging).
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import time

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender, Vt

_COPIES = 50
_REPEATS = 5


def _AddCamera(stage: Usd.Stage, eye: Gf.Vec3d, target: Gf.Vec3d) -> None:
    up = Gf.Vec3d(0, 1, 0) if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y else Gf.Vec3d(0, 0, 1)
    camera = UsdGeom.Camera.Define(stage, "/main_cam")
    camera.AddTransformOp().Set(Gf.Matrix4d(1).SetLookAt(eye, target, up).GetInverse())
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1e6))


def _AddSettings(stage: Usd.Stage, subdivision: str, samples: int) -> None:
    settings = UsdRender.Settings.Define(stage, "/Render/settings").GetPrim()
    settings.CreateAttribute("hdstream:subdivision", Sdf.ValueTypeNames.String).Set(subdivision)
    settings.CreateAttribute("hdstream:samples", Sdf.ValueTypeNames.Int).Set(samples)
    stage.SetMetadata("renderSettingsPrimPath", "/Render/settings")


def _NewStage(path: pathlib.Path, like: pathlib.Path | None) -> Usd.Stage:
    path.unlink(missing_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    if like:
        layer = Usd.Stage.Open(str(like), Usd.Stage.LoadNone)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(layer))
        UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(layer))
    return stage


def _Bounds(path: pathlib.Path) -> Gf.Range3d:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.EarliestTime(), ["default", "render"])
    stage = Usd.Stage.Open(str(path))
    return cache.ComputeWorldBound(stage.GetPseudoRoot()).ComputeAlignedRange()


def MakeEmpty(path: pathlib.Path) -> None:
    stage = _NewStage(path, None)
    _AddCamera(stage, Gf.Vec3d(0, 0, 5), Gf.Vec3d(0))
    _AddSettings(stage, "cage", 1)
    stage.Save()


def MakeCopies(path: pathlib.Path, scene: pathlib.Path, subdivision: str, samples: int) -> None:
    """The scene as the prototype of a point instancer with 50 x 50 points on its ground."""
    bounds = _Bounds(scene)
    size = bounds.GetSize() * 1.1
    stage = _NewStage(path, scene)
    instancer = UsdGeom.PointInstancer.Define(stage, "/copies")
    prototype = stage.DefinePrim("/copies/prototypes/scene")
    source = Usd.Stage.Open(str(scene))
    root = source.GetDefaultPrim() or source.GetPseudoRoot().GetChildren()[0]
    prototype.GetReferences().AddReference(str(scene), root.GetPath())
    instancer.CreatePrototypesRel().AddTarget(prototype.GetPath())
    isYUp = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    positions = [Gf.Vec3f(x * size[0], 0, y * size[2]) if isYUp else Gf.Vec3f(x * size[0], y * size[1], 0)
                 for y in range(_COPIES) for x in range(_COPIES)]
    instancer.CreatePositionsAttr(Vt.Vec3fArray(positions))
    instancer.CreateProtoIndicesAttr(Vt.IntArray(len(positions), 0))
    far = Gf.Vec3d(positions[-1])
    middle = far / 2
    eye = middle + (Gf.Vec3d(0, 0.5, 0.8) if isYUp else Gf.Vec3d(0, -0.8, 0.5)) * far.GetLength()
    _AddCamera(stage, eye, middle)
    _AddSettings(stage, subdivision, samples)
    stage.Save()


def MakeWhole(path: pathlib.Path, scene: pathlib.Path, subdivision: str, samples: int) -> None:
    """The scene itself, seen from a corner of its bounds."""
    bounds = _Bounds(scene)
    stage = _NewStage(path, scene)
    stage.GetRootLayer().subLayerPaths.append(str(scene))
    corner = bounds.GetMidpoint() + bounds.GetSize() * 0.4
    _AddCamera(stage, corner, bounds.GetMidpoint())
    _AddSettings(stage, subdivision, samples)
    stage.Save()


def Record(stage: pathlib.Path, image: pathlib.Path, renderer: str, samples: int) -> tuple[float, float]:
    """Renders a stage some times; the medians of peak resident MB and of seconds."""
    runs = [_RecordOnce(stage, image, renderer, samples) for _ in range(_REPEATS)]
    return statistics.median(mb for mb, _ in runs), statistics.median(seconds for _, seconds in runs)


def _RecordOnce(stage: pathlib.Path, image: pathlib.Path, renderer: str, samples: int) -> tuple[float, float]:
    command = ["usdrecord", "--disableGpu", "--renderer", renderer, "--imageWidth", "320", "--camera", "/main_cam",
               "--complexity", "low", "--renderSettingsPrimPath", "/Render/settings", str(stage), str(image)]
    environment = {**os.environ, "HDEMBREE_SAMPLES_TO_CONVERGENCE": str(samples)}
    start = time.monotonic()
    with open(image.with_suffix(".log"), "w") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
    if status != 0 or not image.exists():
        sys.exit(f"usdrecord failed: {' '.join(command)}; see {log.name}")
    return usage.ru_maxrss / 1024, time.monotonic() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--renderers", default="Stream,Embree")
    parser.add_argument("--samples", type=int, default=4)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    renderers = arguments.renderers.split(",")
    chess = (arguments.scenes / "chess/chess_preview.usda").resolve()
    bookstore = (arguments.scenes / "bookstore/bookstore.usda").resolve()
    MakeEmpty(arguments.out / "empty.usda")
    empty = {renderer: Record(arguments.out / "empty.usda", arguments.out / f"empty{renderer}.exr", renderer, 1)[0]
             for renderer in renderers}
    print("empty stage:", ", ".join(f"{renderer} {mb:.0f} MB" for renderer, mb in empty.items()), flush=True)
    columns = " | ".join(f"{renderer} MB | s" for renderer in renderers)
    print(f"\n| stage | subdivision | {columns} | ratio |\n|{'---|' * (3 + 2 * len(renderers))}")
    for name, make, scene in (("chess, 50 x 50", MakeCopies, chess), ("bookstore", MakeWhole, bookstore)):
        for subdivision in ("cage", "adaptive"):
            stage = arguments.out / f"{scene.stem}-{subdivision}.usda"
            make(stage, scene, subdivision, arguments.samples)
            cells, memory = [], []
            for renderer in renderers:
                peak, seconds = Record(stage, stage.with_name(f"{stage.stem}-{renderer}.exr"), renderer,
                                       arguments.samples)
                memory.append(peak - empty[renderer])
                cells.append(f"{memory[-1]:.0f} | {seconds:.1f}")
            print(f"| {name} | {subdivision} | {' | '.join(cells)} | {memory[0] / memory[-1]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
