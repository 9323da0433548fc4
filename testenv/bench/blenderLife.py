# SPDX-License-Identifier: Apache-2.0
"""A long session of Blender: blenderLife.py --zip ZIP [--renders N].

Installs the zip as *Install from Disk* does, into a folder of its own, renders and edits in one process, and prints the memory
of the process after every tenth render; then how long after a cancel Blender goes on, from moments all over a render.

Runs in a Python that can import bpy of the version that the zip was made for.
"""

import argparse
import gc
import os
import pathlib
import random
import sys
import tempfile
import time
import traceback

HERE = pathlib.Path(__file__).resolve().parent

_temporary = tempfile.TemporaryDirectory()
os.environ["BLENDER_USER_RESOURCES"] = _temporary.name  # nothing of the user's is read or written

import bpy  # noqa: E402


def Install(path: pathlib.Path):
    bpy.ops.extensions.package_install_files(filepath=str(path.absolute()), repo="user_default", enable_on_install=True)
    if "bl_ext.user_default.hdstream" not in bpy.context.preferences.addons:
        sys.exit(f"{path}: Blender did not install it")


def Scene(samples: int):
    scene = bpy.context.scene
    scene.render.engine = "HYDRA_STREAM"
    scene.render.resolution_x, scene.render.resolution_y = 160, 120
    scene.hdstream.final.samples = samples
    return scene


def Edit(scene, random_):
    """One of what an artist does between two renders."""
    cube = bpy.data.objects["Cube"]
    kind = random_.randrange(7)
    if kind == 0:
        cube.location = [random_.uniform(-1, 1) for _ in range(3)]
    elif kind == 1:
        cube.active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value[0] = random_.random()
    elif kind == 2:
        bpy.data.objects["Light"].data.energy = random_.uniform(100, 2000)
    elif kind == 3:
        scene.camera.location.z = random_.uniform(3, 6)
    elif kind == 4:
        for vertex in cube.data.vertices:
            vertex.co *= random_.uniform(0.95, 1.05)
        cube.data.update()
    elif kind == 5:
        scene.hydra.export_method = random_.choice(("HYDRA", "USD"))
        scene.render.use_persistent_data = False
    else:
        scene.render.use_persistent_data = scene.hydra.export_method == "HYDRA"


def ResidentMegabytes() -> float:
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def Renders(count: int):
    scene, random_ = Scene(8), random.Random(1)
    for i in range(count):
        Edit(scene, random_)
        bpy.ops.render.render()
        if i % 10 == 9:
            gc.collect()
            print(f"render {i + 1:4d}: {ResidentMegabytes():7.1f} MB", flush=True)


def Cancels(count: int):
    """Seconds from the moment at which Blender is told to stop until the operator has returned and the renderer is gone."""
    scene, random_ = Scene(1 << 20), random.Random(2)
    scene.render.use_persistent_data = False
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    engine = next(item for item in bpy.types.HydraRenderEngine.__subclasses__()
                  if getattr(item, "bl_idname", "") == "HYDRA_STREAM")
    waits = []
    for _ in range(count):
        stop = time.perf_counter() + random_.uniform(0.3, 4.0)
        engine._IsCancelled = lambda this: time.perf_counter() >= stop
        bpy.ops.render.render()
        waits.append(time.perf_counter() - stop)
    waits.sort()
    print(f"cancel: median {waits[len(waits) // 2]:.2f} s, worst {waits[-1]:.2f} s of {count}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--zip", type=pathlib.Path, required=True)
    parser.add_argument("--renders", type=int, default=100)
    parser.add_argument("--cancels", type=int, default=10)
    args = parser.parse_args()
    Install(args.zip)
    Renders(args.renders)
    Cancels(args.cancels)


if __name__ == "__main__":
    status = 0
    try:
        main()
    except SystemExit as end:
        print(end.code, file=sys.stderr)
        status = 1
    except BaseException:  # pylint: disable=broad-except
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    _temporary.cleanup()
    os._exit(status)  # Blender's own clean-up may wait for ever
