# SPDX-License-Identifier: Apache-2.0
"""Texts that fuzzing of light profiles and of MaterialX files begins with, and the stages that read them."""

from .fuzzBase import HEAD

PROFILES = [
    """IESNA:LM-63-2002
[TEST] 1
TILT=NONE
1 1000 1.5 4 3 1 2 0.1 0.2 0
1 1 40
0 30 60 90
0 45 90
100 80 40 0
90 70 30 0
80 60 20 0
""",
    """IESNA91
[MANUFAC] none
TILT=INCLUDE
1
3
0 45 90
1 0.9 0.8
1,800,1,3,5,1,1,-0.3,0,0
0.9,1,35
0,90,180
90,135,180,225,270
1,2,3,4,5
6,7,8,9,10
11,12,13,14,15
1,2,3,4,5
6,7,8,9,10
""",
    "TILT=NONE\n1 -1 1 2 1 1 1 0 0 0 1 1 0\n0 90\n0\n5 5\n",
]

LAMPS = HEAD + """def Sphere "Ball"
{
    double radius = 1
}
def Plane "Floor"
{
    uniform token axis = "Y"
    double width = 20
    double length = 20
}
""" + "".join(f"""def {kind} "{kind}" (
    prepend apiSchemas = ["ShapingAPI"]
)
{{
    float inputs:intensity = 5
    asset inputs:shaping:ies:file = @./lamp.ies@
    bool inputs:shaping:ies:normalize = {isNormalized}
    float inputs:shaping:ies:angleScale = {scale}
    float inputs:shaping:cone:angle = {angle}
    float inputs:shaping:cone:softness = {softness}
    float inputs:shaping:focus = {focus}
    float3 xformOp:rotateXYZ = (-90, 0, 0)
    double3 xformOp:translate = ({x}, 3, 1)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}}
""" for x, (kind, isNormalized, scale, angle, softness, focus) in enumerate([
    ("SphereLight", 0, 0, 90, 0, 0), ("RectLight", 1, 0.5, 60, 0.5, 2), ("DiskLight", 0, -0.4, 40, 1, 0),
    ("CylinderLight", 1, 0, 180, 0.2, 5), ("DistantLight", 0, 0, 90, 0, 0)]))

MATERIALS = """<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <nodegraph name="NG">
    <input name="tint" type="color3" value="0.5, 0.25, 0.125"/>
    <input name="amount" type="float" value="0.5"/>
    <image name="image" type="color3">
      <input name="file" type="filename" value="color.png" colorspace="srgb_texture"/>
      <input name="uaddressmode" type="string" value="mirror"/>
    </image>
    <tiledimage name="rough" type="float">
      <input name="file" type="filename" value="rough.exr"/>
      <input name="uvtiling" type="vector2" value="2, 3"/>
    </tiledimage>
    <multiply name="product" type="color3">
      <input name="in1" type="color3" nodename="image"/>
      <input name="in2" type="color3" interfacename="tint"/>
    </multiply>
    <noise3d name="noise" type="float">
      <input name="amplitude" type="float" interfacename="amount"/>
    </noise3d>
    <mix name="mixed" type="color3">
      <input name="fg" type="color3" nodename="product"/>
      <input name="bg" type="color3" value="0.1, 0.2, 0.3"/>
      <input name="mix" type="float" nodename="noise"/>
    </mix>
    <output name="color" type="color3" nodename="mixed"/>
    <output name="roughness" type="float" nodename="rough"/>
  </nodegraph>
  <standard_surface name="Surface" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="color"/>
    <input name="specular_roughness" type="float" nodegraph="NG" output="roughness"/>
    <input name="coat" type="float" value="0.5"/>
    <input name="specular_IOR" type="float" value="1.4"/>
    <input name="thin_walled" type="boolean" value="false"/>
  </standard_surface>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Surface"/>
  </surfacematerial>
  <checkerboard name="checks" type="color3">
    <input name="uvtiling" type="vector2" value="4, 4"/>
  </checkerboard>
  <open_pbr_surface name="Layers" type="surfaceshader">
    <input name="base_color" type="color3" nodename="checks"/>
    <input name="fuzz_weight" type="float" value="0.3"/>
    <input name="transmission_weight" type="float" value="0.4"/>
  </open_pbr_surface>
  <surfacematerial name="Cloth" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Layers"/>
  </surfacematerial>
  <gltf_pbr name="Shiny" type="surfaceshader">
    <input name="base_color" type="color3" value="0.8, 0.6, 0.2"/>
    <input name="metallic" type="float" value="1.0"/>
    <input name="roughness" type="float" value="0.2"/>
  </gltf_pbr>
  <surfacematerial name="Metal" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Shiny"/>
  </surfacematerial>
</materialx>
"""

BALLS = HEAD + """def "Looks" (
    references = @./looks.mtlx@</MaterialX/Materials>
)
{
}
def DomeLight "Sky"
{
}
""" + "".join(f"""def Sphere "{name}" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{{
    rel material:binding = </Looks/{name}>
    double3 xformOp:translate = ({x}, 1, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
""" for name, x in (("Wood", -2.2), ("Cloth", 0), ("Metal", 2.2)))
