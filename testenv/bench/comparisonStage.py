# SPDX-License-Identifier: Apache-2.0
"""A stage that draws another with a camera that all renderers can read, and with a light where it has none."""

import pathlib

from hdstream.framing import MakeFramingCamera
from pxr import Sdf, Usd, UsdGeom, UsdLux


def Write(file: pathlib.Path, camera: str, width: int, out: pathlib.Path, number: int) -> tuple:
    """(path of the stage, camera, width, height). The camera is copied, or frames what the stage draws."""
    source = Usd.Stage.Open(str(file))
    layer = Sdf.Layer.CreateNew(str(out / f"stage{number}.usda"))
    layer.subLayerPaths.append(str(file.resolve()))
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(source))
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(source))
    if source.GetDefaultPrim():
        layer.defaultPrim = source.GetDefaultPrim().GetName()
    known = UsdGeom.Camera(source.GetPrimAtPath(camera)) if camera else None
    gfCamera = known.GetCamera(Usd.TimeCode.Default()) if known else _Framing(source)
    own = UsdGeom.Camera.Define(stage, "/hdStreamComparison/Camera")
    own.SetFromCamera(gfCamera, Usd.TimeCode.Default())
    if not any(prim.HasAPI(UsdLux.LightAPI) for prim in source.Traverse()):
        UsdLux.DomeLight.Define(stage, "/hdStreamComparison/Dome")
        sun = UsdLux.DistantLight.Define(stage, "/hdStreamComparison/Sun")
        sun.CreateAngleAttr(2.0)
        sun.CreateIntensityAttr(2000.0)
        isZUp = UsdGeom.GetStageUpAxis(source) == UsdGeom.Tokens.z
        UsdGeom.Xformable(sun).AddRotateXYZOp().Set((30, 20, 0) if isZUp else (-55, 25, 0))
    layer.Save()
    height = round(width * gfCamera.verticalAperture / gfCamera.horizontalAperture) if known else width * 3 // 4
    return str(out / f"stage{number}.usda"), "/hdStreamComparison/Camera", width, height


def _Framing(source):
    """hdStream's own camera for stages that have none."""
    return MakeFramingCamera(source, Usd.TimeCode.Default(), ["default", "render"])
