# SPDX-License-Identifier: Apache-2.0
"""The command line `hdstream` (docs/command-line.md): parser and dispatch.

Commands are imported when they run; the options of `record` come from the core's settings table,
which is loaded for that command only.
"""

import argparse
import difflib
import os
import sys

from hdstream import options
from hdstream.console import OpenStreams, SayError
from hdstream.errors import (EXIT_FAILURE, EXIT_INTERRUPTED, EXIT_OK, EXIT_USAGE, CommandError,
                             OneLine)
from hdstream.interruption import Interruption

_COMPLEXITIES = ("low", "medium", "high", "veryhigh")
_LEVELS = tuple("012345678")


class _Parser(argparse.ArgumentParser):
    """Errors as one line, exit code 2. Arguments that are not known are an error of the command that they are given to."""

    def error(self, message):
        self.exit(EXIT_USAGE, f"{self.prog}: {OneLine(message)}\n")

    def parse_known_args(self, args=None, namespace=None):
        known, unknown = super().parse_known_args(args, namespace)
        # argparse takes an operand that may be missing as missing when options come before it.
        if len(unknown) == 1 and not unknown[0].startswith("-") and getattr(known, "output", "") is None:
            known.output = unknown.pop()
        if unknown:
            self.error("unrecognized arguments: " + " ".join(unknown) + self._Meant(unknown))
        return known, unknown

    def _Meant(self, words):
        """What to say of the options that come closest to those among the words, if any do."""
        names = {name.lower(): name for name in self._option_string_actions if name.startswith("--")}
        closest = [difflib.get_close_matches(word.split("=")[0].lower(), names, 1) for word in words if word.startswith("--")]
        meant = dict.fromkeys(names[one] for ones in closest for one in ones)
        return f"; did you mean {', '.join(meant)}?" if meant else ""


def Main(arguments=None):
    """Runs a command; returns the exit code. Never shows a traceback for a user's error."""
    OpenStreams()
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's other threads would spin beside the render, with nothing to do
    os.environ.setdefault("OPENBLAS_MAIN_FREE", "1")  # numpy would set it beside the thread that opens the device and reads others
    with Interruption():  # the core is loaded for its settings
        parser = _MakeParser(arguments[:1])
        args = parser.parse_args(list(_WithNegativeFrames(arguments)))
    for word in arguments:
        if not word.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in word):
            parser.error(f"{ascii(word)}: neither OpenUSD nor image files can have names that are not UTF-8")
    folder = _WorkingFolder() if _OpensHere(args) else ""
    if not folder.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in folder):
        parser.error(f"the working folder {ascii(folder)}: OpenUSD can open nothing in folders whose names are not UTF-8")
    if not args.name:
        parser.error("no COMMAND: record renders a stage; hdstream --help lists all")
    try:
        exitCode = args.command(args) or EXIT_OK
        sys.stdout.flush()  # what cannot be written is told now, not by Python at its end
        return exitCode
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
        return _Fail(args, OneLine(where + (error.strerror or str(error))), EXIT_FAILURE)
    except Exception as error:  # pylint: disable=broad-except
        return _FailUnexpected(args, error)


def _OpensHere(args):
    """Whether the command opens a stage, and one of its files is named from the working folder."""
    files = (getattr(args, name, None) for name in ("output", "stats", "json"))
    return hasattr(args, "stage") and any(not os.path.isabs(file) for file in (args.stage, *filter(None, files)))


def _WorkingFolder():
    try:
        return os.getcwd()
    except OSError:
        return ""  # it is gone; absolute paths are found all the same


def _Fail(args, message, exitCode):
    SayError(f"hdstream {args.name}: {message}")
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


def _MakeParser(first):
    """`first`: the first word, in a list, if there is one. The options of stages are those of that command alone."""
    parser = _Parser(prog="hdstream", description="Path-traces USD stages on OpenCL devices.",
                     allow_abbrev=False)
    parser.add_argument("--version", action="version", version=_Version())
    commands = parser.add_subparsers(dest="name", metavar="COMMAND",
                                     parser_class=_Parser)
    record = _AddCommand(commands, "record", "render a stage to image files")
    prepare = _AddCommand(commands, "prepare", "fill the persistent cache with what record, with the same words, reads of it")
    for name, command in (("record", record), ("prepare", prepare)):
        if first == [name]:
            _AddRecordOptions(command)
    _AddInfo(commands)
    _AddCompare(commands)
    _AddCommand(commands, "devices", "list the OpenCL devices")
    cache = _AddCommand(commands, "cache", "show or clear the persistent cache")
    action = cache.add_mutually_exclusive_group()
    action.add_argument("--clear", action="store_true", help="delete all entries")
    cache.add_argument("--cacheDir", default="", metavar="DIR", help="another cache than that of $HDSTREAM_CACHE_DIR or the platform")
    action.add_argument("--kernels", nargs="?", const="", metavar="DEVICE",
                        help="compile what most scenes need on the device, so that a first render does not wait for it")
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
        with Interruption():  # modules in C++ swallow Ctrl-C while they are loaded
            module = import_module(f"hdstream.{name}")
        return module.Run(args)

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


def _AddRecordOptions(command):
    from hdstream import _core
    command.add_argument("stage", metavar="STAGE", help="USD file")
    command.add_argument("output", metavar="OUT", nargs="?",
                         help="image file, .exr, .png or .jpg; #### is the frame. Without it all products of the stage's "
                              "render settings are written")
    kinds = _core.SettingGroup
    framing = command.add_argument_group("what to render (usdrecord's names)")
    groups = {kinds.Framing: framing,
              kinds.Quality: command.add_argument_group("when to stop"),
              kinds.Picture: command.add_argument_group("what to write")}
    farm = command.add_argument_group("other machines, and going on (docs/farm.md)")
    groups[kinds.Memory] = command.add_argument_group("memory and streaming")
    groups[kinds.Machine] = machine = command.add_argument_group("machine and reports")
    advanced = command.add_argument_group("for experts: nobody needs these for a picture")
    for info in _core.SettingTable():
        if info.option:
            aliases, overrides = _OPTIONS.get(info.name, ((), {}))
            options.AddSetting(advanced if info.isAdvanced else groups[info.group], info, *aliases, **overrides)
    _AddUsdrecordOptions(framing)
    _AddFarmOptions(farm)
    machine.add_argument("--stats", metavar="FILE", help="write statistics as JSON")
    machine.add_argument("--quiet", action="store_true", help="no progress bar")
    machine.add_argument("--verbose", action="store_true",
                         help="every warning, as it comes (default: one line a kind, with three names)")


def _AddFarmOptions(group):
    group.add_argument("--resume", action="store_true",
                       help="leave frames that are there already, go on with those that have fewer samples, and keep "
                            "what that takes beside the images (OUT.sums; OUT.done of what is no .exr)")
    group.add_argument("--snapshot", type=options.NotNegative, default=0.0, metavar="SECONDS",
                       help="every so many seconds write the picture as it is beside its file (OUT_part), and with --resume "
                            "what a later run goes on from")
    cluster = group.add_mutually_exclusive_group()
    cluster.add_argument("--scheduler", metavar="ADDRESS", help="render on the workers of this dask.distributed scheduler")
    cluster.add_argument("--workers", type=options.IntegerIn(1, 1024), metavar="N",
                         help="render in N processes of this machine")
    group.add_argument("--split", choices=("frames", "samples", "tiles"),
                       help="what is spread over workers (default: frames; the samples of a single frame)")
    group.add_argument("--parts", type=options.IntegerIn(1, 1 << 20), metavar="N",
                       help="parts of a frame that is split (default: as many as workers)")


def _AddUsdrecordOptions(group):
    """Those that are no settings."""
    frames = group.add_mutually_exclusive_group()
    frames.add_argument("--frames", "-f", metavar="SPEC[,SPEC...]",
                        help="time codes: 101, 101:105, 105:101, 101:109x2, 101:104x0.5")
    frames.add_argument("--defaultTime", "-d", action="store_true",
                        help="render at the default time (default: the stage's startTimeCode)")
    group.add_argument("--colorCorrectionMode", "-color", default="",
                       choices=("disabled", "sRGB", "openColorIO"),
                       help="for .png and .jpg (default: OpenColorIO when $OCIO is set, else sRGB)")
    group.add_argument("--mask", type=options.Names, metavar="PATH[,PATH...]",
                       help="only these prims, their descendants and ancestors")
    group.add_argument("--renderSettingsPrimPath", "-rs", metavar="PATH",
                       help="UsdRenderSettings prim (default: the stage's renderSettingsPrimPath)")
    group.add_argument("--renderPassPrimPath", "-rp", metavar="PATH",
                       help="UsdRenderPass prim: its collections, and the render settings that are its renderSource")
    group.add_argument("--disableCameraLight", action="store_true",
                       help="accepted; no camera light is ever added")


def _WithNegativeFrames(words):
    """The words of a command line; frames such as -2:0, which argparse takes for an option, are joined to theirs."""
    words = iter(words)
    for word in words:
        frames = next(words, None) if word in ("--frames", "-f") else None
        if frames is None:
            yield word
        elif frames[:1] == "-" and frames[1:2].isdecimal():
            yield f"--frames={frames}"
        else:
            yield from (word, frames)


def _Complexity(text):
    """A refine level, or usdrecord's word for one."""
    if text in _COMPLEXITIES:
        return _COMPLEXITIES.index(text)
    if text in _LEVELS:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither 0 to 8 nor one of {', '.join(_COMPLEXITIES)}")


# Where the option of a setting is not just what its row says: (further names, keywords of argparse).
_OPTIONS = {
    "camera": (("-cam",), {"help": "name or path of a camera prim (default: main_cam, else the stage is framed)"}),
    "imageWidth": (("-w",), {}),
    "imageHeight": ((), {"help": "pixels (default: from the camera's aspect ratio)"}),
    "refineLevel": (("-c",), {"type": _Complexity, "metavar": "WORD|N",
                              "help": "refine level 0 to 8 with --subdivision complexity; low, medium, high, veryhigh "
                                      "are 0 to 3 (default low)"}),
    "purposes": ((), {"type": options.Purposes,
                      "help": "drawn besides default: render, proxy, guide (default render)"}),
    "timeLimit": ((), {"metavar": "SECONDS"}),
    "cacheDirectory": ((), {"metavar": "DIR"}),
    "chunkBytes": ((), {"type": options.ChunkBytes, "metavar": "SIZE|mesh"}),
}
