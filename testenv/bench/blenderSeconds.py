# SPDX-License-Identifier: Apache-2.0
"""Seconds inside Blender from pressing render to an error, Stream beside Cycles: blenderSeconds.py SCENES [--stages NAME ...].

Imports real stages of the folder SCENES as Blender does, with its own materials, lights and camera, and renders each by both in
turns, 1, 2, 4, ... samples. Every render is a new one, nothing is kept but kernels on disk: what counts is all that passes
until the operator returns, export, sync, preparation and the file included. The error of a picture is relMSE (rivalsLadder)
against two halves by the same renderer, so that what Blender hands over differently is not counted as noise. Settings are
those of an honest comparison (rivalsCycles.Configure): no denoiser, no adaptive sampling, no clamping, the box filter.

Runs in a Python that can import bpy, for whose OpenUSD the plug-in of the build was made ($HDSTREAM_TEST_BUILD).
"""

import argparse
import os
import pathlib
import sys
import tempfile
import time

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "hydra")]

import blenderRows  # noqa: E402
import bpy  # noqa: E402
import rivalsCycles  # noqa: E402
import rivalsLadder  # noqa: E402
import rivalsStages  # noqa: E402
from blenderProcess import RunAndExit  # noqa: E402

_MAX_DEPTH = 8
_MOST_SECONDS = 90.0  # a ladder ends below a rung that would take longer


class _Watch:
    """The last statistics that the engine has shown."""

    def __init__(self):
        engine = next(item for item in bpy.types.HydraRenderEngine.__subclasses__()
                      if getattr(item, "bl_idname", "") == "HYDRA_STREAM")
        show = engine._Show
        self.times = {}

        def Show(this, status, title):
            self.times = (status["statistics"] or {}).get("time", self.times)
            show(this, status, title)

        engine._Show = Show


def Import(name: str, scenes: str, width: int):
    """The scene of a stage, with its camera; a world of radiance 1 where it has no lights."""
    stage = rivalsStages.Make(name, scenes, pathlib.Path("."))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.wm.usd_import(filepath=stage.path, import_guide=False, import_proxy=False, import_render=True, set_frame_range=False)
    wanted = stage.camera.rsplit("/", 1)[1]
    cameras = [item for item in scene.objects if item.type == "CAMERA"]
    scene.camera = next((item for item in cameras if wanted in (item.name, item.data.name)), cameras[0] if cameras else None)
    if scene.camera is None:
        raise SystemExit(f"{name}: Blender has imported no camera")
    if scene.world is None and not any(item.type == "LIGHT" for item in scene.objects):
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    job = dict(width=width, height=width * 3 // 4, maxDepth=_MAX_DEPTH, threads=os.cpu_count())
    rivalsCycles.Configure(scene, job)
    scene.render.use_persistent_data = False
    scene.render.image_settings.color_mode = "RGB"
    final = scene.hdstream.final
    final.maxDepth, final.pixelFilter, final.pixelFilterWidth, final.russianRoulette = _MAX_DEPTH, "box", 1.0, False
    final.subdivision = "cage"
    return scene


def Render(scene, engine: str, samples: int, seed: int, folder: pathlib.Path):
    """(picture [height][width][3], seconds from pressing render)."""
    from stages import imageFile

    scene.render.engine, scene.render.filepath = engine, str(folder / "out.exr")
    scene.cycles.samples = scene.hdstream.final.samples = samples
    scene.cycles.seed = scene.hdstream.final.seed = seed
    begin = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - begin
    planes = imageFile.ReadExr(scene.render.filepath)
    return np.stack([planes[name] for name in "RGB"], -1).astype(np.float64), seconds


def Climb(scene, engines: dict, goal: float, repeats: int, referenceSamples: int, folder: pathlib.Path, watch: _Watch) -> dict:
    """name -> (ladder, statistics' times of the last rung, mean of the reference), of renders that take turns."""
    found, references = {}, {}
    for name, engine in engines.items():
        Render(scene, engine, 1, 998, folder)  # kernels
        references[name] = [Render(scene, engine, referenceSamples // 2, seed, folder)[0] for seed in (101, 102)]
        found[name] = dict(samples=[], errors=[], seconds=[], times={})
    isOpen, samples = dict.fromkeys(engines, True), 1
    while any(isOpen.values()):
        for name, engine in engines.items():
            if not isOpen[name]:
                continue
            record, row, errors = found[name], [], []
            for repeat in range(repeats):
                picture, seconds = Render(scene, engine, samples, 1 + repeat, folder)
                row.append(seconds)
                errors.append(rivalsLadder.Errors(picture, references[name])[0])
            record["samples"].append(samples)
            record["errors"].append(float(np.mean(errors)))
            record["seconds"].append(row)
            if engine != "CYCLES":
                record["times"] = dict(watch.times)
            isOpen[name] = record["errors"][-1] > goal and 2.0 * min(row) < _MOST_SECONDS
        samples *= 2
    return {name: (rivalsLadder.Ladder(record["samples"], record["errors"], np.transpose(record["seconds"]).tolist()),
                   record["times"], float(np.mean(references[name]))) for name, record in found.items()}


def Report(stage: str, found: dict, goal: float) -> list:
    """Lines of one stage."""
    lines, seconds = [], {}
    for name, (ladder, times, mean) in found.items():
        reached = ladder.SecondsTo(goal)
        seconds[name] = reached
        rungs = ", ".join(f"{count}: {np.median([row[i] for row in ladder.seconds]):.2f} s {ladder.errors[i]:.4f}"
                          for i, count in enumerate(ladder.samples))
        text = "not reached" if reached is None else f"{np.median(reached):.2f} s at {ladder.SamplesTo(goal):.0f} samples"
        lines.append(f"{stage:10s} {name:8s} {text}; without samples {np.median(ladder.fixed):.2f} s; mean {mean:.4f}; {rungs}")
        if times:
            parts = ", ".join(f"{key} {value:.2f}" for key, value in times.items()
                              if isinstance(value, (int, float)) and value >= 0.005)
            lines.append(f"{'':10s} {name:8s} of the last rung, statistics' seconds: {parts}")
    ratio = rivalsLadder.Ratio(seconds["Stream"], seconds["Cycles"])
    if ratio:
        lines.append(f"{stage:10s} Stream / Cycles: {ratio[0]:.2f} ({ratio[1]:.2f} to {ratio[2]:.2f})")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scenes")
    parser.add_argument("--stages", nargs="+", choices=rivalsStages.REAL, default=["bookstore", "coffee", "ycb"])
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--goal", type=float, default=0.01, help="relMSE")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--referenceSamples", type=int, default=512)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        engines = {"Stream": blenderRows.MakeEngine(folder), "Cycles": "CYCLES"}
        watch = _Watch()
        print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, Blender {bpy.app.version_string}, "
              f"{args.width} pixels wide", flush=True)
        for name in args.stages:
            scene = Import(name, args.scenes, args.width)
            found = Climb(scene, engines, args.goal, args.repeats, args.referenceSamples, folder, watch)
            print("\n".join(Report(name, found, args.goal)), flush=True)


if __name__ == "__main__":
    RunAndExit(main)
