# SPDX-License-Identifier: Apache-2.0
"""Edits of mesh lights (recordedEdits.py): meshLightScript.py JOB.json"""

import sys

from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

from recordedEdits import Run

_LAMP = "/World/Lamp"
EDITS = {
    "intensity": lambda stage: UsdLux.LightAPI(stage.GetPrimAtPath(_LAMP)).GetIntensityAttr().Set(9.0),
    "color": lambda stage: UsdLux.LightAPI(stage.GetPrimAtPath(_LAMP)).GetColorAttr().Set(Gf.Vec3f(0.2, 1.0, 0.4)),
    "emission": lambda stage: UsdShade.Shader.Get(stage, "/World/Glow/Surface").GetInput("emissiveColor").Set(Gf.Vec3f(2, 1, 0.5)),
    "points": lambda stage: _ScalePoints(UsdGeom.Mesh.Get(stage, _LAMP).GetPointsAttr()),
    "transform": lambda stage: stage.GetPrimAtPath(_LAMP).GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.6, 1.2, 0.1)),
    "prototype": lambda stage: UsdLux.LightAPI(stage.GetPrimAtPath("/World/Bulbs/Bulb")).GetIntensityAttr().Set(1.0),
    "native": lambda stage: UsdLux.LightAPI(stage.GetPrimAtPath("/World/Shared/Bulb")).GetIntensityAttr().Set(2.0),
    "hidden": lambda stage: UsdGeom.Imageable.Get(stage, _LAMP).MakeInvisible(),
    "shown": lambda stage: UsdGeom.Imageable.Get(stage, _LAMP).MakeVisible(),
    "removed": lambda stage: stage.GetPrimAtPath(_LAMP).RemoveAPI(UsdLux.MeshLightAPI),
    "applied": lambda stage: UsdLux.MeshLightAPI.Apply(stage.GetPrimAtPath(_LAMP)),
    "linked": lambda stage: _LinkTo(Usd.CollectionAPI(stage.GetPrimAtPath(_LAMP), "lightLink"), "/World/Lamp"),
}


def _ScalePoints(attribute):
    attribute.Set([1.5 * point for point in attribute.Get()])


def _LinkTo(collection, path):
    collection.CreateIncludeRootAttr(False)
    collection.CreateIncludesRel().AddTarget(path)


if __name__ == "__main__":
    Run(sys.argv[1], EDITS)
