# SPDX-License-Identifier: Apache-2.0
"""The bound core from Python: exceptions, callbacks, lives of objects. The package's interface: testenv/python."""

import numpy as np
import pytest

from cliCase import WriteStage


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
    prim, light = session.Scene().geometry["/Triangle"], session.Scene().lights["/Sun"]
    points = np.array(prim.geometry.points)
    session.Remove("/Triangle")
    light.light.intensity = 7.0
    assert session.Scene().lights["/Sun"].light.intensity == 1.0, "a copy"
    session.Clear()
    del session
    np.testing.assert_array_equal(prim.geometry.points, points)
    assert prim.placement.visible and prim.purpose == "default"
