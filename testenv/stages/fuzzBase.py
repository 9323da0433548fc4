# SPDX-License-Identifier: Apache-2.0
"""Small stages as text that fuzzing begins with: every kind of prim the renderer draws, with arrays short enough that a
mutation of one number matters. The goldens of testenv/translate join them."""

import pathlib

import numpy as np

from . import imageFile

_FOLDER = pathlib.Path(__file__).resolve().parent.parent / "translate"

HEAD = """#usda 1.0
(
    startTimeCode = 1
    endTimeCode = 4
    upAxis = "Y"
    renderSettingsPrimPath = "/Render"
)
def Camera "main_cam"
{
    float2 clippingRange = (0.1, 1000)
    float focalLength = 30
    float focusDistance = 6
    float fStop = 0
    float horizontalAperture = 36
    float verticalAperture = 24
    double3 xformOp:translate = (0, 1, 7)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""

_CUBE = """    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = [0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6, 6, 7, 1, 0, 1, 7, 5, 3, 6, 0, 2, 4]
    point3f[] points = [(-0.5, -0.5, 0.5), (0.5, -0.5, 0.5), (-0.5, 0.5, 0.5), (0.5, 0.5, 0.5), (-0.5, 0.5, -0.5), (0.5, 0.5, -0.5), (-0.5, -0.5, -0.5), (0.5, -0.5, -0.5)]
"""

_FLOOR = """def Mesh "Floor" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    int[] faceVertexCounts = [4, 4, 3, 3]
    int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 6, 4, 5, 6]
    point3f[] points = [(-4, 0, 4), (0, 0, 4), (4, 0, 4), (-4, 0, -4), (0, 0.5, -4), (4, 0, -4), (0, 3, -5)]
    normal3f[] normals = [(0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0)] (
        interpolation = "vertex"
    )
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (2, 0), (0, 2), (1, 2), (2, 2), (1, 3)] (
        interpolation = "vertex"
    )
    color3f[] primvars:displayColor = [(0.8, 0.2, 0.2), (0.2, 0.8, 0.2), (0.2, 0.2, 0.8), (0.5, 0.5, 0.5)] (
        interpolation = "uniform"
    )
    uniform token subdivisionScheme = "none"
    rel material:binding = </Looks/Textured>
    def GeomSubset "Part" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0, 2]
        rel material:binding = </Looks/Glass>
    }
}
"""

_SURFACE = """def Mesh "Surface" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
%s    int[] cornerIndices = [0, 5]
    float[] cornerSharpnesses = [2, 10]
    int[] creaseIndices = [0, 1, 3, 2, 0]
    int[] creaseLengths = [5]
    float[] creaseSharpnesses = [3]
    int[] holeIndices = [5]
    uniform token interpolateBoundary = "edgeAndCorner"
    uniform token faceVaryingLinearInterpolation = "cornersPlus1"
    uniform token triangleSubdivisionRule = "catmullClark"
    uniform token subdivisionScheme = "catmullClark"
    bool doubleSided = 1
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = "faceVarying"
    )
    int[] primvars:st:indices = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]
    float[] primvars:cover = [0, 1, 0.5, 1, 1, 0.2, 1, 1] (
        interpolation = "varying"
    )
    rel material:binding = </Looks/Displaced>
    float3 xformOp:rotateXYZ = (20, 30, 0)
    double3 xformOp:translate = (-1.2, 1, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}
def Mesh "Loop" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    int[] faceVertexCounts = [3, 3, 3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0]
    point3f[] points = [(1, 1, 1), (1, 0, 0), (2, 1, 0), (0, 1, -1)]
    point3f[] points.timeSamples = {
        1: [(1, 1, 1), (1, 0, 0), (2, 1, 0), (0, 1, -1)],
        2: [(1, 2, 1), (1, 0, 0), (2, 1, 0), (0, 1, -1)],
    }
    uniform token subdivisionScheme = "loop"
    uniform token orientation = "leftHanded"
    rel material:binding = </Looks/Glow>
}
""" % _CUBE

_INSTANCES = """def PointInstancer "Many"
{
    int64[] ids = [1, 2, 3, 4]
    int64[] invisibleIds = [3]
    quath[] orientations = [(1, 0, 0, 0), (0.7, 0, 0.7, 0), (1, 0, 0, 0), (0, 1, 0, 0)]
    point3f[] positions = [(2, 0.3, 1), (2.5, 0.3, 0), (3, 0.3, 1), (1.5, 0.4, 2)]
    int[] protoIndices = [0, 1, 0, 2]
    float3[] scales = [(0.3, 0.3, 0.3), (0.5, 0.2, 0.5), (1, 1, 1), (0.1, 0.1, 0.1)]
    rel prototypes = [</Many/Box>, </Many/Group>, </Model>]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)] (
        interpolation = "vertex"
    )
    def Mesh "Box"
    {
    %s    }
    def Xform "Group"
    {
        def Sphere "Ball"
        {
            double radius = 0.4
        }
        def PointInstancer "Inner"
        {
            point3f[] positions = [(0, 1, 0), (1, 0, 0)]
            int[] protoIndices = [0, 0]
            rel prototypes = </Many/Group/Inner/Leaf>
            def Cone "Leaf"
            {
                double height = 0.5
                double radius = 0.2
            }
        }
    }
}
def Xform "Model" (
    instanceable = true
)
{
    def Cylinder "Post"
    {
        double height = 0.6
        double radius = 0.1
        uniform token axis = "Y"
        double3 xformOp:translate = (-2, 0.3, 2)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Capsule "Pill"
    {
        double height = 0.3
        double radius = 0.1
        double3 xformOp:translate = (-2.5, 0.3, 2)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
def Xform "Copy" (
    instanceable = true
    references = </Model>
)
{
    matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 2, 0, 0), (0, 0, 1, 0), (0.5, 0, 0.3, 1))
    uniform token[] xformOpOrder = ["xformOp:transform"]
}
""" % _CUBE

_LIGHTS = """def DomeLight "Sky"
{
    float inputs:intensity = 0.5
    asset inputs:texture:file = @./sky.exr@
}
def DistantLight "Sun"
{
    float inputs:angle = 1
    float inputs:intensity = 2
    float3 xformOp:rotateXYZ = (-40, 20, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}
def RectLight "Panel"
{
    float inputs:height = 1
    float inputs:width = 2
    float inputs:intensity = 5
    asset inputs:texture:file = @./color.png@
    double3 xformOp:translate = (0, 3, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def SphereLight "Lamp"
{
    float inputs:radius = 0.1
    float inputs:intensity = 20
    float inputs:exposure = 1
    bool inputs:enableColorTemperature = 1
    float inputs:colorTemperature = 3000
    double3 xformOp:translate = (1, 2, 1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def DiskLight "Disk"
{
    float inputs:radius = 0.4
    bool inputs:normalize = 1
    float inputs:intensity = 4
    double3 xformOp:translate = (-2, 2, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def CylinderLight "Tube"
{
    float inputs:radius = 0.05
    float inputs:length = 2
    float inputs:intensity = 4
    color3f inputs:color = (1, 0.5, 0.2)
    double3 xformOp:translate = (0, 2.5, -2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""

_LOOKS = """def Scope "Looks"
{
    def Material "Textured"
    {
        token outputs:surface.connect = </Looks/Textured/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Looks/Textured/Color.outputs:rgb>
            float inputs:roughness.connect = </Looks/Textured/Rough.outputs:r>
            float inputs:metallic = 0.3
            normal3f inputs:normal.connect = </Looks/Textured/Bump.outputs:rgb>
            token outputs:surface
        }
        def Shader "Color"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./color.png@
            float4 inputs:scale = (1, 1, 1, 1)
            float4 inputs:bias = (0, 0, 0, 0)
            float4 inputs:fallback = (1, 0, 1, 1)
            token inputs:sourceColorSpace = "auto"
            token inputs:wrapS = "repeat"
            token inputs:wrapT = "mirror"
            float2 inputs:st.connect = </Looks/Textured/Turn.outputs:result>
            float3 outputs:rgb
        }
        def Shader "Rough"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./rough.exr@
            float2 inputs:st.connect = </Looks/Textured/Reader.outputs:result>
            float outputs:r
        }
        def Shader "Bump"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./tile.<UDIM>.png@
            float4 inputs:scale = (2, 2, 2, 1)
            float4 inputs:bias = (-1, -1, -1, 0)
            token inputs:sourceColorSpace = "raw"
            float2 inputs:st.connect = </Looks/Textured/Reader.outputs:result>
            float3 outputs:rgb
        }
        def Shader "Turn"
        {
            uniform token info:id = "UsdTransform2d"
            float2 inputs:in.connect = </Looks/Textured/Reader.outputs:result>
            float inputs:rotation = 30
            float2 inputs:scale = (2, 3)
            float2 inputs:translation = (0.1, 0.2)
            float2 outputs:result
        }
        def Shader "Reader"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 inputs:fallback = (0.5, 0.5)
            float2 outputs:result
        }
    }
    def Material "Glass"
    {
        token outputs:surface.connect = </Looks/Glass/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.5, 0.5, 0.5)
            float inputs:clearcoat = 1
            float inputs:clearcoatRoughness = 0.01
            float inputs:ior = 1.5
            float inputs:opacity = 0.5
            float inputs:opacityThreshold = 0
            float inputs:roughness = 0
            int inputs:useSpecularWorkflow = 1
            color3f inputs:specularColor = (0.2, 0.3, 0.4)
            token outputs:surface
        }
    }
    def Material "Displaced"
    {
        token outputs:surface.connect = </Looks/Displaced/Surface.outputs:surface>
        token outputs:displacement.connect = </Looks/Displaced/Surface.outputs:displacement>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            float inputs:displacement.connect = </Looks/Displaced/Height.outputs:r>
            float inputs:opacity.connect = </Looks/Displaced/Cover.outputs:result>
            float inputs:opacityThreshold = 0.3
            float inputs:roughness = 0.2
            float inputs:metallic = 1
            token outputs:surface
            token outputs:displacement
        }
        def Shader "Height"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./rough.exr@
            float4 inputs:scale = (0.1, 0.1, 0.1, 1)
            float2 inputs:st.connect = </Looks/Textured/Reader.outputs:result>
            float outputs:r
        }
        def Shader "Cover"
        {
            uniform token info:id = "UsdPrimvarReader_float"
            string inputs:varname = "cover"
            float inputs:fallback = 1
            float outputs:result
        }
    }
    def Material "Glow"
    {
        token outputs:surface.connect = </Looks/Glow/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.5, 0.5, 0.5)
            color3f inputs:emissiveColor = (3, 2, 1)
            token outputs:surface
        }
    }
}
"""

_RENDER = """def RenderSettings "Render"
{
    int2 resolution = (16, 12)
    float pixelAspectRatio = 1
    token aspectRatioConformPolicy = "expandAperture"
    float4 dataWindowNDC = (0, 0, 1, 1)
    token[] includedPurposes = ["default", "render"]
    bool disableDepthOfField = 0
    rel camera = </main_cam>
    int hdstream:seed = 3
    double hdstream:mipBias = 0
    string hdstream:pixelFilter = "blackmanHarris"
    double hdstream:pixelFilterWidth = 2
    bool hdstream:russianRoulette = 1
    string hdstream:cullStyle = "nothing"
    rel products = </Render/Product>
    def RenderProduct "Product"
    {
        rel orderedVars = [</Render/Product/Color>, </Render/Product/Depth>]
        def RenderVar "Color"
        {
            string sourceName = "color"
        }
        def RenderVar "Depth"
        {
            string sourceName = "depth"
        }
    }
}
"""


def WriteImages(folder) -> None:
    """The images that the texts name."""
    folder = pathlib.Path(folder)
    y, x = np.mgrid[0:12, 0:10].astype(np.float32)
    color = np.stack([x * 25, y * 20, 255 - 10 * (x + y)], -1)
    imageFile.WritePng(folder / "color.png", color.astype(np.uint8))
    imageFile.WritePng(folder / "tile.1001.png", np.full((4, 4, 3), 128, np.uint8))
    imageFile.WritePng(folder / "tile.1012.png", color[:5, :7].astype(np.uint8))
    imageFile.WriteExr(folder / "rough.exr", {"Y": 0.1 + 0.4 * np.cos(x) ** 2})
    imageFile.WriteExr(folder / "sky.exr", {c: 0.5 + 0.1 * k + 0.3 * np.sin(x + y) for k, c in enumerate("RGB")}, half=False)


def Texts() -> list:
    """The stages. Each own one holds all materials, so that mutated targets find them."""
    parts = [_FLOOR, _SURFACE, _INSTANCES, _LIGHTS]
    own = [HEAD + "".join(parts) + _LOOKS + _RENDER] + [HEAD + part + _LOOKS + _LIGHTS for part in parts[:3]]
    return own + [path.read_text(encoding="utf-8") for path in sorted(_FOLDER.glob("*/scene.usda"))]
