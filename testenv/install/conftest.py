# SPDX-License-Identifier: Apache-2.0
"""The wheel, built once, and a fresh virtual environment that holds it. Both need no network."""

import os
import pathlib
import subprocess
import sys
import sysconfig

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "testenv"))

# A quad of albedo 0.5 under a uniform dome of radiance 1, seen from above: no light bounces twice.
STAGE = """#usda 1.0
(upAxis = "Y")
def DomeLight "Dome" {}
def Mesh "Quad" {
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    uniform token subdivisionScheme = "none"
    color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)]
}
def Camera "Camera" {
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 20
    double3 xformOp:translate = (0, 0, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def CleanEnvironment() -> dict:
    """Ours without what would let a program find the build tree."""
    hidden = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "HDSTREAM_KERNEL_DIR"}
    return {name: value for name, value in os.environ.items() if name not in hidden}


def Run(command: list, **options) -> subprocess.CompletedProcess:
    return subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, **options)


@pytest.fixture
def stage(tmp_path):
    path = tmp_path / "stage.usda"
    path.write_text(STAGE)
    return path


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built with the build requirements of this interpreter; objects stay in build/<tag>."""
    folder = tmp_path_factory.mktemp("wheel")
    result = Run([sys.executable, "-m", "pip", "wheel", ROOT, "--no-deps", "--no-build-isolation",
                  "--wheel-dir", folder], env=CleanEnvironment())
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-4000:]
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """bin/ of a fresh environment with the wheel. usd-core and numpy are lent by a path file: the
    .pth files of the lender, which name the build tree, are not read through it."""
    folder = tmp_path_factory.mktemp("venv with spaces")
    assert Run([sys.executable, "-m", "venv", "--without-pip", folder]).returncode == 0
    python = folder / "bin" / "python"
    result = Run([sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel],
                 env=CleanEnvironment())
    assert result.returncode == 0, result.stdout + result.stderr
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"
