# SPDX-License-Identifier: Apache-2.0
"""Finds an OpenUSD with imaging, its Python and the built plug-in, and runs OpenUSD's programs with it.

Looked for, in this order: $pxr_DIR, $PXR_ROOT, the CMake cache of the build under test, the programs on
PATH, usual places. A prefix without usdrecord is of use where its plug-in was built for Blender's module bpy: the Python that
has it is $HDSTREAM_TEST_BPY, else the one whose folder the prefix's pxrConfig.cmake names, and recorder.py is its usdrecord. The build under test is $HDSTREAM_TEST_BUILD (scripts/test sets it), else
build/release. Programs run in an environment of their own: OpenUSD's Python, not the one of the tests.
"""

import functools
import glob
import os
import pathlib
import re
import shutil
import signal
import subprocess
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
MINIMUM_VERSION = 2411  # as PXR_VERSION counts
SECONDS = 600  # a program that takes longer hangs; the first render of a machine builds kernels
_USUAL_PLACES = ("/opt/*/pxrConfig.cmake", "/usr/local/*/pxrConfig.cmake", "/usr/local/pxrConfig.cmake",
                 "/usr/pxrConfig.cmake")  # as cmake/OpenUsd.cmake
# Of the tests' own Python, and what would change how a stage is composed or drawn.
_HIDDEN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "PXR_PLUGINPATH_NAME", "PXR_AR_DEFAULT_SEARCH_PATH",
           "USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX", "HD_ENABLE_SCENE_INDEX_EMULATION", "HDSTREAM_DUMP_SCENE", "OCIO")


@dataclass(frozen=True)
class OpenUsd:
    """An installation with imaging."""

    prefix: pathlib.Path
    version: int  # as PXR_VERSION: 2411
    python: str  # the interpreter it was built for
    isBlenders: bool = False  # the one in bpy, which has no programs

    @property
    def modules(self) -> str:
        """Folder of the Python package pxr; empty when the interpreter finds it by itself."""
        for folder in sorted(self.prefix.glob("lib*/python")):
            if (folder / "pxr").is_dir():
                return str(folder)
        return ""

    def Program(self, name: str) -> list[str]:
        if self.isBlenders and name == "usdrecord":
            return self.Script(HERE / "recorder.py")
        return [self.python, str(self.prefix / "bin" / name)]

    def Script(self, *words) -> list[str]:
        """The words that run a script with OpenUSD's modules; or "-c" and code."""
        start = [str(HERE / "blenderProgram.py")] if self.isBlenders else []
        return [self.python, *start, *map(str, words)]

    def Environment(self, plugin: pathlib.Path | None = None, **more: str) -> dict[str, str]:
        """The environment of a program. plugin: the plug-in's folder of resources."""
        environment = {name: value for name, value in os.environ.items() if name not in _HIDDEN}
        environment["PATH"] = os.pathsep.join(
            [str(self.prefix / "bin"), os.path.dirname(self.python), environment.get("PATH", "")])
        if self.modules:
            environment["PYTHONPATH"] = self.modules
        if plugin:
            environment["PXR_PLUGINPATH_NAME"] = str(plugin)
        # A crash names its place in the script; OpenUSD's own crash reports go nowhere.
        environment.update(PYTHONFAULTHANDLER="1", TF_FATAL_ERROR_STACK_LOGGING="0", **more)
        return environment

    @property
    def hasMaterialX(self) -> bool:
        """Whether it was built with usdMtlx, which registers MaterialX's nodes."""
        return self.isBlenders or any(self.prefix.glob("lib*/*usdMtlx*"))

    @functools.lru_cache
    def HasModules(self, *names: str) -> bool:
        """True when its Python can import the modules."""
        code = "import " + ", ".join(names)
        return subprocess.run(self.Script("-c", code), env=self.Environment(), capture_output=True).returncode == 0


@dataclass
class Result:
    """Exit code and output of a program."""

    code: int
    output: str  # of both streams

    @property
    def hasCrashed(self) -> bool:
        return self.code < 0 or self.code > 128


def RunProgram(command: list, environment: dict, seconds: float = SECONDS, **keywords) -> Result:
    """Runs a program and all it starts, and ends all of them at the limit (exit code 124)."""
    process = subprocess.Popen([str(word) for word in command], env=environment, stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                               start_new_session=True, **keywords)
    try:
        output, _ = process.communicate(timeout=seconds)
        return Result(process.returncode, output)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return Result(124, process.communicate()[0] + f"\nended after {seconds:g} s")
    except BaseException:
        os.killpg(process.pid, signal.SIGKILL)
        raise


def BuildFolder() -> pathlib.Path:
    return pathlib.Path(os.environ.get("HDSTREAM_TEST_BUILD") or ROOT / "build" / "release").absolute()


def FindPlugin() -> tuple[pathlib.Path | None, str]:
    """The built plug-in's folder of resources (a value for PXR_PLUGINPATH_NAME), or why there is none."""
    folder = BuildFolder() / "plugin" / "usd" / "hdStream" / "resources"
    if not (folder / "plugInfo.json").is_file() or not list(folder.parents[1].glob("hdStream.*")):
        return None, f"the plug-in is not built in {BuildFolder()} (CMake found no OpenUSD with imaging?)"
    return folder, ""


def FindOpenUsd() -> tuple[OpenUsd | None, str]:
    """The installation that the plug-in was built for, else the first usable one, or why there is none."""
    reasons = []
    for prefix in dict.fromkeys(_CandidatePrefixes()):
        found, reason = _Inspect(prefix)
        if found:
            return found, ""
        if reason:
            reasons.append(reason)
    return None, "; ".join(reasons) or "no OpenUSD found; set PXR_ROOT to its prefix"


def _CandidatePrefixes():
    for name in ("pxr_DIR", "PXR_ROOT"):
        if os.environ.get(name):
            yield _PrefixOf(pathlib.Path(os.environ[name]))
    cache = BuildFolder() / "CMakeCache.txt"
    if cache.is_file():
        for place in re.findall(r"^(?:pxr_DIR|PXR_ROOT):\w+=(.*)$", cache.read_text(errors="replace"), re.M):
            yield _PrefixOf(pathlib.Path(place))
    program = shutil.which("usdrecord")
    if program:
        yield pathlib.Path(program).resolve().parents[1]
    for place in _USUAL_PLACES:
        yield from (pathlib.Path(found).parent for found in sorted(glob.glob(place)))


def _PrefixOf(folder: pathlib.Path) -> pathlib.Path:
    """The prefix of a folder that holds pxrConfig.cmake: itself, or some levels up."""
    for prefix in (folder, *folder.parents):
        if (prefix / "bin" / "usdrecord").is_file():
            return prefix
    return folder


def _Inspect(prefix: pathlib.Path) -> tuple[OpenUsd | None, str]:
    """The installation at a prefix; (None, "") when there is nothing at all."""
    header = prefix / "include" / "pxr" / "pxr.h"
    if not header.is_file():
        return None, ""
    program = prefix / "bin" / "usdrecord"
    blenders = "" if program.is_file() else _BlendersPython(prefix)
    if not (program.is_file() or blenders) or not (prefix / "include" / "pxr" / "imaging").is_dir():
        return None, f"{prefix}: no imaging, or neither usdrecord nor a Python with bpy"
    text = header.read_text(errors="replace")
    numbers = {name: int(value) for name, value in re.findall(r"#define PXR_(MINOR|PATCH)_VERSION (\d+)", text)}
    version = numbers.get("MINOR", 0) * 100 + numbers.get("PATCH", 0)
    if version < MINIMUM_VERSION:
        return None, f"{prefix}: version {version} is older than {MINIMUM_VERSION}"
    python = blenders or _PythonOf(program)
    found = OpenUsd(prefix, version, python, bool(blenders)) if python else None
    if not found or not found.HasModules("pxr.UsdAppUtils"):
        return None, f"{prefix}: its Python cannot import pxr.UsdAppUtils"
    return found, ""


def _PythonOf(program: pathlib.Path) -> str | None:
    """The interpreter that OpenUSD was built for: the installer writes it into its scripts."""
    python = program.read_bytes().split(b"\n", 1)[0].decode(errors="replace").removeprefix("#!").strip()
    return shutil.which(python.split()[-1]) if python else None


def _BlendersPython(prefix: pathlib.Path) -> str:
    """The Python whose module bpy holds the libraries of this prefix; empty: none is named."""
    named = os.environ.get("HDSTREAM_TEST_BPY")
    if named:
        return shutil.which(named) or ""
    for config in (prefix / "pxrConfig.cmake", prefix / "lib" / "cmake" / "pxr" / "pxrConfig.cmake"):
        text = config.read_text(errors="replace") if config.is_file() else ""
        for root in re.findall(r"(/[^\s\"';()]*)/lib/python[\d.]+/site-packages/bpy\b", text):
            return shutil.which(f"{root}/bin/python") or ""
    return ""
