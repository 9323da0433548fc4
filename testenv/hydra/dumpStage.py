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


def DumpStage(stagePath) -> tuple[str, list[str]]:
    """The dump at the stage's start time code, and the warnings."""
    diagnostics = Diagnostics()
    session = _core.Session()
    stage = OpenStage(str(stagePath))
    TranslateStage(stage, session, stage.GetStartTimeCode())
    diagnostics.WarnOf(session)
    return session.Dump(), list(session.Warnings())


def main(stagePath: str, out: str) -> None:
    dump, warnings = DumpStage(stagePath)
    pathlib.Path(out).write_text(dump)
    pathlib.Path(out + ".warnings").write_text("".join(f"{line}\n" for line in warnings))


if __name__ == "__main__":
    main(*sys.argv[1:])
