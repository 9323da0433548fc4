# SPDX-License-Identifier: Apache-2.0
"""Volumes that move while the shutter is open, by velocities and by transforms, against brute-force integrals."""

import json

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
import volumeCase
from hdstream import _core
from hdstream.translate import TranslateStage
from hdstream.translate.motion import ReadShutter
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdVol
from stages.smoke import WriteVdb

_RATE = 48.0  # time codes a second
_SCALE = 1.25  # of the volume in the world


def _Stage(tmp_path, density, velocity, voxel, shutter, absorption, name="vel", scattering=0.0, velocityVoxel=None, width=2.0):
    """The file's box is centred about its own origin, which the volume's transform keeps."""
    shape = np.asarray(density.shape)
    first = tuple(int(n) for n in -shape // 2)
    WriteVdb(tmp_path / "smoke.vdb", voxel, first, density=density)
    if velocityVoxel is None:
        velocityVoxel = voxel
    WriteVdb(tmp_path / "motion.vdb", velocityVoxel, tuple(int(n) for n in -np.asarray(velocity.shape[:3]) // 2), motion=velocity)

    def Add(stage):
        stage.SetTimeCodesPerSecond(_RATE)
        volume = UsdVol.Volume.Define(stage, "/World/Smoke")
        for field, file, grid in (("density", "smoke", "density"), (name, "motion", "motion")):
            asset = UsdVol.OpenVDBAsset.Define(stage, f"/World/Smoke/{field}")
            asset.CreateFilePathAttr(f"./{file}.vdb")
            asset.CreateFieldNameAttr(grid)
            volume.CreateFieldRelationship(field, asset.GetPath())
        volume.AddScaleOp().Set(Gf.Vec3f(_SCALE))
        look = UsdShade.Material.Define(stage, "/World/Look")
        medium = UsdShade.Shader.Define(stage, "/World/Look/Medium")
        medium.CreateIdAttr("ND_anisotropic_vdf")
        medium.CreateInput("absorption", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(absorption))
        medium.CreateInput("scattering", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(scattering))
        shader = UsdShade.Shader.Define(stage, "/World/Look/Volume")
        shader.CreateIdAttr("ND_volume")
        shader.CreateInput("vdf", Sdf.ValueTypeNames.Token).ConnectToSource(
            medium.CreateOutput("out", Sdf.ValueTypeNames.Token))
        look.CreateVolumeOutput("mtlx").ConnectToSource(shader.CreateOutput("out", Sdf.ValueTypeNames.Token))
        UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(look)
        camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
        camera.CreateShutterOpenAttr(shutter[0])
        camera.CreateShutterCloseAttr(shutter[1])

    return volumeCase.Stage(tmp_path / "s.usda", width=width, add=Add)


def _Render(path, size, timeCode=Usd.TimeCode(0), **settings) -> ours.Picture:
    session, options = _core.Session(), _core.Settings()
    stage = Usd.Stage.Open(path)
    TranslateStage(stage, session, timeCode, ReadShutter(stage.GetPrimAtPath("/World/Camera"), timeCode))
    options.camera, options.imageWidth, options.imageHeight = "/World/Camera", size, size
    options.pixelFilter, options.pixelFilterWidth, options.noCache, options.russianRoulette = "box", 1.0, True, False
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    layers = {layer.name: np.array(layer.pixels) for layer in session.Layers()}
    return ours.Picture(layers, json.loads(session.Statistics()), list(session.Warnings()))


def _Interpolated(values, at):
    """Linear between voxels, 0 outside; `at` [..., 3] counts from the first voxel."""
    padded = np.pad(values, [(1, 1)] * 3 + [(0, 0)] * (values.ndim - 3))
    at = np.clip(at + 1, 0, np.array(padded.shape[:3]) - 1.000001)
    cell = at.astype(int)
    part, total = at - cell, 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.where(corner, part, 1 - part).prod(-1)
        total = total + weight.reshape(weight.shape + (1,) * (values.ndim - 3)) * padded[tuple(np.moveaxis(cell + corner, -1, 0))]
    return total


def _Moved(density, velocity, at, seconds, voxel, velocityVoxel):
    """What a collision finds at voxels `at`: the density where each of the eight voxels of velocity around comes from, by the
    weights of interpolation."""
    centre, velocityCentre = (np.array(density.shape) // 2, np.array(velocity.shape[:3]) // 2)
    place = (at - centre) * voxel  # of the object
    there = place / velocityVoxel + velocityCentre
    padded = np.pad(velocity, [(1, 1)] * 3 + [(0, 0)])
    cell = np.floor(there).astype(int)
    part, total = there - cell, 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.where(corner, part, 1 - part).prod(-1)
        index = np.clip(cell + corner + 1, 0, np.array(velocity.shape[:3]) + 1)
        moved = at - padded[tuple(np.moveaxis(index, -1, 0))] * seconds[..., None] / voxel
        total = total + weight * _Interpolated(density, moved)
    return total


def _Expected(density, velocity, voxel, velocityVoxel, shutter, absorption, size, width, rays, steps):
    """Transmittances of pixels by quadrature along z, over pixels and the shutter."""
    random = np.random.default_rng(3)
    times = (np.arange(rays) + random.random(rays)) / rays
    picture = np.zeros((size, size))
    half = 0.5 * width
    z = ((np.arange(steps) + 0.5) / steps * 2 - 1) * half
    for row in range(size):
        x = (np.arange(size)[:, None] + random.permuted(np.tile(times, (size, 1)), axis=1)) / size * width - half
        y = half - (row + random.permuted(np.tile(times, (size, 1)), axis=1)) / size * width
        seconds = (shutter[0] + times * (shutter[1] - shutter[0])) / _RATE
        place = np.stack(np.broadcast_arrays(x[..., None], y[..., None], z), -1) / _SCALE
        at = place / voxel + np.array(density.shape) // 2
        found = _Moved(density, velocity, at, np.broadcast_to(seconds[None, :, None], at.shape[:-1]), voxel, velocityVoxel)
        picture[row] = np.exp(-absorption * found.mean(-1) * width).mean(-1)
    return picture


def test_what_goes_straight_is_blurred_by_its_way(tmp_path):
    """A cube that goes along x: each column is the mean of transmittances over the way."""
    density, speed, shutter = np.ones((16, 16, 16)), 0.9, (-8.0, 40.0)
    velocity = np.broadcast_to(np.array((speed, 0, 0)), (48, 48, 48, 3))  # also where the cube comes to
    path = _Stage(tmp_path, density, velocity, 1 / 16, shutter, 2.0, width=4.0)
    picture = _Render(path, 32, samples=4096)
    assert not picture.warnings
    x = (np.arange(32)[:, None] + (np.arange(16) + 0.5)[None] / 16) / 8 - 2
    times = (shutter[0] + (np.arange(512) + 0.5) / 512 * (shutter[1] - shutter[0])) / _RATE
    at = (x[..., None] / _SCALE - speed * times) * 16 + 8
    along = np.interp(at, (-1, 0, 15, 16), (0, 1, 1, 0)) * 16 / 16 * _SCALE
    expected = np.exp(-2.0 * along).mean((1, 2))
    assert picture.rgb[14:18, :, 0].mean(0) == pytest.approx(expected, abs=0.01)
    assert np.abs(picture.rgb[14:18, :, 0].mean(0) - np.exp(-2 * np.interp(x / _SCALE * 16 + 8, (-1, 0, 15, 16), (
        0, 1, 1, 0)) * _SCALE).mean(1)).max() > 0.3, "at rest it would be another picture"


@pytest.mark.parametrize("velocityVoxel", [1 / 16, 0.11])
def test_each_point_comes_from_where_its_velocity_says(tmp_path, velocityVoxel):
    """Velocities of all directions, on the density's own voxels and on others."""
    random = np.random.default_rng(2)
    density = volumeCase.Cloud(16) * 3
    velocity = random.uniform(-0.5, 0.5, (16 if velocityVoxel == 1 / 16 else 12,) * 3 + (3,))
    velocity[:5] = 0
    shutter, size, width = (-24.0, 24.0), 8, 2.0
    path = _Stage(tmp_path, density, velocity, 1 / 16, shutter, 2.0, velocityVoxel=velocityVoxel, width=width)
    picture = _Render(path, size, samples=4096)
    assert not picture.warnings
    expected = _Expected(density, velocity.astype(np.float32), 1 / 16, velocityVoxel, shutter, 2.0, size, width, 256, 96)
    assert picture.rgb[..., 0].mean() == pytest.approx(expected.mean(), abs=0.004)
    assert picture.rgb[..., 0] == pytest.approx(expected, abs=0.025)
    still = _Expected(density, 0 * velocity, 1 / 16, velocityVoxel, shutter, 2.0, size, width, 256, 96)
    assert np.abs(still - expected).max() > 0.1, "it must matter"


def _Pictures(tmp_path, *settings, **options):
    density, random = volumeCase.Cloud(24), np.random.default_rng(2)
    path = _Stage(tmp_path, density, random.uniform(-1, 1, (24, 24, 24, 3)), 1 / 24, (0.0, 12.0), 1.0, scattering=4.0, **options)
    return [_Render(path, 16, samples=8, **one) for one in settings]


def test_bits_are_the_same_at_any_budget(tmp_path):
    resident, *others = _Pictures(tmp_path, dict(residency="resident"), dict(residency="stream", volumeMemory="5%"),
                                  dict(residency="stream", textureMemory="16K"), dict(residency="stream", waveSize=64),
                                  dict(residency="resident", traversal="scalar"))
    assert resident.rgb.std() > 0.01
    for other in others:
        assert np.array_equal(other.rgb, resident.rgb)


def test_a_closed_shutter_and_no_velocity_are_the_same(tmp_path):
    (tmp_path / "b").mkdir()
    moving, still, noFrame = _Pictures(tmp_path, dict(), dict(motionBlur="off"), dict(timeCode=Usd.TimeCode.Default()))
    plain, default = _Pictures(tmp_path / "b", dict(), dict(timeCode=Usd.TimeCode.Default()), name="other")
    assert np.array_equal(still.rgb, plain.rgb) and not np.array_equal(moving.rgb, plain.rgb)
    assert np.array_equal(noFrame.rgb, default.rgb), "at no frame nothing moves"
    assert plain.statistics["volume"]["grids"] == 1 and moving.statistics["volume"]["grids"] == 7


def test_a_velocity_that_is_no_vector_warns_once(tmp_path):
    density = np.ones((8, 8, 8))
    path = _Stage(tmp_path, density, density, 1 / 8, (0.0, 1.0), 1.0)
    picture = _Render(path, 8, samples=4)
    assert [warning for warning in picture.warnings if "no vector" in warning and "/World/Smoke" in warning], picture.warnings


def _Moving(tmp_path, way, **options):
    """A cloud whose transform goes by `way` from frame -24 to 24."""
    density, velocity = volumeCase.Cloud(24), np.broadcast_to(options.pop("velocity", (0, 0, 0)), (48, 48, 48, 3))
    path = _Stage(tmp_path, density, velocity, 1 / 24, options.pop("shutter", (-12.0, 12.0)), 1.0, scattering=4.0, **options)
    stage = Usd.Stage.Open(path)
    volume = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Smoke"))
    scale = volume.GetOrderedXformOps()
    translate = volume.AddTranslateOp()
    for time, sign in ((-24.0, -0.5), (24.0, 0.5)):
        translate.Set(sign * Gf.Vec3d(*way), time)
    volume.SetXformOpOrder([translate, *scale])
    stage.GetRootLayer().Save()
    return path


def test_a_transform_that_undoes_the_velocity_is_at_rest(tmp_path):
    """The velocity carries the smoke along x, of the volume's own space, and the transform carries that back: in the world it is
    at rest, where the frame has it. An event's place, its shadows and its boundaries follow both."""
    speed = np.array((1.3, -0.4, 0.2))
    path = _Moving(tmp_path, tuple(-_SCALE * speed * 48 / _RATE), velocity=speed)
    moving, still = (_Render(path, 16, samples=2048, motionBlur=blur) for blur in ("on", "off"))
    assert not moving.warnings
    assert moving.rgb.mean() == pytest.approx(still.rgb.mean(), rel=0.003)
    blocks = [picture.rgb.reshape(4, 4, 4, 4, 3).mean((1, 3)) for picture in (moving, still)]
    assert blocks[0] == pytest.approx(blocks[1], abs=0.01)
    (tmp_path / "b").mkdir()
    alone = _Render(_Moving(tmp_path / "b", tuple(-_SCALE * speed * 48 / _RATE)), 16, samples=64)
    assert np.abs(alone.rgb.reshape(4, 4, 4, 4, 3).mean((1, 3)) - blocks[1]).max() > 0.05, "it must matter"


def test_bits_of_a_moving_transform_are_the_same_at_any_budget(tmp_path):
    path = _Moving(tmp_path, (1.5, 0.5, 0.0))
    resident, *others = [_Render(path, 16, samples=8, **settings) for settings in (
        dict(residency="resident"), dict(residency="stream", volumeMemory="5%"), dict(residency="stream", waveSize=64),
        dict(residency="resident", traversal="scalar"), dict(motionBlur="off"))]
    for other in others[:-1]:
        assert np.array_equal(other.rgb, resident.rgb)
    assert not np.array_equal(others[-1].rgb, resident.rgb)


def test_a_moving_volume_that_becomes_flat_warns(tmp_path):
    path = _Moving(tmp_path, (1.5, 0.5, 0.0))
    stage = Usd.Stage.Open(path)
    flat = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Smoke")).AddScaleOp(opSuffix="flat")
    flat.Set(Gf.Vec3f(1), 0.0)
    flat.Set(Gf.Vec3f(1, 0, 1), 12.0)
    stage.GetRootLayer().Save()
    picture = _Render(path, 8, samples=2)
    assert [line for line in picture.warnings if "/World/Smoke" in line and "no sense" in line] and np.isfinite(picture.rgb).all()
