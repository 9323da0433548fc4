# SPDX-License-Identifier: Apache-2.0
"""One fibre, round and as a ribbon, beside Mitsuba 3's BSDF `hair`, whose numbers hairMitsuba.py has written."""

import json

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hairMitsuba
import ours
from stages import author, curves
from stages.hair import AddHair

_STORED = json.loads(hairMitsuba.FILE.read_text())


@pytest.fixture(scope="module")
def Folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fibres")


def _Columns(folder, roughness, tilt, light, isRibbon):
    stage = author.NewStage(f"{folder}/a.usda")
    # Mitsuba and pbrt turn the viewer against MaterialX's angle.
    material = AddHair(stage, "/World/Look", hairMitsuba.ABSORPTION, roughness, cuticle=0.5 - hairMitsuba.CUTICLE / 180, ior=hairMitsuba.IOR)
    hair = curves.AddCurves(stage, "/World/Fibre", [np.array([(0, -20.0, 0), (0, 20.0, 0)])], 1.0, type="linear",
                            normals=[(0.0, 0.0, 1.0)] if isRibbon else None, normalInterpolation="constant", rotate=(tilt, 0, 0))
    author.Bind(hair.GetPrim(), material)
    if light is None:
        author.AddLight(stage, "/World/Sky", "Dome")
    else:
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(*light, 0)), intensity=1.0, angle=0.0)
    author.AddCamera(stage, eye=(0, 0, 40), width=10.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    size = hairMitsuba.COLUMNS
    return ours.Render(f"{folder}/a.usda", size, size, samples=4096, maxDepth=1).rgb.mean(0)


@pytest.mark.parametrize("isRibbon", [False, True], ids=["round", "ribbon"])
@pytest.mark.parametrize("name", sorted(_STORED))
def test_fibre_is_mitsubas(Folder, name, isRibbon):
    columns = _Columns(Folder, *hairMitsuba.Cases()[name], isRibbon)
    expected = np.array(_STORED[name])
    assert columns.mean() == pytest.approx(expected.mean(), rel=0.005)
    np.testing.assert_allclose(columns, expected, rtol=0.01, atol=2e-3 * expected.max())


def test_numbers_are_of_the_cases_there_are():
    assert set(_STORED) == set(hairMitsuba.Cases())


@pytest.mark.parametrize("name", ["smooth_back_-10", "rough_front_0"])
def test_numbers_can_be_made_again(name):
    pytest.importorskip("mitsuba")
    try:
        hairMitsuba.UseMitsuba()
    except (ImportError, RuntimeError) as error:
        pytest.skip(f"Mitsuba has no LLVM: {error}")
    again = hairMitsuba.Columns(*hairMitsuba.Cases()[name], samples=1 << 10)
    np.testing.assert_allclose(again, _STORED[name], rtol=0.03, atol=0.01 * np.max(_STORED[name]))
