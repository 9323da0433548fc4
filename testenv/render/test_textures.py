# SPDX-License-Identifier: Apache-2.0
"""Textures as pictures show them, against what UsdPreviewSurface's text defines (textureCases.py) and
against geometry that does the same.

Textures of the look-up tests have few texels, so that every pixel magnifies: what differs from the
definition is the mean over a pixel of a continuous function by 64 samples. Of 8 bits the codec can only approximate
noise; where that would show, images have values that it keeps (KeptCodes).
"""

import pathlib

import numpy as np
import pytest
from pxr import Sdf, UsdUtils

pytest.importorskip("hdstream._core")

import closedForm
import ours
from stages import author, imageFile, shapes
from textureCases import (
    HEIGHT, WIDTH, AddReader, AddTexture, AddTopCamera, AddTransform, Bilinear, Connect, Coordinates, FromSrgb, GlowingPlate,
    KeptCodes, PixelMeans,
)


def _Noise(width: int, height: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).random((height, width, 3)).astype(np.float32)


def _WriteExr(path, image: np.ndarray) -> None:
    imageFile.WriteExr(path, {c: image[..., i] for i, c in enumerate("RGBA"[: image.shape[2]])}, half=False)


def _Glow(texture, output="rgb"):
    return lambda material: Connect(material, "emissiveColor", texture(material), output)


def _Render(path, **settings) -> np.ndarray:
    picture = ours.Render(path, WIDTH, HEIGHT, **dict(dict(samples=64, maxDepth=0), **settings))
    assert not picture.warnings
    return picture.rgb


@pytest.mark.parametrize("wrapS,wrapT", [("repeat", "clamp"), ("mirror", "repeat"), ("clamp", "black"), ("black", "mirror")])
def test_wrap_modes(wrapS, wrapT, tmp_path):
    """Each axis has its own; black fades over half a texel."""
    image, low, high = _Noise(4, 3), (-1.5, -2.2), (2.5, 1.9)
    _WriteExr(f"{tmp_path}/a.exr", image)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.exr", wrapS=wrapS, wrapT=wrapT)), low, high)
    expected = PixelMeans(Bilinear(image, Coordinates(low, high), wrapS, wrapT))
    np.testing.assert_allclose(_Render(path, samples=256), expected, atol=0.01)


@pytest.mark.parametrize("space", ["raw", "sRGB", "auto"])
def test_colour_spaces_scale_and_bias(space, tmp_path):
    """Decoding comes first, then scale and bias; 8 bits with 3 channels are sRGB when nothing is said."""
    codes = KeptCodes(4, 5, 3, 2)
    imageFile.WritePng(f"{tmp_path}/a.png", codes)
    scale, bias = (2.0, 0.5, 1.0, 1.0), (0.1, 0.2, 0.0, 0.0)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(
        m, "T", file="./a.png", sourceColorSpace=space, scale=scale, bias=bias)))
    values = codes / 255 if space == "raw" else FromSrgb(codes / 255)
    expected = PixelMeans(Bilinear(values, Coordinates())) * scale[:3] + bias[:3]
    np.testing.assert_allclose(_Render(path), expected, atol=0.01)


@pytest.mark.parametrize("output,channel", [("r", 0), ("g", 1), ("b", 2), ("a", 3)])
def test_outputs(output, channel, tmp_path):
    """One channel spreads over a colour."""
    image = np.random.default_rng(3).random((3, 3, 4)).astype(np.float32)
    _WriteExr(f"{tmp_path}/a.exr", image)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.exr"), output))
    expected = PixelMeans(Bilinear(image, Coordinates()))[..., channel : channel + 1]
    np.testing.assert_allclose(_Render(path), np.broadcast_to(expected, (HEIGHT, WIDTH, 3)), atol=0.01)


@pytest.mark.parametrize("channels,dtype", [(1, np.uint8), (1, np.uint16), (2, np.uint8), (3, np.uint16), (4, np.uint8)])
def test_channel_counts_and_depths(channels, dtype, tmp_path):
    """Gray shows in all colours; gray with alpha as well."""
    top = np.iinfo(dtype).max
    codes = KeptCodes(5, 6, channels, 4, dtype)
    imageFile.WritePng(f"{tmp_path}/a.png", codes)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.png", sourceColorSpace="raw")))
    color = codes[..., :3] if channels > 2 else np.repeat(codes[..., :1], 3, -1)
    np.testing.assert_allclose(_Render(path), PixelMeans(Bilinear(color / top, Coordinates())), atol=0.01)


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_compression_shows_little(channels, tmp_path):
    """Images of 8 bits against the same values as floats, of which the codec loses at most 1 / 8190 of their range: noise is
    off by a fraction of its range, what varies slowly by three codes of 8 bits at most."""
    columns, rows = np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 12))
    smooth = np.stack([(columns + rows) / 2, columns, 1 - rows, (1 + columns) / 2], -1)[..., :channels]
    noise = np.random.default_rng(8).random((12, 16, channels))
    for name, image, most, mean in (("noise", noise, 0.08, 0.02), ("smooth", smooth, 3 / 255, 0.005)):
        codes = np.round(image * 255).astype(np.uint8)
        imageFile.WritePng(f"{tmp_path}/{name}.png", codes)
        # Colours beyond halves are stored as floats.
        _WriteExr(f"{tmp_path}/{name}.exr", np.broadcast_to(codes[..., :3], (12, 16, 3)) / np.float32(255) * 2.0**17)
        coded, precise = (_Render(GlowingPlate(f"{tmp_path}/{name}.{kind}.usda", _Glow(lambda m: AddTexture(
            m, "T", file=f"./{name}.{kind}", sourceColorSpace="raw", scale=(scale,) * 4))))
            for kind, scale in (("png", 1.0), ("exr", 2.0**-17)))
        difference = np.abs(coded - precise)
        assert 2e-4 < difference.max() < most and difference.mean() < mean, (difference.max(), difference.mean())


def test_transforms_are_chained(tmp_path):
    """in * scale * rotate + translation, one after the other; degrees turn s towards t."""
    image = _Noise(4, 4)
    _WriteExr(f"{tmp_path}/a.exr", image)

    def Build(material):
        first = AddTransform(material, "X", AddReader(material, "R", "float2", "st"), 30.0, (2.0, 0.5), (0.25, 0.0))
        second = AddTransform(material, "Y", first, -75.0, (1.0, 1.5), (0.0, 0.5))
        Connect(material, "emissiveColor", AddTexture(material, "T", st=second, file="./a.exr"), "rgb")

    def Transform(st, degrees, scale, translation):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        x, y = st[..., 0] * scale[0], st[..., 1] * scale[1]
        return np.stack([c * x - s * y + translation[0], s * x + c * y + translation[1]], -1)

    st = Transform(Transform(Coordinates(), 30.0, (2.0, 0.5), (0.25, 0.0)), -75.0, (1.0, 1.5), (0.0, 0.5))
    picture = _Render(GlowingPlate(f"{tmp_path}/a.usda", Build), samples=256)
    np.testing.assert_allclose(picture, PixelMeans(Bilinear(image, st)), atol=0.01)


def _Packed(path) -> str:
    """A usdz of a stage and its textures, in a usdz."""
    inner, outer = f"{path}.inner.usdz", f"{path}.usdz"
    assert UsdUtils.CreateNewUsdzPackage(path, inner)
    root = f"{path}.root.usda"
    pathlib.Path(root).write_text("#usda 1.0\n(\nsubLayers = [@inner.usdz@]\n)\n", encoding="utf-8")
    with Sdf.ZipFileWriter.CreateNew(outer) as writer:
        writer.AddFile(root, "root.usda")
        writer.AddFile(inner, "inner.usdz")
    return outer


@pytest.mark.parametrize("isPacked", [False, True])
def test_udim_tiles_and_holes(tmp_path, isPacked):
    """Tiles 1001, 1003 and 1012 of a set; what is in none shows the fallback, also at negative coordinates. In packages
    too, which nest."""
    images = {number: _Noise(4, 4, number) for number in (1001, 1003, 1012)}
    for number, image in images.items():
        _WriteExr(f"{tmp_path}/a.{number}.exr", image)
    low, high = (-0.5, -0.25), (3.5, 2.25)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(
        m, "T", file="./a.<UDIM>.exr", fallback=(0.25, 0.5, 0.75, 1.0))), low, high)
    path = _Packed(path) if isPacked else path
    st = Coordinates(low, high)
    tile = 1001 + np.floor(st[..., 0]) + 10 * np.floor(st[..., 1])
    tile[(st < 0).any(-1)] = 0
    expected = np.broadcast_to(np.array([0.25, 0.5, 0.75]), st.shape[:-1] + (3,)).copy()
    for number, image in images.items():
        inside = tile == number
        expected[inside] = Bilinear(image, st[inside] % 1, "clamp", "clamp")
    difference = np.abs(_Render(path, samples=256) - PixelMeans(expected))
    assert difference.mean() < 2e-3 and difference.max() < 0.06  # tiles end with jumps


def test_long_images_keep_their_short_side(tmp_path):
    """3 x 997 texels over the whole picture: every pixel has 28 rows and a sixteenth of a column."""
    columns = np.array([0.1, 0.9, 0.4])[None, :, None]
    image = np.float32(columns + 0.1 * np.random.default_rng(6).random((997, 3, 3)))
    _WriteExr(f"{tmp_path}/a.exr", image)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.exr")))
    expected = PixelMeans(Bilinear(image, Coordinates(steps=56)))
    np.testing.assert_allclose(_Render(path, samples=256), expected, atol=0.02)


def test_a_material_without_coordinates_reads_one_point(tmp_path):
    """st that nothing is connected to is (0, 0): the corner where four texels meet under repeat."""
    image = np.float32(KeptCodes(3, 3, 3, 1) + 1) / 256
    _WriteExr(f"{tmp_path}/a.exr", image)

    def Build(material):
        texture = AddTexture(material, "T", file="./a.exr")
        texture.GetInput("st").ClearSources()
        Connect(material, "emissiveColor", texture, "rgb")

    expected = Bilinear(image, np.zeros((1, 1, 2)))[0, 0]
    picture = _Render(GlowingPlate(f"{tmp_path}/a.usda", Build), samples=4)
    np.testing.assert_allclose(picture, np.broadcast_to(expected, picture.shape), rtol=2.0**-11)  # kept as half


@pytest.mark.parametrize("size", [(512, 384), (509, 381), (1000, 3)])
def test_minified_noise_keeps_its_mean(size, tmp_path):
    """Far more texels than pixels, odd sizes too: blocks of pixels show the means of their texels, without seams
    where the texture repeats."""
    image = _Noise(*size)
    _WriteExr(f"{tmp_path}/a.exr", image)
    low, high = (0.0, 0.0), (3.0, 3.0)
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.exr")), low, high)
    picture = _Render(path)
    expected = image.mean((0, 1))
    assert np.abs(picture.mean((0, 1)) - expected).max() < 4e-3
    if size[1] > 3:
        assert np.abs(picture - expected).max() < 0.05


def test_a_constant_texture_has_the_bits_of_a_constant(tmp_path):
    """All inputs from textures of one value against authored values: the machine computes the same floats."""
    values = dict(diffuseColor=(0.25, 0.5, 0.75), roughness=0.375, metallic=0.25, clearcoat=0.5, clearcoatRoughness=0.125,
                  opacity=0.75, ior=1.75)
    pictures = []
    for isTextured in (False, True):
        folder = tmp_path / str(isTextured)
        folder.mkdir()
        stage = author.NewStage(f"{folder}/a.usda")
        material = author.AddMaterial(stage, "/World/M", **({} if isTextured else values))
        for name, value in values.items() if isTextured else ():
            color = value if isinstance(value, tuple) else (value,) * 3
            _WriteExr(f"{folder}/{name}.exr", np.broadcast_to(np.float32(color), (8, 4, 3)))
            Connect(material, name, AddTexture(material, "T" + name, file=f"./{name}.exr"), "rgb" if isinstance(value, tuple) else "g")
        ball = shapes.Sphere(1.0, 24, 48)
        ball = shapes.Shape(ball.points, ball.counts, ball.indices, ball.normals, ball.points[:, :2] * 3)
        author.AddMesh(stage, "/World/Ball", ball, material=material)
        author.AddMesh(stage, "/World/Ground", shapes.Plane(6, 6), color=(0.5, 0.4, 0.3), translate=(0, -1, 0))
        author.AddLight(stage, "/World/Key", "Sphere", dict(translate=(2, 3, 2)), radius=0.5, intensity=8.0)
        author.AddCamera(stage, eye=(0, 1, 5))
        stage.GetRootLayer().Save()
        pictures.append(ours.Render(f"{folder}/a.usda", 61, 47, ("color", "normal", "alpha"), samples=20, maxDepth=4).layers)
    for name, layer in pictures[0].items():
        assert layer.tobytes() == pictures[1][name].tobytes(), name


def test_image_on_a_rect_light(tmp_path):
    """Its first row is at the light's +y, its first column at +x (UsdLuxRectLight): who looks at the emitting side with
    +y up sees the image as it is. Here +y is down."""
    image = _Noise(5, 4)
    _WriteExr(f"{tmp_path}/a.exr", image)
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddLight(stage, "/World/Panel", "Rect", dict(rotate=(90, 0, 0)), width=4.0, height=3.0, intensity=2.0,
                    textureFile="./a.exr")
    AddTopCamera(stage)
    stage.GetRootLayer().Save()
    expected = 2 * PixelMeans(Bilinear(image, 1 - Coordinates(), "clamp", "clamp"))
    np.testing.assert_allclose(_Render(f"{tmp_path}/a.usda"), expected, atol=0.02)


def _WriteLargeDome(folder, codes: np.ndarray) -> np.ndarray:
    """A gray dome image of 8 bits, larger than the table that it is sampled by. Returns its radiance."""
    imageFile.WritePng(f"{folder}/sky.png", codes[..., None], level=1)
    return codes / 255


def test_a_large_dome_is_sharp_in_view(tmp_path):
    """The camera sees texels of a dome of 8 Mpx, though it is sampled by cells of four, which are all equal here."""
    codes = np.zeros((2048, 4096), np.uint8)
    codes[:, ::2] = 255
    _WriteLargeDome(tmp_path, codes)
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddLight(stage, "/World/Dome", "Dome", textureFile="./sky.png")
    author.AddCamera(stage, eye=(0, 0, 0), target=(0, 0, 1), width=0.5, focalLength=50.0)
    stage.GetRootLayer().Save()
    picture = _Render(f"{tmp_path}/a.usda", samples=16)[..., 0]
    # +z is the image's middle; what is to the right has a lesser longitude, a greater column.
    x = ((np.arange(WIDTH * 8) + 0.5) / (WIDTH * 8) - 0.5) * 0.01
    st = np.stack([0.5 + np.arctan(x) / (2 * np.pi), np.full_like(x, 0.5)], -1).reshape(1, 1, WIDTH, 8, 2)
    expected = PixelMeans(Bilinear(codes[..., None] / 255, st))[0, :, 0]
    assert expected.max() > 0.9 and expected.min() < 0.1
    np.testing.assert_allclose(picture.mean(0), expected, atol=0.03)


def test_a_large_dome_lights_without_bias(tmp_path):
    """Light on a plate of a dome with few bright texels, each a quarter of a cell that it is sampled by."""
    codes = np.zeros((2048, 4096), np.uint8)
    for y, x in np.random.default_rng(2).integers((100, 0), (900, 4096), (40, 2)):
        codes[y, x] = 252  # a quarter of it is a code too
    radiance = _WriteLargeDome(tmp_path, codes)
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1e4, textureFile="./sky.png")
    AddTopCamera(stage)
    stage.GetRootLayer().Save()
    irradiance = closedForm.IrradianceOfLatlong(radiance[..., None], np.array([0.0, 1.0, 0.0]))[0]
    picture = _Render(f"{tmp_path}/a.usda", samples=256, maxDepth=0)
    assert picture.mean() == pytest.approx(1e4 * irradiance * 0.5 / np.pi, rel=3e-3)


def _Bump(x, z):
    """A height and its derivatives."""
    a, k = 0.02, 4 * np.pi
    return a * np.sin(k * x) * np.cos(k * z), a * k * np.cos(k * x) * np.cos(k * z), -a * k * np.sin(k * x) * np.sin(k * z)


def _WriteBumpScene(path, mode: str) -> str:
    """A plate of 4 x 3 with a bump: "geometry" by its points' normals, else by a normal map whose coordinates run
    along x and -z ("map"), against x ("mirrored") or turned by 90 degrees ("turned")."""
    folder = path.rsplit("/", 1)[0]
    stage = author.NewStage(path)
    inputs = dict(diffuseColor=(0.7, 0.6, 0.5), roughness=0.4)
    if mode == "geometry":
        plane = shapes.Plane(4, 3, 360, 480)
        _, dx, dz = _Bump(plane.points[:, 0], plane.points[:, 2])
        normals = np.stack([-dx, np.ones_like(dx), -dz], -1)
        plane = shapes.Shape(plane.points, plane.counts, plane.indices, normals / np.linalg.norm(normals, axis=1, keepdims=True))
        material = author.AddMaterial(stage, "/World/M", **inputs)
    else:
        plane = shapes.Plane(4, 3, 3, 4)
        s, t = (plane.points[:, 0] + 2) / 4, (1.5 - plane.points[:, 2]) / 3
        columns, rows = np.meshgrid((np.arange(960) + 0.5) / 960, 1 - (np.arange(720) + 0.5) / 720)
        if mode == "turned":  # coordinates (t, 1 - s)
            st, x, z = np.stack([t, 1 - s], -1), (1 - rows) * 4 - 2, 1.5 - columns * 3
        elif mode == "mirrored":
            st, x, z = np.stack([1 - s, t], -1), (1 - columns) * 4 - 2, 1.5 - rows * 3
        else:
            st, x, z = np.stack([s, t], -1), columns * 4 - 2, 1.5 - rows * 3
        _, dx, dz = _Bump(x, z)
        world = np.stack([-dx, np.ones_like(dx), -dz], -1)
        world /= np.linalg.norm(world, axis=-1, keepdims=True)
        # Tangents along s and t in the world; the map holds the normal's components along them.
        alongS = {"map": (1, 0, 0), "mirrored": (-1, 0, 0), "turned": (0, 0, -1)}[mode]
        alongT = {"map": (0, 0, -1), "mirrored": (0, 0, -1), "turned": (-1, 0, 0)}[mode]
        tangent = np.stack([world @ np.array(alongS, float), world @ np.array(alongT, float), world[..., 1]], -1)
        _WriteExr(f"{folder}/n.exr", (tangent * 0.5 + 0.5).astype(np.float32))
        plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, st)
        material = author.AddMaterial(stage, "/World/M", **inputs)
        Connect(material, "normal", AddTexture(material, "N", file="./n.exr", scale=(2, 2, 2, 1), bias=(-1, -1, -1, 0)), "rgb")
    author.AddMesh(stage, "/World/Plate", plane, material=material)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 25, 0)), angle=0.0, intensity=3.0)
    AddTopCamera(stage)
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("mode", ["map", "mirrored", "turned"])
def test_normal_map_equals_normals_of_the_bump(mode, tmp_path):
    """The frame follows the coordinates, whichever way they run; normals of points against normals of texels."""
    for name in ("geometry", mode):
        (tmp_path / name).mkdir()
    expected = _Render(_WriteBumpScene(f"{tmp_path}/geometry/a.usda", "geometry"))
    picture = _Render(_WriteBumpScene(f"{tmp_path}/{mode}/a.usda", mode), mipBias=-16.0)  # texels, not their means
    assert expected.std() > 0.2 * expected.mean()
    np.testing.assert_allclose(picture, expected, atol=0.01 * expected.max())


def test_normal_map_without_coordinates_is_left_out(tmp_path):
    """Coordinates that are the same everywhere have no directions: the surface stays as it is."""
    pictures = []
    for bump in ((0.5, 0.5, 1.0), (0.9, 0.3, 0.7)):
        _WriteExr(f"{tmp_path}/n.exr", np.broadcast_to(np.float32(bump), (2, 2, 3)))
        stage = author.NewStage(f"{tmp_path}/{bump[0]}.usda")
        material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.7, 0.6, 0.5))
        Connect(material, "normal", AddTexture(material, "N", file="./n.exr", scale=(2, 2, 2, 1), bias=(-1, -1, -1, 0)), "rgb")
        plane = shapes.Plane(4, 3)
        plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, np.full((4, 2), 0.25))
        author.AddMesh(stage, "/World/Plate", plane, material=material)
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 25, 0)), angle=0.0, intensity=3.0)
        AddTopCamera(stage)
        stage.GetRootLayer().Save()
        pictures.append(_Render(f"{tmp_path}/{bump[0]}.usda", samples=4))
    assert pictures[0].tobytes() == pictures[1].tobytes()


def _WriteStripes(path, isTextured: bool, threshold: float, ground: bool) -> str:
    """Stripes over a ground: by a mask, or each a mesh. A mask of 0 and 1 that is interpolated crosses the
    threshold 0.5 at the edges of texels."""
    folder = path.rsplit("/", 1)[0]
    stage = author.NewStage(path)
    material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.7, 0.3, 0.2), opacityThreshold=threshold)
    if isTextured:
        mask = np.zeros((1, 16, 3), np.float32)
        mask[:, ::2] = 1.0
        _WriteExr(f"{folder}/m.exr", mask)
        Connect(material, "opacity", AddTexture(material, "T", file="./m.exr", wrapS="clamp", wrapT="clamp"), "r")
        author.AddMesh(stage, "/World/Plate", shapes.Plane(2, 2), material=material, translate=(0, 0.5, 0))
    else:
        for i in range(8):
            author.AddMesh(stage, f"/World/S{i}", shapes.Plane(2 / 16, 2), material=material, translate=(-1 + (2 * i + 0.5) / 8, 0.5, 0))
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.5,) * 3)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, 30, 0)), angle=1.0, intensity=400.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.3)
    AddTopCamera(stage)
    stage.GetRootLayer().Save()
    return path


def test_a_mask_cuts_as_geometry_does(tmp_path):
    """Seen by the camera, through one bounce and in shadows."""
    for name in ("mask", "cut"):
        (tmp_path / name).mkdir()
    picture = _Render(_WriteStripes(f"{tmp_path}/mask/a.usda", True, 0.5, True), samples=256, maxDepth=2)
    expected = _Render(_WriteStripes(f"{tmp_path}/cut/a.usda", False, 0.0, True), samples=256, maxDepth=2)
    # The mip of the mask may blur its edges by less than a texel where it is minified; here it is magnified.
    assert picture.mean() == pytest.approx(expected.mean(), rel=3e-3)
    blocks = lambda a: a.reshape(HEIGHT // 6, 6, WIDTH // 6, 6, 3).mean((1, 3))
    np.testing.assert_allclose(blocks(picture), blocks(expected), atol=0.02 * expected.max())


def test_soft_opacity_equals_a_constant_half(tmp_path):
    """An opacity of 0.5 in every texel is an opacity of 0.5, by the same random numbers."""
    pictures = []
    for isTextured in (False, True):
        stage = author.NewStage(f"{tmp_path}/{isTextured}.usda")
        material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.7, 0.3, 0.2), **({} if isTextured else dict(opacity=0.5)))
        if isTextured:
            imageFile.WriteExr(f"{tmp_path}/o.exr", {c: np.full((4, 4), 0.5, np.float32) for c in "RGBA"}, half=False)
            Connect(material, "opacity", AddTexture(material, "T", file="./o.exr"), "a")
        author.AddMesh(stage, "/World/Plate", shapes.Plane(2, 2), material=material, translate=(0, 0.5, 0))
        author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.5,) * 3)
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, 30, 0)), angle=1.0, intensity=400.0)
        AddTopCamera(stage)
        stage.GetRootLayer().Save()
        pictures.append(_Render(f"{tmp_path}/{isTextured}.usda", samples=16, maxDepth=3))
    assert pictures[0].tobytes() == pictures[1].tobytes()


@pytest.mark.parametrize("damage", ["missing", "truncated", "text"])
def test_unreadable_images_show_the_fallback_and_warn_once(damage, tmp_path):
    """Rendering goes on."""
    imageFile.WritePng(f"{tmp_path}/a.png", (np.random.default_rng(5).random((64, 64, 3)) * 255).astype(np.uint8))
    data = (tmp_path / "a.png").read_bytes()
    contents = {"truncated": data[: len(data) // 2], "text": b"this is no image"}
    if damage == "missing":
        (tmp_path / "a.png").unlink()
    else:
        (tmp_path / "a.png").write_bytes(contents[damage])
    path = GlowingPlate(f"{tmp_path}/a.usda", _Glow(lambda m: AddTexture(m, "T", file="./a.png", fallback=(0.25, 0.5, 0.75, 1))))
    picture = ours.Render(path, WIDTH, HEIGHT, samples=4, maxDepth=0)
    np.testing.assert_allclose(picture.rgb, np.broadcast_to([0.25, 0.5, 0.75], picture.rgb.shape), rtol=1e-6)
    assert len(picture.warnings) == 1 and "a.png" in picture.warnings[0]


def test_bits_do_not_depend_on_how_it_is_rendered(tmp_path):
    """Wave sizes, traversal forms, chunk sizes and streamed geometry, with textures in camera, indirect and shadow
    rays."""
    path = _WriteStripes(f"{tmp_path}/a.usda", True, 0.0, True)
    render = lambda **settings: ours.Render(path, 61, 47, ("color", "normal"), samples=20, maxDepth=3, **settings).layers
    expected = render(waveSize=1 << 16)
    for settings in (dict(waveSize=3001), dict(traversal="scalar"), dict(chunkBytes=1 << 14), dict(residency="stream")):
        layers = render(**settings)
        for name in expected:
            assert layers[name].tobytes() == expected[name].tobytes(), (settings, name)


def test_displacement_by_a_texture_moves_the_surface(tmp_path):
    """A ramp of heights, turned and scaled by a transform, raises a plate to a plane of known height everywhere."""
    heights = np.repeat(np.arange(16, dtype=np.float32)[None, :, None] / 16, 3, -1)
    _WriteExr(f"{tmp_path}/h.exr", heights)
    stage = author.NewStage(f"{tmp_path}/a.usda")
    material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.5, 0.5, 0.5))
    turned = AddTransform(material, "X", AddReader(material, "R", "float2", "st"), -90.0, (0.5, 0.5), (0.25, 0.75))
    Connect(material, "displacement", AddTexture(material, "T", st=turned, file="./h.exr", scale=(0.8, 1, 1, 1), bias=(0.1, 0, 0, 0)), "r")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(4, 3, 30, 40), material=material)
    AddTopCamera(stage)
    stage.GetRootLayer().Save()
    picture = ours.Render(f"{tmp_path}/a.usda", WIDTH, HEIGHT, ("color", "position"), samples=1)
    position = picture.layers["position"]
    t = 0.5 - position[..., 2] / 3  # of the plate; s of the look-up is t / 2 + 0.25
    expected = 0.8 * ((t / 2 + 0.25) * 16 - 0.5) / 16 + 0.1
    np.testing.assert_allclose(position[..., 1], expected, atol=1e-4)
