# SPDX-License-Identifier: Apache-2.0
"""An animated stage, and pictures compared to the bit."""

from cliCase import TRIANGLE

ANIMATED = TRIANGLE + """def DistantLight "Sun" { float inputs:intensity = 1 }
def Sphere "Ball" {
    double radius = 0.5
    double3 xformOp:translate.timeSamples = { 1: (-1, 0, 1), 24: (1, 0.5, 1) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "main_cam" {
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
OPTIONS = ["-w", "24", "--maxDepth", "2", "--aovs", "color,variance,depth,primId"]


def SameImages(file, reference):
    """Equal layers, to the bit."""
    from hdstream import _core
    difference = _core.CompareImages(str(file), str(reference))
    assert not difference.error, difference.error
    assert len(difference.layers) == 4
    return all(layer.numDifferingPixels == 0 for layer in difference.layers)
