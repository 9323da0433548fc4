# SPDX-License-Identifier: Apache-2.0
"""Volumes in AOVs of first hits, and pictures of volumes that are denoised."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import volumeCase
from stages import author, shapes

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
