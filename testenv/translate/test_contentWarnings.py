# SPDX-License-Identifier: Apache-2.0
"""Odd scene content becomes a warning that names the prim, never an exception."""

import pytest
from pxr import Usd, UsdGeom

from hdstream.diagnostics import Diagnostics
from translateCase import StageOf, Translate

TRIANGLE = """int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0, 1, 2]
point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
"""
LOOK = """def Mesh "B" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    rel material:binding = </M>
}}
def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    float3 inputs:empty
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = {source}
        token outputs:surface
    }}
    def Shader "T" {{
        uniform token info:id = "UsdPrimvarReader_float3"
        string inputs:varname = "displayColor"
        float3 outputs:result
    }}
}}
"""


def WarningsOf(text):
    diagnostics = Diagnostics()
    session = Translate(StageOf(text))
    diagnostics.WarnOf(session)
    return session.Warnings()


@pytest.mark.parametrize("text, expected", [
    ('def Mesh "M" { int points = 7\nint[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2] }',
     "/M: cannot be read"),
    (f'def Mesh "M" {{ {TRIANGLE}\nint subdivisionScheme = 1\nfloat2 orientation = (0, 1) }}',
     "/M: cannot be read: orientation cannot be a float2; subdivisionScheme cannot be a int"),
    (f'def Mesh "M" {{ {TRIANGLE}\nfloat[] purpose = [1] }}', "/M: cannot be read: purpose cannot be a float[]"),
    (f'def Mesh "M" {{ {TRIANGLE}\ndouble holeIndices = inf }}', "/M: cannot be read: holeIndices cannot be a double"),
    (f'def Mesh "M" {{ {TRIANGLE}\nuint64 cornerIndices = 18446744073709551615 }}',
     "/M: cannot be read: cornerIndices cannot be a uint64"),
    ('def Sphere "S" { string radius = "x" }', "/S: cannot be read: radius cannot be a string"),
    ('def NurbsCurves "N" { point3f[] points = [(0, 0, 0), (1, 0, 0)]\nint[] curveVertexCounts = [2]\nint[] order = [2]\n'
     'float knots = 1 }', "/N: cannot be read: knots cannot be a float"),
    ('def PointInstancer "P" { float3[] protoIndices = [(0, 0, 1)]\npoint3f[] positions = [(0, 0, 0)]\n'
     'rel prototypes = </P/S>\ndef Sphere "S" {} }', "/P: cannot be read: protoIndices cannot be a float3[]"),
    ('def PointInstancer "P" { int[] protoIndices = [0, 0]\npoint3f[] positions = [(0, 0, 0)]\n'
     'rel prototypes = </P/S>\ndef Sphere "S" {} }', "/P: point instancer not drawn: 2 protoIndices but 1 positions"),
    ('def PointInstancer "P" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </None> }',
     "/P: prototype /None does not exist"),
    ('def PointInstancer "P" { int[] protoIndices = [0, 3, -1]\npoint3f[] positions = [(0,0,0), (1,0,0), (2,0,0)]\n'
     'rel prototypes = </P/S>\ndef Sphere "S" {} }', "/P: 2 instances have no prototype"),
    ('def PointInstancer "P" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </P> }',
     "/P: point instancer is its own prototype"),
    ('def PointInstancer "P" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </P/S>\n'
     'float[] primvars:a = [1, 2] (interpolation = "vertex")\ndef Sphere "S" {} }',
     "/P: primvar a has 2 values for 1 instances; ignored"),
    ('def PointInstancer "P" { int[] protoIndices = [0, 0]\npoint3f[] positions = [(0, 0, 0), (1, 0, 0)]\n'
     'rel prototypes = </P/S>\nfloat[] primvars:a = [1] (interpolation = "vertex")\nint[] primvars:a:indices = [0, 5]\n'
     'def Sphere "S" {} }', "/P: primvar a has indices out of range; ignored"),
    ('def TetMesh "T" { point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\nint4[] tetVertexIndices = [(0, 1, 2, 3)]\n'
     'def GeomSubset "A" { uniform token elementType = "tetrahedron"\nuniform token familyName = "materialBind"\n'
     'int[] indices = [0] } }', "/T/A: a subset of elements of type tetrahedron binds no material: those of faces alone do"),
    (f'def PointInstancer "P" {{ int[] protoIndices = {[0] * 65}\npoint3f[] positions = {[(0, 0, 0)] * 65}\n'
     f'rel prototypes = </P/S>\nfloat[] primvars:widths = {list(range(65))} (interpolation = "vertex")\n'
     'def Sphere "S" {}\ndef Cube "T" {} }',
     "/P: more than 64 different values by instance of primvars that are read once a prim"),
    ('def PointInstancer "P" { int[] protoIndices = [0, 0]\npoint3f[] positions = [(0, 0, 0), (1, 0, 0)]\n'
     'rel prototypes = </P/Q>\nfloat[] primvars:widths = [1, 2] (interpolation = "vertex")\n'
     'def PointInstancer "Q" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </P/Q/S>\n'
     'def Sphere "S" {} } }', "/P/Q/S: primvars that are read once a prim differ between instances of an outer instancer"),
    ('def PointInstancer "P" { int[] protoIndices = [0, 0, 0]\npoint3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]\n'
     'int64[] ids = [1, 2]\nint64[] invisibleIds = [1]\nrel prototypes = </P/S>\ndef Sphere "S" {} }',
     "/P: 2 ids but 3 instances"),
    ('def Sphere "S" { uniform token purpose = "proxies" }', "/S: purpose proxies is unknown; not drawn"),
    (f'def Mesh "M" {{ {TRIANGLE}\ncolor3f[] primvars:displayColor = [(1, 0, 0)] (interpolation = "weird") }}',
     "/M: primvars:displayColor has the unknown interpolation weird; left out"),
    ('def "A" (references = </A>) {}', "/A: Cycle detected: "),
    ('def "A" (references = </B>) {}\ndef "B" (references = </A>) {}', "/B: Cycle detected: "),
    (LOOK.format(source="</M/None.outputs:rgb>"), "/M/S: input diffuseColor is connected to /M/None.outputs:rgb, which does not exist"),
    (LOOK.format(source="</M/T.outputs:xyz>"), "/M/S: input diffuseColor is connected to /M/T.outputs:xyz, which does not exist"),
    (f'def Mesh "M" {{ {TRIANGLE}\nuniform token orientation = "up" }}', "/M: orientation up is unknown; rightHanded is used"),
    ('def ParticleField "A" {}\ndef ParticleField "B" {}', "/A: ParticleField is not supported yet: 2 prims skipped"),
    ('def Cone "C" { uniform token axis = "x" }', "/C: axis x is unknown; Z is used"),
    ('def Sphere "S" { token visibility = "hidden" }', "/S: visibility hidden is unknown; inherited is used"),
    (f'def Mesh "M" (prepend apiSchemas = ["MeshLightAPI"]) {{ {TRIANGLE}\nuniform token light:materialSyncMode = "glow" }}',
     "/M: light:materialSyncMode glow is unknown; noMaterialResponse is used"),
    ('def NurbsCurves "N" { int[] curveVertexCounts = [2]\npoint3f[] points = [(0, 0, 0), (1, 0, 0)] }',
     "/N: NurbsCurves are drawn as lines between their points: 1 prim"),
    ('def BasisCurves "C" { uniform token basis = "power"\nint[] curveVertexCounts = [4]\n'
     'point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)] }',
     "/C: curve basis power is unknown; drawn as bezier"),
    (f'def Mesh "M" (prepend apiSchemas = ["MeshLightAPI"]) {{ {TRIANGLE}\nrel light:filters = </F> }}',
     "/M: light filter /F is not supported yet"),
    ('def Points "P" (prepend apiSchemas = ["LightAPI"]) { point3f[] points = [(0, 0, 0)] }',
     "/P: LightAPI makes lights of what has faces, and none of Points: 1 prim"),
    ('def Volume "V" (prepend apiSchemas = ["VolumeLightAPI"]) {}',
     "/V: LightAPI makes lights of what has faces, and none of Volume: 1 prim"),
    ('def RectLight "L" { string inputs:intensity = "bright" }', "/L: inputs:intensity cannot be a string; not read"),
    ('def SphereLight "L" { color3f inputs:shaping:focus = (1, 1, 1) }',
     "/L: inputs:shaping:focus cannot be a float3; not read"),
    ('def RectLight "L" { string inputs:texture:file = "a.exr" }', "/L: inputs:texture:file cannot be a string; not read"),
    ('def DomeLight_1 "L" { uniform token poleAxis = "X" }', "/L: poleAxis X is unknown; Y is used"),
    ('def PointInstancer "P" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </C/S> }\n'
     'class "C" { def Sphere "S" {} }', "/P: prototype /C/S is abstract, or below a class"),
    ('def PointInstancer "P" { int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\nrel prototypes = </P/S>\n'
     'def Sphere "S" (active = false) {} }', "/P: prototype /P/S is not active"),
    ('def Mesh "M" (prepend apiSchemas = ["MeshLightAPI"]) {}', "/M: mesh light has no faces; it lights nothing"),
    ('def RectLight "L" { rel light:filters = [</F>, </G>] }', "/L: light filter /F does not exist; left out"),
    ('def RectLight "L" { rel light:filters = [</F>, </G>] }', "/L: light filter /G does not exist; left out"),
    ('def SphereLight "L" { color3f inputs:color.connect = </S.outputs:out> }', "/L: a shader on inputs:color is not supported yet"),
    (f'def Mesh "M" (prepend apiSchemas = ["MeshLightAPI"]) {{ {TRIANGLE}\ncolor3f inputs:color = (1, 0, 0)\n'
     'color3f inputs:color.connect = </S.outputs:out> }', "/M: a shader on inputs:color is not supported yet"),
    (f'def Mesh "M" {{ {TRIANGLE}\ntoken material:binding = "x" }}\ndef Mesh "N" {{ {TRIANGLE} }}',
     "/M: its material binding cannot be read: "),
    ('def "R" (references = @none.usda@) {}', "/R: Could not open asset @none.usda@"),
])
def test_one_line_names_the_prim(text, expected):
    warnings = WarningsOf(text)
    assert len([line for line in warnings if line.startswith(expected)]) == 1, warnings
    assert all("\n" not in line for line in warnings)


def test_bindings_without_their_schema_are_one_line():
    """OpenUSD has one a prim, and some exporters' stages are full of such prims."""
    prims = "".join(f'def Sphere "{name}" {{ rel material:binding = </M> }}\n' for name in ("E", "C", "D"))
    look = LOOK.format(source="</M/T.outputs:result>")
    assert WarningsOf(prims + look) == ["/C: material bindings without MaterialBindingAPI, which not every OpenUSD takes: 3 prims"]
    assert WarningsOf(look) == []


@pytest.mark.parametrize("text", ['def "A" (references = </A>) {}', 'def "A" (references = </B>) {}\ndef "B" (references = </A>) {}'])
def test_a_cycle_of_references_is_one_line_a_prim(text):
    warnings = WarningsOf(text)
    assert len(warnings) == text.count("def") and not any("@anon" in line and "session" in line for line in warnings), warnings


@pytest.mark.parametrize("numIds, expected", [(2, [1, 2]), (3, [1, 2]), (5, [1, 2])])
def test_ids_that_do_not_match_hide_what_they_name(numIds, expected):
    """UsdGeomPointInstancer has an id an instance; the first of three is hidden."""
    session = Translate(StageOf(
        'def PointInstancer "P" { int[] protoIndices = [0, 0, 0]\npoint3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]\n'
        f'int64[] ids = {list(range(7, 7 + numIds))}\nint64[] invisibleIds = [7]\nrel prototypes = </P/S>\ndef Sphere "S" {{}} }}'))
    assert list(session.Scene().geometry["/P/S"].placement.instances) == expected


CLIPS = """def "A" (clips = {{ dictionary default = {{ string primPath = "/A"\n{clips} }} }})
{{ def Mesh "M" {{ int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2] }} }}
"""
EXPLICIT = "asset[] assetPaths = [@./there.usda@, @./none.usda@]\ndouble2[] active = [(0, 0), (3, 1)]\ndouble2[] times = [(0, 0), (9, 9)]"
TEMPLATE = ('string templateAssetPath = "./{0}.##.usda"\ndouble templateStartTime = 1\ndouble templateEndTime = 4\n'
            'double templateStride = 1')


@pytest.mark.parametrize("clips, numPoints, expected", [
    (EXPLICIT.replace(", @./none.usda@", "").replace(", (3, 1)", ""), 3, []),
    (EXPLICIT, 0, ["/A: value clip ./none.usda does not exist; it has no values"]),
    (EXPLICIT + "\nasset manifestAssetPath = @./none.usda@", 0,
     ["/A: the manifest ./none.usda of its value clips does not exist; they are not used",
      "/A: value clip ./none.usda does not exist; it has no values"]),
    (TEMPLATE.format("all"), 3, []),
    (TEMPLATE.format("some"), 3, ["/A: 2 of 4 value clips ./some.##.usda do not exist; those that do fill their times"]),
    (TEMPLATE.format("none"), 0, ["/A: none of 4 value clips ./none.##.usda exists"]),
])
def test_value_clips_that_are_not_there(tmp_path, clips, numPoints, expected):
    """OpenUSD itself is silent on templates, and names no prim on files."""
    clip = '#usda 1.0\ndef "A"\n{\ndef Mesh "M"\n{\npoint3f[] points.timeSamples = {0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)]}\n}\n}\n'
    for name in ("there", "all.01", "all.02", "all.03", "all.04", "some.01", "some.03"):
        (tmp_path / f"{name}.usda").write_text(clip)
    (tmp_path / "stage.usda").write_text("#usda 1.0\n" + CLIPS.format(clips=clips).replace("}", "\n}\n"))
    diagnostics = Diagnostics()
    session = Translate(Usd.Stage.Open(str(tmp_path / "stage.usda")), 4.0)
    diagnostics.WarnOf(session)
    assert sorted(session.Warnings()) == expected
    points = [prim.geometry.points for prim in session.Scene().geometry.values()]
    assert sum(len(array) for array in points) in (numPoints, 3 * numPoints)


@pytest.mark.parametrize("text", [
    LOOK.format(source="</M/T.outputs:result>"), LOOK.format(source="</M.inputs:empty>"),
    "", 'def "A" {}', 'def Mesh "M" {}', f'def Mesh "M" {{ {TRIANGLE} }}', 'def Camera "C" {}',
    'def RectLight "L" (prepend apiSchemas = ["ShapingAPI"]) { float inputs:shaping:cone:angle = 90 }',
])
def test_ordinary_scenes_have_no_warnings(text):
    assert WarningsOf(text) == []


def test_a_bad_prim_does_not_hide_its_children():
    text = (f'def Mesh "M" {{ int points = 7\nint[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n'
            f'def Mesh "Child" {{ {TRIANGLE} }} }}')
    assert list(Translate(StageOf(text)).Scene().geometry) == ["/M/Child"]


def test_deep_hierarchies_are_walked():
    """Deeper than Python's recursion limit."""
    stage = Usd.Stage.CreateInMemory()
    path = ""
    for level in range(1500):
        path += f"/g{level}"
    stage.DefinePrim(path, "Xform")
    UsdGeom.Sphere.Define(stage, path + "/ball")
    assert len(Translate(stage).Scene().geometry) == 1
