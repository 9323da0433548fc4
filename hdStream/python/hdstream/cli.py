# SPDX-License-Identifier: Apache-2.0
"""The command line `hdstream` (docs/command-line.md): parser and dispatch.

Commands are imported when they run: parsing and --help need neither USD nor the core.
"""

import argparse
import os
import sys

from hdstream import options
from hdstream.errors import (EXIT_FAILURE, EXIT_INTERRUPTED, EXIT_OK, EXIT_USAGE, CommandError,
                             OneLine)

_MAX_SAMPLES = 1 << 24
_MAX_DEPTH = 4096
_MAX_WAVE = 1 << 24


class _Parser(argparse.ArgumentParser):
    """Errors as one line, exit code 2."""

    def error(self, message):
        self.exit(EXIT_USAGE, f"{self.prog}: {OneLine(message)}\n")


def Main(arguments=None):
    """Runs a command; returns the exit code. Never shows a traceback for a user's error."""
    args = _MakeParser().parse_args(arguments)
    try:
        return args.command(args) or EXIT_OK
    except CommandError as error:
        return _Fail(args, error, error.exitCode)
    except KeyboardInterrupt:
        return _Fail(args, "interrupted", EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader of stdout has gone (head, less): nothing is wrong. Python flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_OK
    except MemoryError:
        return _Fail(args, "out of memory", EXIT_FAILURE)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _Fail(args, where + (error.strerror or str(error)), EXIT_FAILURE)
    except Exception as error:  # pylint: disable=broad-except
        return _FailUnexpected(args, error)


def _Fail(args, message, exitCode):
    print(f"hdstream {args.name}: {message}", file=sys.stderr)
    return exitCode


def _FailUnexpected(args, error):
    """Errors of the core, which are one line already; all else is a bug of ours."""
    if os.environ.get("HDSTREAM_DEBUG"):
        raise error
    from hdstream import _core
    if isinstance(error, _core.UsageError):
        return _Fail(args, OneLine(error), EXIT_USAGE)
    if isinstance(error, _core.Error):
        return _Fail(args, OneLine(error), EXIT_FAILURE)
    return _Fail(args, f"internal error, please report it (HDSTREAM_DEBUG=1 shows where): "
                       f"{type(error).__name__}: {OneLine(error)}", EXIT_FAILURE)


def _MakeParser():
    parser = _Parser(prog="hdstream", description="Path-traces USD stages on OpenCL devices.",
                     allow_abbrev=False)
    parser.add_argument("--version", action="version", version=_Version())
    commands = parser.add_subparsers(dest="name", required=True, metavar="COMMAND",
                                     parser_class=_Parser)
    _AddRecord(commands)
    _AddInfo(commands)
    _AddCompare(commands)
    _AddCommand(commands, "devices", "list the OpenCL devices")
    cache = _AddCommand(commands, "cache", "show or clear the persistent cache")
    cache.add_argument("--clear", action="store_true", help="delete all entries")
    return parser


def _Version():
    from importlib import metadata
    try:
        return f"hdstream {metadata.version('hdstream')}"
    except metadata.PackageNotFoundError:  # run from a build folder
        return "hdstream (not installed)"


def _AddCommand(commands, name, text):
    command = commands.add_parser(name, help=text, description=text.capitalize() + ".",
                                  allow_abbrev=False)
    command.set_defaults(command=_Importer(name))
    return command


def _Importer(name):
    """The command's Run function, imported when it is called."""

    def Run(args):
        from importlib import import_module
        return import_module(f"hdstream.{name}").Run(args)

    return Run


def _AddInfo(commands):
    command = _AddCommand(commands, "info", "say what is in a stage")
    command.add_argument("stage", metavar="STAGE", help="USD file")
    command.add_argument("--json", metavar="FILE", help="also write it as JSON; - is stdout")


def _AddCompare(commands):
    command = _AddCommand(commands, "compare", "measure the difference of two images")
    command.add_argument("image", metavar="A", help="image file")
    command.add_argument("reference", metavar="B", help="reference image file")
    command.add_argument("--threshold", type=options.NotNegative, metavar="T",
                         help="exit with 1 when the relMSE of any layer is above T")


def _AddRecord(commands):
    command = _AddCommand(commands, "record", "render a stage to image files")
    command.add_argument("stage", metavar="STAGE", help="USD file")
    command.add_argument("output", metavar="OUT",
                         help="image file, .exr, .png or .jpg; #### is the frame")
    _AddUsdrecordOptions(command)
    _AddQualityOptions(command)
    _AddStreamingOptions(command)
    _AddEnvironmentOptions(command)


def _AddUsdrecordOptions(command):
    group = command.add_argument_group("what to render (usdrecord's names)")
    group.add_argument("--camera", "-cam", metavar="CAMERA",
                       help="name or path of a camera prim (default: main_cam, else the stage is framed)")
    frames = group.add_mutually_exclusive_group()
    frames.add_argument("--frames", "-f", metavar="SPEC[,SPEC...]",
                        help="time codes: 101, 101:105, 105:101, 101:109x2, 101:104x0.5")
    frames.add_argument("--defaultTime", "-d", action="store_true",
                        help="render at the default time (default: the stage's startTimeCode)")
    group.add_argument("--imageWidth", "-w", type=options.ImageSize, metavar="N",
                       help="pixels (default 960)")
    group.add_argument("--imageHeight", type=options.ImageSize, metavar="N",
                       help="pixels (default: from the camera's aspect ratio)")
    group.add_argument("--complexity", "-c", choices=("low", "medium", "high", "veryhigh"),
                       help="refine level 0 to 3 with --subdivision complexity (default low)")
    group.add_argument("--colorCorrectionMode", "-color", default="",
                       choices=("disabled", "sRGB", "openColorIO"),
                       help="for .png and .jpg (default: OpenColorIO when $OCIO is set, else sRGB)")
    group.add_argument("--purposes", type=options.Purposes, metavar="PURPOSE[,PURPOSE...]",
                       help="drawn besides default: render, proxy, guide (default render)")
    group.add_argument("--mask", type=options.Names, metavar="PATH[,PATH...]",
                       help="only these prims, their descendants and ancestors")
    group.add_argument("--renderSettingsPrimPath", "-rs", metavar="PATH",
                       help="UsdRenderSettings prim (default: the stage's renderSettingsPrimPath)")
    group.add_argument("--disableCameraLight", action="store_true",
                       help="accepted; no camera light is ever added")


def _AddQualityOptions(command):
    group = command.add_argument_group("when to stop")
    group.add_argument("--samples", type=options.IntegerIn(1, _MAX_SAMPLES), metavar="N",
                       help="per pixel (default 64)")
    group.add_argument("--maxDepth", type=options.IntegerIn(0, _MAX_DEPTH), metavar="N",
                       help="bounces after the first hit (default 8)")
    group.add_argument("--seed", type=options.IntegerIn(0, 0xFFFFFFFF), metavar="N",
                       help="of the random numbers (default 0)")
    group.add_argument("--time", type=options.NotNegative, metavar="SECONDS", help="time limit")
    group.add_argument("--noise", type=options.NotNegative, metavar="T",
                       help="relative error at which a pixel is done")
    group.add_argument("--aovs", type=options.Names, metavar="NAME[,NAME...]",
                       help="layers of the EXR (default color)")


def _AddStreamingOptions(command):
    group = command.add_argument_group("memory and streaming")
    group.add_argument("--residency", choices=("auto", "resident", "stream", "mapped"), default="auto",
                       help="whole scene in device memory, or loaded on demand (default auto)")
    group.add_argument("--subdivision", choices=("adaptive", "complexity", "cage"),
                       help="limit surface, uniform level, or cage as it is (default adaptive)")
    group.add_argument("--hostMemory", type=options.Bytes, metavar="SIZE",
                       help="bound on prepared data in host memory")
    group.add_argument("--geometryMemory", type=options.BytesOrPercent, metavar="SIZE",
                       help="device memory for geometry: bytes (K, M, G) or a percentage")
    group.add_argument("--textureMemory", type=options.BytesOrPercent, metavar="SIZE",
                       help="device memory for textures: bytes (K, M, G) or a percentage")
    group.add_argument("--geometryEviction", choices=("clock", "flush"), default="clock",
                       help="what makes room for geometry (default clock)")
    group.add_argument("--chunkSize", type=options.BytesOrMesh, metavar="SIZE|mesh",
                       default=argparse.SUPPRESS,
                       help="upper bound of a unit of geometry (default 1M)")
    group.add_argument("--request", choices=("last", "first"), default="last",
                       help="ask for missing geometry after a ray's walk or at once (default last)")
    group.add_argument("--waveSize", type=options.IntegerIn(16, _MAX_WAVE), metavar="N",
                       help="paths in flight (default: measured for the device)")
    group.add_argument("--shadeIterations", type=options.IntegerIn(0, 64), metavar="N", default=0,
                       help="0: until all texels are exact")
    group.add_argument("--prepare", choices=("lazy", "eager"), default="lazy",
                       help="prepare on first use or all before rendering (default lazy)")


def _AddEnvironmentOptions(command):
    group = command.add_argument_group("machine and reports")
    group.add_argument("--device", metavar="NAME", help="OpenCL device by part of its name")
    group.add_argument("--cacheDir", metavar="DIR",
                       help="persistent cache (default: $HDSTREAM_CACHE_DIR, else the platform's)")
    group.add_argument("--noCache", action="store_true", help="use no persistent cache")
    group.add_argument("--stats", metavar="FILE", help="write statistics as JSON")
    group.add_argument("--quiet", action="store_true", help="no progress bar")
