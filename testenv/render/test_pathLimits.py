# SPDX-License-Identifier: Apache-2.0
"""Bounds of what paths may do: clamps, depths by lobe, filtered bounces. Depths have another oracle in light path
expressions, which sort the paths of a render without bounds."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from lightPathCase import RenderLightPaths, WriteLightPathStage
from stages import author, shapes
from stages.materialX import STANDARD, AddSurface


@pytest.fixture(scope="module", name="stage")
def MakeStage(tmp_path_factory):
    return WriteLightPathStage(tmp_path_factory.mktemp("pathLimits") / "all.usda")


def _Aovs(stage, aovs=("color",), **settings):
    return RenderLightPaths(stage, aovs, **settings).aovs


def test_a_light_that_is_seen_is_clamped_to_the_value(tmp_path):
    stage = author.NewStage(str(tmp_path / "s.usda"))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=10.0, color=(1.0, 0.5, 0.1))
    author.AddCamera(stage, eye=(0, 0, 5))
    stage.GetRootLayer().Save()
    path = str(tmp_path / "s.usda")
    assert np.allclose(ours.Render(path, 4, 4, clampDirect=2.0).rgb, (2.0, 1.0, 0.2), rtol=1e-6)
    assert np.allclose(ours.Render(path, 4, 4, clampDirect=11.0).rgb, (10.0, 5.0, 1.0), rtol=1e-6)
    assert np.allclose(ours.Render(path, 4, 4, clampIndirect=2.0).rgb, (10.0, 5.0, 1.0), rtol=1e-6)


def test_a_light_sample_is_clamped_to_the_value(tmp_path):
    """A sun on a white floor: one light sample at each hit, all alike. Without the clamp 20, red most."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(1.0, 1.0, 1.0))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), angle=0.0, intensity=20 * np.pi, color=(1.0, 0.25, 0.0))
    author.AddCamera(stage, eye=(0, 5, 0.01))
    stage.GetRootLayer().Save()
    whole, clamped = (ours.Render(tmp_path / "s.usda", 4, 4, maxDepth=0, **more) for more in ({}, dict(clampDirect=3.0)))
    assert clamped.rgb.max() == pytest.approx(3.0, rel=1e-5)
    assert clamped.rgb[..., 1] == pytest.approx(0.25 * clamped.rgb[..., 0], rel=1e-5)
    assert whole.rgb.max() > 10.0 and whole.statistics["accuracy"]["clampedSamples"] == 0
    assert clamped.statistics["accuracy"]["clampedSamples"] == 16 * 64  # each sample once


def test_bounds_that_bind_nothing_change_no_bit(stage):
    plain = _Aovs(stage)["color"]
    for settings in (dict(clampIndirect=9e5), dict(clampDirect=9e5), dict(filterGlossy=1e-6), dict(maxDiffuseDepth=8), dict(maxGlossyDepth=9)):
        assert np.array_equal(_Aovs(stage, **settings)["color"], plain), settings


def test_clamps_tell_direct_from_indirect(stage):
    aovs = ("emission", "direct", "indirect")
    plain, direct, indirect = (_Aovs(stage, aovs, **more) for more in ({}, dict(clampDirect=0.05), dict(clampIndirect=0.05)))
    for name in ("emission", "direct"):
        assert np.array_equal(indirect[name], plain[name])
        assert direct[name].mean() < 0.9 * plain[name].mean()
    assert np.array_equal(direct["indirect"], plain["indirect"])
    assert indirect["indirect"].mean() < 0.9 * plain["indirect"].mean()


def test_parts_of_a_clamped_picture_add_up(stage):
    parts = ("emission", "diffuse", "specular", "transmission", "volume")
    layers = _Aovs(stage, ("color", *parts), clampDirect=0.5, clampIndirect=0.05)
    total = sum(layers[name].astype(np.float64) for name in parts)
    assert total == pytest.approx(layers["color"][..., :3], rel=1e-5, abs=1e-5)


_DEPTHS = [
    # The last scattering finds a light; of those before no more than the depth are of the lobe.
    (dict(maxDiffuseDepth=0), "C[GS]*.?[LO]"),
    (dict(maxDiffuseDepth=1), "C[GS]*D?[GS]*.?[LO]"),
    (dict(maxGlossyDepth=0), "C(<.D>|<TG>|<TS>)*.?[LO]"),
    (dict(maxTransmissionDepth=0), "C(<RD>|<RG>|<RS>)*.?[LO]"),
    (dict(maxTransmissionDepth=0, maxGlossyDepth=0), "CD*.?[LO]"),
]


@pytest.mark.parametrize("depths, expression", _DEPTHS, ids=lambda value: str(value))
def test_depths_of_lobes_are_what_expressions_say(stage, depths, expression):
    name = f"lpe:{expression}"
    whole = _Aovs(stage, ("color", name), samples=256)
    picture = _Aovs(stage, ("color",), samples=256, **depths)["color"][..., :3].astype(np.float64)
    expected = whole[name].astype(np.float64)
    assert np.abs(whole["color"][..., :3] - expected).mean() > 0.005 * expected.mean()  # it leaves something out
    Blocks = lambda image: image.reshape(4, 16, 6, 16, 3).mean((1, 3))
    assert Blocks(picture) == pytest.approx(Blocks(expected), rel=0.05, abs=0.01)
    assert picture.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=0.01)


def _Caustic(path):
    """A smooth metal ball on a floor, below a small lamp: caustics that paths find by chance."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(0.6, 0.6, 0.6))
    metal = AddSurface(stage, "/World/Metal", STANDARD, metalness=1.0, base=1.0, base_color=(1.0, 1.0, 1.0), specular_roughness=0.2)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.8, 32, 64), material=metal, translate=(0, 0.8, 0))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1.5, 2.5, 1.0)), radius=0.05, intensity=2000.0)
    author.AddCamera(stage, eye=(0, 2.5, 5), target=(0, 0.4, 0))
    stage.GetRootLayer().Save()
    return str(path)


def test_filtered_caustics_are_less_noisy_and_as_bright(tmp_path):
    path = _Caustic(tmp_path / "s.usda")
    pictures = {value: [ours.Render(path, 48, 32, samples=64, seed=seed, filterGlossy=value).rgb for seed in range(8)]
                for value in (0.0, 1.0)}
    plain, filtered = (np.var(pictures[value], axis=0).mean() for value in (0.0, 1.0))
    assert filtered < 0.6 * plain
    assert np.mean(pictures[1.0]) == pytest.approx(np.mean(pictures[0.0]), rel=0.03)
    assert np.array_equal(*(ours.Render(path, 16, 16, samples=4, maxDepth=0, filterGlossy=value).rgb for value in (0.0, 1.0)))


def test_filtered_surfaces_lose_no_light(tmp_path):
    """White metals in a white sky, whatever they are filtered to."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    white = dict(metalness=1.0, base=1.0, base_color=(1.0, 1.0, 1.0))
    for k, roughness in enumerate((0.0, 0.3, 0.6)):
        metal = AddSurface(stage, f"/World/M{k}", STANDARD, specular_roughness=roughness, **white)
        author.AddMesh(stage, f"/World/Ball{k}", shapes.Sphere(0.5, 48, 96), material=metal, translate=(1.02 * (k - 1), 0, 0))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 5))
    stage.GetRootLayer().Save()
    picture = ours.Render(tmp_path / "s.usda", 64, 32, samples=256, maxDepth=64, filterGlossy=1.0)
    assert picture.rgb.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("more", [dict(waveSize=777), dict(traversal="scalar"), dict(residency="stream", geometryMemory="30%")], ids=str)
def test_bits_depend_on_nothing_else(stage, more):
    limits = dict(clampDirect=2.0, clampIndirect=0.1, filterGlossy=0.5, maxDiffuseDepth=2, maxTransmissionDepth=3)
    assert np.array_equal(_Aovs(stage, **limits)["color"], _Aovs(stage, **limits, **more)["color"])
