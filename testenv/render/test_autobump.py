# SPDX-License-Identifier: Apache-2.0
"""What triangles lack of a displacement is in the shading: against closed forms, and against triangles that have it."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hdstream
import ours
from pxr import Gf, Sdf, UsdGeom, UsdShade
from stages import author, imageFile, shapes
from stages.materialX import STANDARD, AddNode

_T = Sdf.ValueTypeNames
_SIZE = 96
_WAVES = ((0.009, 40.0), (0.006, 55.0))  # heights and wave numbers along x and z
_SUN = np.array([-np.sin(np.pi / 3) * 0.5, np.sin(np.pi / 3) * np.cos(np.pi / 6), 0.5])  # to it: rotateXYZ (-60, 0, 30)


def _Float(stage, root, name, category, types="float", **inputs):
    return AddNode(stage, f"{root}/{name}", f"ND_{category}_{types}", _T.Float, **inputs)


def _Material(stage, displace=None, **surface):
    """`displace(stage, root)` adds nodes and gives the inputs of the displacement node."""
    root = "/World/Look"
    material = UsdShade.Material.Define(stage, root)
    shader, _ = AddNode(stage, f"{root}/Surface", STANDARD, _T.Token, base=1.0, base_color=(0.7, 0.6, 0.5), **{"specular": 0.0, **surface})
    material.CreateSurfaceOutput("mtlx").ConnectToSource(shader.GetOutput("out"))
    if displace is not None:
        inputs = displace(stage, root)
        node, _ = AddNode(stage, f"{root}/Displacement", inputs.pop("identifier", "ND_displacement_float"), _T.Token, **inputs)
        material.CreateDisplacementOutput("mtlx").ConnectToSource(node.GetOutput("out"))
    return material


def _Waves(stage, root):
    """The heights of _WAVES above the sheet, by its position."""
    position = AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f)
    sines = []
    for axis, (height, number) in zip((0, 2), _WAVES):
        x = AddNode(stage, f"{root}/X{axis}", "ND_extract_vector3", _T.Float, index=axis, **{"in": position})
        turns = _Float(stage, root, f"Turns{axis}", "multiply", in1=x, in2=number)
        sines.append(_Float(stage, root, f"Wave{axis}", "multiply", in1=_Float(stage, root, f"Sine{axis}", "sin", **{"in": turns}),
                            in2=height))
    return dict(displacement=_Float(stage, root, "Sum", "add", in1=sines[0], in2=sines[1]))


def _Sheet(path, displace, scheme="none", matrix=np.eye(4), isLeftHanded=False, hasNormals=True):
    """A sheet of few triangles in x and z below a sun and an orthographic camera."""
    stage = author.NewStage(str(path))
    plane = shapes.Plane(1, 1, 3, 3)
    plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals if hasNormals else None, plane.texcoords)
    mesh = author.AddMesh(stage, "/World/Sheet", plane, material=_Material(stage, displace), doubleSided=True,
                          matrix=Gf.Matrix4d(matrix.T.tolist()))
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    if isLeftHanded:
        mesh.CreateOrientationAttr("leftHanded")
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-60, 0, 30)), angle=0.0, intensity=1.0)
    author.AddCamera(stage, eye=(0, 50, 0), target=(0, 0, 0), up=(0, 0, -1), width=8.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return stage


def _Render(stage, size=_SIZE, **settings):
    return ours.Render(stage.GetRootLayer().realPath, size, size, **{"aovs": ("color", "position"), "samples": 16, "maxDepth": 1, **settings})


_STRETCHED = np.array([[1.4, 0.0, 0.2, 0], [0.3, 0.6, 0, 0], [0, 0.1, 1.3, 0], [0, 0, 0, 1]])
_SHEETS = {
    "normals": {},
    "flat": dict(hasNormals=False),
    "catmullClark": dict(scheme="catmullClark"),
    "bilinear": dict(scheme="bilinear"),
    "stretched": dict(scheme="catmullClark", matrix=_STRETCHED),
    "mirrored": dict(scheme="catmullClark", matrix=_STRETCHED @ np.diag([-1, 1, 1, 1])),
    "leftHanded": dict(scheme="catmullClark", isLeftHanded=True),
    "leftHandedFlat": dict(hasNormals=False, isLeftHanded=True, matrix=_STRETCHED),
}


def _Cosines(positions, matrix, side):
    """Between the sun and the displaced surface at world positions [...][3], as mean over the pixels they are the centres of."""
    inverse = np.linalg.inv(matrix[:3, :3])
    places = positions @ inverse.T
    rows, columns = np.gradient(places, axis=(0, 1))
    offsets = (np.arange(8) + 0.5) / 8 - 0.5
    total = 0.0
    for down in offsets:
        for right in offsets:
            at = places + down * rows + right * columns
            slopes = [side * height * number * np.cos(number * at[..., axis]) for axis, (height, number) in zip((0, 2), _WAVES)]
            normal = np.stack([-slopes[0], np.ones_like(slopes[0]), -slopes[1]], -1) @ inverse  # by the transposed inverse
            normal *= np.sign(normal[..., 1:2])
            total = total + np.maximum(0, normal @ _SUN / np.linalg.norm(normal, axis=-1))
    return total / len(offsets) ** 2


@pytest.mark.parametrize("kind", _SHEETS)
def test_a_sheet_shines_as_its_closed_form_does(tmp_path, kind):
    options = _SHEETS[kind]
    matrix = options.get("matrix", np.eye(4))
    side = -1.0 if options.get("isLeftHanded") else 1.0
    settings = dict(subdivision="complexity", refineLevel=1)
    picture = _Render(_Sheet(tmp_path / "waves.usda", _Waves, **options), **settings)
    coarse = _Render(_Sheet(tmp_path / "waves.usda", _Waves, **options), autobump=False, **settings)
    flat = _Render(_Sheet(tmp_path / "flat.usda", None, **options), **settings)
    assert picture.warnings == []
    inner = (slice(8, -8), slice(8, -8))
    up = np.linalg.inv(matrix[:3, :3])[1]
    lit = (up / np.linalg.norm(up) * np.sign(up[1])) @ _SUN
    color = lambda one: one.rgb[..., 0][inner] / flat.rgb[..., 0][inner] * lit  # noqa: E731
    position = flat.layers["position"].astype(np.float64)
    expected = _Cosines(position, matrix, side)[inner]
    assert np.ptp(position[inner][..., 0]) > 0.6 and expected.std() > 0.05
    error, before = (np.sqrt(np.mean((color(one) - expected) ** 2)) for one in (picture, coarse))
    assert before > 0.05 and error < 0.01, (error, before)


def _Noise(stage, root):
    scaled = AddNode(stage, f"{root}/Scaled", "ND_multiply_vector3FA", _T.Vector3f, in2=14.0,
                     in1=AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f))
    return dict(displacement=_Float(stage, root, "Noise", "noise3d", amplitude=0.03, position=scaled))


def _Image(stage, root):
    """Bumps in the red channel, at coordinates that are scaled."""
    folder = stage.GetRootLayer().realPath.rsplit("/", 1)[0]
    s, t = np.meshgrid((np.arange(256) + 0.5) / 256, (np.arange(256) + 0.5) / 256)
    bumps = 0.5 + 0.25 * np.sin(28 * np.pi * s) + 0.25 * np.sin(20 * np.pi * t)
    imageFile.WriteExr(f"{folder}/bumps.exr", dict(R=bumps, G=bumps, B=bumps), half=False)
    coordinates = AddNode(stage, f"{root}/St", "ND_texcoord_vector2", _T.Float2)
    placed = AddNode(stage, f"{root}/Placed", "ND_multiply_vector2FA", _T.Float2, in1=coordinates, in2=2.0)
    return dict(scale=0.03, displacement=AddNode(stage, f"{root}/Image", "ND_image_float", _T.Float, texcoord=placed,
                                                 file=Sdf.AssetPath(f"{folder}/bumps.exr")))


def _Vectors(space):
    """Noise in three components."""
    def Displace(stage, root):
        scaled = AddNode(stage, f"{root}/Scaled", "ND_multiply_vector3FA", _T.Vector3f, in2=14.0,
                         in1=AddNode(stage, f"{root}/Place", "ND_position_vector3", _T.Vector3f))
        return dict(identifier="ND_displacement_vector3", space=space, displacement=AddNode(
            stage, f"{root}/Noise", "ND_noise3d_vector3", _T.Vector3f, amplitude=(0.01, 0.01, 0.03), position=scaled))
    return Displace


def _Ball(path, displace, levelOfDetail=(8, 12)):
    stage = author.NewStage(str(path))
    ball = shapes.Sphere(1.0, *levelOfDetail)
    ball = shapes.Shape(ball.points, ball.counts, ball.indices, None, 0.5 * ball.points[:, :2])
    mesh = author.AddMesh(stage, "/World/Ball", ball, material=_Material(stage, displace, specular=0.3, specular_roughness=0.5),
                          matrix=Gf.Matrix4d(1.0).SetRotate(Gf.Rotation((1, 2, 3), 50)))
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2, 4, 3), rotate=(-50, -30, 0)), width=2.0, height=2.0, intensity=15.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 0, 6), target=(0, 0, 0), width=15.0, aspect=1.0)  # the middle of the ball
    stage.GetRootLayer().Save()
    return stage


@pytest.mark.parametrize("displace", [_Noise, _Image, _Vectors("tangent"), _Vectors("object")], ids=["noise", "image", "tangent", "object"])
def test_few_triangles_look_as_many_do(tmp_path, displace):
    """A ball at level 2, with and without its bumps in the shading, against triangles that have them."""
    stage = _Ball(tmp_path / "ball.usda", displace)
    settings = dict(aovs=("color",), samples=16, maxDepth=2, subdivision="complexity")
    many = _Render(stage, refineLevel=6, autobump=False, **settings).rgb
    errors = []
    for isOn in (True, False):
        picture = _Render(stage, refineLevel=2, autobump=isOn, **settings)
        assert picture.warnings == []
        errors.append(np.mean((picture.rgb - many) ** 2 / (many ** 2 + 0.01)))
    assert errors[1] > 0.01 and errors[0] < 0.2 * errors[1], errors


def test_triangles_that_have_all_keep_their_bits(tmp_path):
    """Pixels far larger than triangles: nothing is added."""
    stage = _Ball(tmp_path / "ball.usda", _Noise)
    pictures = [_Render(stage, 12, subdivision="complexity", refineLevel=5, autobump=isOn) for isOn in (True, False)]
    assert np.array_equal(pictures[0].layers["color"], pictures[1].layers["color"]) and pictures[0].rgb.std() > 0.01


def _Facing(stage, root):
    """The world normal as the material sees it, at least as large as (-1, 1, -1): its second component is 1 everywhere."""
    normal = AddNode(stage, f"{root}/Facing", "ND_normal_vector3", _T.Vector3f, space="world")
    return AddNode(stage, f"{root}/Limited", "ND_max_vector3", _T.Vector3f, in1=normal, in2=(-1.0, 1.0, -1.0))


@pytest.mark.parametrize("isWhole", [True, False], ids=["oneExpression", "partOfOne"])
def test_opacity_that_shares_what_the_normal_gives_changes_nothing(tmp_path, isWhole):
    """Opacity is known before surfaces are bumped; what colours take of the same expression is of the bumped normal even so."""
    pictures = []
    for hasOpacity in (True, False):
        stage = _Sheet(tmp_path / f"waves{hasOpacity}.usda", _Waves)
        root = "/World/Look"
        inputs = dict(diffuseColor=_Facing(stage, root), roughness=0.6)
        if not isWhole:
            inputs["diffuseColor"] = AddNode(stage, f"{root}/Half", "ND_multiply_vector3FA", _T.Vector3f, in1=inputs["diffuseColor"], in2=0.5)
        if hasOpacity:
            inputs["opacity"] = _Float(stage, root, "Opacity", "extract", "vector3", index=1, **{"in": _Facing(stage, root)})
        node, output = AddNode(stage, f"{root}/Preview", "ND_UsdPreviewSurface_surfaceshader", _T.Token, **inputs)
        UsdShade.Material.Get(stage, root).CreateSurfaceOutput("mtlx").ConnectToSource(node.GetOutput(output))
        stage.GetRootLayer().Save()
        picture = _Render(stage, 48)
        assert picture.warnings == []
        pictures.append(picture.layers["color"])
    flat = _Render(stage, 48, autobump=False).layers["color"]
    assert np.array_equal(*pictures) and np.abs(pictures[1] - flat).max() > 0.03


def test_a_preview_surface_is_displaced_by_materialX_too(tmp_path):
    """A displacement beside a UsdPreviewSurface moves as the surface's own input does."""
    pictures = []
    for isOwn in (True, False):
        stage = _Sheet(tmp_path / f"waves{isOwn}.usda", _Waves)
        waves = dict(displacement=(UsdShade.Shader.Get(stage, "/World/Look/Sum"), "out")) if isOwn else {}
        node, output = AddNode(stage, "/World/Look/Preview", "ND_UsdPreviewSurface_surfaceshader", _T.Token, **waves)
        material = UsdShade.Material.Get(stage, "/World/Look")
        material.CreateSurfaceOutput("mtlx").ConnectToSource(node.GetOutput(output))
        if isOwn:
            material.GetDisplacementOutput("mtlx").GetAttr().ClearConnections()
        stage.GetRootLayer().Save()
        pictures.append(_Render(stage, 48, subdivision="complexity", refineLevel=1))
    assert np.array_equal(pictures[0].layers["color"], pictures[1].layers["color"]) and pictures[0].rgb.std() > 0.01


def test_displacement_by_a_primvar_alone_keeps_no_rest_pose(tmp_path):
    """Its triangles have all of it, so pages are as without autobump; noise of the same mesh makes them larger."""
    def ByPrimvar(stage, root):
        return dict(displacement=AddNode(stage, f"{root}/Amount", "ND_geompropvalue_float", _T.Float, geomprop="amount"))
    sizes = {}
    for name, displace in dict(primvar=ByPrimvar, noise=_Noise).items():
        stage = _Ball(tmp_path / f"{name}.usda", displace)
        ball = stage.GetPrimAtPath("/World/Ball")
        amounts = 0.1 * np.cos(1.3 * np.arange(len(ball.GetAttribute("points").Get())))
        UsdGeom.PrimvarsAPI(ball).CreatePrimvar("amount", _T.FloatArray, "vertex").Set(amounts.tolist())
        stage.GetRootLayer().Save()
        for isOn in (True, False):
            picture = _Render(stage, 16, subdivision="complexity", refineLevel=2, autobump=isOn)
            assert picture.warnings == []
            sizes[name, isOn] = picture.statistics["geometry"]["bytesTotal"]
    assert sizes["primvar", True] == sizes["primvar", False] and sizes["noise", True] > 1.2 * sizes["noise", False]


_BALLS = (dict(translate=(-0.6, 0, 0), rotate=(20, 40, 60), scale=(0.5, 0.5, 0.5)), dict(translate=(0.7, 0.2, 0), scale=(0.7, 0.4, 0.5)))


@pytest.mark.parametrize("scheme", ["none", "catmullClark"])
@pytest.mark.parametrize("kind", ["points", "native"])
def test_instances_are_bumped_as_meshes_of_their_own(tmp_path, kind, scheme):
    def Write(isInstanced):
        stage = author.NewStage(str(tmp_path / f"{isInstanced}.usda"))
        material = _Material(stage, _Noise)
        ball = shapes.Sphere(1.0, 8, 12)
        root = {"points": "/World/Balls/Ball", "native": "/World/Prototype/Ball"}[kind]
        if isInstanced and kind == "points":
            instancer = UsdGeom.PointInstancer.Define(stage, "/World/Balls")
            instancer.CreatePrototypesRel().AddTarget(root)
            instancer.CreateProtoIndicesAttr([0] * len(_BALLS))
            instancer.CreatePositionsAttr([place["translate"] for place in _BALLS])
            turns = [Gf.Rotation((1, 0, 0), r[0]) * Gf.Rotation((0, 1, 0), r[1]) * Gf.Rotation((0, 0, 1), r[2])
                     for r in (place.get("rotate", (0, 0, 0)) for place in _BALLS)]
            instancer.CreateOrientationsAttr([Gf.Quath(turn.GetQuat()) for turn in turns])
            instancer.CreateScalesAttr([place["scale"] for place in _BALLS])
        if isInstanced:
            mesh = author.AddMesh(stage, root, ball, material=material)
            mesh.GetSubdivisionSchemeAttr().Set(scheme)
            if kind == "native":
                stage.GetPrimAtPath("/World/Prototype").SetSpecifier(Sdf.SpecifierOver)
                for number, place in enumerate(_BALLS):
                    copy = UsdGeom.Xform.Define(stage, f"/World/Copy{number}")
                    copy.GetPrim().GetReferences().AddInternalReference("/World/Prototype")
                    author.Place(copy, **place)
                    copy.GetPrim().SetInstanceable(True)
        else:
            for number, place in enumerate(_BALLS):
                author.AddMesh(stage, f"/World/Ball{number}", ball, material=material, **place).GetSubdivisionSchemeAttr().Set(scheme)
        author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2, 4, 3), rotate=(-50, -30, 0)), width=2.0, height=2.0, intensity=15.0)
        author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
        author.AddCamera(stage, eye=(0, 0, 4), target=(0, 0, 0), width=30.0, aspect=1.0)
        stage.GetRootLayer().Save()
        return stage
    settings = dict(aovs=("color",), maxDepth=2, subdivision="complexity", refineLevel=1)
    instances, coarse, meshes = (_Render(Write(isInstanced), 64, autobump=isOn, **settings).rgb
                                 for isInstanced, isOn in ((True, True), (True, False), (False, True)))
    error, other = (np.mean((one - meshes) ** 2 / (meshes ** 2 + 0.01)) for one in (instances, coarse))
    assert other > 3e-4 and error < 1e-3 * other, (error, other)


def _Bent(stage, keys):
    """The sheet's points at frames: {frame: how far its columns are lifted}."""
    mesh = UsdGeom.Mesh.Get(stage, "/World/Sheet")
    points = np.array(mesh.GetPointsAttr().Get())
    for frame, height in keys.items():
        bent = points.copy()
        bent[:, 1] += height * bent[:, 0] ** 2
        mesh.GetPointsAttr().Set(bent, frame)
    stage.GetRootLayer().Save()
    return stage


def _AtFrame(stage, frame, **settings):
    renderer = hdstream.Renderer(stage.GetRootLayer().realPath)
    return renderer.Render(frame, camera="/World/Camera", imageWidth=48, imageHeight=48, maxDepth=1, noCache=True, **settings).aovs["color"]


def test_deformed_meshes_are_bumped_where_they_rest_in_the_frame(tmp_path):
    """Points at a frame are those of a mesh that has them at all times; while the shutter is open normals are the triangles'."""
    settings = dict(subdivision="complexity", refineLevel=1, samples=4)
    moving = _Bent(_Sheet(tmp_path / "moving.usda", _Waves), {1: 0.0, 3: 0.4})
    still = _Bent(_Sheet(tmp_path / "still.usda", _Waves), {1: 0.2})
    seen, expected, coarse = (_AtFrame(one, 2.0, motionBlur="off", autobump=isOn, **settings)
                              for one, isOn in ((moving, True), (still, True), (moving, False)))
    assert np.array_equal(seen, expected) and np.abs(seen - coarse).max() > 0.01
    UsdGeom.Camera.Get(moving, "/World/Camera").CreateShutterCloseAttr(0.5)
    moving.GetRootLayer().Save()
    blurred, triangles = (_AtFrame(moving, 2.0, autobump=isOn, **settings) for isOn in (True, False))
    assert np.array_equal(blurred, triangles) and np.abs(blurred - seen).max() > 0.01


@pytest.mark.parametrize("name", ["hdstream:autobump", "arnold:autobump"])
def test_a_prim_may_refuse(tmp_path, name):
    stage = _Ball(tmp_path / "ball.usda", _Noise)
    settings = dict(subdivision="complexity", refineLevel=1)
    bumped, coarse = (_Render(stage, 32, autobump=isOn, **settings).layers["color"] for isOn in (True, False))
    UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Ball")).CreatePrimvar(name, _T.Bool, "constant").Set(False)
    stage.GetRootLayer().Save()
    assert np.array_equal(_Render(stage, 32, **settings).layers["color"], coarse) and not np.array_equal(bumped, coarse)


def test_bits_do_not_depend_on_pools_of_textures_and_geometry(tmp_path):
    stage = _Ball(tmp_path / "ball.usda", _Image)
    settings = dict(subdivision="complexity", refineLevel=2, maxDepth=3)
    whole = _Render(stage, 40, residency="resident", **settings).layers["color"]
    streamed = _Render(stage, 40, residency="stream", chunkBytes=1 << 14, geometryMemory="20%", textureMemory="40%", **settings)
    assert np.array_equal(whole, streamed.layers["color"]) and whole.std() > 0.01
