# SPDX-License-Identifier: Apache-2.0
"""A stage in which every kind of light and scattering is seen, for tests of light path expressions."""

import hdstream

WIDTH, HEIGHT, SAMPLES = 96, 64, 16
LIGHTS = ("key", "fill", "sky", "sun", "panel")  # panel: a mesh that is a light
_HEADER = '#usda 1.0\n(\n    upAxis = "Y"\n    metersPerUnit = 1\n)\n'
_MATERIALS = {
    "rough": "color3f inputs:diffuseColor = (0.7, 0.5, 0.3)\nfloat inputs:roughness = 0.4",
    "mirror": "color3f inputs:diffuseColor = (0.9, 0.8, 0.7)\nfloat inputs:metallic = 1\nfloat inputs:roughness = 0",
    "car": "color3f inputs:diffuseColor = (0.8, 0.1, 0.1)\nfloat inputs:roughness = 0.5\nfloat inputs:clearcoat = 1\n"
           "float inputs:clearcoatRoughness = 0",
    "glow": "color3f inputs:emissiveColor = (3, 6, 3)",
    "veil": "float inputs:opacity = 0.5\ncolor3f inputs:diffuseColor = (0.2, 0.6, 0.2)",
}
_GLASS = """        def Shader "s" {
            uniform token info:id = "ND_standard_surface_surfaceshader"
            float inputs:transmission = 0.8
            float inputs:specular_roughness = 0.1
            color3f inputs:base_color = (0.4, 0.6, 0.9)
            token outputs:out
        }
"""
_PLACES = {"ball": ((-0.9, 0.7, 0), 0.7, "mirror"), "car": ((0.7, 0.6, 0.4), 0.6, "car"), "lamp": ((2, 0.3, 0.4), 0.2, "glow"),
           "glass": ((-0.1, 0.35, 1.6), 0.35, "glass")}


def _Place(place, rotation=(0, 0, 0)):
    return (f"double3 xformOp:translate = {place}\nfloat3 xformOp:rotateXYZ = {rotation}\n"
            'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]\n')


def _Quad(name, points, material, further="", schemas=""):
    return (f'def Mesh "{name}" (prepend apiSchemas = ["MaterialBindingAPI"{schemas}]) {{\nint[] faceVertexCounts = [4]\n'
            f'int[] faceVertexIndices = [0, 1, 2, 3]\npoint3f[] points = {points}\nuniform token subdivisionScheme = "none"\n'
            f"rel material:binding = </World/Looks/{material}>\n{further}}}\n")


def WriteLightPathStage(file, lights=LIGHTS, further=""):
    """`lights`: those that shine; all are there. The sky is in no group."""
    def Intensity(name, value):
        return f"float inputs:intensity = {value if name in lights else 0}\n"

    text = _HEADER + 'def Xform "World" {\n'
    text += 'def Camera "Camera" {\nfloat focalLength = 30\n' + _Place((0, 1.2, 6)) + "}\n"
    text += ('def RectLight "Key" {\n' + Intensity("key", 12) + "float inputs:width = 1.5\nfloat inputs:height = 1.5\n"
             "color3f inputs:color = (1, 0.8, 0.5)\n" 'string hdstream:light:group = "key"\n' + _Place((1.5, 3, 1), (-70, 20, 0)) + "}\n")
    text += ('def SphereLight "Fill" {\n' + Intensity("fill", 8) + "float inputs:radius = 0.3\n"
             "color3f inputs:color = (0.4, 0.6, 1)\n" 'token inputs:karma:light:lpetag = "fill"\n' + _Place((-2, 2, 0.5)) + "}\n")
    text += 'def DomeLight "Sky" {\n' + Intensity("sky", 0.3) + "}\n"
    text += ('def DistantLight "Sun" {\n' + Intensity("sun", 1500) + "float inputs:angle = 2\n"
             'string inputs:ri:light:lightGroup = "sun"\n' + _Place((0, 0, 0), (-40, -50, 0)) + "}\n")
    text += _Quad("Floor", "[(-5, 0, 5), (5, 0, 5), (5, 0, -5), (-5, 0, -5)]", "rough")
    text += _Quad("Veil", "[(0.5, 0.9, 1.5), (1.5, 0.9, 1.5), (1.5, 1.9, 1.5), (0.5, 1.9, 1.5)]", "veil")
    text += _Quad("Panel", "[(-2, 0.2, -1.5), (-1.2, 0.2, -1.5), (-1.2, 1.5, -1.5), (-2, 1.5, -1.5)]", "rough",
                  "color3f inputs:color = (1, 0.3, 0.6)\n" + Intensity("panel", 4) +
                  'string primvars:arnold:aov = "panel"\nuniform token light:materialSyncMode = "independent"\n', ', "MeshLightAPI"')
    for name, (place, radius, material) in _PLACES.items():
        text += (f'def Sphere "{name}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{\ndouble radius = {radius}\n'
                 f"rel material:binding = </World/Looks/{material}>\n" + _Place(place) + "}\n")
    text += 'def Scope "Looks" {\n'
    for name, inputs in _MATERIALS.items():
        text += (f'def Material "{name}" {{\ntoken outputs:surface.connect = </World/Looks/{name}/s.outputs:surface>\n'
                 f'def Shader "s" {{\nuniform token info:id = "UsdPreviewSurface"\n{inputs}\ntoken outputs:surface\n}}\n}}\n')
    text += ('def Material "glass" {\ntoken outputs:mtlx:surface.connect = </World/Looks/glass/s.outputs:out>\n' + _GLASS + "}\n}\n}\n")
    file.write_text(text + further, encoding="utf-8")
    return file


def RenderLightPaths(file, aovs, **settings):
    """All that `aovs` names, by hdstream's own front end."""
    values = {"imageWidth": WIDTH, "imageHeight": HEIGHT, "samples": SAMPLES, "camera": "/World/Camera", "noCache": True, **settings}
    return hdstream.Renderer(str(file)).Render(aovs=list(aovs), **values)
