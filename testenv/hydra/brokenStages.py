# SPDX-License-Identifier: Apache-2.0
"""Stages that open and are wrong inside: BROKEN, name -> text of a .usda file."""


def _Mesh(points="[(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]", counts="[4]", indices="[0, 1, 2, 3]",
          scheme="none", more="", metadata=""):
    return f"""def Mesh "M" {metadata}
{{
    point3f[] points = {points}
    int[] faceVertexCounts = {counts}
    int[] faceVertexIndices = {indices}
    uniform token subdivisionScheme = "{scheme}"
    {more}
}}
"""


_MATERIAL_LOOP = """def Material "L"
{
    token outputs:surface.connect = </L/S.outputs:surface>
    def Shader "S"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </L/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        float2 inputs:st.connect = </L/T.outputs:rgb>
        float3 outputs:rgb
    }
}
"""
# No loop of prototypes, which overflows the stack of OpenUSD 24.11's UsdImaging with any renderer, and no
# negative index, which it reads from before its arrays.
_PROTOTYPE_BEYOND = """def PointInstancer "P"
{
    rel prototypes = [</P/Q>, </P/Missing>]
    int[] protoIndices = [0, 7, 1]
    point3f[] positions = [(0, 0, 0)]
    def Sphere "Q"
    {
    }
}
"""
_MISSING_TEXTURE = """def DomeLight "D"
{
    asset inputs:texture:file = @nothing.exr@
}
"""
_BOUND_TO_NOTHING = 'rel material:binding = </Nothing>'
_SHORT_PRIMVAR = """color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (
        interpolation = "vertex"
    )"""
_SUBSET_BEYOND = """uniform token subsetFamily:materialBind:familyType = "partition"
    def GeomSubset "Part"
    {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0, 5, -3]
    }"""
_API = '(\n    prepend apiSchemas = ["MaterialBindingAPI"]\n)'

BROKEN = {name: "#usda 1.0\n" + text for name, text in {
    "indexBeyondPoints": _Mesh(indices="[0, 1, 2, 9]"),
    "countsBeyondIndices": _Mesh(counts="[4, 4]"),
    "negativeCount": _Mesh(counts="[-4]"),
    "noPoints": _Mesh(points="[]"),
    "notANumber": _Mesh(points="[(nan, -1, 0), (1, inf, 0), (1, 1, 0), (-1, 1, 0)]"),
    "unknownScheme": _Mesh(scheme="wrong"),
    "shortPrimvar": _Mesh(more=_SHORT_PRIMVAR),
    "subsetBeyondFaces": _Mesh(more=_SUBSET_BEYOND),
    "boundToNothing": _Mesh(more=_BOUND_TO_NOTHING, metadata=_API),
    "missingTexture": _MISSING_TEXTURE + _Mesh(),
    "materialLoop": _MATERIAL_LOOP + _Mesh(more="rel material:binding = </L>", metadata=_API),
    "prototypeBeyond": _PROTOTYPE_BEYOND + _Mesh(),
    "emptyStage": "",
}.items()}
