# SPDX-License-Identifier: Apache-2.0
"""The package from Python: the example of docs/command-line.md, exceptions, callbacks."""

import pathlib
import re

import numpy as np
import pytest

from cliCase import WriteStage

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "command-line.md"


def MakeSession(tmp_path):
    from pxr import Usd
    from hdstream import _core
    from hdstream.translate import TranslateStage
    stage = Usd.Stage.Open(str(WriteStage(tmp_path)))
    session = _core.Session()
    TranslateStage(stage, session, stage.GetStartTimeCode())
    settings = _core.Settings()
    settings.camera = "/main_cam"
    settings.imageWidth, settings.imageHeight, settings.samples = 8, 5, 4
    return session, settings


def test_example_of_the_page_runs(tmp_path, monkeypatch, capsys):
    block = re.search(r"From Python:\n\n((?:    .*\n|\n)+)", PAGE.read_text(encoding="utf-8")).group(1)
    code = "\n".join(line[4:] for line in block.splitlines())
    WriteStage(tmp_path)
    monkeypatch.chdir(tmp_path)
    # Its camera is another one, its image larger than a test needs.
    code = code.replace("/World/camera", "/main_cam").replace(
        "session.Render", "settings.imageWidth = settings.imageHeight = 8; settings.samples = 1; session.Render")
    exec(compile(code, str(PAGE), "exec"), {})
    assert "(8, 8, 4)" in capsys.readouterr().out


def test_errors_are_exceptions(tmp_path):
    from hdstream import _core
    session, settings = MakeSession(tmp_path)
    settings.camera = "/none"
    with pytest.raises(_core.UsageError, match="/none"):
        session.Render(settings)
    assert issubclass(_core.UsageError, _core.Error)


def test_the_callback_stops_a_render(tmp_path):
    from hdstream import _core
    session, settings = MakeSession(tmp_path)
    seen = []
    assert session.Render(settings, lambda progress: not seen.append(progress.fraction)) == _core.RenderResult.Complete
    assert seen and seen == sorted(seen) and seen[-1] == pytest.approx(1.0)
    settings.samples = 1 << 20
    assert session.Render(settings, lambda progress: False) == _core.RenderResult.Stopped
    layer, = session.Layers()
    assert layer.pixels.shape == (5, 8, 4) and np.isfinite(layer.pixels).all()


def test_exceptions_of_the_callback_stop_the_render_and_are_raised(tmp_path):
    session, settings = MakeSession(tmp_path)
    settings.samples = 1 << 20

    def OnProgress(progress):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        session.Render(settings, OnProgress)


def test_layers_outlive_the_session(tmp_path):
    session, settings = MakeSession(tmp_path)
    session.Render(settings)
    pixels = session.Layers()[0].pixels
    copy = pixels.copy()
    del session
    np.testing.assert_array_equal(pixels, copy)


def test_prims_outlive_their_removal(tmp_path):
    """What Scene() has given stays what it was, whatever becomes of the scene."""
    session, settings = MakeSession(tmp_path)
    mesh, light = session.Scene().meshes["/Triangle"], session.Scene().lights["/Sun"]
    points = np.array(mesh.mesh.points)
    session.Remove("/Triangle")
    light.light.intensity = 7.0
    assert session.Scene().lights["/Sun"].light.intensity == 1.0, "a copy"
    session.Clear()
    del session
    np.testing.assert_array_equal(mesh.mesh.points, points)
    assert mesh.placement.visible and mesh.purpose == "default"
