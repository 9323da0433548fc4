# SPDX-License-Identifier: Apache-2.0
"""A ball with subsurface scattering below a uniform sky of 1: `python testenv/bench/subsurfaceFurnace.py [--samples N]`, with a Python
that has bpy, pxr and hdstream.

Light enters and leaves by Lambert's law and nothing reflects at the surface, so all points of the ball are alike, and the ball gives
back what walks in it do: 1 where nothing is absorbed. Printed are these walks in double precision (render/ballWalk.py), ours, and
Cycles' random walk, whose radius is 4 pi mean free paths, for colours and mean free paths of a ball of radius 1; and of the walks what
is left when those of more than 256 events are lost.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

CASES = [(color, path) for path in (0.03, 0.1, 0.4) for color in (1.0, 0.8, 0.5, 0.3)]
SIZE, RINGS = 16, 96  # pixels of a picture of the ball's middle; of its mesh
EVENTS = 256


def RenderCycles(color: float, path: float, samples: int) -> float:
    import bpy
    import rivalsCycles
    from rivalsMatter import CyclesLook

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    rivalsCycles.Configure(scene, dict(width=SIZE, height=SIZE, maxDepth=1024, threads=os.cpu_count()))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=2 * RINGS, ring_count=RINGS, radius=1.0)
    look = CyclesLook(rivalsCycles._Nodes("ball"), {"subsurface": dict(color=(color,) * 3 + (1.0,), radius=(path,) * 3)})
    bpy.context.object.data.materials.append(look)
    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 1.0
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 10)
    scene.collection.objects.link(scene.camera)
    return float(rivalsCycles.Renderer(scene)(samples, 1).mean())


def RenderOurs(color: float, path: float, samples: int) -> float:
    import ours
    from stages import author, materialX, shapes

    with tempfile.TemporaryDirectory() as folder:
        stage = author.NewStage(f"{folder}/ball.usda")
        look = materialX.AddSurface(stage, "/World/Look", base=0.0, specular=0.0, subsurface=1.0, subsurface_color=(color,) * 3,
                                    subsurface_radius=(path,) * 3)
        author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, RINGS, 2 * RINGS), material=look)
        author.AddLight(stage, "/World/Sky", "Dome")
        author.AddCamera(stage, eye=(0, 0, 10), width=10.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        return float(ours.Render(f"{folder}/ball.usda", SIZE, SIZE, samples=samples, maxDepth=24).rgb.mean())


def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--cycles", nargs=2, type=float, metavar=("COLOR", "PATH"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.cycles:  # in a process of its own: bpy has an OpenUSD of its own
        print(f"RESULT {RenderCycles(*options.cycles, options.samples)}", flush=True)
        os._exit(0)
    from ballWalk import AlbedoOf, BallAlbedo

    print(f"| colour | mean free path | walks | ours | Cycles | walks of {EVENTS} events at most |\n|---|---|---|---|---|---|")
    for color, path in CASES:
        albedo = 1.0 if color == 1.0 else AlbedoOf(color)
        walks, cut = (BallAlbedo(albedo, path, 50000, most) for most in (None if color < 1.0 else 20000, EVENTS))
        run = subprocess.run([sys.executable, __file__, f"--samples={options.samples}", "--cycles", str(color), str(path)],
                             capture_output=True, text=True)
        lines = [line for line in run.stdout.splitlines() if line.startswith("RESULT ")]
        cycles = f"{float(lines[0].split()[1]):.3f}" if lines else "not run: " + (run.stderr.strip().splitlines() or ["?"])[-1]
        print(f"| {color} | {path} | {walks:.3f} | {RenderOurs(color, path, options.samples):.3f} | {cycles} | {cut:.3f} |", flush=True)


if __name__ == "__main__":
    Main()
