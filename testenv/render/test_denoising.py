# SPDX-License-Identifier: Apache-2.0
"""Denoising: what it does to a noisy picture, what it leaves alone, and what is said where it is not installed."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages.verify import CASES

_SIZE = (96, 72)


@pytest.fixture(scope="module")
def Stage(tmp_path_factory):
    from hdstream import _core
    from hdstream.denoiser import FindDenoiser

    FindDenoiser()
    try:
        _core.CheckDenoiser()
    except _core.Error as error:
        pytest.skip(str(error))
    return CASES["fiveLights"].Write(f"{tmp_path_factory.mktemp('denoising')}/stage.usda")


def _RelMse(picture, reference) -> float:
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01)))


def test_the_error_falls_and_the_samples_are_kept(Stage):
    plain = ours.Render(Stage, *_SIZE, ("color",), samples=2)
    denoised = ours.Render(Stage, *_SIZE, ("color", "noisy", "alpha"), samples=2, denoise=True)
    reference = ours.Render(Stage, *_SIZE, samples=512, seed=3).rgb
    assert list(denoised.layers) == ["color", "noisy", "alpha"], "guides are not shown"
    assert denoised.layers["noisy"].tobytes() == plain.layers["color"].tobytes()
    assert np.array_equal(denoised.layers["color"][..., 3], plain.layers["color"][..., 3])
    assert _RelMse(denoised.rgb, reference) < 0.5 * _RelMse(plain.rgb, reference)
    assert denoised.rgb.mean() == pytest.approx(reference.mean(), rel=0.02)


def test_guides_that_are_asked_for_stay(Stage):
    aovs = ("normal", "color", "depth")
    plain = ours.Render(Stage, *_SIZE, aovs, samples=2)
    denoised = ours.Render(Stage, *_SIZE, aovs, samples=2, denoise=True)
    assert list(denoised.layers) == list(aovs)
    for name in ("normal", "depth"):
        assert denoised.layers[name].tobytes() == plain.layers[name].tobytes()


def test_a_render_without_color_has_nothing_to_denoise(Stage):
    picture = ours.Render(Stage, *_SIZE, ("depth", "alpha"), samples=2, denoise=True)
    assert list(picture.layers) == ["depth", "alpha"] and not picture.warnings


def test_without_denoising_noisy_is_the_color(Stage):
    picture = ours.Render(Stage, *_SIZE, ("noisy", "color"), samples=3)
    assert picture.layers["noisy"].tobytes() == picture.layers["color"].tobytes()
