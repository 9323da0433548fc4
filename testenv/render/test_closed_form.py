# SPDX-License-Identifier: Apache-2.0
"""hdStream's pictures equal closed forms: lights on a plate, furnaces, enclosures, camera scales.

Renders are small; tolerances are the noise at the given samples (named at each) or half a percent where
the integrand is smooth.
"""

import numpy as np
import pytest
from pxr import UsdGeom, UsdShade, Vt

pytest.importorskip("hdstream._core")

import closedForm
import ours
import plateCases
import stageReader
from stages import author, geometryCases, shapes


@pytest.mark.parametrize("name", sorted(plateCases.PLATES))
def test_light_on_plate(name, tmp_path):
    """Irradiance of each light type: the mean within 0.2 %, blocks of 6 x 6 pixels within 0.5 %."""
    path = plateCases.WritePlate(name, str(tmp_path))
    expected = plateCases.ExpectedPlate(path)
    picture = ours.Render(path, plateCases.WIDTH, plateCases.HEIGHT, samples=1024, maxDepth=0).rgb
    assert picture.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=2e-3)
    blocks = lambda a: a.reshape(6, 6, 8, 6, 3).mean((1, 3))
    np.testing.assert_allclose(blocks(picture), blocks(expected), rtol=5e-3, atol=1e-3 * expected.max())


def test_many_lights_on_plate(tmp_path):
    """However lights are selected, none is lost or counted twice: 60 spheres and 20 panels, of powers over
    three orders of magnitude, some of them hidden behind the plate."""
    rng = np.random.default_rng(4)
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(60, 60), color=(plateCases.ALBEDO,) * 3)
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=40.0, orthographic=True)
    for i in range(80):
        place = rng.uniform((-8, 0.6, -8), (8, 4, 8))
        intensity = float(10 ** rng.uniform(-1, 2))
        if i % 10 == 9:
            place[1] *= -1
        if i < 60:
            author.AddLight(stage, f"/World/L{i}", "Sphere", dict(translate=place), radius=float(rng.uniform(0.05, 0.3)),
                            intensity=intensity)
        else:
            author.AddLight(stage, f"/World/L{i}", "Rect", dict(translate=place, rotate=(-90, 0, 0)), width=0.5, height=0.3,
                            intensity=intensity)
    stage.GetRootLayer().Save()
    x, z = np.meshgrid((np.arange(plateCases.WIDTH) + 0.5) / 12 - 2, (np.arange(plateCases.HEIGHT) + 0.5) / 12 - 1.5)
    points = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], -1)
    expected = np.zeros(len(points))
    up = np.array([0.0, 1.0, 0.0])
    for light in stageReader.ReadStage(f"{tmp_path}/a.usda").lights:
        if light.matrix[3, 1] < 0:
            continue
        if light.kind == "Sphere":
            factor = closedForm.IrradianceOfSphere(points, up, light.matrix[3, :3], light.inputs["radius"])
        else:
            factor = closedForm.IrradianceOfRect(points, up, light.matrix, 0.5, 0.3, steps=8)
        expected += factor * light.radiance[0] * plateCases.ALBEDO / np.pi
    expected = expected.reshape(plateCases.HEIGHT, plateCases.WIDTH)
    picture = ours.Render(f"{tmp_path}/a.usda", plateCases.WIDTH, plateCases.HEIGHT, samples=1024, maxDepth=0).rgb[..., 0]
    assert picture.mean() == pytest.approx(expected.mean(), rel=3e-3)
    blocks = lambda a: a.reshape(6, 6, 8, 6).mean((1, 3))
    np.testing.assert_allclose(blocks(picture), blocks(expected), rtol=0.015)


def _Furnace(path: str, build) -> str:
    """A dense ball with `build(stage)`'s material in a uniform dome of radiance 1."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 96, 192), **build(stage))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 5), width=24.0, focalLength=50.0)
    stage.GetRootLayer().Save()
    return path


def test_furnace_of_white_lambert_is_invisible(tmp_path):
    """A white convex body in a uniform white dome cannot be told from the dome."""
    path = _Furnace(f"{tmp_path}/a.usda", lambda stage: dict(color=(1, 1, 1)))
    picture = ours.Render(path, 64, 48, samples=256, maxDepth=2).rgb
    assert picture.mean() == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(picture.reshape(12, 4, 16, 4, 3).mean((1, 3)), 1.0, atol=0.01)


_WHITE = dict(diffuseColor=(1.0, 1.0, 1.0))
_MATERIALS = {
    "default": dict(diffuseColor=(0.18, 0.18, 0.18)), "colour": dict(diffuseColor=(0.8, 0.4, 0.1)), "white": _WHITE,
    "smooth": dict(_WHITE, roughness=0.1), "rough": dict(_WHITE, roughness=1.0), "metal": dict(_WHITE, metallic=1.0, roughness=0.3),
    "roughMetal": dict(diffuseColor=(0.9, 0.5, 0.2), metallic=1.0, roughness=0.9),
    "halfMetal": dict(diffuseColor=(0.9, 0.5, 0.2), metallic=0.5, roughness=0.2),
    "coat": dict(diffuseColor=(0.5, 0.2, 0.1), clearcoat=1.0, clearcoatRoughness=0.1),
    "coatedMetal": dict(_WHITE, metallic=1.0, roughness=0.4, clearcoat=0.6, clearcoatRoughness=0.3),
    "highIor": dict(diffuseColor=(0.3, 0.3, 0.3), ior=3.0, roughness=0.3), "iorOne": dict(diffuseColor=(0.3, 0.3, 0.3), ior=1.0),
    "specular": dict(diffuseColor=(0.4, 0.4, 0.4), specularColor=(0.5, 0.25, 0.1), roughness=0.3),
}


@pytest.mark.parametrize("name", sorted(_MATERIALS))
def test_furnace_shows_the_directional_albedo(name, tmp_path):
    """In a uniform dome a convex body's pixel is the albedo of its material at that angle, here against a
    double-precision integral of the formula. (Its sum of lobes may pass 1 for white at grazing angles:
    OpenUSD's 1 - F(EdotH) does not account for all that the specular lobe reflects.)"""
    inputs = _MATERIALS[name]
    authored = dict(inputs, useSpecularWorkflow=1) if "specularColor" in inputs else inputs
    stage = author.NewStage(f"{tmp_path}/a.usda")
    material = author.AddMaterial(stage, "/World/M", **authored)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 192, 384), material=material)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 5), width=24.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(f"{tmp_path}/a.usda", 64, 48, samples=256, maxDepth=1).rgb
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64 * 2.4 - 1.2, (np.arange(48) + 0.5) / 64 * 2.4 - 0.9)
    radius2 = x * x + y * y
    cosines = np.linspace(0.3, 1.0, 15)
    rgb = inputs["diffuseColor"]
    table = np.array([closedForm.PreviewAlbedo(c, rgb, steps=300, **{k: v for k, v in inputs.items() if k != "diffuseColor"})
                      for c in cosines])
    for low, high in ((0.35, 0.6), (0.6, 0.85), (0.85, 1.0)):  # rings of equal-looking pixels average the noise
        cosine = np.sqrt(np.maximum(1 - radius2, 0))
        ring = (cosine > low) & (cosine < high)
        expected = np.array([np.interp(cosine[ring], cosines, table[:, c]).mean() for c in range(3)])
        np.testing.assert_allclose(picture[ring].mean(0), expected, rtol=5e-3)


def test_mirror_metal_reflects_everything(tmp_path):
    """A white metal of roughness 0 has no masking to lose energy to: albedo 1."""
    path = _Furnace(f"{tmp_path}/a.usda", lambda stage: dict(material=author.AddMaterial(stage, "/World/M", **_WHITE, metallic=1.0, roughness=0.0)))
    assert ours.Render(path, 64, 48, samples=64, maxDepth=2).rgb.mean() == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("bounces", [0, 1, 3, 30])
def test_integrating_sphere(bounces, tmp_path):
    """The wall of a closed sphere with one black, glowing patch has the radiance of the closed form,
    cut after as many bounces as maxDepth says."""
    shape = shapes.Sphere(1.0, 96, 192)
    inward = shapes.Shape(shape.points, shape.counts,
                          np.concatenate([f[::-1] for f in np.split(shape.indices, np.cumsum(shape.counts)[:-1])]))
    ends = np.cumsum(inward.counts)
    centres = np.array([inward.points[inward.indices[e - c : e]].mean(0) for e, c in zip(ends, inward.counts)])
    glowing = np.nonzero(centres[:, 1] > 0.8)[0]
    stage = author.NewStage(f"{tmp_path}/a.usda")
    mesh = author.AddMesh(stage, "/World/Shell", inward, color=(0.8, 0.8, 0.8))
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), metallic=1.0, emissiveColor=(5, 5, 5))
    author.Bind(UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset("glow", Vt.IntArray.FromNumpy(
        glowing.astype(np.int32))), glow)
    author.AddCamera(stage, eye=(0, 0, 0.3), target=(0, -0.5, -1), focalLength=60.0)
    stage.GetRootLayer().Save()
    areas = _FaceAreas(inward)
    expected = closedForm.EnclosureRadiance(5.0, 0.8, areas[glowing].sum() / areas.sum(), bounces)
    picture = ours.Render(f"{tmp_path}/a.usda", 48, 36, samples=256, maxDepth=bounces).rgb
    assert picture.mean() == pytest.approx(expected, rel=3e-3)


def _FaceAreas(shape) -> np.ndarray:
    areas, start = [], 0
    for count in shape.counts:
        p = shape.points[shape.indices[start : start + count]]
        areas.append(sum(np.linalg.norm(np.cross(p[k] - p[0], p[k + 1] - p[0])) / 2 for k in range(1, count - 1)))
        start += count
    return np.array(areas)


def test_emissive_square_facing_a_plate(tmp_path):
    """A glowing square mesh lights a plate as a rect light of the same radiance and place would."""
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(0.5,) * 3)
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), metallic=1.0, emissiveColor=(4, 4, 4))
    author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), material=glow, translate=(0, 1, 0), rotate=(180, 0, 0))
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=40.0, orthographic=True)
    stage.GetRootLayer().Save()
    x, z = np.meshgrid((np.arange(48) + 0.5) / 12 - 2, (np.arange(36) + 0.5) / 12 - 1.5)
    points = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], -1)
    down = np.diag([1.0, 1, 1, 1])[[0, 2, 1, 3]]
    down[3, 1] = 1.0
    expected = closedForm.IrradianceOfRect(points, np.array([0, 1.0, 0]), down, 1, 1).reshape(36, 48) * 4 * 0.5 / np.pi
    picture = ours.Render(f"{tmp_path}/a.usda", 48, 36, samples=512, maxDepth=0).rgb.mean(-1)
    assert picture.mean() == pytest.approx(expected.mean(), rel=3e-3)
    blocks = lambda a: a.reshape(6, 6, 8, 6).mean((1, 3))
    np.testing.assert_allclose(blocks(picture), blocks(expected), rtol=0.01)


def test_light_seen_has_its_radiance(tmp_path):
    """A camera ray that meets a rect light from the front brings its radiance; from behind nothing."""
    for turn, expected in ((180, 2.5), (0, 0.0)):
        stage = author.NewStage(f"{tmp_path}/{turn}.usda")
        author.AddLight(stage, "/World/Panel", "Rect", dict(rotate=(0, turn, 0)), width=50.0, height=50.0, intensity=2.5)
        author.AddCamera(stage, eye=(0, 0, 5))
        stage.GetRootLayer().Save()
        picture = ours.Render(f"{tmp_path}/{turn}.usda", 16, 12, samples=4).rgb
        np.testing.assert_allclose(picture, expected, rtol=1e-5)


def _BlocksStage(path: str, edit) -> str:
    stage = author.NewStage(path)
    geometryCases.AddBlocks(stage)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    edit(stage, UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")))
    stage.GetRootLayer().Save()
    return path


def test_camera_exposure_scales_exactly(tmp_path):
    """Three stops are a factor of 8 on every pixel (a power of two: exact but for the last bit)."""
    plain = ours.Render(_BlocksStage(f"{tmp_path}/a.usda", lambda stage, camera: None), 40, 30, samples=8).rgb
    bright = ours.Render(_BlocksStage(f"{tmp_path}/b.usda", lambda stage, camera: camera.CreateExposureAttr(3.0)), 40, 30, samples=8).rgb
    np.testing.assert_allclose(bright, 8 * plain, rtol=1e-5)


def test_photographic_exposure(tmp_path):
    """time, iso, fStop and responsivity act as UsdGeom's ComputeLinearExposureScale says."""
    camera = UsdGeom.Camera
    if not hasattr(camera, "ComputeLinearExposureScale"):
        pytest.skip("this usd-core has no photographic exposure")

    def Edit(stage, camera):
        camera.CreateExposureTimeAttr(0.25)
        camera.CreateExposureIsoAttr(200.0)
        camera.CreateExposureFStopAttr(2.0)
        camera.CreateExposureResponsivityAttr(1.5)

    plain = ours.Render(_BlocksStage(f"{tmp_path}/a.usda", lambda stage, camera: None), 40, 30, samples=8).rgb
    photo = ours.Render(_BlocksStage(f"{tmp_path}/b.usda", Edit), 40, 30, samples=8).rgb
    np.testing.assert_allclose(photo, plain * (0.25 * 200 / 100 * 1.5 / 4), rtol=1e-4)


def test_far_from_the_origin(tmp_path):
    """10^7 units away the picture is as near the origin: same samples, rounding differs at edges only."""
    near, far = geometryCases.WriteFarPair(str(tmp_path))
    a = ours.Render(near, 120, 90, samples=16)
    b = ours.Render(far, 120, 90, samples=16)
    assert np.isfinite(b.rgb).all()
    assert np.mean((a.rgb - b.rgb) ** 2 / (a.rgb**2 + 0.01)) < 1e-5
    assert np.mean(np.abs(a.rgb - b.rgb) > 0.02 * a.rgb + 1e-3) < 0.01
