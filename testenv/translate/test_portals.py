# SPDX-License-Identifier: Apache-2.0
"""Portals of domes in the scene: their transforms and sizes, of those that are PortalLights."""

from translateCase import StageOf, Translate

_STAGE = """
def DomeLight "Sky" { rel portals = [</Wall/Portal>, </Plain>, </Wall>] }
def PortalLight "Plain" { }
def Xform "Wall" {
    double3 xformOp:translate = (0, -2, 1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def PortalLight "Portal" { float inputs:width = 2
        float inputs:height = 1.5 }
}
"""


def test_portals_of_a_dome():
    session = Translate(StageOf(_STAGE))
    lines = [line.strip() for line in session.Dump().splitlines() if line.startswith("  portal ")]
    assert lines == [
        "portal 0: [16] 1 0 0 0 0 1 0 0 0 0 1 0 0 -2 1 1", "portal 0 width: 2", "portal 0 height: 1.5",
        "portal 1: [16] 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "portal 1 width: 1", "portal 1 height: 1"]
    assert session.Warnings() == ["/Sky: portal /Wall is no PortalLight; left out"]
