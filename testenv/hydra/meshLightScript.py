# SPDX-License-Identifier: Apache-2.0
"""Edits mesh lights while an engine draws them, and draws each edited stage with a fresh engine: meshLightScript.py JOB.json

Runs in OpenUSD's Python without a screen. The job names the stage, its camera and render settings, the renderer's plug-in, the
width and the folder of the pictures: EDIT.exr and EDIT.fresh.exr for each edit of `EDITS`, in this order, and start.exr.
"""

import json
import sys

from pxr import Gf, Sdf, Usd, UsdAppUtils, UsdGeom, UsdLux, UsdShade

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


def main(jobPath):
    with open(jobPath, encoding="utf-8") as stream:
        job = json.load(stream)
    stage = Usd.Stage.Open(job["stage"])
    camera = UsdGeom.Camera.Get(stage, job["camera"])

    def MakeRecorder():
        recorder = UsdAppUtils.FrameRecorder(job["renderer"], False)
        recorder.SetActiveRenderSettingsPrimPath(Sdf.Path(job["settings"]))
        recorder.SetImageWidth(job["width"])
        recorder.SetCameraLightEnabled(False)
        recorder.SetColorCorrectionMode("disabled")
        recorder.SetIncludedPurposes(["render"])
        return recorder

    def Record(recorder, name):
        if not recorder.Record(stage, camera, Usd.TimeCode.EarliestTime(), f"{job['out']}/{name}.exr"):
            raise RuntimeError(f"{name} was not recorded")

    live = MakeRecorder()
    Record(live, "start")
    for name, Edit in EDITS.items():
        Edit(stage)
        Record(live, name)
        Record(MakeRecorder(), f"{name}.fresh")


if __name__ == "__main__":
    main(*sys.argv[1:])
