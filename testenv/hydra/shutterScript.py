# SPDX-License-Identifier: Apache-2.0
"""Records one stage many times, with one engine: shutterScript.py JOB.json

Runs in OpenUSD's Python without a screen. The job names the stage, its camera and render settings, the renderer's plug-in, the
width, and the pictures: each has a time code, a file, and the render settings that are set before it.
"""

import json
import sys

from pxr import Sdf, Usd, UsdAppUtils, UsdGeom


def main(jobPath):
    with open(jobPath, encoding="utf-8") as stream:
        job = json.load(stream)
    stage = Usd.Stage.Open(job["stage"])
    camera = UsdGeom.Camera.Get(stage, job["camera"])
    settings = stage.GetPrimAtPath(job["settings"])
    recorder = UsdAppUtils.FrameRecorder(job["renderer"], False)
    recorder.SetActiveRenderSettingsPrimPath(Sdf.Path(job["settings"]))
    recorder.SetImageWidth(job["width"])
    recorder.SetCameraLightEnabled(False)
    recorder.SetColorCorrectionMode("disabled")
    recorder.SetIncludedPurposes(["render"])
    recorder.SetDomeLightVisibility(True)
    for picture in job["pictures"]:
        for name, value in picture["settings"].items():
            settings.GetAttribute(f"hdstream:{name}").Set(value)
        if not recorder.Record(stage, camera, Usd.TimeCode(picture["time"]), picture["file"]):
            raise RuntimeError(f"{picture['file']} was not recorded")


if __name__ == "__main__":
    main(sys.argv[1])
