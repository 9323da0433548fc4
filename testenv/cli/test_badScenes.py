# SPDX-License-Identifier: Apache-2.0
"""Broken scene content renders: a warning a prim, exit code 0, an image of finite numbers."""

import zipfile

import pytest

from cliCase import SCENE, SMALL, Run, RunHere, WriteStage

MESH = """def Mesh "{name}"
{{
    int[] faceVertexCounts = {counts}
    int[] faceVertexIndices = {indices}
    point3f[] points = {points}
    uniform token subdivisionScheme = "none"
    {more}
}}
"""
POINTS = "[(-1, -1, 1), (1, -1, 1), (0, 1, 1)]"


def BadMesh(counts="[3]", indices="[0, 1, 2]", points=POINTS, more=""):
    return MESH.format(name="Bad", counts=counts, indices=indices, points=points, more=more)


MATRIX = "matrix4d xformOp:transform = {}\nuniform token[] xformOpOrder = [\"xformOp:transform\"]"
SURFACE = """def Material "Look"
{{
    token outputs:surface.connect = </Look/Surface.outputs:surface>
    def Shader "Surface"
    {{
        uniform token info:id = "{identifier}"
        {inputs}
        token outputs:surface
    }}
    def Shader "Texture"
    {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @none/such.png@
        float3 outputs:rgb
    }}
}}
"""


def Bound(identifier, inputs=""):
    mesh = BadMesh(more="rel material:binding = </Look>").replace(
        '"Bad"', '"Bad" (prepend apiSchemas = ["MaterialBindingAPI"])')
    return mesh + SURFACE.format(identifier=identifier, inputs=inputs)


@pytest.mark.parametrize("body, subject", [
    (BadMesh(indices="[0, 1, 7]"), "/Bad"),
    (BadMesh(indices="[0, 1, -1]"), "/Bad"),
    (BadMesh(counts="[3, 3]"), "/Bad"),
    (BadMesh(counts="[-3]"), "/Bad"),
    (BadMesh(points="[(nan, 0, 0), (1, 0, 0), (0, 1, 0)]"), "/Bad"),
    (BadMesh(points="[(inf, 0, 0), (1, 0, 0), (0, 1, 0)]"), "/Bad"),
    (BadMesh(points="[(0, 0, 0), (0, 0, 0), (0, 0, 0)]"), "/Bad"),
    (BadMesh(more=MATRIX.format("((1, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 1))")), "/Bad"),
    (BadMesh(more=MATRIX.format("((0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 1))")), "/Bad"),
    (BadMesh(more=MATRIX.format("((nan, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))")), "/Bad"),
    (Bound("NoSuchShader"), "/Look"),
    (Bound("UsdPreviewSurface", "color3f inputs:diffuseColor.connect = </Look/Texture.outputs:rgb>"), "/Look"),
    ('def DomeLight "Sky" { asset inputs:texture:file = @none/sky.exr@\n}\n', "/Sky"),
    ('def "Ref" (references = @none.usda@) { }\n', "/Ref"),
    ('def SphereLight "Lamp" { color3f inputs:color = (3.4e38, 1, 1)\nfloat inputs:intensity = 8\n}\n', "/Lamp"),
    (BadMesh(more='uniform token[] xformOpOrder = ["raw"]'), "/Bad"),
])
def test_bad_content_warns_and_renders(tmp_path, body, subject):
    result = Run("record", WriteStage(tmp_path, SCENE + body), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors, result.text
    assert any(line.startswith(subject) for line in result.warnings), result.text
    assert Finite(tmp_path / "o.exr")


def Finite(path):
    from hdstream import _core
    comparison = _core.CompareImages(str(path), str(path))
    assert not comparison.error
    return all(layer.numNonFinite == 0 for layer in comparison.layers)


_TEXTURED = Bound("UsdPreviewSurface", "color3f inputs:diffuseColor.connect = </Look/Texture.outputs:rgb>")
_FALLBACK = "/Look: cannot read image {name} of /Look/Texture{why}; its fallback is used"


def test_an_image_that_is_not_there_is_told_so(tmp_path):
    result = RunHere("record", WriteStage(tmp_path, SCENE + _TEXTURED), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and result.warnings == [_FALLBACK.format(name="none/such.png", why=": no such file")]


def test_an_image_that_is_compressed_in_its_package_is_told_so(tmp_path):
    """OpenUSD finds it, and packages are not to compress what they hold: `info` says why it is not read."""
    stage = WriteStage(tmp_path, SCENE + _TEXTURED.replace("none/such.png", "./image.png"))
    with zipfile.ZipFile(tmp_path / "scene.usdz", "w") as archive:
        archive.write(stage, "scene.usda")
        archive.writestr("image.png", bytes(1000), zipfile.ZIP_DEFLATED)
    result = RunHere("record", tmp_path / "scene.usdz", tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and result.warnings == [_FALLBACK.format(name="./image.png", why="")], result.text
    assert "./image.png: is compressed or damaged in its package" in RunHere("info", tmp_path / "scene.usdz").text


def test_displacement_without_end_is_not_laid_to_the_transform(tmp_path):
    body = Bound("UsdPreviewSurface", "float inputs:displacement = 1e30\ntoken outputs:displacement").replace(
        "token outputs:surface.connect", "token outputs:displacement.connect = </Look/Surface.outputs:displacement>\ntoken outputs:surface.connect")
    result = Run("record", WriteStage(tmp_path, SCENE + body), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors, result.text
    assert [line for line in result.warnings if line.startswith("/Bad: ") and "its place or size is not finite" in line], result.text


def test_empty_stage(tmp_path):
    result = Run("record", WriteStage(tmp_path, ""), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors, result.text
    assert any("nothing to draw" in line for line in result.warnings), result.text
    assert Finite(tmp_path / "o.exr")
    assert Run("info", WriteStage(tmp_path, "")).code == 0


@pytest.mark.parametrize("body", [
    'def Camera "main_cam" { float focalLength = 0\n}\n',
    'def Camera "main_cam" { float horizontalAperture = 0\n}\n',
    'def Camera "main_cam" { float2 clippingRange = (0, 0)\n}\n',
])
def test_degenerate_cameras_do_not_crash(tmp_path, body):
    from cliCase import TRIANGLE
    result = Run("record", WriteStage(tmp_path, TRIANGLE + body), tmp_path / "o.exr", *SMALL)
    assert result.code in (0, 1) and "Traceback" not in result.text, result.text


@pytest.mark.parametrize("translate, isUsable", [("(nan, 0, 5)", False), ("(0, 0, inf)", False), ("(0, 0, 5)", True)])
def test_cameras_without_a_place_are_told(tmp_path, translate, isUsable):
    from cliCase import TRIANGLE
    body = f'def Camera "main_cam" {{ double3 xformOp:translate = {translate}\nuniform token[] xformOpOrder = ["xformOp:translate"]\n}}\n'
    result = Run("record", WriteStage(tmp_path, TRIANGLE + body), tmp_path / "o.exr", *SMALL, "--camera", "/main_cam")
    assert result.code == 0 and not result.errors, result.text
    told = [line for line in result.warnings if "/main_cam" in line]
    assert [line.partition(" or not finite")[0] for line in told] == (
        [] if isUsable else ["/main_cam: a camera whose transform is singular"]), result.text
    assert Finite(tmp_path / "o.exr")


PLACE = 'double3 xformOp:translate = (0, 0, 5)\nuniform token[] xformOpOrder = ["xformOp:translate"]\n'


@pytest.mark.parametrize("numbers, meant, expected", [
    ("float focalLength = 0\nfloat fStop = 1\nfloat focusDistance = 3", "float focalLength = 10", "focalLength is 0;"),
    ("float focalLength = nan", "", "focalLength is not finite; 50 is used"),
    ("float horizontalAperture = inf", "", "aperture is not above 0; 20.955 x 15.2908 is used"),
    ("float horizontalApertureOffset = nan", "", "horizontalApertureOffset is not finite; 0 is used"),
    ("float2 clippingRange = (nan, 1)", "", "clippingRange is not a number; (1, 1000000) is used"),
    ("float2 clippingRange = (5, 1)", "float2 clippingRange = (5, 1)", "clippingRange is empty;"),
    ("float fStop = 1\nfloat focusDistance = inf", "float fStop = 1\nfloat focusDistance = 1e18", ""),
    ("float fStop = nan\nfloat focusDistance = 3", "", "fStop is not finite; 0 is used"),
    ("float fStop = -1\nfloat focusDistance = 3", "", "fStop is below 0; everything is in focus"),
    ("float fStop = 1\nfloat focusDistance = nan", "", "focusDistance is not a number; everything is in focus"),
    ("float exposure = nan", "", "the factor of its exposure is not finite; 1 is used"),
    ("float exposure = 1000", "", "the factor of its exposure is not finite; 1 is used"),
    ("float exposure:fStop = 0", "", "the factor of its exposure is not finite; 1 is used"),
    ("double shutter:open = nan\ndouble shutter:close = 1", "double shutter:close = 1", "shutter:open is nan, and no finite number; 0 is used"),
    ("double shutter:open = 1\ndouble shutter:close = -1", "", "its shutter closes at -1 before it opens at 1; nothing moves"),
    ('token projection = "fisheye"', "", "projection fisheye is unknown; perspective is used"),
])
def test_numbers_of_cameras_become_what_is_said(tmp_path, numbers, meant, expected):
    """The picture is, to the bit, that of the camera that is meant."""
    from cliCase import TRIANGLE
    pictures = []
    for name, body in (("odd", numbers), ("meant", meant)):
        camera = f'def Camera "main_cam" {{ {body}\n{PLACE} }}\n'
        result = Run("record", WriteStage(tmp_path, TRIANGLE + camera), tmp_path / f"{name}.exr", *SMALL, "--camera", "/main_cam")
        assert result.code == 0 and not result.errors, result.text
        told = [line for line in result.warnings if line.startswith("/main_cam: ")]
        isTold = bool(expected) and (name == "odd" or "empty" in expected)
        assert len(told) == isTold and (not isTold or told[0].startswith(f"/main_cam: {expected}")), result.text
        pictures.append(tmp_path / f"{name}.exr")
    from hdstream import _core
    layers = _core.CompareImages(*map(str, pictures)).layers
    assert layers and all(layer.maxAbs == 0 and layer.numNonFinite == 0 for layer in layers)


def test_instances_whose_turn_is_no_number_are_dropped(tmp_path):
    """As for OpenUSD, whose matrix of it is none."""
    body = """def PointInstancer "Crowd" {
    rel prototypes = [</Crowd/Ball>]
    int[] protoIndices = [0, 0, 0]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    quath[] orientations = [(nan, 0, 0, 0), (1, 0, 0, 0), (inf, 0, 0, 0)]
    def Sphere "Ball" { double radius = 0.2 }
}
"""
    result = Run("record", WriteStage(tmp_path, SCENE + body), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and Finite(tmp_path / "o.exr"), result.text
    assert [line for line in result.warnings if line.startswith("/Crowd: 2 instances dropped")], result.text


@pytest.mark.parametrize("leaf", ['Sphere "In40" { }', 'SphereLight "In40" { }'])
def test_instancers_that_multiply_without_end_are_told(tmp_path, leaf):
    """Each of the chain places the next twice: 2^40 leaves, deeper than groups are kept."""
    body, ends = "", ""
    for i in range(40):
        body += f'def PointInstancer "In{i}" {{ rel prototypes = [<In{i + 1}>]\n int[] protoIndices = [0, 0]\n'
        body += ' point3f[] positions = [(0, 0, 0), (1, 0, 0)]\n'
        ends += "}\n"
    result = Run("record", WriteStage(tmp_path, SCENE + body + f"def {leaf}\n" + ends), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and Finite(tmp_path / "o.exr"), result.text
    told = [line for line in result.warnings if "In40: placed more than 16777216 times" in line]
    assert len(told) == 1, result.text


def test_a_focal_length_of_0_has_the_frustum_of_openusd():
    from pxr import Gf
    windows = [Gf.Camera(focalLength=length).frustum.window for length in (0.0, 10.0)]
    assert windows[0] == windows[1]


def test_extreme_lights_stay_finite(tmp_path):
    """Sums of samples and of their squares would not be."""
    lamp = 'def SphereLight "Lamp" { float inputs:intensity = 1e29\nfloat inputs:radius = 100\n}\n'
    result = Run("record", WriteStage(tmp_path, SCENE + lamp), tmp_path / "o.exr", *SMALL, "--aovs", "color,variance", "--samples", "40")
    assert result.code == 0 and not result.errors and not result.warnings, result.text
    assert Finite(tmp_path / "o.exr")


def test_a_camera_that_cannot_be_read_is_an_error(tmp_path):
    from cliCase import TRIANGLE, AssertFails
    body = TRIANGLE + 'def Camera "main_cam" { uniform token[] xformOpOrder = ["Sky"]\n}\n'
    AssertFails(Run("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL), 1, "/main_cam", "Invalid xform op")


def test_instancers_that_place_themselves_have_no_bounds(tmp_path):
    """OpenUSD looks for their bounds until the stack is full; found by fuzzing."""
    body = """def Xform "Model" (
    prepend apiSchemas = ["GeomModelAPI"]
    kind = "component"
)
{
    uniform token model:drawMode = "bounds"
    uniform bool model:applyDrawMode = 1
    def PointInstancer "A"
    {
        point3f[] positions = [(0, 0, 0)]
        int[] protoIndices = [0]
        rel prototypes = </Other>
    }
}
def Xform "Other"
{
    def PointInstancer "B"
    {
        point3f[] positions = [(0, 0, 0)]
        int[] protoIndices = [0]
        rel prototypes = </Model>
    }
}
def Sphere "Ball"
{
}
"""
    result = Run("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors, result.text
    assert any("/Model: bounds of a model without extent; left out" in line for line in result.warnings), result.text


def test_a_stage_without_bounds_is_framed(tmp_path):
    from cliCase import TRIANGLE
    body = TRIANGLE + BadMesh(more='uniform token[] xformOpOrder = ["raw"]')
    result = Run("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors, result.text
    assert any(line.startswith("/Bad: cannot be read: Invalid xform op") for line in result.warnings), result.text
