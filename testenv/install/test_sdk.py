# SPDX-License-Identifier: Apache-2.0
"""What programs that embed the core install: it may be moved, names no place of this machine's trees, and a
program that finds it with find_package renders the bits of the command line."""

import os
import pathlib
import re
import shutil
import sys

import numpy as np
import pytest
from installCase import ROOT, CleanEnvironment, Run
from stages.imageFile import ReadExr

CONSUMER = ROOT / "testenv" / "install" / "consumer"
BUILD = pathlib.Path(os.environ.get("HDSTREAM_TEST_BUILD", ROOT / "build" / "release"))
# What consumer/triangle.cpp describes, as a stage.
STAGE = """#usda 1.0
def DomeLight "Dome" {}
def Mesh "Triangle" {
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    uniform token subdivisionScheme = "none"
    color3f[] primvars:displayColor = [(0.5, 0.25, 0.125)]
}
def Camera "Camera" {
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 20
    double3 xformOp:translate = (0, 0, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def Installed(component: str, folder: pathlib.Path) -> pathlib.Path:
    """The component, installed to one place and moved to another."""
    first = folder / "first"
    result = Run(["cmake", "--install", BUILD, "--component", component, "--prefix", first])
    assert result.returncode == 0, result.stderr
    return first.rename(folder / "moved here")


@pytest.fixture(scope="module")
def sdk(tmp_path_factory):
    if not (BUILD / "hdStream" / "libhdsSession.a").exists():
        pytest.skip(f"no build in {BUILD}")
    return Installed("sdk", tmp_path_factory.mktemp("sdk"))


def test_package_names_no_place_of_this_machine(sdk):
    # Imported targets of other packages go by their names; only their own files say where they are.
    for path in sdk.rglob("*.cmake"):
        text = "\n".join(line for line in path.read_text().splitlines() if not line.lstrip().startswith("#"))
        for place in (str(ROOT), str(sdk.parent), "/usr/lib", "/usr/include"):
            assert place not in text, path.name


def test_every_include_of_a_public_header_is_installed(sdk):
    include = sdk / "include" / "hdStreamCore"
    headers = [path for path in include.rglob("*.h")]
    assert include / "hdStream" / "session" / "session.h" in headers
    for header in headers:
        for name in re.findall(r'^\s*#\s*include "(.*)"', header.read_text(), re.MULTILINE):
            assert (include / name).exists() or (include / "kernels" / name).exists(), f"{header}: {name}"


def test_embedding_program_renders_as_the_command_line_does(sdk, tmp_path):
    environment = CleanEnvironment()
    configured = Run(["cmake", "-S", CONSUMER, "-B", tmp_path / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={sdk}",
                      "-DCMAKE_BUILD_TYPE=Release"], env=environment)
    assert configured.returncode == 0, configured.stderr
    built = Run(["cmake", "--build", tmp_path / "build"], env=environment)
    assert built.returncode == 0, built.stdout
    result = Run([tmp_path / "build" / "triangle", tmp_path / "ours.exr"], env=environment)
    assert result.returncode == 0, result.stderr
    (tmp_path / "stage.usda").write_text(STAGE)
    assert Run([sys.executable, "-m", "hdstream", "record", tmp_path / "stage.usda", tmp_path / "theirs.exr", "--camera",
                "/Camera", "--imageWidth", 32, "--samples", 4, "--noCache", "--quiet"]).returncode == 0
    ours, theirs = ReadExr(tmp_path / "ours.exr"), ReadExr(tmp_path / "theirs.exr")
    assert np.array_equal(ours["R"], theirs["R"]) and np.array_equal(ours["A"], theirs["A"])
    # The triangle's centre is a diffuse surface that sees half of the dome, and nothing else.
    assert abs(ours["R"][14:18, 14:18].mean() - 0.5) < 0.05


def test_the_program_that_compiles_kernels_is_installed(sdk):
    assert Run([sdk / "bin" / "hdstreamCompileKernels"]).returncode == 2, "started by hand"


def test_an_older_interface_is_refused(sdk, tmp_path):
    (tmp_path / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.22)\nproject(p LANGUAGES CXX)\n"
                                             "find_package(hdStream 0.0 REQUIRED)\n")
    result = Run(["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={sdk}"])
    assert result.returncode != 0 and "hdStream" in result.stderr


def test_hydra_plugin_may_be_moved(tmp_path):
    """plugInfo.json finds the library by a relative path, and the library is linked to nothing of the build."""
    if not (BUILD / "plugin" / "usd" / "hdStream.so").exists():
        pytest.skip("the Hydra plug-in is not built")
    moved = Installed("hydra", tmp_path)
    information = (moved / "plugin" / "usd" / "hdStream" / "resources" / "plugInfo.json").read_text()
    relative = re.search(r'"LibraryPath": "(.*)"', information).group(1)
    # LibraryPath is below Root, which is the parent of the folder of plugInfo.json.
    root = moved / "plugin" / "usd" / "hdStream"
    library = (root / relative).resolve()
    assert library.exists() and library.is_relative_to(moved.resolve())
    assert Run([library.parent / "hdstreamCompileKernels"]).returncode == 2, "beside the plug-in; started by hand"
    dynamic = Run(["readelf", "-d", library]).stdout
    assert "$ORIGIN" in dynamic and str(ROOT) not in dynamic and str(tmp_path) not in dynamic
    assert "not found" not in Run(["ldd", library]).stdout
    shutil.rmtree(moved)
