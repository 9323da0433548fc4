# SPDX-License-Identifier: Apache-2.0
"""firstBlender.py ZIP PICTURE: installs the zip as *Install from Disk* does, renders Blender's first scene twice, and judges it.

For a Python that can import bpy; nothing of the user's is read or written. The picture must show the cube, its lit sides and the
grey world: the same values as Cycles gives for the three, within a twentieth, since both draw one scene.
"""

import os
import pathlib
import sys
import tempfile
import time
import traceback

_temporary = tempfile.TemporaryDirectory()
os.environ["BLENDER_USER_RESOURCES"] = _temporary.name

import bpy  # noqa: E402
import numpy as np  # noqa: E402


def _Render(scene, engine: str, path: pathlib.Path):
    scene.render.engine, scene.render.filepath = engine, str(path)
    begin = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print(f"{engine}: {time.perf_counter() - begin:.1f} s", flush=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    return np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)


def _Blocks(picture):
    """Means of 16 x 16 pixels."""
    height, width = picture.shape[0] // 16, picture.shape[1] // 16
    return picture[:height * 16, :width * 16, :3].reshape(height, 16, width, 16, 3).mean((1, 3))


def main():
    package, path = map(pathlib.Path, sys.argv[1:])
    bpy.ops.extensions.package_install_files(filepath=str(package.absolute()), repo="user_default", enable_on_install=True)
    if "bl_ext.user_default.hdstream" not in bpy.context.preferences.addons:
        sys.exit(f"{package}: Blender did not install it")
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 480, 270
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"
    scene.hdstream.final.samples = scene.cycles.samples = 64
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    _Render(scene, "HYDRA_STREAM", path)
    ours = _Blocks(_Render(scene, "HYDRA_STREAM", path))
    theirs = _Blocks(_Render(scene, "CYCLES", path.with_name("cycles.png")))
    apart = float(np.abs(ours - theirs).max())
    print(f"largest difference of 16 x 16 pixels from Cycles: {apart:.4f}; ours from {ours.min():.3f} to {ours.max():.3f}")
    if apart > 0.05 or ours.max() - ours.min() < 0.3:
        sys.exit("the picture is not that of the scene")


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
