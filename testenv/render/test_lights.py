# SPDX-License-Identifier: Apache-2.0
"""Lights as production stages have them equal closed forms: shaping, links, multipliers of lobes, shadow controls.

A Lambert plate under one light, seen from above; irradiance by quadrature in double precision.
"""

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

import closedForm
import ours
from stages import author, imageFile, shapes

WIDTH, HEIGHT, SIZE, ALBEDO = 24, 18, 4.0, 0.5
_UP = np.array([0.0, 1.0, 0.0])
# A profile with a lobe down and a ring, brighter towards azimuth 90: polar angles, azimuths, values.
_POLARS, _AZIMUTHS = (0, 20, 45, 60, 90), (0, 45, 90, 180)
_CANDELA = ((8, 6, 1, 3, 0), (8, 7, 2, 5, 0), (8, 8, 4, 9, 1), (8, 5, 1, 1, 0))


def _IesText():
    rows = "\n".join(" ".join(map(str, row)) for row in _CANDELA)
    return (f"IESNA:LM-63-2002\n[TEST] made by testenv\nTILT=NONE\n1 1000 0.25 {len(_POLARS)} {len(_AZIMUTHS)} 1 2 0 0 0\n"
            f"2.0 1.0 10\n{' '.join(map(str, _POLARS))}\n{' '.join(map(str, _AZIMUTHS))}\n{rows}\n")


def _Profile(polar, azimuth):
    """The profile, bilinear, symmetric about azimuths 0 and 180; 0.25 * 2 are the file's factors."""
    azimuth = np.degrees(np.minimum(azimuth, 2 * np.pi - azimuth))
    polar = np.degrees(polar)
    columns = np.stack([np.interp(polar, _POLARS, row, right=0.0) for row in _CANDELA])
    at = np.clip(np.searchsorted(_AZIMUTHS, azimuth, side="right") - 1, 0, len(_AZIMUTHS) - 2)
    low, high = np.array(_AZIMUTHS)[at], np.array(_AZIMUTHS)[at + 1]
    t = (azimuth - low) / (high - low)
    i = np.arange(len(polar))
    return 0.5 * ((1 - t) * columns[at, i] + t * columns[at + 1, i])


def _MeanOfProfile():
    """Over the hemisphere that the profile spans, by midpoints in cosine and azimuth."""
    n = 500
    cosine, azimuth = np.meshgrid((np.arange(n) + 0.5) / n, 2 * np.pi * (np.arange(n) + 0.5) / n)
    return _Profile(np.arccos(cosine).ravel(), azimuth.ravel()).mean()


_IES = dict(iesFile="./lamp.ies", coneAngle=180.0)
# kind, placement, inputs, shaping
SHAPED = {
    "sphereCone": ("Sphere", dict(translate=(0.3, 2.5, 0.2), rotate=(-80, 15, 0)), dict(radius=0.2), dict(coneAngle=30.0)),
    "sphereSoftCone": ("Sphere", dict(translate=(0.3, 2.5, 0.2), rotate=(-80, 15, 0), scale=0.5), dict(radius=0.8),
                       dict(coneAngle=45.0, coneSoftness=0.6)),
    "sphereFallback": ("Sphere", dict(translate=(0.6, 1.0, 0), rotate=(0, 90, 0)), dict(radius=0.2), dict()),
    "sphereFocus": ("Sphere", dict(translate=(0, 2, 0), rotate=(-70, 0, 0)), dict(radius=0.3),
                    dict(focus=6.0, focusTint=(0.1, 0.3, 0.6))),
    "rectFocus": ("Rect", dict(translate=(0.4, 2, 0), rotate=(-75, 20, 0)), dict(width=1.2, height=0.6), dict(focus=8.0)),
    "diskSoft": ("Disk", dict(translate=(0.4, 2, 0), rotate=(-85, -10, 0), scale=2.0), dict(radius=0.3),
                 dict(coneAngle=60.0, coneSoftness=1.0, focus=1.0)),
    # Cones that reach beyond all that a light emits dim from less on than that.
    "rectWideSoft": ("Rect", dict(translate=(0.4, 1.5, 0), rotate=(-75, 20, 0)), dict(width=1.2, height=0.6),
                     dict(coneAngle=181.0, coneSoftness=1.0)),
    "sphereWideSoft": ("Sphere", dict(translate=(0.3, 1.5, 0.2), rotate=(80, 15, 0)), dict(radius=0.2),
                       dict(coneAngle=400.0, coneSoftness=0.9)),
    "cylinderFocus": ("Cylinder", dict(translate=(0, 1.6, 0), rotate=(-70, 0, 20)), dict(radius=0.15, length=1.5),
                      dict(focus=3.0, coneAngle=100.0)),
    "distantFocus": ("Distant", dict(rotate=(-60, 30, 0)), dict(angle=40.0), dict(focus=30.0, focusTint=(0.5, 0, 0))),
    "sphereIes": ("Sphere", dict(translate=(0.2, 1.6, 0.1), rotate=(-80, 15, 30)), dict(radius=0.15), dict(_IES)),
    "rectIesScaled": ("Rect", dict(translate=(0.2, 1.6, 0.1), rotate=(-90, 0, 20)), dict(width=0.3, height=0.3),
                      dict(_IES, iesAngleScale=0.5, iesNormalize=True)),
    "sphereIesUp": ("Sphere", dict(translate=(0.2, 1.6, 0.1), rotate=(95, 0, 20)), dict(radius=0.15),
                    dict(_IES, iesAngleScale=-1.6)),
    "point": ("Sphere", dict(translate=(0.1, 2.0, 0.2), rotate=(-80, 10, 0)), dict(radius=0.5, treatAsPoint=True),
              dict(coneAngle=40.0, coneSoftness=0.5, focus=2.0)),
}


def _Plate(path, size=40.0):
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(size, size), color=(ALBEDO,) * 3)
    author.AddCamera(stage, eye=(0, 0.4, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    return stage


def _Points(steps=3):
    """[HEIGHT * steps][WIDTH * steps] points of the plate, row by row."""
    sub = (np.arange(steps) + 0.5) / steps
    x = ((np.arange(WIDTH)[:, None] + sub).ravel() / WIDTH - 0.5) * SIZE
    z = ((np.arange(HEIGHT)[:, None] + sub).ravel() / HEIGHT - 0.5) * SIZE * HEIGHT / WIDTH
    gz, gx = np.meshgrid(z, x, indexing="ij")
    return np.stack([gx, 0 * gx, gz], -1).reshape(-1, 3)


def _PictureOf(irradiance, steps=3):
    return irradiance.reshape(HEIGHT, steps, WIDTH, steps, 3).mean((1, 3)) * ALBEDO / np.pi


def _Blocks(picture):
    return picture.reshape(6, HEIGHT // 6, 8, WIDTH // 8, 3).mean((1, 3))


def _Render(stage, samples=512, **settings):
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, WIDTH, HEIGHT, samples=samples, **{"maxDepth": 0, **settings})


def _MatrixOf(stage, path):
    return np.array(UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0))


def _Expected(stage, kind, inputs, shaping):
    matrix = _MatrixOf(stage, "/World/Light")
    shaping = dict(shaping)
    if shaping.pop("iesFile", ""):
        mean = _MeanOfProfile() if shaping.get("iesNormalize") else 1.0
        shaping["profile"] = lambda polar, azimuth: _Profile(polar, azimuth) / mean
    if inputs.get("treatAsPoint"):
        d = matrix[3, :3] - _Points()
        distance = np.linalg.norm(d, axis=-1)
        factor = closedForm.ShapingFactor(-d / distance[:, None], matrix, shaping)
        return _PictureOf(np.pi * inputs["radius"] ** 2 * (d[:, 1] / distance**3)[:, None] * factor)
    if kind == "Distant":
        irradiance = closedForm.IrradianceOfShapedCone(_UP, matrix, np.radians(inputs["angle"] / 2), shaping)
        return 50000.0 * np.broadcast_to(irradiance * ALBEDO / np.pi, (HEIGHT, WIDTH, 3))
    if kind == "Sphere":
        patches = closedForm.PatchesOfSphere(matrix, inputs["radius"], 24)
    elif kind == "Cylinder":
        patches = closedForm.PatchesOfCylinder(matrix, inputs["radius"], inputs["length"], 24)
    else:
        patches = closedForm.PatchesOfFlat(matrix, *inputs.values(), steps=24)
    return _PictureOf(closedForm.IrradianceOfShaped(_Points(), _UP, patches, matrix, shaping))


@pytest.mark.parametrize("name", sorted(SHAPED))
def test_shaped_light_on_plate(name, tmp_path):
    """Irradiance under each kind of shaping: the mean within 0.4 %, blocks within 1.5 % of the brightest."""
    kind, placement, inputs, shaping = SHAPED[name]
    (tmp_path / "lamp.ies").write_text(_IesText())
    stage = _Plate(f"{tmp_path}/a.usda")
    author.ShapeLight(author.AddLight(stage, "/World/Light", kind, placement, **inputs), **shaping)
    picture = _Render(stage, samples=1024)
    assert picture.warnings == []
    expected = _Expected(stage, kind, inputs, shaping)
    assert picture.rgb.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=4e-3)
    np.testing.assert_allclose(_Blocks(picture.rgb), _Blocks(expected), atol=0.015 * expected.max())


@pytest.mark.parametrize("image", [False, True], ids=["plain", "image"])
def test_rects_far_away_are_points(image, tmp_path):
    """Seen from aside, up to where float's rounding of their corners is far larger than what they subtend."""
    inputs = dict(width=1.0, height=1.0, normalize=True)
    if image:
        imageFile.WriteExr(tmp_path / "white.exr", {name: np.ones((4, 4)) for name in "RGB"})
        inputs["textureFile"] = "./white.exr"
    for exponent in range(2, 8):
        distance = 10.0 ** exponent
        stage = _Plate(f"{tmp_path}/{exponent}.usda", size=10.0)
        author.AddLight(stage, "/World/Light", "Rect", dict(translate=(0.48 * distance, 0.6 * distance, 0.64 * distance), rotate=(-90, 0, 0)),
                        intensity=distance * distance, **inputs)
        picture = _Render(stage, samples=16, lightsVisible=False)
        expected = 0.6 * 0.6 * ALBEDO / np.pi
        assert picture.rgb.mean((0, 1)) == pytest.approx(np.full(3, expected), rel=3e-3), f"{distance:g}"
        assert picture.rgb.max() < 1.2 * expected, f"{distance:g}"


@pytest.mark.parametrize("radius, distance", [(1e-3, 10.0), (1e-6, 1.0), (1e-6, 10.0), (1e-4, 1e4), (1e-4, 1e6)])
def test_wires_far_away_are_lines(radius, distance, tmp_path):
    """A cylinder about the x axis, of whose radius the rounding of its distance leaves little or nothing."""
    length = 100.0 * radius
    stage = _Plate(f"{tmp_path}/a.usda")
    for side, size in (("horizontal", 4.0), ("vertical", 3.0)):  # what is seen is small beside the distance
        stage.GetPrimAtPath("/World/Camera").GetAttribute(f"{side}Aperture").Set(size * min(0.002 * distance, 1.0))
    author.AddLight(stage, "/World/Light", "Cylinder", dict(translate=(0.48 * distance, 0.6 * distance, 0.64 * distance)), radius=radius,
                    length=length, intensity=distance * distance / (2 * radius * length))
    picture = _Render(stage, samples=64, lightsVisible=False)
    expected = 0.6 * np.sqrt(1 - 0.48 ** 2) * ALBEDO / np.pi
    assert picture.rgb.mean((0, 1)) == pytest.approx(np.full(3, expected), rel=2e-3)


def test_shaped_light_seen(tmp_path):
    """A disk seen off its axis: its radiance times the factor of that angle, and nothing, alpha included, outside its cone."""
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddCamera(stage, eye=(0, 0, 8), width=SIZE * 10, orthographic=True)
    for x, tilt in ((-1, 20), (0, 40), (1, 70)):
        light = author.AddLight(stage, f"/World/L{tilt}", "Disk", dict(translate=(x, 0, 0), rotate=(0, 180 + tilt, 0)),
                                radius=0.4, intensity=2.0)
        author.ShapeLight(light, coneAngle=60.0, focus=3.0, focusTint=(0.5, 0.0, 0.0))
    picture = _Render(stage, samples=4, aovs=("color", "alpha"))
    color, alpha = picture.rgb, picture.layers["alpha"].reshape(HEIGHT, WIDTH)
    for column, tilt in ((6, 20), (12, 40)):
        focus = np.cos(np.radians(tilt)) ** 3
        np.testing.assert_allclose(color[9, column], 2 * (focus + (1 - focus) * np.array([0.5, 0, 0])), rtol=1e-5)
        assert alpha[9, column] == 1
    assert not color[9, 18].any() and alpha[9, 18] == 0


def test_lights_that_the_camera_does_not_see(tmp_path):
    """A ball of light over a plate, from above: with `lightsVisible` off it lights as before, and the camera sees through it."""
    radius, height = 0.3, 1.0
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(ALBEDO,) * 3)
    author.AddCamera(stage, eye=(0, 3, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    author.AddLight(stage, "/World/Light", "Sphere", dict(translate=(0, height, 0)), radius=radius, intensity=2.0)
    seen, unseen = (_Render(stage, samples=64, lightsVisible=isSeen).layers["color"] for isSeen in (True, False))
    middle = (slice(HEIGHT // 2 - 1, HEIGHT // 2 + 1), slice(WIDTH // 2 - 1, WIDTH // 2 + 1))
    assert (seen[middle][..., :3] >= 2.0).all()
    np.testing.assert_allclose(unseen[middle][..., :3].mean(), ALBEDO * 2.0 * (radius / height) ** 2, rtol=0.03)
    assert seen[:, :6].tobytes() == unseen[:, :6].tobytes()


@pytest.mark.parametrize("content, reason", [
    (None, "the file does not exist"), ("", "it has no line TILT="), ("TILT=NONE\n1 2", "its header is incomplete")])
def test_bad_profiles_are_named(content, reason, tmp_path):
    """One warning that names the file; the light shines without it."""
    if content is not None:
        (tmp_path / "lamp.ies").write_text(content)
    stage = _Plate(f"{tmp_path}/a.usda")
    author.ShapeLight(author.AddLight(stage, "/World/Light", "Sphere", dict(translate=(0, 2, 0))), iesFile="./lamp.ies",
                      coneAngle=180.0)
    picture = _Render(stage, samples=16)
    assert [line for line in picture.warnings if "lamp.ies" in line] == [
        f"./lamp.ies: not used as an IES profile: {reason}"]
    assert picture.rgb.min() > 0


def test_a_profile_may_be_a_link(tmp_path):
    """As studios have them: the present version of a file is a link."""
    (tmp_path / "v2.ies").write_text(_IesText())
    (tmp_path / "lamp.ies").symlink_to("v2.ies")
    pictures = []
    for name, file in (("a", "./v2.ies"), ("b", "./lamp.ies")):
        stage = _Plate(f"{tmp_path}/{name}.usda")
        author.ShapeLight(author.AddLight(stage, "/World/Light", "Sphere", dict(translate=(0, 2, 0))), iesFile=file, coneAngle=180.0)
        pictures.append(_Render(stage, samples=4))
    assert [picture.warnings for picture in pictures] == [[], []]
    assert pictures[0].rgb.tobytes() == pictures[1].rgb.tobytes()


# --- Links -----------------------------------------------------------------------------------------


_LAMP = dict(radius=0.3, intensity=20.0)
_PLACE = (0.8, 2.0, 0.3)


def _LampOnPlate():
    points = _Points()
    irradiance = 20.0 * closedForm.IrradianceOfSphere(points, _UP, np.array(_PLACE), 0.3)
    return _PictureOf(np.repeat(irradiance[:, None], 3, 1))


def _Tiles(path, instanced=False):
    """Two halves of a plate, at x below and above 0: /World/A and /World/B."""
    stage = author.NewStage(path)
    author.AddCamera(stage, eye=(0, 0.4, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    if instanced:
        author.AddMesh(stage, "/World/Prototype/Tile", shapes.Plane(20, 40), color=(ALBEDO,) * 3)
        stage.GetPrimAtPath("/World/Prototype").SetSpecifier(Sdf.SpecifierOver)
    for name, x in (("A", -10.0), ("B", 10.0)):
        if instanced:
            tile = UsdGeom.Xform.Define(stage, f"/World/{name}")
            author.Place(tile, translate=(x, 0, 0))
            tile.GetPrim().GetReferences().AddInternalReference("/World/Prototype")
            tile.GetPrim().SetInstanceable(True)
        else:
            author.AddMesh(stage, f"/World/{name}", shapes.Plane(20, 40), color=(ALBEDO,) * 3, translate=(x, 0, 0))
    return stage


@pytest.mark.parametrize("instanced", [False, True])
def test_light_links(instanced, tmp_path):
    """What a light is not linked to it does not light at all; the rest is as without links. With a dome, so that lights
    are chosen among."""
    stage = _Tiles(f"{tmp_path}/a.usda", instanced)
    lamp = author.AddLight(stage, "/World/Light", "Sphere", dict(translate=_PLACE), **_LAMP)
    author.LinkLight(lamp, "lightLink", excludes=["/World/A"])
    dome = author.AddLight(stage, "/World/Dome", "Dome", intensity=0.25)
    author.LinkLight(dome, "lightLink", includes=["/World/A"])
    picture = _Render(stage).rgb
    np.testing.assert_allclose(_Blocks(picture)[:, :4], 0.25 * ALBEDO, rtol=0.005)
    np.testing.assert_allclose(_Blocks(picture)[:, 4:], _Blocks(_LampOnPlate())[:, 4:], rtol=0.01)


def test_many_linked_lights(tmp_path):
    """More than are weighed one by one: each tile is lit by those linked to it alone."""
    stage = _Tiles(f"{tmp_path}/a.usda")
    expected = {}
    for tile in "AB":
        expected[tile] = 0.0
        for i in range(20):
            place = np.array([-1.8 + 0.18 * i, 1.5, 0.3 if tile == "A" else -0.3])
            intensity = 1.0 + i if tile == "A" else 21.0 - i
            light = author.AddLight(stage, f"/World/{tile}{i}", "Sphere", dict(translate=place), radius=0.1, intensity=intensity)
            author.LinkLight(light, "lightLink", includes=[f"/World/{tile}"])
            expected[tile] = expected[tile] + intensity * closedForm.IrradianceOfSphere(_Points(), _UP, place, 0.1)
    picture = _Blocks(_Render(stage, samples=1024).rgb)
    for tile, columns in (("A", slice(0, 4)), ("B", slice(4, 8))):
        blocks = _Blocks(_PictureOf(np.repeat(expected[tile][:, None], 3, 1)))
        np.testing.assert_allclose(picture[:, columns], blocks[:, columns], rtol=0.025)


def _WithBlocker(path):
    """The plate under the lamp, with a square between them, above the camera."""
    stage = _Plate(path)
    author.AddMesh(stage, "/World/Blocker", shapes.Plane(30.0, 30.0), doubleSided=True, translate=(0, 1.0, 0), color=(0, 0, 0))
    return stage, author.AddLight(stage, "/World/Light", "Sphere", dict(translate=_PLACE), **_LAMP)


@pytest.mark.parametrize("kind, factor", [("none", 0.0), ("shadowLink", 1.0), ("enable", 1.0), ("near", 1.0), ("far", 0.0),
                                          ("color", (0.5, 0.25, 0.0))])
def test_shadow_controls(kind, factor, tmp_path):
    """A square hides the whole lamp from the plate: of the irradiance without it a factor is left."""
    stage, lamp = _WithBlocker(f"{tmp_path}/a.usda")
    if kind == "shadowLink":
        author.LinkLight(lamp, "shadowLink", excludes=["/World/Blocker"])
    elif kind in ("near", "far"):
        author.ShadowLight(lamp, distance=0.9 if kind == "near" else 30.0)
    elif kind == "color":
        author.ShadowLight(lamp, color=factor)
    elif kind == "enable":
        author.ShadowLight(lamp, enable=False)
    picture = _Render(stage).rgb
    np.testing.assert_allclose(_Blocks(picture), _Blocks(_LampOnPlate() * np.array(factor)), rtol=0.01, atol=1e-6)


@pytest.mark.parametrize("falloff, gamma, color", [(1.5, 1.0, (0.0, 0.0, 0.0)), (9.0, 2.5, (0.2, 0.5, 0.0))])
def test_shadow_falloff(falloff, gamma, color, tmp_path):
    """A parallel light from above through a slanted square, each point's occluder of which is as far as the square is high:
    what is left of the shadow is linear between the distance less the falloff and the distance, by the power of gamma."""
    distance, slope, height = 2.0, 0.5, 1.5
    stage = _Plate(f"{tmp_path}/a.usda")
    sun = author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), angle=0.0, intensity=3.0)
    author.ShadowLight(sun, distance=distance, falloff=falloff, falloffGamma=gamma, color=color)
    square = shapes.Plane(30.0, 30.0)
    square.points[:, 1] += height + slope * square.points[:, 0]
    author.AddMesh(stage, "/World/Blocker", square, doubleSided=True, color=(0, 0, 0))
    left = np.clip((distance - (height + slope * _Points()[:, 0])) / min(falloff, distance), 0.0, 1.0) ** gamma
    irradiance = 3.0 * (1.0 - left[:, None] * (1.0 - np.array(color)))
    picture = _Render(stage, samples=64).rgb
    np.testing.assert_allclose(picture, _PictureOf(irradiance), atol=4e-3 * ALBEDO)


def test_shadow_links_of_one_light_leave_the_others_alone(tmp_path):
    """Two lamps in one place, one without shadows of the square: half of the irradiance."""
    stage, lamp = _WithBlocker(f"{tmp_path}/a.usda")
    author.LinkLight(lamp, "shadowLink", excludes=["/World/Blocker"])
    author.AddLight(stage, "/World/Other", "Sphere", dict(translate=_PLACE), **_LAMP)
    picture = _Render(stage).rgb
    np.testing.assert_allclose(_Blocks(picture), _Blocks(_LampOnPlate()), rtol=0.02)


def test_shadow_controls_leave_a_lights_image_alone(tmp_path):
    """Nothing casts shadows: however short shadow rays are, the image lights the plate as it does with none of it cut."""
    image = np.zeros((8, 8, 3), np.float32)
    image[:, 4:] = (1.0, 0.6, 0.2)
    imageFile.WriteExr(tmp_path / "half.exr", {c: image[..., i] for i, c in enumerate("RGB")}, half=False)
    pictures = {}
    for name, shadow in (("far", dict(distance=30.0)), ("near", dict(distance=0.5)), ("off", dict(enable=False))):
        stage = _Plate(f"{tmp_path}/{name}.usda")
        panel = author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0, 1.5, 0), rotate=(-90, 0, 0)), width=2.0, height=2.0,
                                textureFile="./half.exr")
        author.ShadowLight(panel, **shadow)
        pictures[name] = _Render(stage, samples=16).layers["color"]
    left, right = (pictures["far"][:, columns, :3].mean() for columns in (slice(0, 6), slice(-6, None)))
    assert left > 2 * right > 0, "the image tells the sides apart"
    assert pictures["near"].tobytes() == pictures["far"].tobytes() and pictures["off"].tobytes() == pictures["far"].tobytes()


def test_streamed_geometry_gives_the_same_bits(tmp_path):
    """Links, shadow colours and multipliers while shadow rays wait for chunks, among lights and behind cut-outs."""
    stage, lamp = _WithBlocker(f"{tmp_path}/a.usda")
    author.LinkLight(lamp, "shadowLink", excludes=["/World/Blocker"])
    veil = author.AddMaterial(stage, "/World/Veil", opacity=0.5)
    author.AddMesh(stage, "/World/Curtain", shapes.Plane(3, 3), material=veil, translate=(0, 0.7, 0))
    for i in range(3):
        ball = author.AddMesh(stage, f"/World/Ball{i}", shapes.Sphere(0.2, 24, 48), translate=(i - 1, 0.15, 0.3))
    author.LinkLight(lamp, "lightLink", excludes=[str(ball.GetPath())])
    tinted = author.AddLight(stage, "/World/Tinted", "Rect", dict(translate=(0, 3, 0), rotate=(-90, 0, 0)), specular=0.0, intensity=5.0)
    author.ShadowLight(author.ShapeLight(tinted, focus=2.0), color=(0.5, 0.2, 0.1))
    resident = _Render(stage, samples=16, maxDepth=2, residency="resident", waveSize=4096, chunkBytes=8192).layers["color"]
    streamed = _Render(stage, samples=16, maxDepth=2, residency="stream", geometryMemory="30%", waveSize=4096,
                       chunkBytes=8192).layers["color"]
    assert resident.max() > 0 and resident.tobytes() == streamed.tobytes()


# --- Multipliers of lobes --------------------------------------------------------------------------


def _Glossy(path, diffuse, specular, kind="Distant", **inputs):
    stage = author.NewStage(path)
    material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.6, 0.4, 0.2), roughness=0.4, clearcoat=0.3,
                                  clearcoatRoughness=0.3)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), material=material)
    author.AddCamera(stage, eye=(0, 0.4, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    author.AddLight(stage, "/World/Light", kind, dict(translate=(0, 2, 0), rotate=(-65, 0, 0)), diffuse=diffuse,
                    specular=specular, **inputs)
    return stage


def test_lobe_multipliers_of_a_parallel_light(tmp_path):
    """UsdPreviewSurface's formula, its lobes weighed apart."""
    up, toLight = np.array([0.0, 1.0, 0.0]), np.array([0, np.sin(np.radians(65)), np.cos(np.radians(65))])
    inputs = dict(roughness=0.4, clearcoat=0.3, clearcoatRoughness=0.3)
    whole = closedForm.PreviewReflected(up, up, toLight, diffuseColor=(0.6, 0.4, 0.2), **inputs)
    coat = closedForm.PreviewReflected(up, up, toLight, diffuseColor=(0, 0, 0), **inputs)
    for diffuse, specular in ((0.5, 2.0), (0.0, 1.0), (1.0, 0.0)):
        stage = _Glossy(f"{tmp_path}/{diffuse}.usda", diffuse, specular, angle=0.0, intensity=1.0)
        picture = _Render(stage, samples=4).rgb
        np.testing.assert_allclose(picture, np.broadcast_to(diffuse * (whole - coat) + specular * coat, picture.shape), rtol=1e-3)


def test_lobe_multipliers_add_up(tmp_path):
    """Under a wide light, which both techniques find: twice the one lobe and half of the other is their sum."""
    render = lambda diffuse, specular: _Render(
        _Glossy(f"{tmp_path}/{diffuse}-{specular}.usda", diffuse, specular, "Rect", width=2.0, height=2.0, intensity=3.0),
        samples=256).rgb
    both, plain = render(2.0, 0.5), render(1.0, 1.0)
    diffuse, specular = render(1.0, 0.0), render(0.0, 1.0)
    assert (diffuse + specular).mean() == pytest.approx(plain.mean(), rel=3e-3)
    np.testing.assert_allclose(_Blocks(both), _Blocks(2 * diffuse + 0.5 * specular), rtol=0.02)
