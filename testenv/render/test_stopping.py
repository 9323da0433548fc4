# SPDX-License-Identifier: Apache-2.0
"""When a render stops: error target, time limit, interruption. What is kept is exact for its samples."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages.verify import CASES

_SIZE = (64, 48)


@pytest.fixture(scope="module")
def Stage(tmp_path_factory):
    return CASES["fiveLights"].Write(f"{tmp_path_factory.mktemp('stopping')}/stage.usda")


def _Counts(picture) -> np.ndarray:
    return np.asarray(picture.layers["sampleCount"])


def test_noise_stops_pixels_at_block_borders(Stage):
    picture = ours.Render(Stage, *_SIZE, ("color", "sampleCount", "variance"), samples=256, noise=0.05)
    counts = _Counts(picture)
    assert counts.min() >= 32 and counts.max() <= 256
    assert np.all(counts % 16 == 0)
    assert counts.min() < counts.max(), "some pixels are easier than others"
    error = _OwnError(picture, counts)
    # The pixel's own variance counts by a quarter; the estimate is summed in float.
    assert np.all(error[counts < 256] <= 2 * 0.05 * 1.001)


def _OwnError(picture, counts) -> np.ndarray:
    luminance = picture.rgb @ (0.2126, 0.7152, 0.0722)
    return np.sqrt(picture.layers["variance"][..., 0] / (luminance**2 + 0.01))


def test_a_pixel_stops_by_the_errors_around_it(Stage):
    """The mean of the estimates is the program's own figure; here it is computed again from the pixels' variances."""
    picture = ours.Render(Stage, *_SIZE, ("color", "sampleCount", "variance"), samples=32)
    own = _OwnError(picture, _Counts(picture)) ** 2
    height, width = own.shape
    estimates = np.empty_like(own)
    for y in range(height):
        for x in range(width):
            window = own[max(0, y - 2) : y + 3, max(0, x - 2) : x + 3]
            estimates[y, x] = np.sqrt(max(window.mean(), own[y, x] / 4))
    assert picture.statistics["accuracy"]["meanRelativeError"] == pytest.approx(estimates.mean(), rel=1e-4)
    threshold = float(np.median(estimates))
    stopped = _Counts(ours.Render(Stage, *_SIZE, ("color", "sampleCount"), samples=48, noise=threshold)) == 32
    clear = np.abs(estimates / threshold - 1) > 1e-4
    assert np.array_equal(stopped[clear], (estimates < threshold)[clear])


def test_the_estimated_error_is_no_less_than_the_real_one(Stage):
    """Pixels' estimates, as a mean, against a converged picture. They know what stratification does inside a block of 16
    samples; what it does beyond may make them too large."""
    picture = ours.Render(Stage, *_SIZE, ("color", "variance"), samples=64)
    luminance, truth = (rgb @ (0.2126, 0.7152, 0.0722) for rgb in (picture.rgb, ours.Render(Stage, *_SIZE, samples=2048, seed=9).rgb))
    estimated = np.mean(picture.layers["variance"][..., 0] / (truth**2 + 0.01))
    real = np.mean((luminance - truth) ** 2 / (truth**2 + 0.01))
    assert 0.9 * real <= estimated <= 2 * real


def test_a_stopped_pixel_has_the_bits_of_that_many_samples(Stage):
    adaptive = ours.Render(Stage, *_SIZE, ("color", "sampleCount"), samples=64, noise=0.08)
    counts = _Counts(adaptive)
    assert counts.min() < 64
    for samples in np.unique(counts):
        plain = ours.Render(Stage, *_SIZE, samples=int(samples)).layers["color"]
        mask = counts == samples
        assert adaptive.layers["color"][mask].tobytes() == plain[mask].tobytes()


@pytest.mark.parametrize("waveSize", [4096, 777])
def test_waves_do_not_change_what_stops(Stage, waveSize):
    a = ours.Render(Stage, *_SIZE, ("color", "sampleCount"), samples=64, noise=0.08)
    b = ours.Render(Stage, *_SIZE, ("color", "sampleCount"), samples=64, noise=0.08, waveSize=waveSize)
    assert a.layers["color"].tobytes() == b.layers["color"].tobytes()
    assert np.array_equal(_Counts(a), _Counts(b))


def test_a_time_limit_keeps_whole_samples(Stage):
    picture = ours.Render(Stage, *_SIZE, ("color", "sampleCount"), samples=1 << 20, timeLimit=1.0)
    counts = _Counts(picture)
    assert 1 <= counts.min() and counts.max() < 1 << 20
    exact = ours.Render(Stage, *_SIZE, samples=int(counts.max())).layers["color"]
    mask = counts == counts.max()
    assert mask.any() and picture.layers["color"][mask].tobytes() == exact[mask].tobytes()


def test_stopping_from_the_callback_keeps_what_is_there(Stage):
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(str(Stage)), session, Usd.TimeCode.Default())
    settings = _core.Settings()
    settings.camera, settings.imageWidth, settings.imageHeight, settings.samples = "/World/Camera", *_SIZE, 1 << 16
    settings.aovs = ["color", "sampleCount"]
    fractions = []
    strides = []

    def OnProgress(progress):
        fractions.append(progress.fraction)
        strides.append(progress.previewStride)
        return progress.previewStride != 1

    assert session.Render(settings, OnProgress) == _core.RenderResult.Stopped
    assert session.HasImage()
    assert fractions == sorted(fractions)
    assert strides[0] == 0 and strides[-1] == 1 and strides.count(1) == 1
    layers = {layer.name: np.array(layer.pixels) for layer in session.Layers()}
    assert layers["sampleCount"].max() > 0 and np.isfinite(layers["color"]).all()


def test_stopping_while_the_scene_is_prepared_leaves_no_picture(Stage):
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(str(Stage)), session, Usd.TimeCode.Default())
    settings = _core.Settings()
    settings.camera, settings.imageWidth, settings.imageHeight, settings.samples = "/World/Camera", *_SIZE, 2
    assert session.Render(settings, lambda progress: False) == _core.RenderResult.Stopped
    assert not session.HasImage()
    with pytest.raises(_core.Error, match="nothing has been rendered yet"):
        session.Layers()
    assert session.Render(settings) == _core.RenderResult.Complete
    assert session.HasImage()
