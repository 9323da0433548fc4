# SPDX-License-Identifier: Apache-2.0
"""An edited stage gives the scene of a fresh session, whatever was translated again; and no more is than needed."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from cliCase import WriteStage

BODY = """def Xform "World" {
    double3 xformOp:translate = (0, 1, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Xform "Left" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        color3f[] primvars:displayColor = [(0.2, 0.4, 0.6)]
        rel material:binding = </World/Looks/Red>
        def Mesh "Card" {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
            uniform token subdivisionScheme = "none"
            double3 xformOp:translate = (0, 0, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }
        def Sphere "Ball" { double radius = 0.5 }
    }
    def Cube "Right" { double3 xformOp:translate = (3, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"] }
    def Scope "Looks" {
        def Material "Red" {
            token outputs:surface.connect = </World/Looks/Red/Surface.outputs:surface>
            def Shader "Surface" {
                uniform token info:id = "UsdPreviewSurface"
                color3f inputs:diffuseColor = (1, 0, 0)
                token outputs:surface
            }
        }
    }
}
def SphereLight "Lamp" { float inputs:intensity = 3 }
def Camera "main_cam" { double3 xformOp:translate = (0, 0, 8); uniform token[] xformOpOrder = ["xformOp:translate"] }
"""
INSTANCES = """def Xform "Prototype" { def Sphere "Ball" {} }
def Xform "A" (instanceable = true; references = </Prototype>) {}
def Xform "B" (instanceable = true; references = </Prototype>) {
    double3 xformOp:translate = (4, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"] }
"""


def Set(path, value):
    def Edit(stage):
        stage.GetAttributeAtPath(path).Set(value)

    return Edit


def Add(stage):
    UsdGeom.Cone.Define(stage, "/World/Left/New")


def Remove(stage):
    stage.RemovePrim("/World/Left/Ball")


def Bind(stage):
    stage.GetPrimAtPath("/World/Left").GetRelationship("material:binding").ClearTargets(True)


def Hide(stage):
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Left")).MakeInvisible()


def MoveAnew(stage):
    UsdGeom.Xformable(stage.GetPrimAtPath("/Lamp")).AddTranslateOp().Set((1, 2, 3))


def Purpose(stage):
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Left")).CreatePurposeAttr("guide")


def Pixel(stage):
    stage.OverridePrim("/Render").CreateAttribute("note", Sdf.ValueTypeNames.Int).Set(3)


# name -> (edit, prims visited: None: all of them)
EDITS = {
    "camera": (Set("/main_cam.xformOp:translate", Gf.Vec3d(0, 1, 9)), 1),
    "light": (Set("/Lamp.inputs:intensity", 7.0), 1),
    "light moves": (MoveAnew, 1),
    "material": (Set("/World/Looks/Red/Surface.inputs:diffuseColor", Gf.Vec3f(0, 1, 0)), 1),
    "group moves": (Set("/World.xformOp:translate", Gf.Vec3d(0, 2, 0)), 7),
    "mesh moves": (Set("/World/Left/Card.xformOp:translate", Gf.Vec3d(0, 0, 1)), 1),
    "points": (Set("/World/Left/Card.points", [(-2, -1, 0), (1, -1, 0), (0, 1, 0)]), 1),
    "radius": (Set("/World/Left/Ball.radius", 0.75), 1),
    "inherited primvar": (Set("/World/Left.primvars:displayColor", [(1, 1, 0)]), 3),
    "hide": (Hide, 3),
    "purpose": (Purpose, 3),
    "new prim": (Add, None),
    "removed prim": (Remove, None),
    "binding": (Bind, None),
}


def SessionOf(stage):
    from hdstream import _core
    from hdstream.translate.stageEdits import StageTranslation
    session = _core.Session()
    return session, StageTranslation(stage, session, lambda: None)


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_stage_gives_the_scene_of_a_fresh_session(name, tmp_path):
    edit, numPrims = EDITS[name]
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY)))
    session, translation = SessionOf(stage)
    numAll = translation.Update(1.0)
    before = session.Dump()
    assert translation.Update(1.0) == 0, "nothing changed"
    edit(stage)
    visited = translation.Update(1.0)
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert session.Dump() == fresh.Dump()
    assert session.Dump() != before, "the edit shows"
    assert visited == numPrims if numPrims else visited >= numAll - 1


def test_all_edits_one_after_another(tmp_path):
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY)))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    for name, (edit, _) in EDITS.items():
        edit(stage)
        translation.Update(1.0)
        fresh, whole = SessionOf(stage)
        whole.Update(1.0)
        assert session.Dump() == fresh.Dump(), name


@pytest.mark.parametrize("path, value, isWhole", [
    ("/Prototype/Ball.radius", 2.0, True), ("/B.xformOp:translate", Gf.Vec3d(5, 0, 0), True),
    ("/World/Right.xformOp:translate", Gf.Vec3d(5, 0, 0), True), ("/Lamp.inputs:intensity", 2.0, False)])
def test_stages_with_instances(path, value, isWhole, tmp_path):
    """Gprims may be prototypes there: all is translated again, but for cameras and lights."""
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + INSTANCES)))
    session, translation = SessionOf(stage)
    numAll = translation.Update(1.0)
    stage.GetAttributeAtPath(path).Set(value)
    assert translation.Update(1.0) == (numAll if isWhole else 1)
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert session.Dump() == fresh.Dump()


@pytest.mark.parametrize("path, value, isWhole", [
    ("/World/Left/Card.xformOp:translate", Gf.Vec3d(0, 0, 2), True), ("/Key.inputs:intensity", 2.0, True),
    ("/main_cam.xformOp:translate", Gf.Vec3d(0, 0, 9), False)])
def test_stages_with_light_links(path, value, isWhole, tmp_path):
    """What a prim's links are, lights elsewhere say."""
    links = 'def SphereLight "Key" { float inputs:intensity = 1; rel collection:lightLink:excludes = </World/Left/Card> }'
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + links)))
    session, translation = SessionOf(stage)
    numAll = translation.Update(1.0)
    stage.GetAttributeAtPath(path).Set(value)
    assert translation.Update(1.0) == (numAll if isWhole else 1)
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert session.Dump() == fresh.Dump()


def test_settings_prims_and_other_prims_translate_nothing_or_all(tmp_path):
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + 'def RenderSettings "Render" {}')))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    Pixel(stage)
    assert translation.Update(1.0) == 0
    assert translation.Update(2.0) > 0, "another time code"


_MESH = """def Mesh "Mesh" { int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0, 1, 2]
point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
"""
_BOUNDS = 'kind = "component"; prepend apiSchemas = ["GeomModelAPI"]'


_INACTIVE = _MESH.replace('"Mesh" {', '"Mesh" (active = false) {')


@pytest.mark.parametrize("text", [
    f'class Xform "Model" {{ {_MESH} }} }}\ndef Xform "Heir" (inherits = </Model>) {{}}', f'over Xform "Model" {{ {_MESH} }} }}',
    f'def Xform "Model" {{ {_INACTIVE} }} }}',
    f'def Xform "Model" ({_BOUNDS}) {{ uniform token model:drawMode = "bounds"\n{_MESH} }} }}',
    f'def Xform "Model" ({_BOUNDS}) {{ uniform token model:drawMode = "cards"\n{_MESH} }} }}'],
    ids=["class", "over", "inactive", "bounds", "cards"])
def test_edits_of_what_is_not_drawn_draw_nothing(text, tmp_path):
    """Below classes and overs, inactive prims and models that something stands in for, whose bounds follow."""
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + text)))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    stage.GetAttributeAtPath("/Model/Mesh.points").Set([(0, 0, 0), (3, 0, 0), (0, 1, 2)])
    translation.Update(1.0)
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert session.Dump() == fresh.Dump()


def test_lights_that_an_instancer_places_follow_the_light(tmp_path):
    many = """def PointInstancer "Many" { rel prototypes = </Lamp>
int[] protoIndices = [0, 0]
point3f[] positions = [(0, 0, 0), (2, 0, 0)]
}
"""
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + many)))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    assert len(session.Scene().lights) == 2
    stage.GetAttributeAtPath("/Lamp.inputs:intensity").Set(7.0)
    translation.Update(1.0)
    assert [prim.light.intensity for prim in session.Scene().lights.values()] == [7, 7]


def test_a_gprim_below_a_gprim_keeps_what_it_inherits(tmp_path):
    above = """def Mesh "Above" (prepend apiSchemas = ["MaterialBindingAPI"]) { int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0, 1, 2]
point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
color3f[] primvars:displayColor = [(1, 0, 0)]
rel material:binding = </World/Looks/Red>
""" + _MESH + "} }\n"
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + above)))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    stage.GetAttributeAtPath("/Above/Mesh.points").Set([(0, 0, 0), (3, 0, 0), (0, 1, 2)])
    assert translation.Update(1.0) == 1
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert session.Dump() == fresh.Dump()
    assert session.Scene().geometry["/Above/Mesh"].materialPath == "/World/Looks/Red"


_SHARED = """def Material "Owner" {
    color3f inputs:tint = (1, 0, 0)
    def Shader "Texture" { uniform token info:id = "UsdUVTexture"
        float4 inputs:fallback = (1, 0, 0, 1)
        float3 outputs:rgb }
    def Material "Inner" { def Shader "Texture" { uniform token info:id = "UsdUVTexture"
        float4 inputs:fallback = (1, 0, 0, 1)
        float3 outputs:rgb } } }
def Material "Heir" { token outputs:surface.connect = </Heir/Surface.outputs:surface>
    def Shader "Surface" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </Owner/Texture.outputs:rgb>
        color3f inputs:emissiveColor.connect = </Owner.inputs:tint>
        color3f inputs:specularColor.connect = </Owner/Inner/Texture.outputs:rgb>
        token outputs:surface } }
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Heir> }
"""


@pytest.mark.parametrize("attribute, value", [
    ("/Owner/Texture.inputs:fallback", Gf.Vec4f(0, 1, 0, 1)), ("/Owner.inputs:tint", Gf.Vec3f(0, 1, 0)),
    ("/Owner/Inner/Texture.inputs:fallback", Gf.Vec4f(0, 1, 0, 1))])
def test_a_material_with_nodes_of_another_follows_them(attribute, value, tmp_path):
    """Though that other one is bound to nothing."""
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + _SHARED)))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    before = session.Dump()
    for edited in (value, type(value)(0.5)):  # a second edit finds what the first left
        stage.GetAttributeAtPath(attribute).Set(edited)
        assert translation.Update(1.0) == 1
        fresh, whole = SessionOf(stage)
        whole.Update(1.0)
        assert before != session.Dump() == fresh.Dump()


_OWNER = """def Material "Owner" {{
    {declared}
    def NodeGraph "Graph" {{ float3 outputs:out.connect = </Third/A.outputs:rgb> }} }}
def Material "Third" {{
    color3f inputs:tint = (1, 0, 1)
    color3f inputs:other = (1, 1, 1)
    def Shader "A" {{ uniform token info:id = "UsdUVTexture"
        float4 inputs:fallback = (1, 0, 0, 1)
        float3 outputs:rgb }}
    def Shader "B" {{ uniform token info:id = "UsdUVTexture"
        float4 inputs:fallback = (0, 0, 1, 1)
        float3 outputs:rgb }} }}
def Material "Heir" {{ token outputs:surface.connect = </Heir/Surface.outputs:surface>
    def Shader "Surface" {{ uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = {connected}
        token outputs:surface }} }}
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </Heir> }}
"""


def _Connect(path, *targets):
    return lambda stage: stage.GetAttributeAtPath(path).SetConnections([Sdf.Path(target) for target in targets])


_ON_THE_WAY = {
    "valueWhereNoneWas": ("color3f inputs:tint", "</Owner.inputs:tint>",
                          lambda stage: stage.GetAttributeAtPath("/Owner.inputs:tint").Set(Gf.Vec3f(0, 1, 0))),
    "attributeIsMade": ("", "</Owner.inputs:tint>", lambda stage: stage.GetPrimAtPath("/Owner").CreateAttribute(
        "inputs:tint", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0, 1, 0))),
    "graphIsRedirected": ("", "</Owner/Graph.outputs:out>", _Connect("/Owner/Graph.outputs:out", "/Third/B.outputs:rgb")),
    "interfaceIsRedirected": ("color3f inputs:tint.connect = </Third.inputs:tint>", "</Owner.inputs:tint>",
                              _Connect("/Owner.inputs:tint", "/Third.inputs:other")),
    "connectionIsCleared": ("color3f inputs:tint = (0, 0, 1)\ncolor3f inputs:tint.connect = </Third.inputs:tint>",
                            "</Owner.inputs:tint>", _Connect("/Owner.inputs:tint"))}


@pytest.mark.parametrize("name", _ON_THE_WAY)
def test_edits_on_the_way_to_another_material_are_followed(name, tmp_path):
    """Where the edited attribute is not what the value came from."""
    declared, connected, edit = _ON_THE_WAY[name]
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, BODY + _OWNER.format(declared=declared, connected=connected))))
    session, translation = SessionOf(stage)
    translation.Update(1.0)
    before = session.Dump()
    edit(stage)
    translation.Update(1.0)
    fresh, whole = SessionOf(stage)
    whole.Update(1.0)
    assert before != session.Dump() == fresh.Dump()
