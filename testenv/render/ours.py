# SPDX-License-Identifier: Apache-2.0
"""Renders a stage with hdStream for the tests: in this process, or in one of its own.

Tests use a box filter of one pixel and no Russian roulette, so that pixels are plain means over their
area and path lengths are exact; both are settings, not other code. They keep nothing in the persistent cache unless they say so:
PoCL compiles a kernel a second time to hand out what would be kept, and has a cache of its own.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import numpy as np


@dataclass
class Picture:
    """Layers by AOV name ([height][width][channels], ids [height][width]) and what the run said."""

    layers: dict
    statistics: dict
    warnings: list

    @property
    def rgb(self) -> np.ndarray:
        return self.layers["color"][..., :3].astype(np.float64)


def Render(stagePath, width: int, height: int, aovs=("color",), camera: str = "/World/Camera", renderPass: str = "",
           **settings) -> Picture:
    """One frame at the default time, of a UsdRenderPass where a path says so. `settings` are members of hdstream's Settings."""
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    stage = Usd.Stage.Open(str(stagePath))
    TranslateStage(stage, session, Usd.TimeCode.Default(), passPrim=stage.GetPrimAtPath(renderPass) if renderPass else None)
    options = _core.Settings()
    options.camera, options.imageWidth, options.imageHeight = camera, width, height
    options.aovs, options.pixelFilter, options.pixelFilterWidth = list(aovs), "box", 1.0
    options.russianRoulette, options.noCache = False, True
    options.kernels = os.environ.get("HDSTREAM_TEST_KERNELS", "auto")  # conftest.py
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    layers = {layer.name: np.array(layer.pixels) for layer in session.Layers()}
    return Picture(layers, json.loads(session.Statistics()), list(session.Warnings()))


def RenderApart(stagePath, width: int, height: int, environment: dict, **settings) -> dict:
    """The layers as rendered by a new process with `environment` added; for settings that a driver
    reads once. Raises with the process's own words when it fails."""
    with tempfile.TemporaryDirectory() as folder:
        job = dict(stage=str(stagePath), width=width, height=height, settings=settings, out=f"{folder}/out.npz")
        run = subprocess.run([sys.executable, __file__, json.dumps(job)], capture_output=True, text=True,
                             env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment})
        if run.returncode != 0:
            raise RuntimeError(f"render process failed: {run.stderr[-2000:]}")
        with np.load(job["out"]) as data:
            return {name: data[name] for name in data.files}


if __name__ == "__main__":
    _job = json.loads(sys.argv[1])
    np.savez(_job["out"], **Render(_job["stage"], _job["width"], _job["height"], **_job["settings"]).layers)
