# SPDX-License-Identifier: Apache-2.0
"""What is asked of each prim by shorter ways than OpenUSD's own is what OpenUSD says."""

import pytest

pytest.importorskip("hdstream._core")

from pxr import Usd, UsdGeom

from hdstream.translate import colorSpaces, pathTexts, primState, usdCalls
from translateCase import StageOf, Translate

# Native instances, one in another; a point instancer with prototypes outside of it; prims below a gprim; names that begin alike.
_NESTED = """
class Xform "Tree" { def Mesh "Leaf" { def Scope "Below" {} } }
class Xform "Wood" { def Xform "One" (instanceable = true; references = </Tree>) {} def Cube "Stone" {} }
def Xform "World" {
    def Xform "A" (instanceable = true; references = </Wood>) {}
    def Xform "B" (instanceable = true; references = </Wood>) {}
    def Xform "A1" { def Cube "A" {} }
    def PointInstancer "P" {
        point3f[] positions = [(0, 0, 0), (3, 0, 0)]
        int[] protoIndices = [0, 1]
        rel prototypes = [</World/P/Inside>, </Elsewhere/Ball>]
        def Cube "Inside" {}
    }
}
def Scope "Elsewhere" { def Sphere "Ball" {} }
"""

_INSTANCES = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)


def test_texts_of_paths_are_those_of_sdfpath():
    pathTexts.Forget()
    stage = StageOf(_NESTED)
    prims = list(Usd.PrimRange.Stage(stage, _INSTANCES))
    prims += [below for prototype in stage.GetPrototypes() for below in Usd.PrimRange(prototype, _INSTANCES)]
    assert sum(prim.IsInstanceProxy() for prim in prims) > 8
    for _ in range(2):  # parents are known the second time
        assert [pathTexts.PathText(prim) for prim in prims] == [prim.GetPath().pathString for prim in prims]


def test_a_translation_keeps_no_prims():
    """Those of a stage that is gone would stand for others of a later one."""
    scene = Translate(StageOf(_NESTED)).Scene()
    assert len(scene.geometry) == 5
    assert not pathTexts._ofParents


def test_a_stage_that_is_edited_between_has_the_paths_of_now():
    stage = StageOf('def Xform "A" { def Xform "B" { def Cube "C" {} } }')
    first = set(Translate(stage).Scene().geometry)
    editor = Usd.NamespaceEditor(stage)
    assert editor.MovePrimAtPath("/A/B", "/D") and editor.ApplyEdits()
    assert (first, set(Translate(stage).Scene().geometry)) == ({"/A/B/C"}, {"/D/C"})


def test_functions_say_what_methods_say():
    stage = StageOf(_NESTED)
    for prim in Usd.PrimRange.Stage(stage, _INSTANCES):
        assert usdCalls.GetFilteredChildren(prim, primState.PREDICATE) == prim.GetFilteredChildren(primState.PREDICATE)
        assert usdCalls.GetAuthoredPropertyNames(prim) == prim.GetAuthoredPropertyNames()
        assert usdCalls.GetParent(prim) == prim.GetParent()
        for name in prim.GetAuthoredPropertyNames():
            attribute = prim.GetAttribute(name)
            assert usdCalls.GetAttribute(prim, name) == attribute
            if attribute:
                assert usdCalls.GetValue(attribute, Usd.TimeCode(1)) == attribute.Get(1)


@pytest.mark.parametrize("given", [False, True])
def test_colour_spaces_of_prims_that_are_known(given):
    """The prim may be handed over with its attribute; a space of an ancestor counts until another one has its own."""
    colorSpaces.Forget()
    stage = StageOf("""
def Xform "Plain" { def Mesh "M" { color3f[] primvars:displayColor = [(1, 0, 0)] } }
def Xform "Above" (prepend apiSchemas = ["ColorSpaceAPI"]) {
    uniform token colorSpace:name = "lin_ap1_scene"
    def Xform "Between" {
        def Mesh "M" { color3f[] primvars:displayColor = [(1, 0, 0)] }
        def Mesh "Own" (prepend apiSchemas = ["ColorSpaceAPI"]) {
            uniform token colorSpace:name = "srgb_rec709_scene"
            color3f[] primvars:displayColor = [(1, 0, 0)]
        }
        def Mesh "OfAttribute" { color3f[] primvars:displayColor = [(1, 0, 0)] (colorSpace = "g22_rec709_scene") }
    }
}
""")
    found = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            attribute = prim.GetAttribute("primvars:displayColor")
            found[prim.GetName()] = found.get(prim.GetName(), ()) + (
                colorSpaces.ColorSpaceOfColor(attribute, prim) if given else colorSpaces.ColorSpaceOfColor(attribute),)
    assert found == {"M": ("", "lin_ap1_scene"), "Own": ("srgb_rec709_scene",), "OfAttribute": ("g22_rec709_scene",)}
