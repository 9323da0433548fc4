# SPDX-License-Identifier: Apache-2.0
"""A stage with its camera and render settings made explicit, so that usdrecord and `hdstream record`
render the same thing.

The wrapper is a layer that sublayers the stage, repeats the metadata that only a root layer can have, and
adds a camera where the stage has none and a UsdRenderSettings prim with "hdstream:" attributes.

What usdrecord does by itself (OpenUSD 24.11, bin/usdrecord and UsdAppUtilsFrameRecorder), and what we do
about it:
  camera      --camera NAME|PATH, default main_cam, else it frames the stage as framing.py does but keeps
              the near plane at 1: the wrapper's camera is always named
  size        --imageWidth; the height is width / aspect ratio of the aperture in float32, cut off, and at
              least 1, whatever the render settings' resolution: UsdrecordHeight gives it, for --imageHeight
  conforming  whatever the render settings say, legacy imaging fits the camera's height to the image's and
              leaves the width to follow, scene-index imaging fits as HdCamera does by default; where the
              height above is exact, roundings differ between the two: the wrapper says which one holds
  time        the stage's startTimeCode, which is the rule of `hdstream record` too
  purposes    default is "proxy" where ours is "render": always named
  lights      adds a light at the camera unless --disableCameraLight
  domes       light, but are drawn only with --enableDomeLightVisibility
  complexity  low, refine level 0; the core's default "adaptive" does not look at it
  colours     with a GPU the picture is corrected to sRGB unless --colorCorrectionMode disabled; with
              --disableGpu never, with a warning unless told so
  EXR         holds what the renderer's colour buffer has: 8 bits and halves are written as half, Float32
              as float, unpremultiplied by nobody, so a Float32Vec4 buffer arrives bit for bit
  settings    the prim of --renderSettingsPrimPath, or of the stage's metadata, is made active, its
              products are announced as missing (a warning) and --imageWidth and --camera still count
"""

import pathlib
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdRender

from hdstream.framing import FREE_CAMERA_PATH, FindCamera, MakeFramingCamera
from hdstream.stage import OpenStage

SETTINGS_PATH = "/Render/hdStreamTest"
_CONFORM_POLICIES = {"legacy": "adjustApertureWidth", "sceneIndex": "expandAperture"}
# Metadata of a root layer that its sublayers' opinions do not reach.
_ROOT_METADATA = ("upAxis", "metersPerUnit", "kilogramsPerUnit", "startTimeCode", "endTimeCode", "timeCodesPerSecond",
                  "framesPerSecond", "defaultPrim", "expressionVariables", "colorConfiguration",
                  "colorManagementSystem")
_TYPES = {bool: Sdf.ValueTypeNames.Bool, int: Sdf.ValueTypeNames.Int, float: Sdf.ValueTypeNames.Double,
          str: Sdf.ValueTypeNames.String, list: Sdf.ValueTypeNames.StringArray}


@dataclass
class Wrapper:
    """A written wrapper and what both programs must be told."""

    path: pathlib.Path
    camera: str  # prim path
    width: int  # pixels
    height: int  # as usdrecord computes it
    purposes: list = field(default_factory=lambda: ["render"])

    def UsdrecordOptions(self, usesGpu: bool = False) -> list[str]:
        options = ["--camera", self.camera, "--imageWidth", str(self.width), "--purposes", ",".join(self.purposes),
                   "--renderSettingsPrimPath", SETTINGS_PATH, "--disableCameraLight", "--enableDomeLightVisibility",
                   "--colorCorrectionMode", "disabled"]
        return options if usesGpu else [*options, "--disableGpu"]

    def RecordOptions(self) -> list[str]:
        return ["--camera", self.camera, "--imageWidth", str(self.width), "--imageHeight", str(self.height),
                "--purposes", ",".join(self.purposes), "--renderSettingsPrimPath", SETTINGS_PATH, "--quiet"]


def WriteWrapper(stagePath, out, width: int, camera: str = "", purposes=("render",), mode: str = "legacy",
                 **settings) -> Wrapper:
    """Writes the wrapper of a stage to `out` (.usda).

    camera: name or path; else main_cam, else the stage's first camera, else one that frames it
    mode: one of frontEnds.MODES
    settings: core settings: samples, seed ...

    Raises what opening the stage raises (hdstream.errors.CommandError for a broken one).
    """
    original = OpenStage(str(stagePath))
    timeCode = Usd.TimeCode(original.GetStartTimeCode())
    layer = Sdf.Layer.CreateNew(str(out))
    _CopyMetadata(original, layer)
    layer.subLayerPaths.append(str(pathlib.Path(stagePath).resolve()))
    stage = Usd.Stage.Open(layer)
    prim = FindCamera(original, camera, None) or _FirstCamera(original)
    if prim is None:
        free = UsdGeom.Camera.Define(stage, FREE_CAMERA_PATH)
        free.SetFromCamera(MakeFramingCamera(original, timeCode, ["default", *purposes]), Usd.TimeCode.Default())
        prim = free.GetPrim()
    _AuthorSettings(stage, prim.GetPath(), mode, settings)
    layer.Save()
    height = UsdrecordHeight(UsdGeom.Camera(prim), timeCode, width)
    return Wrapper(pathlib.Path(out), prim.GetPath().pathString, width, height, list(purposes))


def _FirstCamera(stage: Usd.Stage) -> Usd.Prim | None:
    return next((prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera)), None)


def UsdrecordHeight(camera: UsdGeom.Camera, timeCode: Usd.TimeCode, width: int) -> int:
    gfCamera = camera.GetCamera(timeCode)
    aspect = np.float32(gfCamera.aspectRatio)
    if abs(aspect) < 1e-4:
        aspect = np.float32(1.0)
    return max(1, int(np.float32(width) / aspect))


def _CopyMetadata(stage: Usd.Stage, layer: Sdf.Layer) -> None:
    root = stage.GetRootLayer()
    for name in _ROOT_METADATA:
        if root.pseudoRoot.HasInfo(name):
            layer.pseudoRoot.SetInfo(name, root.pseudoRoot.GetInfo(name))
    layer.pseudoRoot.SetInfo("renderSettingsPrimPath", SETTINGS_PATH)


def _AuthorSettings(stage: Usd.Stage, cameraPath: Sdf.Path, mode: str, settings: dict) -> None:
    prim = UsdRender.Settings.Define(stage, SETTINGS_PATH)
    prim.CreateCameraRel().SetTargets([cameraPath])
    prim.CreateAspectRatioConformPolicyAttr(_CONFORM_POLICIES[mode])
    for name, value in settings.items():
        prim.GetPrim().CreateAttribute(f"hdstream:{name}", _TYPES[type(value)], True).Set(value)
