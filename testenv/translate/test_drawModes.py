# SPDX-License-Identifier: Apache-2.0
"""Draw modes replace the subtrees that OpenUSD's functions say; what cards cannot be made of is one warning.

The oracle is usd-core: UsdGeomModelAPI.ComputeModelDrawMode and model kinds, on random stages. The cards
themselves are in the golden scene and in testenv/hydra.
"""

import os
import struct

import numpy as np
import pytest
from pxr import Kind, Usd, UsdGeom

from hdstream import _core
from hdstream.translate.exrHeader import ReadMatrices
from translateCase import FOLDER, StageOf, Translate

TRIANGLE = ("point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 1)]\n"
            "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]")
MODES = ["cards", "cards", "bounds", "origin", "default", "inherited"]
CARDS = 'prepend apiSchemas = ["GeomModelAPI"]'


def RandomModels(seed):
    """Groups, components and other prims with draw modes, applied or not, each with a mesh."""
    rng = np.random.default_rng(seed)
    stage = Usd.Stage.CreateInMemory()

    def Fill(path, depth):
        prim = UsdGeom.Xform.Define(stage, path).GetPrim()
        if rng.random() < 0.8:
            Usd.ModelAPI(prim).SetKind(str(rng.choice(["group", "group", "assembly", "component", "subcomponent"])))
        if rng.random() < 0.7:
            model = UsdGeom.ModelAPI.Apply(prim)
            if rng.random() < 0.6:
                model.CreateModelDrawModeAttr(str(rng.choice(MODES)))
            if rng.random() < 0.3:
                model.CreateModelApplyDrawModeAttr(bool(rng.random() < 0.6))
        mesh = UsdGeom.Mesh.Define(stage, path + "/Mesh")
        mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 1)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        if depth:
            for index in range(2):
                Fill(f"{path}/P{index}", depth - 1)

    for index in range(3):
        Fill(f"/R{index}", 3)
    return stage


def StandInOf(prim):
    """The model that stands in for a prim and its draw mode; (None, "") when the prim itself is drawn."""
    for path in prim.GetPath().GetPrefixes():
        ancestor = prim.GetStage().GetPrimAtPath(path)
        mode = UsdGeom.ModelAPI(ancestor).ComputeModelDrawMode() if ancestor.IsModel() else "default"
        if mode == "default":
            continue
        authored = ancestor.HasAPI(UsdGeom.ModelAPI) and ancestor.GetAttribute("model:applyDrawMode").Get()
        isAuthored = (ancestor.HasAPI(UsdGeom.ModelAPI)
                      and ancestor.GetAttribute("model:applyDrawMode").HasAuthoredValue())
        if authored if isAuthored else Usd.ModelAPI(ancestor).GetKind() == Kind.Tokens.component:
            return str(path), mode
    return None, ""


@pytest.mark.parametrize("seed", range(30))
def test_models_are_replaced_where_openusd_says(seed):
    stage = RandomModels(seed)
    meshes, lines = set(), set()
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            model, mode = StandInOf(prim)
            (lines if mode in ("bounds", "origin") else meshes).add(model or str(prim.GetPath()))
    session = Translate(stage)
    scene = session.Scene()
    isLines = {path: prim.geometry.primitives == _core.PrimitiveKind.Curves for path, prim in scene.geometry.items()}
    assert {path for path, isLine in isLines.items() if not isLine} == meshes
    assert {path for path, isLine in isLines.items() if isLine} == lines
    assert not session.Warnings()


def test_instances_that_look_otherwise_have_their_own_cards():
    """UsdImaging's legacy mode takes the first instance's for all of a prototype."""
    body = "".join(f"""
        def Xform "{name}" (instanceable = true; kind = "component"; references = </P>; {CARDS}) {{
            uniform token model:drawMode = "{mode}"
            uniform color3f model:drawModeColor = ({red}, 0, 0)
        }}""" for name, mode, red in (("A", "cards", 1), ("B", "cards", 0.5), ("C", "cards", 1), ("D", "default", 1)))
    scene = Translate(StageOf(f'class "P" {{ def Mesh "M" {{ {TRIANGLE} }} }} {body}')).Scene()
    assert {path: len(instancer.instanceTransforms) for path, instancer in scene.instancers.items()} == {
        "/A": 2, "/B": 1, "/D": 1}
    assert sorted(scene.geometry) == ["/A{/A}", "/B{/B}", "/D/M"]


def test_instances_share_cards_whatever_their_assets_bind_inside():
    body = "".join(f'def Xform "{name}" (instanceable = true; kind = "component"; references = </P>) {{}}\n' for name in "ABC")
    scene = Translate(StageOf(f"""class "P" ({CARDS.replace("]", ', "MaterialBindingAPI"]')}) {{
            uniform token model:drawMode = "cards"
            rel material:binding = </P/Look>
            def Material "Look" {{}}
            def Mesh "M" {{ {TRIANGLE} }} }}
        {body}""")).Scene()
    assert {path: len(instancer.instanceTransforms) for path, instancer in scene.instancers.items()} == {"/A": 3}


def test_instances_that_inherit_other_modes_are_apart():
    """The models are below the instances, which look alike but for what they hand down."""
    stage = StageOf(f"""
        class "P" {{ def Mesh "M" (kind = "component") {{ {TRIANGLE} }} }}
        def Xform "A" (instanceable = true; kind = "group"; references = </P>; {CARDS}) {{
            uniform token model:drawMode = "cards"
        }}
        def Xform "B" (instanceable = true; kind = "group"; references = </P>) {{}}
        def Xform "G" (kind = "group"; {CARDS}) {{
            uniform token model:drawMode = "bounds"
            def Xform "C" (instanceable = true; kind = "group"; references = </P>) {{}}
        }}
    """)
    session = Translate(stage)
    scene = session.Scene()
    assert {path: len(prim.geometry.faceVertexCounts) for path, prim in scene.geometry.items()} == {
        "/A/M": 6, "/B/M": 1, "/G/C/M": 1}
    assert sorted(scene.instancers) == ["/A", "/B", "/G/C"]
    assert scene.geometry["/G/C/M"].geometry.curves.wrap == "segmented"
    assert not session.Warnings()


def test_lines_are_the_edges_of_the_bounds():
    """And the axes of an origin; the widths are the core's, not the authored 1."""
    stage = StageOf(f"""
        def Mesh "B" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "bounds"
            {TRIANGLE} }}
        def Mesh "O" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "origin"
            uniform color3f model:drawModeColor = (1, 0.5, 0)
            {TRIANGLE} }}
    """)
    scene = Translate(stage).Scene()

    def Edges(path):
        lines = scene.geometry[path].geometry
        ends = lines.points.reshape(-1, 3)[lines.faceVertexIndices].reshape(-1, 2, 3)
        assert list(lines.faceVertexCounts) == [2 * len(ends)] and lines.curves.type == "linear"
        return {frozenset(map(tuple, pair.tolist())) for pair in ends}

    corners = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
    assert Edges("/B") == {frozenset((a, b)) for a in corners for b in corners
                           if sum(p != q for p, q in zip(a, b)) == 1}
    assert Edges("/O") == {frozenset(((0.0, 0.0, 0.0), axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))}
    primvars = {primvar.name: primvar.values.ravel().tolist() for primvar in scene.geometry["/O"].geometry.primvars}
    assert primvars == {"displayColor": [1, 0.5, 0], "displayOpacity": [1], "widths": [1]}


@pytest.mark.parametrize("text, expected", [
    (f'def Xform "M" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "cards" }}',
     "/M: cards of a model without extent"),
    (f'def Mesh "M" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "film"\n{TRIANGLE} }}',
     "/M: draw mode film is unknown"),
    (f'def Mesh "M" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "cards"\n'
     f'uniform token model:cardGeometry = "disc"\n{TRIANGLE} }}', "/M: card geometry disc is unknown"),
    (f'def Mesh "M" (kind = "component"; {CARDS}) {{ uniform token model:drawMode = "cards"\n'
     f'uniform token model:cardGeometry = "fromTexture"\nasset model:cardTextureXPos = @none.exr@\n{TRIANGLE} }}',
     "/M: texture none.exr has no worldtoscreen matrix"),
])
def test_what_is_no_card_is_one_warning(text, expected):
    session = Translate(StageOf(text))
    assert not session.Scene().geometry
    assert len(session.Warnings()) == 1 and session.Warnings()[0].startswith(expected)


def test_cut_off_images_have_no_matrices(tmp_path):
    """Wherever the file ends: no matrix or the whole one, never an exception."""
    whole = (FOLDER / "drawModes" / "card.exr").read_bytes()
    expected = ReadMatrices(_core.AssetReference("", str(FOLDER / "drawModes" / "card.exr")))
    assert list(expected) == ["worldToNDC"] and expected["worldToNDC"][3][2] == pytest.approx(0.3)
    path = tmp_path / "cut.exr"
    for size in range(0, len(whole), 3):
        path.write_bytes(whole[:size])
        assert ReadMatrices(_core.AssetReference("", str(path))) in ({}, expected)
    path.write_bytes(whole[:8] + b"a\0b\0" + struct.pack("<i", -9) + whole[8:])
    assert ReadMatrices(_core.AssetReference("", str(path))) == {}
    os.mkfifo(tmp_path / "pipe.exr")  # nobody writes into it
    assert ReadMatrices(_core.AssetReference("", f"{tmp_path}/pipe.exr")) == {}
    path.write_bytes(b"in a package" + whole)
    assert ReadMatrices(_core.AssetReference("", str(path), 12, len(whole))) == expected


@pytest.mark.parametrize("mode", ["default", "cards", "bounds"])
@pytest.mark.parametrize("isInstanced", [False, True])
def test_stand_ins_are_linked_as_their_models(mode, isInstanced):
    instanceable = "instanceable = true; references = </P>" if isInstanced else "references = </P>"
    body = "".join(f"""def Xform "{name}" ({instanceable}; kind = "component"; {CARDS}) {{
        uniform token model:drawMode = "{mode}" }}
        """ for name in "ABC")
    scene = Translate(StageOf(f"""class "P" {{ def Mesh "M" {{ {TRIANGLE} }} }}
        {body}
        def SphereLight "L" (prepend apiSchemas = ["CollectionAPI:lightLink"]) {{
            uniform bool collection:lightLink:includeRoot = 0
            rel collection:lightLink:includes = [</A>, </C>]
        }}""")).Scene()
    assert {path.split("{")[0].split("/")[1]: prim.categories for path, prim in scene.geometry.items()} == (
        {"A": {"/L.collection:lightLink"}, "B": set()} if isInstanced
        else {"A": {"/L.collection:lightLink"}, "B": set(), "C": {"/L.collection:lightLink"}})
    if isInstanced:
        assert {path: len(instancer.instanceTransforms) for path, instancer in scene.instancers.items()} == {"/A": 2, "/B": 1}


def test_instanced_stand_ins_move_as_their_models():
    moving = """double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 2: (5, 0, 0) }
        uniform token[] xformOpOrder = ["xformOp:translate"]"""
    def SamplesIn(mode):
        stage = StageOf(f"""class "P" {{ def Mesh "M" {{ {TRIANGLE} }} }}
            def Xform "A" (instanceable = true; references = </P>; kind = "component"; {CARDS}) {{
                uniform token model:drawMode = "{mode}"
                {moving} }}
            def Xform "B" (instanceable = true; references = </P>; kind = "component"; {CARDS}) {{
                uniform token model:drawMode = "{mode}" }}
            def Camera "Camera" {{ double shutter:open = -0.5; double shutter:close = 0.5 }}""")
        (instancer,) = Translate(stage, 1.0).Scene().instancers.values()
        return [(time, np.asarray(matrices).reshape(2, 4, 4)[:, 3, 0].tolist()) for time, matrices in instancer.samples]

    found = SamplesIn("cards")
    assert found[0] == (-0.5, [1.25, 0]) and found[-1] == (0.5, [3.75, 0])
    assert found == SamplesIn("bounds") == SamplesIn("default")
