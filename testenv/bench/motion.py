#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What motion blur costs: time and bytes with the shutter open and closed.

`motion.py FOLDER [--width W] [--samples S] [--rounds R]` renders, with resident geometry, a stage in which nothing moves (the ratio
must be 1.00: the kernels are the same) and stages in which instances, points and the camera move, and prints a table. Rounds
alternate; the least times count. Correctness is not judged.
"""

import argparse
import json
import pathlib
import sys

import numpy as np
from pxr import UsdGeom

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from stages import author, motion, shapes  # noqa: E402

_INSTANCES = 400


def _WriteStill(path):
    stage = author.NewStage(path)
    _AddSwarm(stage, 0.0)
    _Finish(stage)


def _WriteInstances(path):
    stage = author.NewStage(path)
    _AddSwarm(stage, 0.5)
    _Finish(stage)


def _AddSwarm(stage, reach):
    """Spheres that move by up to `reach`."""
    rng = np.random.default_rng(1)
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Swarm")
    author.AddMesh(stage, "/World/Swarm/Ball", shapes.Sphere(0.15, 32, 64), color=(0.7, 0.5, 0.3))
    swarm.CreatePrototypesRel().SetTargets(["/World/Swarm/Ball"])
    swarm.CreateProtoIndicesAttr([0] * _INSTANCES)
    first = rng.uniform(-2, 2, (_INSTANCES, 3))
    positions = swarm.CreatePositionsAttr()
    for time, way in ((0.0, -1.0), (2.0, 1.0)) if reach else ((0.0, 0.0),):
        positions.Set((first + way * reach * rng.uniform(-1, 1, first.shape)).tolist(), time)


def _WritePoints(path):
    stage = author.NewStage(path)
    grid = motion.Grid(300)
    mesh = author.AddMesh(stage, "/World/Sheet", grid, color=(0.7, 0.5, 0.3), scale=2.0)
    bump = 0.2 * np.sin(9 * grid.points[:, 0]) * np.cos(7 * grid.points[:, 1])
    motion.SetPoints(mesh, grid.points + np.stack([0 * bump, 0 * bump, bump], -1), grid.points - np.stack([0 * bump, bump, bump], -1))
    _Finish(stage)


def _WriteCamera(path):
    stage = author.NewStage(path)
    _AddSwarm(stage, 0.0)
    _Finish(stage, moves=True)


def _Finish(stage, moves=False):
    author.AddMesh(stage, "/World/Wall", shapes.Plane(12, 12), color=(0.4, 0.4, 0.4), translate=(0, 0, -2.5), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    camera = author.AddCamera(stage, eye=(0, 0, 7), focalLength=40.0)
    camera.CreateShutterOpenAttr(motion.SHUTTER[0])
    camera.CreateShutterCloseAttr(motion.SHUTTER[1])
    if moves:
        camera.ClearXformOpOrder()
        motion.AddWay(camera, (-0.3, 0, 7), (0.3, 0, 7), degrees=10.0)
    stage.GetRootLayer().Save()


def _Measure(path, arguments):
    """(statistics without blur, with): of the round in which tracing took least."""
    import hdstream

    renderers = {blur: hdstream.Renderer(str(path)) for blur in ("off", "on")}
    best = {}
    for index in range(arguments.rounds + 1):  # the first one compiles and prepares
        for blur, renderer in renderers.items():
            image = renderer.Render(motion.FRAME, camera="/World/Camera", imageWidth=arguments.width, residency="resident",
                                    samples=1 if index == 0 else arguments.samples, motionBlur=blur)
            if index > 0 and (blur not in best or image.statistics["time"]["render"] < best[blur]["time"]["render"]):
                best[blur] = image.statistics
    return best["off"], best["on"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    writers = {"nothing moves": _WriteStill, "instances": _WriteInstances, "points": _WritePoints, "camera": _WriteCamera}
    print("| what moves | s without blur | s with | ratio | Mrays/s without | with | pages MB without | with | always resident KB without | with |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, write in writers.items():
        path = arguments.folder / f"{name.replace(' ', '')}.usdc"
        write(path)
        off, on = _Measure(path, arguments)
        cells = [f"{run['time']['render']:.2f}" for run in (off, on)] + [f"{on['time']['render'] / off['time']['render']:.2f}"]
        cells += [f"{run['rays']['perSecond'] / 1e6:.2f}" for run in (off, on)]
        cells += [f"{run['geometry']['bytesTotal'] / 1e6:.1f}" for run in (off, on)]
        cells += [f"{run['geometry']['alwaysResidentBytes'] / 1e3:.0f}" for run in (off, on)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
        json.dump({"off": off, "on": on}, (arguments.folder / f"{path.stem}.json").open("w"))


if __name__ == "__main__":
    main()
