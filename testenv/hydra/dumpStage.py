# SPDX-License-Identifier: Apache-2.0
"""Writes the scene dump of usd-core's translator, and the warnings of it: dumpStage.py STAGE OUT

OUT gets Session.Dump(), which needs no device; OUT.warnings one line a warning. The counterpart is what
the Hydra plug-in writes to $HDSTREAM_DUMP_SCENE.
"""

import pathlib
import sys

from hdstream import _core
from hdstream.diagnostics import Diagnostics
from hdstream.stage import OpenStage
from hdstream.translate import TranslateStage
from hdstream.translate.motion import ReadShutter
from pxr import UsdGeom


def DumpStage(stagePath) -> tuple[str, list[str]]:
    """The dump at the stage's start time code, and the warnings."""
    diagnostics = Diagnostics()
    session = _core.Session()
    stage = OpenStage(str(stagePath))
    timeCode = stage.GetStartTimeCode()
    # Hydra samples what moves while the shutter of any camera is open.
    shutters = [ReadShutter(prim, timeCode) for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera)]
    shutters = [shutter for shutter in shutters if shutter[1] > shutter[0]] or [(0.0, 0.0)]
    shutter = min(shutter[0] for shutter in shutters), max(shutter[1] for shutter in shutters)
    TranslateStage(stage, session, timeCode, shutter)
    diagnostics.WarnOf(session)
    return session.Dump(), list(session.Warnings())


def main(stagePath: str, out: str) -> None:
    dump, warnings = DumpStage(stagePath)
    pathlib.Path(out).write_text(dump)
    pathlib.Path(out + ".warnings").write_text("".join(f"{line}\n" for line in warnings))


if __name__ == "__main__":
    main(*sys.argv[1:])
