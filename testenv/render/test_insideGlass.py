# SPDX-License-Identifier: Apache-2.0
"""Light on smooth glass that is met from inside, which is left to BSDF samples but for lights that rays do not find: all of it
arrives, and none of it twice, whatever the kind of light."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes
from stages.materialX import AddSurface
from test_glassShadows import _Fresnel

_RADIANCE = 3.0
_DEGREES = (38.0, 60.0)  # off the normal: some is reflected, and all of it is
_FIELD = 0.5  # the picture's width over the distance


def _Rect(stage):
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(0, -4, 0), rotate=(90, 0, 0)), width=80.0, height=80.0,
                    intensity=_RADIANCE)


def _Mesh(stage):
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), roughness=1.0, ior=1.0, emissiveColor=(_RADIANCE,) * 3)
    author.AddMesh(stage, "/World/Lamp", shapes.Plane(80, 80), material=glow, translate=(0, -4, 0))


def _Ball(stage):
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(0, -64, 0)), radius=60.0, intensity=_RADIANCE)


def _Dome(stage):
    author.AddLight(stage, "/World/Lamp", "Dome", intensity=_RADIANCE)


_LAMPS = {"rect": _Rect, "mesh": _Mesh, "ball": _Ball, "dome": _Dome}


def _Render(path, addLamp, degrees, samples, roughness=0.0, size=8, field=0.02) -> np.ndarray:
    """A sheet of glass whose inside is below, seen from there."""
    stage = author.NewStage(str(path))
    look = AddSurface(stage, "/World/Look", base=0.0, transmission=1.0, specular_IOR=1.5, specular_roughness=roughness)
    author.AddMesh(stage, "/World/Sheet", shapes.Plane(400, 400), material=look, translate=(0, 1, 0))
    addLamp(stage)
    author.AddCamera(stage, target=(np.tan(np.radians(degrees)), 1, 0), eye=(0, 0, 0), up=(0, 0, 1), aspect=1.0, focalLength=35.0,
                     width=35.0 * field)
    stage.GetRootLayer().Save()
    picture = ours.Render(path, size, size, samples=samples, maxDepth=4)
    assert not picture.warnings
    return picture.rgb


def _Reflected(degrees: float) -> float:
    cosine = np.cos(np.radians(degrees))
    if 1.5 * np.sin(np.radians(degrees)) >= 1:
        return 1.0
    return _Fresnel(cosine, 1 / 1.5)


@pytest.mark.parametrize("degrees", _DEGREES)
@pytest.mark.parametrize("lamp", _LAMPS)
def test_the_mirror_image_of_a_lamp_has_its_radiance(lamp, degrees, tmp_path):
    """Times what the surface reflects by Fresnel's equations; a dome is behind the surface too."""
    picture = _Render(tmp_path / "stage.usda", _LAMPS[lamp], degrees, samples=1024)
    part = 1.0 if lamp == "dome" else _Reflected(degrees)
    assert picture.mean() / _RADIANCE == pytest.approx(part, rel=0.03)


@pytest.mark.parametrize("angle, hasShadows, degrees", [(0.0, True, 25.0), (0.0, True, 60.0), (8.0, False, 25.0), (8.0, False, 60.0),
                                                        (8.0, True, 25.0), (1.0, True, 60.0)])
def test_a_sun_is_reflected(angle, hasShadows, degrees, tmp_path):
    """Of its irradiance across its direction the reflection has Fresnel's part, spread over the directions of the lobe: what the
    picture sees of it over its solid angle. Light samples alone find the first four suns, rays alone the others, of which the last
    is so small that a ray which was weighed against light samples would count little."""
    def AddSun(stage):
        sun = author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(90, 0, degrees)), angle=angle, normalize=True,
                              intensity=_RADIANCE)
        if not hasShadows:
            author.ShadowLight(sun, enable=False)
    picture = _Render(tmp_path / "stage.usda", AddSun, degrees, samples=256, roughness=0.1, size=48, field=_FIELD)
    seen = picture[..., 0].sum() * (_FIELD / 48) ** 2
    assert seen / _RADIANCE == pytest.approx(_Reflected(degrees), rel=0.05)
