# SPDX-License-Identifier: Apache-2.0
"""What the install tests share: a stage with a known picture and ways to run programs."""

import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
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
