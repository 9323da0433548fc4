# SPDX-License-Identifier: Apache-2.0
"""Edits of light filters, and of links of native instances (recordedEdits.py): lightEditScript.py JOB.json"""

import sys

from pxr import Gf, Usd, UsdLux

from recordedEdits import Run

_DOORS = "/World/Doors"


def _Doors(stage):
    return stage.GetPrimAtPath(_DOORS)


def _Name(stage, filters):
    UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lamp")).GetFiltersRel().SetTargets(filters)


def _Exclude(stage, collection, paths):
    Usd.CollectionAPI(stage.GetPrimAtPath("/World/Sun"), collection).GetExcludesRel().SetTargets(paths)


EDITS = {
    "value": lambda stage: _Doors(stage).GetAttribute("inputs:width").Set(0.6),
    "moved": lambda stage: _Doors(stage).GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.5, 0, 1)),
    "gone": lambda stage: _Doors(stage).SetActive(False),
    "back": lambda stage: _Doors(stage).SetActive(True),
    "unnamed": lambda stage: _Name(stage, []),
    "named": lambda stage: _Name(stage, [_DOORS]),
    "valueAgain": lambda stage: _Doors(stage).GetAttribute("inputs:width").Set(0.3),
    "linkedBoth": lambda stage: _Exclude(stage, "lightLink", ["/World/Nothing"]),
    "linkedLeft": lambda stage: _Exclude(stage, "lightLink", ["/World/Right"]),
    "sun": lambda stage: UsdLux.LightAPI(stage.GetPrimAtPath("/World/Sun")).GetIntensityAttr().Set(2.0),
    "linkedShadow": lambda stage: _Exclude(stage, "shadowLink", ["/World/Left", "/World/BlockRight"]),
}

if __name__ == "__main__":
    Run(sys.argv[1], EDITS)
