# SPDX-License-Identifier: Apache-2.0
"""Edits a stage while an engine draws it, and draws each edited stage with a fresh engine.

Runs in OpenUSD's Python without a screen. The job names the stage, its camera and render settings, the renderer's plug-in, the
width, the folder of the pictures, and the edits where not all are meant: EDIT.exr and EDIT.fresh.exr for each, in their order,
and start.exr.
"""

import json

from pxr import Sdf, Usd, UsdAppUtils, UsdGeom


def Run(jobPath, edits):
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
    for name in job.get("edits", edits):
        edits[name](stage)
        Record(live, name)
        Record(MakeRecorder(), f"{name}.fresh")
