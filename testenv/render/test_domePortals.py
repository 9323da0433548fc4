# SPDX-License-Identifier: Apache-2.0
"""Portals of domes change how domes are sampled, and no picture: light through a window equals that of a rect."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdLux

pytest.importorskip("hdstream._core")

import closedForm
from stages import author, imageFile, shapes
from test_lights import _UP, ALBEDO, _PictureOf, _Plate, _Points, _Render


def _Window(path):
    """A plate below a wide ceiling with a hole of 1 x 1 at height 1.5, and a dome above."""
    stage = _Plate(path)
    far = 500.0
    for name, x, z, width, depth in (("A", -far - 0.5, 0, 2 * far, 4 * far), ("B", far + 0.5, 0, 2 * far, 4 * far),
                                     ("C", 0, -far - 0.5, 1, 2 * far), ("D", 0, far + 0.5, 1, 2 * far)):
        author.AddMesh(stage, f"/World/Ceiling{name}", shapes.Plane(width, depth), color=(0, 0, 0), doubleSided=True,
                       translate=(x, 1.5, z))
    author.AddMesh(stage, "/World/Plate2", shapes.Plane(4 * far, 4 * far), color=(0, 0, 0), translate=(0, -0.1, 0))
    return stage


# Portals: translation, rotation (they let light in towards -z), size.
_DOWN = (-90, 0, 0)
PORTALS = {
    "none": (),
    "exact": (((0, 1.5, 0), _DOWN, (1, 1)),),
    "half of it": (((-0.25, 1.5, 0), _DOWN, (0.5, 1)),),
    "two that overlap, of which one is larger": (((0.1, 1.6, 0), _DOWN, (2, 2)), ((-0.25, 1.4, 0.2), _DOWN, (0.6, 0.7))),
    "elsewhere": (((3, 0.5, 0), (0, 0, 0), (1, 1)), ((0, -3, 0), _DOWN, (1, 1))),
}


@pytest.mark.parametrize("image", [False, True])
def test_portals_change_the_noise_alone(image, tmp_path):
    """Irradiance through a window is that of a rect, wherever portals are said to be."""
    inputs = dict(intensity=3.0)
    if image:
        imageFile.WriteExr(tmp_path / "sky.exr", {name: np.ones((8, 16)) for name in "RGB"})
        inputs["textureFile"] = "./sky.exr"
    errors = {}
    for name, portals in PORTALS.items():
        stage = _Window(f"{tmp_path}/{len(errors)}.usda")
        dome = author.AddLight(stage, "/World/Sky", "Dome", **inputs)
        for i, (translate, rotate, size) in enumerate(portals):
            portal = UsdLux.PortalLight.Define(stage, f"/World/Portal{i}")
            for key, value in zip(("width", "height"), size):
                portal.GetPrim().CreateAttribute(f"inputs:{key}", Sdf.ValueTypeNames.Float).Set(float(value))
            author.Place(portal, translate=translate, rotate=rotate)
            dome.CreatePortalsRel().AddTarget(portal.GetPath())
        window = np.array(Gf.Matrix4d().SetRotate(Gf.Rotation((1, 0, 0), -90)))
        window[3, :3] = (0, 1.5, 0)
        expected = _PictureOf(3.0 * np.repeat(closedForm.IrradianceOfRect(_Points(), _UP, window, 1, 1)[:, None], 3, 1))
        picture = _Render(stage, samples=512)
        assert picture.warnings == []
        assert picture.rgb.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=0.01), name
        errors[name] = np.sqrt(np.mean((picture.rgb - expected) ** 2)) / expected.mean()
    assert errors["exact"] < 0.3 * errors["none"]


def test_portals_far_away_keep_the_sky(tmp_path):
    """A portal that a point sees almost nothing of changes nothing of its light."""
    for distance in (1e3, 1e4, 1e5, 1e6):
        stage = _Plate(f"{tmp_path}/{distance:g}.usda")
        dome = author.AddLight(stage, "/World/Sky", "Dome")
        author.Place(UsdLux.PortalLight.Define(stage, "/World/Portal"), translate=(0.48 * distance, 0.6 * distance, 0.64 * distance), rotate=_DOWN)
        dome.CreatePortalsRel().AddTarget("/World/Portal")
        picture = _Render(stage, samples=64)
        assert picture.rgb.mean((0, 1)) == pytest.approx(ALBEDO, rel=0.01), f"{distance:g}"


def _Noise(folder, sun, hasPortal):
    """Relative RMS difference of two pictures by a sky with a sun, through the window; and their mean."""
    stage = _Window(f"{folder}/{sun[0]}{hasPortal}.usda")
    sky = np.ones((64, 128))
    sky[sun] = 5000.0
    imageFile.WriteExr(folder / f"{sun[0]}.exr", {name: sky for name in "RGB"}, half=False)
    dome = author.AddLight(stage, "/World/Sky", "Dome", textureFile=f"./{sun[0]}.exr")
    if hasPortal:
        author.Place(UsdLux.PortalLight.Define(stage, "/World/Portal"), translate=(0, 1.5, 0), rotate=_DOWN)
        dome.CreatePortalsRel().AddTarget("/World/Portal")
    first, second = (_Render(stage, samples=64, seed=seed).rgb for seed in (1, 2))
    mean = 0.5 * (first + second).mean()
    return np.sqrt(np.mean((first - second) ** 2)) / mean, mean


@pytest.mark.parametrize("sun, bound", [((1, 40), 0.9), ((29, 40), 0.6)], ids=["overhead", "that the window does not show"])
def test_portals_know_the_sun(sun, bound, tmp_path):
    """Samples through a portal follow the image: they waste none on a sun beside it, and do not miss one behind it."""
    noise, mean = _Noise(tmp_path, sun, False)
    withPortal, sameMean = _Noise(tmp_path, sun, True)
    assert sameMean == pytest.approx(mean, rel=0.02)
    assert withPortal < bound * noise


def test_portals_that_are_none_are_named(tmp_path):
    stage = _Plate(f"{tmp_path}/a.usda")
    dome = author.AddLight(stage, "/World/Sky", "Dome")
    dome.CreatePortalsRel().SetTargets(["/World/Plate", "/World/Nothing"])
    picture = _Render(stage, samples=4)
    assert sorted(picture.warnings) == ["/World/Sky: portal /World/Nothing is no PortalLight; left out",
                                        "/World/Sky: portal /World/Plate is no PortalLight; left out"]
    np.testing.assert_allclose(picture.rgb, ALBEDO, rtol=1e-3)
