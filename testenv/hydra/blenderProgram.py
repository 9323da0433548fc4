# SPDX-License-Identifier: Apache-2.0
"""Runs a script with the OpenUSD of Blender's Python module: blenderProgram.py SCRIPT ARGUMENTS, or -c CODE

For a Python that can import bpy. There $PXR_PLUGINPATH_NAME would replace the search path of OpenUSD's own plug-ins; so what it
names is registered by hand.
"""

import os
import runpy
import sys
import traceback

_PLUGINS = os.environ.pop("PXR_PLUGINPATH_NAME", "")

import bpy  # noqa: E402


def main():
    bpy.utils.expose_bundled_modules()
    from pxr import Plug

    if _PLUGINS:
        Plug.Registry().RegisterPlugins(_PLUGINS.split(os.pathsep))
    del sys.argv[0]
    if sys.argv[0] == "-c":
        exec(sys.argv[1], {"__name__": "__main__"})  # pylint: disable=exec-used
    else:
        sys.path[0] = os.path.dirname(os.path.abspath(sys.argv[0]))
        runpy.run_path(sys.argv[0], run_name="__main__")


def ExitCode():
    try:
        main()
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    except BaseException:  # pylint: disable=broad-except
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    code = ExitCode()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # Blender's own clean-up may wait for ever
