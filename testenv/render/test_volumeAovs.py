# SPDX-License-Identifier: Apache-2.0
"""Volumes in AOVs of first hits, and pictures of volumes that are denoised."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
import volumeCase
from pxr import Usd
from stages import author, shapes
from test_meshMedia import _Stage as _MediaStage

_UNIT = np.ones((16, 16, 16))  # of edge 1
_GRAY = (0.6, 0.3, 0.1)
_AOVS = ("color", "albedo", "volumeDepth", "cameraDepth", "primId")


def _AddWall(stage):
    """The right half of the picture, two units behind the origin."""
    author.AddMesh(stage, "/World/Wall", shapes.Box(4, 4, 0.1), color=_GRAY, translate=(2, 0, -2))


def _Slab(**coefficients):
    return {"/V": volumeCase.Volume(volumeCase.Grid(_UNIT), **coefficients)}


def _Stage(tmp_path, width=0.5):
    return volumeCase.Stage(tmp_path / "s.usda", width=width, add=_AddWall)


def test_albedo_before_a_wall_and_before_nothing(tmp_path):
    """Of a slab of even density by Beer's law, in each channel."""
    scattering, absorption = np.array((0.5, 2.0, 1.0)), np.array((0.5, 0.0, 3.0))
    layers, *_ = volumeCase.Render(_Stage(tmp_path), _Slab(scattering=scattering, absorption=absorption), aovs=_AOVS, samples=1)
    extinction = scattering + absorption
    left = np.exp(-extinction)
    own = scattering / extinction * (1 - left)
    expected = np.where(layers["primId"][..., None] >= 0, own + left * np.array(_GRAY), own)
    np.testing.assert_allclose(layers["albedo"], expected, rtol=1e-4)
    assert np.unique(layers["primId"]).size == 2


def test_depth_of_half_the_light(tmp_path):
    """The camera is at z = 10, the slab from 0.5 to -0.5 but for half a voxel; the wall behind it stays in cameraDepth."""
    layers, *_ = volumeCase.Render(_Stage(tmp_path), _Slab(absorption=(1.0, 2.0, 3.0)), aovs=_AOVS, samples=1)
    np.testing.assert_allclose(layers["volumeDepth"], 9.5 + np.log(2) / 2, atol=1 / 16)
    wall = layers["primId"] >= 0
    np.testing.assert_allclose(layers["cameraDepth"][wall], 11.95, rtol=1e-5)
    assert np.isinf(layers["cameraDepth"][~wall]).all()
    thin, *_ = volumeCase.Render(_Stage(tmp_path), _Slab(absorption=0.5), aovs=_AOVS, samples=1)
    assert np.isinf(thin["volumeDepth"]).all()


def test_two_volumes_share_what_is_lost(tmp_path):
    volumes = {"/A": volumeCase.Volume(volumeCase.Grid(_UNIT), scattering=1.0),
               "/B": volumeCase.Volume(volumeCase.Grid(_UNIT), absorption=3.0, scale=0.8)}
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=0.5), volumes, aovs=_AOVS, samples=1)
    expected = 1.0 / (1.0 + 2.4) * (1 - np.exp(-3.4))
    np.testing.assert_allclose(layers["albedo"], expected, rtol=1e-4)
    np.testing.assert_allclose(layers["volumeDepth"], 9.6 + np.log(2) / 3, atol=1 / 16)


def test_a_cloud_is_that_of_the_means_of_its_cells(tmp_path):
    """Pixels lie on voxels; those between two cells may be of either. In the mean it is the integral of the voxels."""
    voxels = volumeCase.Cloud(32)
    layers, *_ = volumeCase.Render(volumeCase.Stage(tmp_path / "s.usda", width=1.0),
                                   {"/V": volumeCase.Volume(volumeCase.Grid(voxels), scattering=2.0)}, size=32, aovs=_AOVS,
                                   samples=1)
    albedo = layers["albedo"][::-1, :, 0].T  # [x][y]
    means = voxels.reshape(4, 8, 4, 8, 32).mean((1, 3, 4))
    expected = np.repeat(np.repeat(1 - np.exp(-2.0 * means), 8, 0), 8, 1)
    inside = np.arange(32) % 8 != 0
    np.testing.assert_allclose(albedo[inside][:, inside], expected[inside][:, inside], rtol=1e-4)
    assert albedo.mean() == pytest.approx((1 - np.exp(-2.0 * voxels.sum(2) / 32)).mean(), abs=0.005)


def test_no_brick_is_read_and_no_bit_depends_on_pools(tmp_path):
    volumes = {"/V": volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud(32)), scattering=2.0)}
    first = [name for name in _AOVS if name != "color"]
    stage = _Stage(tmp_path)
    resident, *_ = volumeCase.Render(stage, volumes, aovs=first, samples=1, residency="resident")
    for settings in (dict(volumeMemory="4K"), dict(volumeMemory="100%", waveSize=64)):
        streamed, _, _ = volumeCase.Render(stage, volumes, aovs=first, samples=1, residency="stream", **settings)
        for name in first:
            assert streamed[name].tobytes() == resident[name].tobytes(), name


def test_a_denoised_cloud_is_nearer_to_the_truth(tmp_path):
    """And nearer than without what volumes are in the guide: the wall behind it does not show through."""
    from hdstream import _core
    from hdstream.denoiser import FindDenoiser

    FindDenoiser()
    try:
        _core.CheckDenoiser()
    except _core.Error as error:
        pytest.skip(str(error))
    stage = _Stage(tmp_path, width=1.2)
    volumes = {"/V": volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud(32)), scattering=12.0, absorption=0.5)}
    options = dict(size=96, aovs=("color", "noisy"))
    truth = volumeCase.Render(stage, volumes, samples=1024, seed=5, **options)[0]["noisy"][..., :3]
    layers, *_ = volumeCase.Render(stage, volumes, samples=8, denoise=True, **options)

    def Error(picture):
        return float(np.mean((picture[..., :3] - truth) ** 2 / (truth**2 + 0.01)))

    assert Error(layers["color"]) < 0.35 * Error(layers["noisy"]), (Error(layers["color"]), Error(layers["noisy"]))
    assert layers["color"][..., :3].mean() == pytest.approx(truth.mean(), rel=0.02)


_LIT = (("Dome", {}),)


def _Body(size, absorption=0.0, scattering=0.0, **placement):
    """A mesh that is filled, for test_meshMedia._Stage."""
    return shapes.Box(*size), dict(absorption=absorption, scattering=scattering), placement


def _FirstHits(path, **settings):
    picture = ours.Render(path, 16, 16, _AOVS, samples=1, **settings)
    assert not picture.warnings
    return picture.layers


def _Through(ways, behind):
    """\\param ways: (length, absorption, scattering) of each part of the ray. \\return the albedo."""
    left, albedo = np.ones(3), np.zeros(3)
    for length, absorption, scattering in ways:
        absorption, scattering = (np.broadcast_to(value, 3).astype(float) for value in (absorption, scattering))
        after = np.exp(-length * (absorption + scattering))
        albedo += left * (1 - after) * scattering / np.maximum(absorption + scattering, 1e-30)
        left = left * after
    return albedo + left * np.array(behind)


_OUTER, _INNER = ((0.5, 0.0, 3.0), (0.5, 2.0, 0.0)), ((0.0, 1.0, 0.2), (1.0, 0.5, 0.7))


def test_media_in_meshes_before_a_wall_and_before_nothing(tmp_path):
    """One in the other, by Beer's law of each part; first hits are those behind them."""
    path = _MediaStage(tmp_path / "s.usda", [_Body((4, 4, 1), *_OUTER), _Body((4, 4, 0.25), *_INNER)], _LIT, add=_AddWall)
    layers = _FirstHits(path)
    ways = [(0.375, *_OUTER), (0.25, *_INNER), (0.375, *_OUTER)]
    wall = layers["primId"] == layers["primId"][0, -1]
    assert 0.3 < wall.mean() < 0.7
    np.testing.assert_allclose(layers["albedo"][wall], np.tile(_Through(ways, _GRAY), (wall.sum(), 1)), rtol=1e-5)
    np.testing.assert_allclose(layers["albedo"][~wall], np.tile(_Through(ways, (0, 0, 0)), ((~wall).sum(), 1)), rtol=1e-5)
    np.testing.assert_allclose(layers["cameraDepth"][wall], 11.95, rtol=1e-5)


@pytest.mark.parametrize("absorption, depth", [((1.0, 2.0, 3.0), 9.5 + np.log(2) / 2), (0.5, np.inf)], ids=["deep", "thin"])
def test_media_in_meshes_have_the_depth_of_half_the_light(tmp_path, absorption, depth):
    layers = _FirstHits(_MediaStage(tmp_path / "s.usda", [_Body((4, 4, 1), absorption)], _LIT, add=_AddWall))
    np.testing.assert_allclose(layers["volumeDepth"], depth, rtol=1e-6)


def test_half_of_the_light_is_lost_in_all_media_together(tmp_path):
    """A quarter of a unit each of 1 and of 9, a gap between them: ln 2 is come to in the second."""
    bodies = [_Body((4, 4, 0.25), 1.0, translate=(0, 0, 0.5)), _Body((4, 4, 0.25), 4.0, 5.0)]
    layers = _FirstHits(_MediaStage(tmp_path / "s.usda", bodies, _LIT))
    np.testing.assert_allclose(layers["volumeDepth"], 9.875 + (np.log(2) - 0.25) / 9.0, rtol=1e-6)


@pytest.mark.parametrize("far", [1e6, 1.0], ids=["wall", "farPlane"])
def test_media_around_the_camera_are_in_the_aovs(tmp_path, far):
    """The camera in a body that is in another, both of which the far plane may cut."""
    bodies = [_Body((4, 4, 3), *_OUTER), _Body((4, 4, 1), *_INNER)]
    path = _MediaStage(tmp_path / "s.usda", bodies, _LIT, eye=(0, 0, 0.25), target=(0, 0, -1), width=0.02, add=_AddWall)
    stage = Usd.Stage.Open(path)
    stage.GetPrimAtPath("/World/Camera").GetAttribute("clippingRange").Set((1e-3, far))
    stage.Save()
    layers = _FirstHits(path)
    wall = layers["primId"] != -1
    ways = [(0.75, *_INNER), (0.25 if far == 1.0 else 1.0, *_OUTER)]
    assert wall.any() == (far > 1.0)
    for where, behind in ((wall, _GRAY), (~wall, (0, 0, 0))):
        np.testing.assert_allclose(layers["albedo"][where], np.tile(_Through(ways, behind), (where.sum(), 1)), rtol=2e-3)


def test_a_cloud_in_a_mesh_with_a_medium(tmp_path):
    """Both dim what is behind; the nearer of their depths of half the light counts."""
    path = _MediaStage(tmp_path / "s.usda", [_Body((4, 4, 0.25), 4.0, translate=(0, 0, 1))], _LIT, add=_AddWall)
    layers, *_ = volumeCase.Render(path, _Slab(scattering=(0.5, 2.0, 1.0)), aovs=_AOVS, samples=1)
    cloud = np.exp(-np.array((0.5, 2.0, 1.0)))
    wall = layers["primId"] == layers["primId"][0, -1]
    expected = (1 - cloud) + cloud * np.exp(-1.0) * np.array(_GRAY)
    np.testing.assert_allclose(layers["albedo"][wall], np.tile(expected, (wall.sum(), 1)), rtol=1e-4)
    np.testing.assert_allclose(layers["volumeDepth"], 8.875 + np.log(2) / 4, rtol=1e-5)
