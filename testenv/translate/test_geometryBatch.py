# SPDX-License-Identifier: Apache-2.0
"""Geometry is handed over while the stage is walked, with the materials that UsdShade says and the links of lights that come later."""

import pytest

pytest.importorskip("hdstream._core")

from pxr import UsdGeom, UsdShade

from hdstream.translate import geometryBatch, materials
from translateCase import StageOf, Translate

# Bindings of all kinds: inherited, of the prim itself, of purpose full, stronger than those of descendants, by a collection, and
# to a material that is not there.
_BOUND = """
def Scope "Looks" { def Material "Red" {} def Material "Green" {} def Material "Blue" {} }
def Xform "Plain" { def Cube "A" {} def Cube "B" {} }
def Xform "Above" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </Looks/Red>
    def Cube "Inherits" {}
    def Cube "Too" {}
    def Cube "Own" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Looks/Green> }
    def Xform "Between" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding:full = </Looks/Blue>
        def Cube "Full" {}
        def Cube "Preview" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding:preview = </Looks/Green> }
    }
}
def Xform "Strong" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </Looks/Blue> (bindMaterialAs = "strongerThanDescendants")
    def Cube "Weak" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Looks/Green> }
    def Cube "None" {}
}
def Xform "Collected" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:some"]) {
    rel collection:some:includes = </Collected/In>
    rel material:binding = </Looks/Red>
    rel material:binding:collection:some = [</Collected.collection:some>, </Looks/Green>]
    def Cube "In" {}
    def Cube "Out" {}
}
def Xform "Gone" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </Looks/Nobody>
    def Cube "A" {}
    def Cube "B" {}
}
def PointInstancer "Many" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = </Many/Bound>
    def Xform "Bound" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding = </Looks/Green>
        def Cube "A" {}
        def Cube "B" {}
    }
}
"""

# The light that leaves something out is the last prim.
_LINKED = "".join(f'def Cube "Cube{i}" {{}}\n' for i in range(10)) + """
def PointInstancer "Many" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = </Kept/Cube>
}
def Scope "Kept" { def Cube "Cube" {} }
def SphereLight "Last" (prepend apiSchemas = ["CollectionAPI:lightLink"]) {
    rel collection:lightLink:excludes = [</Cube3>, </Kept/Cube>]
}
"""


# USD discourages gprims below gprims; files have them.
_PLAIN = 'def Cube "Plain{}" {{}}\n'
_NESTED = """
    def Cube "Outer" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding = </Looks/Green>
        def Cube "Inner" { def Cube "Deep" {} }
        def Xform "Between" { def Cube "Below" {} }
        def BasisCurves "Curves" {
            uniform token type = "linear"
            int[] curveVertexCounts = [2]
            point3f[] points = [(0, 0, 0), (1, 0, 0)]
            def Cube "OfCurves" {}
        }
    }
"""


@pytest.fixture(params=[1, 3, 1 << 14])
def atOnce(request, monkeypatch):
    monkeypatch.setattr(geometryBatch, "_AT_ONCE", request.param)
    return request.param


@pytest.mark.parametrize("text", [
    _BOUND, *("\n".join(('def Scope "Looks" { def Material "Red" {} def Material "Green" {} }',
                       'def Xform "Above" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Looks/Red>',
                       *order, "}"))
              for order in ((_PLAIN.format(1), _NESTED, _PLAIN.format(2)), (_NESTED, _PLAIN.format(1), _PLAIN.format(2))))],
    ids=["kinds", "nested", "nestedFirst"])
def test_materials_are_those_of_UsdShade(atOnce, text):
    stage = StageOf(text)
    session = Translate(stage)
    geometry = session.Scene().geometry
    assert len(geometry) == sum(prim.IsA(UsdGeom.Gprim) for prim in stage.Traverse())
    for path, prim in geometry.items():
        expected, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial("full")
        assert prim.materialPath == (expected.GetPath().pathString if expected else ""), path
    warned = [line for line in session.Warnings() if "does not exist" in line]
    assert warned == ([f"/Gone/{name}: bound material /Looks/Nobody does not exist" for name in "AB"] if text == _BOUND else [])


def test_prims_that_inherit_alike_are_asked_for_once(monkeypatch):
    asked = []
    compute = materials._ComputeBoundMaterials
    monkeypatch.setattr(materials, "_ComputeBoundMaterials",
                        lambda prims, warn: asked.extend(str(prim.GetPath()) for prim in prims) or compute(prims, warn))
    Translate(StageOf(_BOUND))
    assert sorted(asked) == ["/Above/Between/Full", "/Above/Between/Preview", "/Above/Inherits", "/Above/Own", "/Collected/In",
                             "/Collected/Out", "/Gone/A", "/Many/Bound/A", "/Plain/A", "/Strong/None", "/Strong/Weak"]


def test_lights_that_come_later_are_linked(atOnce, monkeypatch):
    waiting = []
    add = geometryBatch.GeometryBatch.Add
    monkeypatch.setattr(geometryBatch.GeometryBatch, "Add",
                        lambda batch, *entry: (add(batch, *entry), waiting.append(len(batch._entries))))
    session = Translate(StageOf(_LINKED))
    assert len(waiting) == 12 and max(waiting) < max(atOnce, 2)
    linked = {path: bool(prim.categories) for path, prim in session.Scene().geometry.items()}
    assert len(linked) == 12
    assert {path for path, isLinked in linked.items() if not isLinked} == {"/Cube3", "/Kept/Cube", "/Many{/Kept/Cube}"}


def test_only_geometry_that_is_there_is_linked():
    from hdstream import _core
    with pytest.raises(_core.Error, match="/Nowhere: there is no geometry"):
        _core.Session().SetCategories("/Nowhere", {"a"})


def test_a_prim_of_the_scene_is_found_by_its_path():
    session = Translate(StageOf(_LINKED))
    scene = session.Scene()
    assert scene.hasInstancers and not scene.isEmpty
    assert scene.FindGeometry("/Cube3").materialPath == "" and scene.FindGeometry("/Nowhere") is None
    empty = Translate(StageOf('def Xform "Nothing" {}')).Scene()
    assert empty.isEmpty and not empty.hasInstancers
