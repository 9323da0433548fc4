# SPDX-License-Identifier: Apache-2.0
"""One renderer of comparison.py in a process of its own: comparisonWorker.py JOB.json. Prints "ENTRY [number, message]" for
each stage from the job's first on; the message is empty where its picture was saved."""

import json
import os
import pathlib
import sys

_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent), str(_HERE.parent / "render")]

import numpy as np  # noqa: E402

_DEPTH = 6
_SEED = 1


def _HdStream(entry: dict, job: dict) -> np.ndarray:
    import hdstream
    from pxr import Usd

    image = hdstream.Render(entry["stage"], timeCode=Usd.TimeCode.Default(), camera=entry["camera"], samples=job["samples"],
                            imageWidth=entry["width"], imageHeight=entry["height"], maxDepth=_DEPTH, pixelFilter="box",
                            pixelFilterWidth=1.0)
    return image.aovs["color"][..., :3]


def _Mitsuba(entry: dict, job: dict) -> np.ndarray:
    import rivalsMitsuba
    import rivalsScene
    import rivalsWorker

    scene = rivalsScene.Read(entry["stage"], entry["camera"])
    rivalsWorker.Fit(scene.camera, entry["width"], entry["height"])
    exposure = scene.camera["exposure"]
    render, _ = rivalsMitsuba.Build(scene, dict(entry, renderer=rivalsMitsuba.PREVIEW, maxDepth=_DEPTH, threads=job["threads"]))
    return exposure * render(job["samples"], _SEED)


def _Cycles(entry: dict, job: dict) -> np.ndarray:
    import rivalsCycles
    import rivalsScene
    import rivalsWorker

    camera, lights = rivalsScene.ReadView(entry["stage"], entry["camera"])
    rivalsWorker.Fit(camera, entry["width"], entry["height"])
    render = rivalsCycles.BuildImported(entry["stage"], camera, lights, dict(entry, maxDepth=_DEPTH, threads=job["threads"]))
    return camera["exposure"] * render(job["samples"], _SEED)


_RENDERERS = {"hdstream": _HdStream, "mitsuba": _Mitsuba, "cycles": _Cycles}


def main() -> None:
    job = json.loads(pathlib.Path(sys.argv[1]).read_text())
    for number, entry in enumerate(job["entries"]):
        if number < job["first"]:
            continue
        message = ""
        try:
            picture = _RENDERERS[job["renderer"]](entry, job)
            np.save(pathlib.Path(job["out"]) / f"{number}-{job['renderer']}.npy", np.asarray(picture, np.float32))
        except Exception as error:  # whatever a rival says of a stage is its line in the table
            message = f"{type(error).__name__}: {error}".splitlines()[0]
        print("ENTRY " + json.dumps([number, message]), flush=True)
    os._exit(0)  # Blender and Dr.Jit may take long to take themselves down, or fail at it


if __name__ == "__main__":
    main()
