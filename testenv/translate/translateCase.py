# SPDX-License-Identifier: Apache-2.0
"""Translating stages in tests: a session that holds a stage, and its warnings."""

import pathlib

from pxr import Sdf, Usd

from hdstream import _core
from hdstream.diagnostics import Diagnostics
from hdstream.translate import TranslateStage

FOLDER = pathlib.Path(__file__).resolve().parent
CASES = sorted(path.parent.name for path in FOLDER.glob("*/scene.usda"))


def Translate(stage, timeCode=None):
    """A session with the stage at a time code (default: its start)."""
    session = _core.Session()
    TranslateStage(stage, session, stage.GetStartTimeCode() if timeCode is None else timeCode)
    return session


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
