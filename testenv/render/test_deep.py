# SPDX-License-Identifier: Apache-2.0
"""Deep pictures: a sample a surface, read back by a decoder of our own and by OpenImageIO's tool.

Oracles: the flat picture of the same render; rays against triangles by brute force; opacities as authored.
"""

import shutil
import subprocess

import deepFile
import exrFile
import numpy as np
import pytest
import volumeCase
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

import hdstream
from matteCase import RenderMattes, WriteMatteStage
from stages import author, shapes
from test_meshMedia import AddVolume

_SIZE = 24
_COLORS = ("R", "G", "B", "A")


@pytest.fixture(scope="module", name="stage")
def MakeStage(tmp_path_factory):
    """A cut-out out of focus before what moves, instances, a wall; the dome is seen."""
    return WriteMatteStage(tmp_path_factory.mktemp("deep") / "all.usda")


@pytest.fixture(scope="module", name="image")
def MakeImage(stage):
    return RenderMattes(stage, ("color", "alpha"), deep=True, domeVisible=True)


@pytest.fixture(scope="module", name="file")
def MakeFile(image, tmp_path_factory):
    file = tmp_path_factory.mktemp("file") / "deep.exr"
    image.WriteDeep(file, {"shot": "seq10"})
    return file


def _Colors(deep):
    return np.stack([deep.channels[name] for name in _COLORS], -1).astype(np.float64)


def _AssertTidy(counts, z, zBack):
    """No sample of a pixel begins before the one before it ends, and none where that begins."""
    assert (zBack >= z).all() and np.isfinite(zBack).all()
    starts = deepFile.Starts(counts)
    isFirst = np.zeros(z.size, bool)
    isFirst[starts[:-1][counts.ravel() > 0]] = True
    follows = ~isFirst[1:]
    assert follows.any() and (z[1:] > z[:-1])[follows].all() and (z[1:] >= zBack[:-1])[follows].all()


def _AssertFlat(image):
    """Alpha to the last digits of a float, colour to 1e-6 of it."""
    _AssertFlattens(image.deep, image.aovs["color"])


def _AssertFlattens(deep, pixels):
    flat = deepFile.Flatten(deep.counts, deep.samples[:, 2:].astype(np.float64))
    color = pixels.astype(np.float64)
    assert np.abs(flat[..., 3] - color[..., 3]).max() < 2e-7
    assert (np.abs(flat - color) <= 1e-6 * (np.abs(color) + 0.01)).all()


def test_the_file_holds_the_picture(file, image):
    deep = deepFile.Read(file)
    assert deep.texts["shot"] == "seq10"
    assert np.array_equal(deep.counts, image.deep.counts)
    for index, name in enumerate(("Z", "ZBack", *_COLORS)):
        assert deep.channels[name].tobytes() == np.ascontiguousarray(image.deep.samples[:, index]).tobytes(), name
    assert image.deep.counts.max() > 3
    _AssertTidy(deep.counts, deep.channels["Z"], deep.channels["ZBack"])
    assert (deep.channels["A"] >= 0).all() and (deep.channels["A"] <= 1).all()
    _AssertFlat(image)


@pytest.mark.skipif(not shutil.which("oiiotool"), reason="openimageio-tools is not installed")
def test_a_foreign_reader_flattens_it_to_the_flat_picture(file, image, tmp_path):
    information = subprocess.run(["oiiotool", "--info", "-v", str(file)], capture_output=True, text=True, check=True).stdout
    assert "deep float openexr" in information and "channel list: R, G, B, A, Z, ZBack" in information
    flat = tmp_path / "flat.exr"
    subprocess.run(["oiiotool", str(file), "--flatten", "--compression", "zip", "-o", str(flat)], check=True)
    _, channels = exrFile.Read(flat)
    color = image.aovs["color"]
    assert np.abs(channels["A"] - color[..., 3]).max() < 4e-7
    for index, name in enumerate(_COLORS):
        assert np.allclose(channels[name], color[..., index], rtol=2e-6, atol=2e-8), name


def test_halves(image, tmp_path):
    image.WriteDeep(tmp_path / "half.exr", isHalf=True)
    deep = deepFile.Read(tmp_path / "half.exr")
    assert deep.channels["R"].dtype == np.float16 and deep.channels["Z"].dtype == np.float32
    assert np.array_equal(_Colors(deep), image.deep.samples[:, 2:].astype(np.float16).astype(np.float64))


@pytest.mark.parametrize("settings", [{"residency": "stream", "geometryMemory": "30%", "chunkBytes": 16384}, {"waveSize": 4096},
                                      {"residency": "stream", "geometryMemory": "30%", "chunkBytes": 16384, "waveSize": 1024},
                                      {"traversal": "scalar"}], ids=["pool", "waves", "slotsUsedAgain", "scalar"])
def test_bits_depend_on_nothing_else(stage, image, settings):
    other = RenderMattes(stage, ("color", "alpha"), deep=True, domeVisible=True, **settings)
    assert other.deep.counts.tobytes() == image.deep.counts.tobytes()
    assert other.deep.samples.tobytes() == image.deep.samples.tobytes()


def test_the_flat_picture_has_the_bits_of_a_render_without(tmp_path):
    """Where each camera ray meets one surface: of what it passes a deep sample has no light."""
    stage = WriteMatteStage(tmp_path / "opaque.usda", ("Mover", "Many", "Wall"))
    image = RenderMattes(stage, ("color", "alpha"), deep=True, domeVisible=True)
    without = RenderMattes(stage, ("color", "alpha"), domeVisible=True)
    assert without.aovs["color"].tobytes() == image.aovs["color"].tobytes()
    assert without.deep is None and without.statistics["memory"]["deep"] == 0 < image.statistics["memory"]["deep"]
    # Of a path that keeps nothing of its first hit: 16 bytes less.
    assert without.statistics["memory"]["pathState"] < image.statistics["memory"]["pathState"]
    with pytest.raises(hdstream.Error, match="no deep picture"):
        without.WriteDeep("never.exr")


def test_what_rays_pass_changes_the_noise_of_the_flat_picture_only(stage, image):
    without = RenderMattes(stage, ("color", "alpha"), domeVisible=True)
    flat, other = image.aovs["color"].astype(np.float64), without.aovs["color"].astype(np.float64)
    assert without.aovs["alpha"].tobytes() == image.aovs["alpha"].tobytes() and (flat[..., 3] == other[..., 3]).all()
    isVeiled = (flat != other).any(-1)  # the card covers a part of the picture
    assert 100 < isVeiled.sum() < isVeiled.size // 2
    difference = (flat - other)[isVeiled][:, :3]
    assert np.abs(difference.mean(0)).max() < 4 * (difference.std(0) / len(difference) ** 0.5).max()


def test_with_a_cryptomatte_both_are_as_alone(stage, image):
    both = RenderMattes(stage, ("color", "alpha", "crypto_object"), deep=True, domeVisible=True)
    assert both.deep.samples.tobytes() == image.deep.samples.tobytes()
    alone = RenderMattes(stage, ("crypto_object",), domeVisible=True)
    assert all(both.aovs[name].tobytes() == pixels.tobytes() for name, pixels in alone.aovs.items())


def test_adaptive_pixels_are_divided_by_their_own_samples(stage):
    image = RenderMattes(stage, ("color", "sampleCount"), samples=96, noise=0.02, deep=True)
    assert len(np.unique(image.aovs["sampleCount"])) > 1
    _AssertFlat(image)


def test_what_has_no_room_joins_the_nearest(stage, image):
    few = RenderMattes(stage, ("color", "alpha"), deep=True, domeVisible=True, deepSamples=2)
    assert few.deep.counts.max() == 2 and few.statistics["accuracy"]["deepCrowded"] > 0
    assert image.statistics["accuracy"]["deepCrowded"] == 0
    _AssertFlat(few)


def test_tolerance_joins_what_lies_close(stage, image):
    fine = RenderMattes(stage, ("color", "alpha"), deep=True, domeVisible=True, deepTolerance=0.0)
    assert fine.deep.samples.shape[0] > 1.5 * image.deep.samples.shape[0]
    _AssertFlat(fine)
    # Of a surface never more than the tolerance on either side of its first sample.
    z, zBack = image.deep.samples[:, 0], image.deep.samples[:, 1]
    assert (zBack <= 1.01 / 0.99 * z * (1 + 1e-6)).all() and (zBack > z).any()


# --- Against rays and triangles by brute force --------------------------------------------------------------------------------

_EYE, _FOCAL, _APERTURE = np.array([0.0, 0.0, 8.0]), 40.0, 36.0


def _Hits(triangles, offset=(0.0, 0.0)):
    """Depths along -Z of all triangles, by pixel: [triangles][size][size], infinite where missed. Rays through the centres of
    pixels, so many pixels beside."""
    x, y = (((np.arange(_SIZE) + 0.5 + along) / _SIZE - 0.5) * _APERTURE / _FOCAL for along in offset)
    x, y = np.meshgrid(x, -y)
    way = np.stack([x, y, -np.ones_like(x)], -1)  # t is the depth
    depths = np.full((len(triangles), _SIZE, _SIZE), np.inf)
    for number, (a, b, c) in enumerate(triangles):
        matrix = np.stack([np.broadcast_to(b - a, way.shape), np.broadcast_to(c - a, way.shape), -way], -1)
        determinant = np.linalg.det(matrix)
        safe = np.where(np.abs(determinant)[..., None, None] > 1e-12, matrix, np.eye(3))
        u, v, t = np.moveaxis(np.linalg.solve(safe, np.broadcast_to((_EYE - a)[:, None], (*way.shape, 1)))[..., 0], -1, 0)
        isHit = (np.abs(determinant) > 1e-12) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        depths[number][isHit] = t[isHit]
    return depths


def _Triangles(shape, translate):
    points = np.asarray(shape.points, np.float64) + translate
    indices = np.asarray(shape.indices).reshape(-1, 4)  # boxes and planes: quads
    return [points[list(corners)] for quad in indices for corners in (quad[[0, 1, 2]], quad[[0, 2, 3]])]


def test_depths_are_those_of_all_surfaces_that_rays_cross(tmp_path):
    """Half transparent boxes before a wall; a pixel is as good as a point."""
    stage = author.NewStage(str(tmp_path / "boxes.usda"))
    veil = author.AddMaterial(stage, "/Looks/Veil", opacity=0.4, ior=1.0)  # nothing is reflected
    wall = shapes.Box(6.0, 6.0, 0.5)
    author.AddMesh(stage, "/World/Wall", wall, translate=(0.7, 0.3, -3.0))
    triangles = [(corners, 1.0) for corners in _Triangles(wall, (0.7, 0.3, -3.0))]
    for number, (size, place) in enumerate((((1.2, 2.0, 0.7), (-0.9, 0.2, 1.0)), ((2.2, 1.1, 1.3), (0.5, -0.4, 0.1)))):
        box = shapes.Box(*size)
        author.AddMesh(stage, f"/World/Box{number}", box, material=veil, translate=place)
        triangles += [(corners, 0.4) for corners in _Triangles(box, place)]
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=tuple(_EYE), target=(0, 0, 0), focalLength=_FOCAL, width=_APERTURE, aspect=1.0)
    stage.GetRootLayer().Save()
    image = hdstream.Renderer(stage.GetRootLayer().realPath).Render(
        imageWidth=_SIZE, imageHeight=_SIZE, samples=512, maxDepth=1, pixelFilter="box", pixelFilterWidth=0.02, noCache=True,
        camera="/World/Camera", domeVisible=False, deep=True, aovs=["color"])
    corners = [corners for corners, _ in triangles]
    depths = _Hits(corners)
    around = np.stack([_Hits(corners, (x, y)) for x in (-0.01, 0.01) for y in (-0.01, 0.01)])  # corners of the filter
    isWhole = (np.isfinite(around) == np.isfinite(depths)).all((0, 1))  # no edge in the pixel
    least, most = around.min(0), around.max(0)
    opacities = np.array([opacity for _, opacity in triangles])
    starts, errors, numChecked = deepFile.Starts(image.deep.counts), [], 0
    for pixel, (y, x) in enumerate(np.ndindex(_SIZE, _SIZE)):
        order = np.argsort(depths[:, y, x])
        found = depths[order, y, x]
        expected = [(least[i, y, x], most[i, y, x], opacities[i]) for i in order if np.isfinite(depths[i, y, x])]
        gaps = np.diff(found[np.isfinite(found)])
        samples = image.deep.samples[starts[pixel]:starts[pixel + 1]]
        if not expected:
            assert len(samples) == 0
            continue
        opaque = next((i for i, (_, _, opacity) in enumerate(expected) if opacity == 1.0), len(expected) - 1)
        isSteep = any(end > 1.009 * begin for begin, end, _ in expected)  # so that a surface is several samples
        if not isWhole[y, x] or isSteep or (gaps < 0.12).any():  # triangles share an edge, or surfaces are one sample
            continue
        expected = expected[:opaque + 1]
        assert len(samples) == len(expected), (x, y)
        for sample, (begin, end, opacity) in zip(samples, expected):
            assert begin * (1 - 1e-6) <= sample[0] <= sample[1] <= end * (1 + 1e-6), (x, y)
            if end - begin < 1e-6:  # seen straight on; beside that surfaces reflect by Fresnel's law, and cover more
                errors.append(sample[5] - opacity)
            if opacity == 1.0:
                assert sample[5] == 1.0
        numChecked += 1
    assert numChecked > 150
    assert abs(np.mean(errors)) < 0.01 and np.abs(errors).max() < 0.35  # the deepest of four has 66 samples
    _AssertFlat(image)


def _Moving(tmp_path):
    """A camera that comes nearer to a wall by a fourth of its distance while the shutter is open."""
    stage = author.NewStage(str(tmp_path / "moves.usda"))
    author.AddMesh(stage, "/World/Wall", shapes.Box(20.0, 20.0, 1.0), translate=(0.0, 0.0, -0.5))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    camera = author.AddCamera(stage, eye=(0, 0, 0), target=(0, 0, -1), aspect=1.0)
    way = camera.AddTranslateOp(opSuffix="way")
    way.Set((0.0, 0.0, 8.0), 0)
    way.Set((0.0, 0.0, 6.0), 1)
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def test_depths_of_a_moving_camera_are_those_of_its_samples(tmp_path):
    image = hdstream.Renderer(_Moving(tmp_path)).Render(0, imageWidth=8, imageHeight=8, samples=64, maxDepth=1, noCache=True,
                                                        camera="/World/Camera", deep=True, deepTolerance=0.5)
    samples = image.deep.samples
    assert (image.deep.counts == 1).all() and (samples[:, 5] == 1.0).all()
    assert (samples[:, 0] >= 6.0 - 1e-4).all() and (samples[:, 1] <= 8.0 + 1e-4).all()
    assert samples[:, 0].mean() < 6.1 and samples[:, 1].mean() > 7.9


def test_depths_are_along_the_axis_that_a_turning_camera_has(tmp_path):
    """In the centre of a sphere each pixel has one depth, wherever the camera looks: of a pose of another time it had many."""
    stage = author.NewStage(str(tmp_path / "turns.usda"))
    author.AddMesh(stage, "/World/Sky", shapes.Sphere(5.0, 180, 360), doubleSided=True)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    camera = author.AddCamera(stage, eye=(0, 0, 0), target=(0, 0, -1), width=36.0, aspect=1.0, focalLength=18.0)
    turn = camera.AddRotateYOp(opSuffix="way")
    turn.Set(0.0, 0)
    turn.Set(40.0, 1)
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    stage.GetRootLayer().Save()
    image = hdstream.Renderer(stage.GetRootLayer().realPath).Render(
        0, imageWidth=8, imageHeight=8, samples=64, maxDepth=0, noCache=True, camera="/World/Camera", deep=True, deepTolerance=0.5,
        pixelFilter="box", pixelFilterWidth=0.05)
    x, y = np.meshgrid((np.arange(8) + 0.5) / 4 - 1, (np.arange(8) + 0.5) / 4 - 1)
    expected = 5.0 / np.sqrt(1 + x * x + y * y)
    assert (image.deep.counts == 1).all()
    assert np.allclose(image.deep.samples[:, 0].reshape(8, 8), expected, rtol=0.01)
    assert np.allclose(image.deep.samples[:, 1].reshape(8, 8), expected, rtol=0.01)


def test_lights_volumes_and_what_is_held_out(tmp_path):
    """A light that is seen is there at its depth, a volume from its first to its last event; what is held out is not there."""
    stage = author.NewStage(str(tmp_path / "more.usda"))
    medium = AddVolume(stage, "/Looks/Fog", scattering=0.4)
    author.AddMesh(stage, "/World/Fog", shapes.Box(2.0, 2.0, 2.0), material=medium, translate=(-2.0, 0.0, 0.0))
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(2.0, 0.0, 1.0), rotate=(0, 180, 0)), intensity=3.0, width=1.5, height=1.5)
    held = author.AddMesh(stage, "/World/Held", shapes.Box(2.5, 2.5, 0.5), translate=(2.0, 3.0, 0.0))
    author.AddPrimvar(held.GetPrim(), "hdstream:holdout", _Bool(), "constant", True)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    author.AddCamera(stage, eye=(0, 0, 12), target=(0, 0, 0), width=36.0, aspect=1.0, focalLength=36.0)
    stage.GetRootLayer().Save()
    image = hdstream.Renderer(stage.GetRootLayer().realPath).Render(
        imageWidth=_SIZE, imageHeight=_SIZE, samples=64, maxDepth=4, noCache=True, camera="/World/Camera", deep=True)
    _AssertFlat(image)
    starts = deepFile.Starts(image.deep.counts).reshape(-1)

    def At(x, y):
        """Samples of the pixel that shows (x, y, z = 0)."""
        column, row = int((x / 12 + 0.5) * _SIZE), int((0.5 - y / 12) * _SIZE)
        pixel = row * _SIZE + column
        return image.deep.samples[starts[pixel]:starts[pixel + 1]]

    lamp = At(2.0 * 12 / 11, 0.0)
    assert np.allclose(lamp[0, :2], 11.0, rtol=1e-4) and lamp[0, 5] == 1.0
    fog = At(-2.2, 0.0)
    seen = fog[:-1]
    assert len(seen) > 3 and seen[0, 0] > 11.0 - 0.01 and seen[-1, 1] < 13.0 + 0.01 and seen[:, 5].max() < 0.5
    assert (fog[-1, :2] == 1000.0).all() and fog[-1, 5] == 1.0  # the dome behind it, at the far clipping plane
    assert len(At(2.0, 3.0)) == 0 < len(At(2.0, 5.0))


def _Bool():
    from pxr import Sdf
    return Sdf.ValueTypeNames.Bool


def test_a_cloud_between_cards_is_where_it_scatters(tmp_path):
    """A grid between a half transparent card before it and an opaque one behind it, which let nothing of the dome be seen."""
    def AddCards(stage):
        veil = author.AddMaterial(stage, "/Looks/Veil", opacity=0.5, ior=1.0)
        author.AddMesh(stage, "/World/Front", shapes.Box(4.0, 4.0, 0.01), material=veil, translate=(0, 0, 3))
        author.AddMesh(stage, "/World/Back", shapes.Box(4.0, 4.0, 0.01), translate=(0, 0, -3))

    volume = volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud()), scattering=4.0)
    stage = volumeCase.Stage(tmp_path / "cloud.usda", add=AddCards)
    session = volumeCase.RenderSession(stage, {"/V": volume}, size=16, samples=64, deep=True)
    deep, (color,) = session.Deep(), session.Layers()
    _AssertFlattens(deep, color.pixels)
    without = volumeCase.RenderSession(stage, {"/V": volume}, size=16, samples=64).Layers()[0].pixels
    difference = (without - color.pixels).astype(np.float64)[..., :3]  # in the light of the veil that rays pass
    assert np.abs(difference.mean()) < 4 * difference[..., 0].std() / difference[..., 0].size ** 0.5
    depths = deep.samples[:, :2]
    isFront, isBack = (depths[:, 1] < 7.1), (depths[:, 0] > 12.9)
    inside = depths[~isFront & ~isBack]
    assert isFront.any() and isBack.any() and len(inside) > 250
    assert (inside[:, 0] > 9.5 - 0.05).all() and (inside[:, 1] < 10.5 + 0.05).all()  # the grid and half a voxel
    assert inside[:, 0].min() < 9.6 and inside[:, 1].max() > 10.4


@pytest.mark.parametrize("projection", ["latlong", "fisheyeEquidistant"])
def test_panoramas_have_distances(projection, tmp_path):
    """Balls about the camera, half transparent and opaque: in all directions at their radius, the nearer one first."""
    stage = author.NewStage(str(tmp_path / "balls.usda"))
    veil = author.AddMaterial(stage, "/Looks/Veil", opacity=0.5, ior=1.0)
    for name, radius, material in (("Near", 2.0, veil), ("Far", 5.0, None)):
        ball = UsdGeom.Sphere.Define(stage, f"/World/{name}")
        ball.CreateRadiusAttr(radius)
        if material is not None:
            author.Bind(ball, material)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1, 1, 1)), radius=0.2)
    camera = author.AddCamera(stage, eye=(0, 0, 0), target=(1, 0.5, 2), width=36.0, aspect=1.0).GetPrim()
    camera.CreateAttribute("hdstream:camera:projection", Sdf.ValueTypeNames.Token).Set(projection)
    camera.CreateAttribute("hdstream:camera:fieldOfView", Sdf.ValueTypeNames.Float).Set(320.0)
    stage.GetRootLayer().Save()
    deep = hdstream.Renderer(stage.GetRootLayer().realPath).Render(
        imageWidth=_SIZE, imageHeight=_SIZE, samples=16, maxDepth=1, noCache=True, camera="/World/Camera", deep=True, lightsVisible=False).deep
    starts = deepFile.Starts(deep.counts)
    assert (deep.counts == 2).sum() > 300
    for pixel in np.flatnonzero(deep.counts.ravel() == 2):
        assert np.allclose(deep.samples[starts[pixel]:starts[pixel] + 2, 0], (2.0, 5.0), rtol=0.02)


def test_shadow_catchers_are_said_not_to_be_there(tmp_path):
    stage = author.NewStage(str(tmp_path / "catcher.usda"))
    floor = author.AddMesh(stage, "/World/Floor", shapes.Box(4.0, 0.1, 4.0), translate=(0.0, -1.0, 0.0))
    author.AddPrimvar(floor.GetPrim(), "hdstream:shadowCatcher", _Bool(), "constant", True)
    author.AddMesh(stage, "/World/Box", shapes.Box(1.0, 1.0, 1.0))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-60, 0, 0)), intensity=2.0, angle=1.0)
    author.AddCamera(stage, eye=(0, 3, 6), target=(0, 0, 0), width=36.0, aspect=1.0)
    stage.GetRootLayer().Save()
    lines = []
    image = hdstream.Renderer(stage.GetRootLayer().realPath, onWarning=lines.append).Render(
        imageWidth=_SIZE, imageHeight=_SIZE, samples=16, maxDepth=1, noCache=True, camera="/World/Camera", deep=True,
        aovs=["color", "crypto_object"])
    assert any("a deep picture shows nothing of shadow catchers" in line for line in lines)
    flat = deepFile.Flatten(image.deep.counts, image.deep.samples[:, 2:].astype(np.float64))[..., 3]
    box = sum(image.aovs[f"crypto_object{layer:02}"][..., 1::2].sum(-1) for layer in range(3))
    assert np.allclose(flat, box, atol=1e-6) and (image.aovs["color"][..., 3] > flat + 0.1).any()


def test_samples_cannot_be_split(stage):
    renderer = hdstream.Renderer(stage)
    renderer.Prepare(1, imageWidth=8, imageHeight=8, samples=16, noCache=True, camera="/World/Camera", deep=True)
    assert renderer.RenderPrepared().deep is not None
    sums = renderer.Sums()
    renderer.Prepare(1, imageWidth=8, imageHeight=8, samples=32, noCache=True, camera="/World/Camera", deep=True)
    with pytest.raises(hdstream.UsageError, match="--deep: samples of a deep picture cannot be split or continued"):
        renderer.RenderPrepared(start=[sums])
