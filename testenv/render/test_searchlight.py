# SPDX-License-Identifier: Apache-2.0
"""Light that scatters through matter beside Mitsuba's volpath, where that is installed, by z-tests of independent renders: the
profile of light beside a lamp on a slab, and blocks of a cloud."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")
mi = pytest.importorskip("mitsuba")

import mitsubaScene
import ours
import volumeCase
from stages import shapes
from test_meshMedia import _Stage
from test_volumes import _MitsubaCloud

_RENDERS = 8  # with a seed each
_MOST = 5.0  # deviations that any of the numbers below may be off
_SIGMA, _ALBEDO, _G = 4.0, np.array((0.95, 0.8, 0.5)), 0.3
_SIZE, _WIDTH = 24, 3.0
_RINGS = (0.3, 0.45, 0.65, 0.9, 1.2, 1.5)  # beside the lamp
_LAMP, _HEIGHT = 0.25, 0.05  # its edge, and how far above the slab it is


def _OursBelowALamp(path, seed: int) -> np.ndarray:
    return ours.Render(path, _SIZE, _SIZE, samples=1024, maxDepth=24, russianRoulette=True, seed=seed).rgb.astype(np.float64)


def _Searchlight(path) -> str:
    lamp = ("Rect", dict(width=_LAMP, height=_LAMP, intensity=1.0, placement=dict(translate=(0, 0, _HEIGHT))))
    medium = dict(absorption=_SIGMA * (1 - _ALBEDO), scattering=_SIGMA * _ALBEDO, anisotropy=_G)
    return _Stage(path, [(shapes.Box(6, 6, 2), medium, dict(translate=(0, 0, -1)))], (lamp,), width=_WIDTH)


def _MitsubaSearchlight():
    color = lambda values: dict(type="rgb", value=[float(value) for value in values])
    place = mi.ScalarTransform4f
    medium = dict(type="homogeneous", sigma_t=dict(type="constvolume", value=_SIGMA), phase=dict(type="hg", g=_G),
                  albedo=dict(type="constvolume", value=color(_ALBEDO)))
    film = dict(type="hdrfilm", width=_SIZE, height=_SIZE, rfilter=dict(type="box"), pixel_format="rgb")
    view = place().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0]) @ place().scale([_WIDTH / 2, _WIDTH / 2, 1])
    lamp = place().translate([0, 0, _HEIGHT]) @ place().rotate([1, 0, 0], 180) @ place().scale([_LAMP / 2, _LAMP / 2, 1])
    return mi.load_dict(dict(
        type="scene", integrator=dict(type="volpath", max_depth=1000, rr_depth=50),
        sensor=dict(type="orthographic", to_world=view, film=film, sampler=dict(type="independent")),
        slab=dict(type="cube", to_world=place().translate([0, 0, -1]) @ place().scale([3, 3, 1]), bsdf=dict(type="null"),
                  interior=medium),
        lamp=dict(type="rectangle", to_world=lamp, bsdf=dict(type="null"), emitter=dict(type="area", radiance=color((1,) * 3)))))


def _Rings(picture) -> np.ndarray:
    """Means [ring][channel] by the distance from the beam."""
    at = (np.arange(_SIZE) + 0.5) / _SIZE * _WIDTH - _WIDTH / 2
    radius = np.hypot(at[:, None], at[None])
    return np.stack([picture[(radius >= a) & (radius < b)].mean(0) for a, b in zip(_RINGS, _RINGS[1:])])


def _CheckEqual(mine: list, theirs: list, share: float) -> None:
    """Numbers of independent renders of two renderers. \\param share of each mean that noise may be: else the test says nothing."""
    mine, theirs = np.array(mine), np.array(theirs)
    isSeen = theirs.mean(0) > 0
    assert np.all(mine[:, ~isSeen] == 0)
    mine, theirs = mine[:, isSeen], theirs[:, isSeen]
    difference = mine.mean(0) - theirs.mean(0)
    deviation = np.sqrt(mine.var(0, ddof=1) / len(mine) + theirs.var(0, ddof=1) / len(theirs))
    assert np.median(deviation / theirs.mean(0)) < share
    # Eight renders each: some estimates of a deviation are far too small, so all of them together count beside each.
    pooled = np.maximum(deviation, 0.5 * np.median(deviation / theirs.mean(0)) * theirs.mean(0))
    assert np.abs(difference / pooled).max() < _MOST, np.abs(difference / pooled).max()
    assert abs(difference.sum() / theirs.mean(0).sum()) < 0.02


def test_profile_of_a_searchlight(tmp_path):
    """A lamp of one mean free path just above a slab of eight: what comes back beside it, in rings."""
    mitsubaScene.UseVariant("scalar_rgb")
    path, scene = _Searchlight(tmp_path / "s.usda"), _MitsubaSearchlight()
    mine = [_Rings(_OursBelowALamp(path, seed)) for seed in range(_RENDERS)]
    theirs = [_Rings(np.array(mi.render(scene, spp=512, seed=seed)).astype(np.float64)) for seed in range(_RENDERS)]
    assert np.mean(theirs, 0)[0].min() > 10 * np.mean(theirs, 0)[-1].min(), "it has to fall off"
    _CheckEqual(mine, theirs, 0.03)


def test_blocks_of_a_cloud(tmp_path):
    mitsubaScene.UseVariant("scalar_rgb")
    density = volumeCase.Cloud(24)
    density[[0, -1]] = density[:, [0, -1]] = density[:, :, [0, -1]] = 0.0  # beyond its grid Mitsuba goes on, we fade
    volume = volumeCase.Volume(volumeCase.Grid(density), scattering=12.0 * _ALBEDO, absorption=12.0 * (1 - _ALBEDO), anisotropy=_G)
    lamp = ("Rect", dict(width=6.0, height=6.0, intensity=1.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))
    path = volumeCase.Stage(tmp_path / "s.usda", lights=(lamp,), width=1.2)
    blocks = lambda picture: picture[..., :3].astype(np.float64).reshape(4, 4, 4, 4, 3).mean((1, 3))
    mine = [blocks(volumeCase.Render(path, {"/V": volume}, samples=256, seed=seed)[0]["color"]) for seed in range(_RENDERS)]
    theirs = [blocks(_MitsubaCloud(density, 12.0, _ALBEDO, _G, 128, seed)) for seed in range(_RENDERS)]
    _CheckEqual(mine, theirs, 0.03)
