# SPDX-License-Identifier: Apache-2.0
"""Progress of a long render over time, how fast it can be cancelled, and the first picture after an edit.

    progressOverTime.py STAGE [--camera NAME] [--imageWidth N] [--imageHeight N] [--samples N] [--interactive]
                        [--cancels N] [--edits N] [NAME=VALUE...]

Kernels and prepared geometry are made by a short render before. Prints when how much was told to be done, the largest gap
between two reports that differ, the seconds from asking for the end to the end (so many times, at moments spread over the
render), and, with --edits, the seconds from an edit to the first coarse picture and to the first one of all pixels, for a
moved camera and for a moved mesh, as a host that edits while nothing is rendered sees them. NAME=VALUE are settings
(docs/settings.md). Without --camera the first one of the stage is used. The exit code is 1 when a gap is above 1.5 s or a
cancellation takes more than 0.5 s.
Run with PYTHONPATH=build/release/python.
"""

import argparse
import pathlib
import statistics
import sys
import threading
import time

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

import numpy as np  # noqa: E402
from bench.sceneRun import Scene  # noqa: E402
from hdstream import _core  # noqa: E402

_MAX_GAP = 1.5
_MAX_CANCEL = 0.5
_NUM_SHOWN = 16


def _SettingsOf(arguments) -> dict:
    values = dict(imageWidth=arguments.imageWidth, imageHeight=arguments.imageHeight, interactive=arguments.interactive)
    for text in arguments.settings:
        name, _, value = text.partition("=")
        values[name] = int(value) if value.isdigit() else value
    return values


class Render:
    """A render whose reports are kept."""

    def __init__(self, scene: Scene, samples: int):
        self._scene = scene
        self._settings = _core.Settings()
        for name, value in {**scene.settings, "samples": samples}.items():
            setattr(self._settings, name, value)
        self.reports = []  # seconds, fraction
        self.seconds = 0.0

    def Run(self, isCancelled=None) -> None:
        start = time.perf_counter()

        def OnProgress(progress) -> bool:
            self.reports.append((time.perf_counter() - start, progress.fraction))
            return True

        self._scene.session.Render(self._settings, OnProgress, [], isCancelled)
        self.seconds = time.perf_counter() - start

    def Changes(self) -> list:
        """The reports that told something new."""
        changes, last = [], -1.0
        for seconds, fraction in self.reports:
            if fraction > last:
                changes.append((seconds, fraction))
                last = fraction
        return changes

    def LargestGap(self) -> float:
        times = [0.0] + [seconds for seconds, _ in self.Changes()] + [self.seconds]
        return max(b - a for a, b in zip(times, times[1:]))


def CancelSeconds(scene: Scene, samples: int, after: float) -> float:
    """From asking, that long after the beginning, to the end."""
    isAsked = threading.Event()
    asked = []

    def Ask():
        asked.append(time.perf_counter())
        isAsked.set()

    timer = threading.Timer(after, Ask)
    timer.start()
    Render(scene, samples).Run(isAsked.is_set)
    end = time.perf_counter()
    timer.cancel()
    return end - asked[0] if asked else 0.0


def _MoveCamera(scene: Scene, turn: int) -> None:
    path = scene.settings["camera"]
    camera = scene.session.Scene().cameras[path]
    matrix = np.array(camera.worldFromCamera)
    matrix[3, 0] += 1e-3 * (turn + 1)
    camera.worldFromCamera = matrix
    scene.session.SetCamera(path, camera)


def _MoveMesh(scene: Scene, turn: int) -> None:
    path, prim = next(iter(scene.session.Scene().geometry.items()))
    placement = prim.placement
    matrix = np.array(placement.worldFromObject)
    matrix[3, 0] += 1e-3 * (turn + 1)
    placement.worldFromObject = matrix
    prim.placement = placement
    scene.session.SetGeometry(path, prim)


def EditSeconds(scene: Scene, edit, numEdits: int) -> tuple:
    """Medians of (to the first picture, to the first picture of all pixels)."""
    settings = _core.Settings()
    for name, value in {**scene.settings, "samples": 2, "interactive": True}.items():
        setattr(settings, name, value)
    coarse, fine = [], []
    for turn in range(numEdits + 1):  # the first one warms up
        seen = {}
        start = time.perf_counter()
        edit(scene, turn)

        def OnProgress(progress, seen=seen, start=start) -> bool:
            if progress.previewStride > 0 and progress.previewStride not in seen:
                scene.session.Layers(False)
                seen[progress.previewStride] = time.perf_counter() - start
            return 1 not in seen

        scene.session.Render(settings, OnProgress)
        coarse.append(seen[max(seen)])
        fine.append(seen[1])
    return statistics.median(coarse[1:]), statistics.median(fine[1:])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("settings", nargs="*", metavar="NAME=VALUE")
    parser.add_argument("--camera", default="")
    parser.add_argument("--imageWidth", type=int, default=1280)
    parser.add_argument("--imageHeight", type=int, default=720)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--interactive", action="store_true")
    parser.add_argument("--cancels", type=int, default=0)
    parser.add_argument("--edits", type=int, default=0)
    arguments = parser.parse_intermixed_args()
    scene = Scene(arguments.stage, arguments.camera, **_SettingsOf(arguments))
    if not arguments.camera:
        scene.settings["camera"] = min(scene.session.Scene().cameras, default="")
    scene.Render(1, imageWidth=320, imageHeight=180)
    isGood = True
    if arguments.samples > 0:
        render = Render(scene, arguments.samples)
        render.Run()
        changes = render.Changes()
        step = max(1, len(changes) // _NUM_SHOWN)
        print("| s | % |\n|---|---|")
        for seconds, fraction in changes[::step] + changes[-1:]:
            print(f"| {seconds:.2f} | {100 * fraction:.1f} |")
        gap = render.LargestGap()
        isGood = gap <= _MAX_GAP
        print(f"{len(render.reports)} reports in {render.seconds:.2f} s, the largest gap {gap:.2f} s")
        took = [CancelSeconds(scene, arguments.samples, render.seconds * (turn + 0.5) / arguments.cancels)
                for turn in range(arguments.cancels)]
        if took:
            isGood = isGood and max(took) <= _MAX_CANCEL
            print(f"cancelled in {statistics.median(took):.3f} s, {max(took):.3f} s at most")
    if arguments.edits:
        for name, edit in (("camera", _MoveCamera), ("mesh", _MoveMesh)):
            coarse, fine = EditSeconds(scene, edit, arguments.edits)
            print(f"{name} moved: first picture {1e3 * coarse:.0f} ms, of all pixels {1e3 * fine:.0f} ms")
    return 0 if isGood else 1


if __name__ == "__main__":
    sys.exit(main())
