# SPDX-License-Identifier: Apache-2.0
"""Translating stages in tests: a session that holds a stage, and its warnings."""

import pathlib

from pxr import Sdf, Usd, UsdGeom

from hdstream import _core
from hdstream.diagnostics import Diagnostics
from hdstream.translate import TranslateStage
from hdstream.translate.motion import ReadShutter

FOLDER = pathlib.Path(__file__).resolve().parent
CASES = sorted(path.parent.name for path in FOLDER.glob("*/scene.usda"))


def Translate(stage, timeCode=None):
    """A session with the stage at a time code (default: its start)."""
    session = _core.Session()
    timeCode = stage.GetStartTimeCode() if timeCode is None else timeCode
    TranslateStage(stage, session, timeCode, ShutterOf(stage, timeCode))
    return session


def ShutterOf(stage, timeCode):
    """While the shutter of some camera of the stage is open."""
    shutters = [ReadShutter(prim, timeCode) for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera)]
    shutters = [shutter for shutter in shutters if shutter[1] > shutter[0]] or [(0.0, 0.0)]
    return min(shutter[0] for shutter in shutters), max(shutter[1] for shutter in shutters)


def StageOf(text):
    """A stage in memory from the body of a .usda file; braces need no lines of their own."""
    text = text.replace("}", "\n}\n")
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString("#usda 1.0\n" + text)
    return Usd.Stage.Open(layer)


def GoldenText(case):
    """The dump of a case with the warnings of its translation, as its golden file holds it."""
    diagnostics = Diagnostics()
    stage = Usd.Stage.Open(str(FOLDER / case / "scene.usda"))
    session = Translate(stage)
    diagnostics.WarnOf(session)
    # Warnings of asset paths would name this folder.
    warnings = [line.replace(str(FOLDER), "") for line in session.Warnings()]
    return session.Dump() + "".join(f"warning {line}\n" for line in warnings)
