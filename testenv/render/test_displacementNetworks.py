# SPDX-License-Identifier: Apache-2.0
"""Displacement by networks: surfaces are where numpy moves them, pictures those of meshes moved by hand, and of any pool."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, UsdGeom, UsdShade, Vt
from stages import author, imageFile, shapes
from stages.materialX import STANDARD, AddNode

_T = Sdf.ValueTypeNames
_SIZE = 32  # pixels of a picture, and points of the sheet, which lie at their centres


def _Sheet():
    """The unit square in x and y, seen along -z, whose points lie at the centres of pixels; z is 0."""
    at = (np.arange(_SIZE) + 0.5) / _SIZE
    y, x = np.meshgrid(at, at, indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    quads = shapes._GridIndices(_SIZE, _SIZE, False)
    return shapes.Shape(points, np.full(len(quads), 4), quads.ravel(), None, points[:, :2])


def _Stage(path, shape, displace=None, color=(0.7, 0.4, 0.2), scheme="none"):
    """`displace(stage, root)` adds nodes and gives the inputs of the displacement node."""
    stage = author.NewStage(str(path))
    material = UsdShade.Material.Define(stage, "/World/Look")
    surface, _ = AddNode(stage, "/World/Look/Surface", STANDARD, _T.Token, base=1.0, base_color=color, specular=0.0)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))
    if displace is not None:
        inputs = displace(stage, "/World/Look")
        identifier = inputs.pop("identifier", "ND_displacement_float")
        node, _ = AddNode(stage, "/World/Look/Displacement", identifier, _T.Token, **inputs)
        material.CreateDisplacementOutput("mtlx").ConnectToSource(node.GetOutput("out"))
    mesh = author.AddMesh(stage, "/World/Sheet", shape, material=material, doubleSided=True)
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), angle=0.0, intensity=1.0)
    author.AddCamera(stage, eye=(0.5, 0.5, 50), target=(0.5, 0.5, 0), width=10.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return stage


def _Render(stage, aovs=("color", "position"), **settings):
    return ours.Render(stage.GetRootLayer().realPath, _SIZE, _SIZE, aovs, **{"samples": 1, "maxDepth": 1, "autobump": False, **settings})


def _Float(stage, root, name, category, types="float", **inputs):
    return AddNode(stage, f"{root}/{name}", f"ND_{category}_{types}", _T.Float, **inputs)


def _Waves(stage, root):
    """0.1 sin(8 x) + bumps y, times a scale that varies."""
    position = AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f)
    x = AddNode(stage, f"{root}/X", "ND_extract_vector3", _T.Float, index=0, **{"in": position})
    y = AddNode(stage, f"{root}/Y", "ND_extract_vector3", _T.Float, index=1, **{"in": position})
    sine = _Float(stage, root, "Sine", "sin", **{"in": _Float(stage, root, "Turns", "multiply", in1=x, in2=8.0)})
    low = _Float(stage, root, "Low", "multiply", in1=sine, in2=0.1)
    bumps = AddNode(stage, f"{root}/Bumps", "ND_geompropvalue_float", _T.Float, geomprop="bumps")
    slope = _Float(stage, root, "Slope", "multiply", in1=bumps, in2=y)
    return dict(displacement=_Float(stage, root, "Sum", "add", in1=low, in2=slope), scale=x)


def _WavesBy(points, bumps):
    return points[:, 0] * (0.1 * np.sin(8 * points[:, 0]) + bumps * points[:, 1])


def _AddBumps(stage, values):
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Sheet")).CreatePrimvar("bumps", _T.FloatArray, "vertex")
    primvar.Set(Vt.FloatArray.FromNumpy(values.astype(np.float32)))


def _Moved(sheet, heights):
    return shapes.Shape(np.stack([*sheet.points[:, :2].T, heights], -1), sheet.counts, sheet.indices, None, sheet.texcoords)


def _Inner(picture, layer):
    """Without the border, half of which the sheet does not cover."""
    return picture.layers[layer][1:-1, 1:-1].astype(np.float64)


def _ExpectHeights(stage, byHand):
    """The same surface, and so the same picture, but for rays that rounding puts on the other side of an edge."""
    picture, expected = _Render(stage), _Render(byHand)
    assert picture.warnings == []
    assert _Inner(picture, "position") == pytest.approx(_Inner(expected, "position"), abs=2e-6)
    difference = np.abs(_Inner(picture, "color") - _Inner(expected, "color"))
    assert _Inner(expected, "color")[..., 0].std() > 0.01 and np.quantile(difference, 0.95) < 1e-4


def test_a_network_moves_what_numpy_moves(tmp_path):
    sheet, bumps = _Sheet(), np.random.default_rng(1).uniform(0, 0.05, _SIZE * _SIZE)
    stage = _Stage(tmp_path / "network.usda", sheet, _Waves)
    _AddBumps(stage, bumps)
    stage.GetRootLayer().Save()
    _ExpectHeights(stage, _Stage(tmp_path / "byHand.usda", _Moved(sheet, _WavesBy(sheet.points, bumps))))


def _Noise(stage, root):
    return dict(displacement=_Float(stage, root, "Noise", "fractal3d", amplitude=0.2, octaves=3, position=AddNode(
        stage, f"{root}/Scaled", "ND_multiply_vector3FA", _T.Vector3f, in2=5.0,
        in1=AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f))))


def _Cards(path, displaces, scheme):
    """A card for each pixel with a primvar of three random numbers, whose noise moves it, or is its glow."""
    corner = np.arange(_SIZE) / _SIZE
    y, x = np.meshgrid(corner, corner, indexing="ij")
    low = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 1, 3)
    step = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) / _SIZE
    numCards = _SIZE * _SIZE
    cards = shapes.Shape((low + step).reshape(-1, 3), np.full(numCards, 4), np.arange(4 * numCards))

    def Noise(stage, root):
        at = AddNode(stage, f"{root}/At", "ND_geompropvalue_vector3", _T.Vector3f, geomprop="at")
        flat = AddNode(stage, f"{root}/Flat", "ND_convert_vector3_vector2", _T.Float2, **{"in": at})
        parts = [_Float(stage, root, "Fractal", "fractal3d", position=at, octaves=3),
                 _Float(stage, root, "Worley", "worleynoise3d", position=at),
                 _Float(stage, root, "Noise", "noise2d", texcoord=flat), _Float(stage, root, "Cell", "cellnoise2d", texcoord=flat)]
        total = _Float(stage, root, "Sum0", "constant", value=1.5)
        for number, part in enumerate(parts):
            total = _Float(stage, root, f"Sum{number + 1}", "add", in1=total, in2=part)
        return total
    stage = _Stage(path, cards, (lambda stage, root: dict(displacement=Noise(stage, root), scale=0.3)) if displaces else None, scheme=scheme)
    values = np.random.default_rng(2).uniform(-5, 5, (numCards, 3)).astype(np.float32)
    UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Sheet")).CreatePrimvar("at", _T.Float3Array, "uniform").Set(
        Vt.Vec3fArray.FromNumpy(values))
    if not displaces:
        surface = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Surface"))
        surface.SetShaderId("ND_surface_unlit")
        color = AddNode(stage, "/World/Look/Color", "ND_convert_float_color3", **{"in": Noise(stage, "/World/Look")})
        surface.CreateInput("emission_color", _T.Color3f).ConnectToSource(color[0].GetOutput("out"))
    stage.GetRootLayer().Save()
    return stage


@pytest.mark.parametrize("scheme", ["none", "bilinear"])
def test_noise_moves_cards_as_far_as_they_shine(tmp_path, scheme):
    """The host's functions against those of kernels, which other tests judge."""
    heights = _Render(_Cards(tmp_path / "noise.usda", True, scheme)).layers["position"][..., 2]
    glowing = _Render(_Cards(tmp_path / "glow.usda", False, scheme)).layers["color"][..., 0]
    assert glowing.min() > 0.1 and glowing.std() > 0.3
    assert heights == pytest.approx(0.3 * glowing, abs=2e-6)


def test_images_are_looked_up_on_their_tiles(tmp_path):
    """The square of a channel of two UDIM tiles, the second three times as high."""
    ramp = np.tile(np.linspace(0, 1, 64), (64, 1))
    for number, scale in ((1001, 0.1), (1002, 0.3)):
        imageFile.WriteExr(tmp_path / f"h.{number}.exr", dict(R=scale * ramp, G=ramp, B=ramp), half=False)
    sheet = _Sheet()
    sheet = shapes.Shape(sheet.points, sheet.counts, sheet.indices, None, sheet.points[:, :2] * [2.0, 1.0])

    def Tiles(stage, root):
        image = AddNode(stage, f"{root}/Image", "ND_image_color3", file=Sdf.AssetPath(str(tmp_path / "h.<UDIM>.exr")))
        red = AddNode(stage, f"{root}/Red", "ND_extract_color3", _T.Float, index=0, **{"in": image})
        return dict(displacement=_Float(stage, root, "Power", "power", in1=red, in2=2.0))
    s = sheet.texcoords[:, 0]
    heights = (np.where(s < 1, 0.1, 0.3) * np.clip((s % 1) * 64 - 0.5, 0, 63) / 63) ** 2
    _ExpectHeights(_Stage(tmp_path / "tiles.usda", sheet, Tiles), _Stage(tmp_path / "byHand.usda", _Moved(sheet, heights)))


def _Vectors(space=None):
    """(0.1 x, 0.05 y, 0.2 x y), times 2."""
    def Displace(stage, root):
        position = AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f)
        x, y = (AddNode(stage, f"{root}/{name}", "ND_extract_vector3", _T.Float, index=index, **{"in": position})
                for index, name in enumerate("XY"))
        parts = [_Float(stage, root, "Dx", "multiply", in1=x, in2=0.1), _Float(stage, root, "Dy", "multiply", in1=y, in2=0.05),
                 _Float(stage, root, "Dz", "multiply", in1=_Float(stage, root, "Xy", "multiply", in1=x, in2=y), in2=0.2)]
        vector = AddNode(stage, f"{root}/Vector", "ND_combine3_vector3", _T.Vector3f, in1=parts[0], in2=parts[1], in3=parts[2])
        inputs = dict(identifier="ND_displacement_vector3", displacement=vector, scale=2.0)
        return inputs if space is None else dict(inputs, space=space)
    return Displace


def _VectorsBy(points):
    x, y = points[:, 0], points[:, 1]
    return 2.0 * np.stack([0.1 * x, 0.05 * y, 0.2 * x * y], -1)


# Texture coordinates of the sheet, and where they and the normal take x, y and z of a vector.
_FRAMES = {
    "plain": ([[1, 0], [0, 1]], np.eye(3)),
    "turned": ([[0, 2], [-1, 0]], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
    "mirrored": ([[-3, 0], [0, 1]], [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]),
}


def _ExpectVectors(tmp_path, sheet, space, moved, scheme):
    stage = _Stage(tmp_path / "vectors.usda", sheet, _Vectors(space), scheme=scheme)
    byHand = _Stage(tmp_path / "byHand.usda", shapes.Shape(sheet.points + moved, sheet.counts, sheet.indices, None, None), scheme=scheme)
    picture, expected = (_Render(one, subdivision="complexity", refineLevel=0) for one in (stage, byHand))
    assert picture.warnings == []
    for layer, tolerance in (("position", 4e-6), ("color", 2e-3)):
        difference = np.abs(_Inner(picture, layer) - _Inner(expected, layer))
        assert np.quantile(difference, 0.98) < tolerance, layer
    assert np.ptp(_Inner(picture, "position")[..., 2]) > 0.2


@pytest.mark.parametrize("scheme", ["none", "bilinear"])
@pytest.mark.parametrize("frame", _FRAMES)
def test_vectors_are_in_the_frame_of_texture_coordinates(tmp_path, frame, scheme):
    sheet = _Sheet()
    rows, columns = _FRAMES[frame]
    sheet = shapes.Shape(sheet.points, sheet.counts, sheet.indices, None, sheet.points[:, :2] @ np.array(rows, float).T)
    _ExpectVectors(tmp_path, sheet, None, _VectorsBy(sheet.points) @ np.array(columns, float), scheme)


@pytest.mark.parametrize("scheme", ["none", "bilinear"])
def test_vectors_are_in_object_space_where_that_is_said(tmp_path, scheme):
    """On a sheet that stands aslant, so that its own frame is another one."""
    flat = _Sheet()
    points = flat.points @ np.array([[1, 0, 0.5], [0, 1, 0], [0, 0, 1]], float)
    sheet = shapes.Shape(points, flat.counts, flat.indices, None, flat.texcoords)
    _ExpectVectors(tmp_path, sheet, "object", _VectorsBy(points), scheme)


def test_vectors_are_looked_up_on_their_tiles(tmp_path):
    """Three channels of two UDIM tiles, in the frame of coordinates and in object space, which are the same on this sheet."""
    ramp = np.tile(np.linspace(0, 1, 64), (64, 1))
    for number, scale in ((1001, 0.1), (1002, 0.2)):
        imageFile.WriteExr(tmp_path / f"v.{number}.exr", dict(R=scale * ramp, G=-0.5 * scale * ramp, B=0.5 - scale * ramp), half=False)
    sheet = _Sheet()
    sheet = shapes.Shape(sheet.points, sheet.counts, sheet.indices, None, sheet.points[:, :2] * [2.0, 1.0])

    def Tiles(space):
        return lambda stage, root: dict(identifier="ND_displacement_vector3", space=space, displacement=AddNode(
            stage, f"{root}/Image", "ND_image_vector3", _T.Vector3f, file=Sdf.AssetPath(str(tmp_path / "v.<UDIM>.exr"))))
    s = sheet.texcoords[:, 0]
    at = np.where(s < 1, 0.1, 0.2) * np.clip((s % 1) * 64 - 0.5, 0, 63) / 63
    byHand = shapes.Shape(sheet.points + np.stack([at, -0.5 * at, 0.5 - at], -1), sheet.counts, sheet.indices, None, None)
    expected = _Inner(_Render(_Stage(tmp_path / "byHand.usda", byHand)), "position")
    for space in ("tangent", "object"):
        picture = _Render(_Stage(tmp_path / f"{space}.usda", sheet, Tiles(space)))
        assert picture.warnings == []
        difference = np.abs(_Inner(picture, "position") - expected)
        assert np.quantile(difference, 0.98) < 4e-6 and np.ptp(expected[..., 2]) > 0.15


def test_a_space_that_is_unknown_is_said(tmp_path):
    pictures = [_Render(_Stage(tmp_path / f"{name}.usda", _Sheet(), _Vectors(space))) for name, space in (("odd", "world"), ("none", None))]
    assert sum('space "world" of /World/Look/Displacement is neither tangent nor object' in line for line in pictures[0].warnings) == 1
    assert np.array_equal(pictures[0].layers["position"], pictures[1].layers["position"])


@pytest.mark.parametrize("scheme", ["none", "catmullClark"])
def test_vectors_without_coordinates_keep_what_they_have_along_the_normal(tmp_path, scheme):
    sheet = _Sheet()
    sheet = shapes.Shape(sheet.points, sheet.counts, sheet.indices, None, None)
    picture = _Render(_Stage(tmp_path / "vectors.usda", sheet, _Vectors(), scheme=scheme))
    assert sum("texture coordinates" in line for line in picture.warnings) == 1
    position = _Inner(picture, "position")
    assert position[8:-8, 8:-8, 2] == pytest.approx((0.4 * position[..., 0] * position[..., 1])[8:-8, 8:-8], abs=2e-3)


@pytest.mark.parametrize("displace", [_Noise, _Vectors(), _Vectors("object")], ids=["noise", "tangent", "object"])
def test_bits_do_not_depend_on_pools(tmp_path, displace):
    ball = shapes.Sphere(0.4, 12, 24).Moved((0.5, 0.5, 0.0))
    ball = shapes.Shape(ball.points, ball.counts, ball.indices, None, ball.points[:, :2])
    stage = _Stage(tmp_path / "ball.usda", ball, displace, scheme="catmullClark")
    settings = dict(aovs=("color", "position"), samples=4, maxDepth=3, subdivision="complexity", refineLevel=3, autobump=True)
    whole = _Render(stage, residency="resident", **settings)
    assert whole.layers["color"].max() > 0.1
    for share in (100, 30, 5):
        streamed = _Render(stage, residency="stream", chunkBytes=1 << 14, geometryMemory=f"{share}%", **settings)
        for layer in settings["aovs"]:
            assert np.array_equal(whole.layers[layer], streamed.layers[layer]), share


def test_what_the_host_cannot_evaluate_is_said(tmp_path):
    def Facing(stage, root):
        return dict(displacement=_Float(stage, root, "Facing", "facingratio"))
    picture = _Render(_Stage(tmp_path / "facing.usda", _Sheet(), Facing))
    assert sum("displacement by a network with normals" in line for line in picture.warnings) == 1
    assert np.abs(_Inner(picture, "position")[..., 2]).max() < 1e-6
