# SPDX-License-Identifier: Apache-2.0
"""Render passes: the scene of a pass is the scene of a stage that says the same by other means.

Oracles: the stage with prims deactivated, made invisible, or with primvars of visibility; what usd-core's own query of the
collection says of every instance proxy.
"""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdRender

from hdstream import _core
from hdstream.translate import TranslateStage

from translateCase import StageOf

BODY = """
def Xform "World" {
    def Xform "Left" {
        def Cube "A" { def Sphere "Inside" {} }
        def Sphere "B" {}
    }
    def Xform "Right" {
        def Mesh "C" {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
        }
        def BasisCurves "D" {
            int[] curveVertexCounts = [2]
            point3f[] points = [(0, 0, 0), (0, 1, 0)]
            uniform token type = "linear"
        }
    }
    def SphereLight "Lamp" {}
}
def Xform "Shape" { def Cube "Body" {} def Sphere "Head" {} }
def Xform "I1" (instanceable = true; references = </Shape>) {}
def Xform "I2" (instanceable = true; references = </Shape>) {
    double3 xformOp:translate = (4, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"] }
def Xform "I3" (instanceable = true; references = </Shape>) {
    double3 xformOp:translate = (8, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"] }
def PointInstancer "Many" {
    rel prototypes = [</Many/Protos/P>, </Elsewhere/Q>]
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 0), (0, 3, 0), (0, 6, 0)]
    def Scope "Protos" { def Xform "P" { def Cube "Box" {} def Sphere "Ball" {} } }
}
def Scope "Elsewhere" { def Cube "Q" {} }
"""
_CAMERA, _HOLDOUT = "hdstream:pass:camera", "hdstream:pass:matte"


def _Stage():
    return StageOf(BODY)


def _Pass(stage, **collections):
    """A pass. A collection: (includes, excludes), or the text of a path expression."""
    prim = UsdRender.Pass.Define(stage, "/Render/Pass").GetPrim()
    for name, members in collections.items():
        api = Usd.CollectionAPI.Apply(prim, name)
        if isinstance(members, str):
            api.CreateIncludeRootAttr(False)
            api.CreateMembershipExpressionAttr(Sdf.PathExpression(members))
            continue
        includes, excludes = members
        if includes is not None:
            api.CreateIncludeRootAttr(False)
            api.CreateIncludesRel().SetTargets(includes)
        api.CreateExcludesRel().SetTargets(excludes)
    return prim


def _Session(stage, passPrim=None):
    session = _core.Session()
    TranslateStage(stage, session, Usd.TimeCode.Default(), passPrim=passPrim)
    return session


def _Dump(stage, passPrim=None):
    return _Session(stage, passPrim).Dump()


def _DumpOfPass(**collections):
    stage = _Stage()
    return _Dump(stage, _Pass(stage, **collections))


def _Say(prim, name, value):
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, Sdf.ValueTypeNames.Float, UsdGeom.Tokens.constant).Set(value)


def test_a_pass_whose_collections_do_nothing_is_no_pass():
    plain = _Dump(_Stage())
    assert _DumpOfPass() == plain
    assert _DumpOfPass(renderVisibility=(None, []), cameraVisibility=(None, []), matte=([], []), prune=([], [])) == plain


@pytest.mark.parametrize("pruned", [
    ["/World/Left"], ["/World/Left/A"], ["/World/Right/D", "/World/Lamp"], ["/I2"], ["/Many"], ["/Many/Protos/P/Ball"],
    ["/Elsewhere/Q"], ["/Elsewhere", "/I1", "/I2", "/I3"],
])
def test_what_is_pruned_is_as_if_deactivated(pruned):
    stage = _Stage()
    for path in pruned:
        stage.GetPrimAtPath(path).SetActive(False)
    expected = _Dump(stage)
    assert expected != _Dump(_Stage())
    assert _DumpOfPass(prune=(pruned, [])) == expected
    assert _DumpOfPass(prune=" ".join(pruned)) == expected


def test_pruning_inside_an_instance_leaves_the_other_instances():
    """An instance cannot be edited below its root, so the oracle is a stage with a second prototype."""
    stage = StageOf(BODY.replace('def Xform "I2" (instanceable = true; references = </Shape>)',
                                 'def Xform "I2" (instanceable = true; references = </Other>)')
                    + 'def Xform "Other" { def Cube "Body" {} }')
    stage.GetPrimAtPath("/Other").SetActive(False)  # is drawn where it is
    stage.GetPrimAtPath("/Other").SetSpecifier(Sdf.SpecifierClass)
    stage.GetPrimAtPath("/Other").SetActive(True)
    assert _DumpOfPass(prune=(["/I2/Head"], [])) == _Dump(stage)


@pytest.mark.parametrize("hidden", [
    ["/World/Left/B"], ["/World/Left/A"], ["/World/Right", "/World/Lamp"], ["/Many"], ["/Many/Protos/P"],
])
def test_what_is_left_out_of_renderVisibility_is_invisible(hidden):
    stage = _Stage()
    for path in hidden:
        UsdGeom.Imageable(stage.GetPrimAtPath(path)).CreateVisibilityAttr("invisible")
    expected = _Dump(stage)
    assert expected != _Dump(_Stage())
    assert _DumpOfPass(renderVisibility=(None, hidden)) == expected
    assert _DumpOfPass(renderVisibility="// - " + " - ".join(f"{path}//" for path in hidden)) == expected


def test_membership_is_each_prims_own():
    """A prim may be seen below one that is not."""
    stage = _Stage()
    session = _Session(stage, _Pass(stage, renderVisibility="/World/Left/A/Inside"))
    visible = {path for path, prim in session.Scene().geometry.items() if prim.placement.visible}
    assert visible == {"/World/Left/A/Inside"}
    assert "/I1" not in session.Scene().instancers


@pytest.mark.parametrize("name, primvar, value", [("cameraVisibility", _CAMERA, 0.0), ("matte", _HOLDOUT, 1.0)])
def test_cameraVisibility_and_matte_are_primvars_of_prims(name, primvar, value):
    chosen = ["/World/Left", "/World/Right/C", "/World/Right/D"]
    stage = _Stage()
    for path in chosen:
        for prim in Usd.PrimRange(stage.GetPrimAtPath(path)):
            if prim.IsA(UsdGeom.Gprim):
                _Say(prim, primvar, value)
    collection = ([path for path in chosen], []) if name == "matte" else (None, chosen)
    assert _DumpOfPass(**{name: collection}) == _Dump(stage)


def test_a_pass_takes_away_and_gives_nothing():
    """What says itself that the camera does not see it stays so; what says that it does is overruled."""
    stage = _Stage()
    _Say(stage.GetPrimAtPath("/World/Left/A"), _CAMERA, 0.0)
    _Say(stage.GetPrimAtPath("/World/Left/B"), _CAMERA, 1.0)
    scene = _Session(stage, _Pass(stage, cameraVisibility=(None, ["/World/Left/B"]))).Scene()
    for name in "AB":
        primvars = scene.geometry[f"/World/Left/{name}"].geometry.primvars
        assert [float(primvar.values[0]) for primvar in primvars if primvar.name == _CAMERA] == [0.0]


def test_lights_are_hidden_from_the_camera():
    stage = _Stage()
    scene = _Session(stage, _Pass(stage, cameraVisibility=(None, ["/World/Lamp"]))).Scene()
    assert not scene.lights["/World/Lamp"].light.visibleToCamera


def _FlagsByPlace(session):
    """(is rendered, seen by the camera, is matte) by the place of each leaf of native instances, from the scene."""
    scene = session.Scene()
    found = {}
    for path, prim in scene.geometry.items():
        instancer = scene.instancers.get(prim.placement.instancerPath)
        if instancer is None or not path.endswith(("Body", "Head")):
            continue
        rows = {primvar.name: primvar.values.reshape(-1) for primvar in instancer.primvars}
        own = {primvar.name: float(primvar.values[0]) for primvar in prim.geometry.primvars}
        for index in prim.placement.instances:
            primvars = {**{name: float(values[index]) for name, values in rows.items()}, **own}
            place = round(float(instancer.instanceTransforms.reshape(-1, 4, 4)[index, 3, 0]))
            found[place, path[-4:]] = (prim.placement.visible, primvars.get(_CAMERA, 1.0) != 0.0, primvars.get(_HOLDOUT) == 1.0)
    return found


@pytest.mark.parametrize("collections", [
    dict(matte=(["/I2"], [])), dict(cameraVisibility=(None, ["/I1", "/I3/Head"])), dict(renderVisibility=(["/I2", "/I3/Body"], [])),
    dict(matte="/I*/Head", cameraVisibility="// - /I2//", renderVisibility=(None, ["/I3"])),
    dict(matte=(["/I1/Body", "/I2/Body", "/I3/Body"], []), renderVisibility="//Head"),
])
def test_native_instances_are_told_apart(collections):
    stage = _Stage()
    prim = _Pass(stage, **collections)
    queries = {name: Usd.CollectionAPI(prim, name).ComputeMembershipQuery()
               for name in ("renderVisibility", "cameraVisibility", "matte")}
    expected = {}
    for place, instance in ((0, "/I1"), (4, "/I2"), (8, "/I3")):
        for leaf in ("Body", "Head"):
            flags = tuple(bool(query.IsPathIncluded(f"{instance}/{leaf}")) for query in queries.values())
            if flags[0]:
                expected[place, leaf] = flags
    found = _FlagsByPlace(_Session(stage, prim))
    assert {key: flags for key, flags in found.items() if flags[0]} == expected


def test_prototypes_have_the_membership_of_their_instancer():
    """And of their own path where they lie below it; /Elsewhere/Q does not, and is drawn where it is as well."""
    def FlagsOf(**collections):
        stage = _Stage()
        scene = _Session(stage, _Pass(stage, **collections)).Scene()
        return {path: any(primvar.name == _HOLDOUT for primvar in prim.geometry.primvars)
                for path, prim in scene.geometry.items() if path.startswith(("/Many", "/Else"))}

    box, ball, foreign, own = "/Many/Protos/P/Box", "/Many/Protos/P/Ball", "/Many{/Elsewhere/Q}", "/Elsewhere/Q"
    assert FlagsOf(matte=(["/Many"], [])) == {box: True, ball: True, foreign: True, own: False}
    assert FlagsOf(matte=(["/Many/Protos/P/Ball"], [])) == {box: False, ball: True, foreign: False, own: False}
    assert FlagsOf(matte=(["/Elsewhere"], [])) == {box: False, ball: False, foreign: False, own: True}


def test_draw_modes_are_matted_too():
    body = BODY.replace('def Xform "World" {', 'def Xform "World" (kind = "group") {').replace('def Xform "Left" {', 'def Xform "Left" (kind = "component"; prepend apiSchemas = ["GeomModelAPI"]) {'
                        ' uniform token model:drawMode = "bounds"')
    stage = StageOf(body)
    scene = _Session(stage, _Pass(stage, matte=(["/World/Left"], []))).Scene()
    assert [float(primvar.values[0]) for primvar in scene.geometry["/World/Left"].geometry.primvars
            if primvar.name == _HOLDOUT] == [1.0]


def test_volumes_warn():
    stage = StageOf('def Volume "Cloud" {}')
    warnings = _Session(stage, _Pass(stage, matte=(["/Cloud"], []))).Warnings()
    assert any("volumes have no matte" in line for line in warnings), warnings


def test_edits_of_a_pass_and_of_what_is_in_it(tmp_path):
    """An edited session has the scene of a fresh one."""
    from hdstream.translate.stageEdits import StageTranslation
    stage = StageOf(BODY.split('def Xform "Shape"')[0])  # without instances, so that edits translate what they touch
    prim = _Pass(stage, prune="/World/Left", matte=(["/World/Right/C"], []))
    session = _core.Session()
    translation = StageTranslation(stage, session, lambda: None)

    def AssertFresh(path="/Render/Pass"):
        translation.Update(Usd.TimeCode.Default(), passPath=path)
        assert session.Dump() == _Dump(stage, prim if path else None)

    AssertFresh()
    stage.GetPrimAtPath("/World/Left/B").GetAttribute("radius").Set(3.0)  # pruned
    AssertFresh()
    stage.GetPrimAtPath("/World/Right/C").GetAttribute("points").Set([(-2, -1, 0), (1, -1, 0), (0, 1, 0)])
    AssertFresh()
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Right")).MakeInvisible()
    AssertFresh()
    Usd.CollectionAPI(prim, "prune").GetMembershipExpressionAttr().Set(Sdf.PathExpression("/World/Lamp"))
    AssertFresh()
    AssertFresh("")
    UsdLux.SphereLight(stage.GetPrimAtPath("/World/Lamp")).GetIntensityAttr().Set(3.0)
    AssertFresh()


@pytest.mark.parametrize("collections", [dict(matte=(["/I2"], [])), dict(cameraVisibility=(None, ["/I1"]), matte=(["/I1", "/I3"], []))])
def test_instances_that_differ_as_wholes_share_their_geometry(collections):
    """By primvars of their instancer; not where something inside a prototype is an instance again."""
    stage = _Stage()
    scene = _Session(stage, _Pass(stage, **collections)).Scene()
    assert [path for path in scene.instancers if path.startswith("/I")] == ["/I1"]
    assert sorted(path for path in scene.geometry if path.startswith("/I")) == ["/I1/Body", "/I1/Head"]
    nested = StageOf(BODY.replace('def Xform "Shape" {', 'def Xform "Shape" { def Xform "In" (instanceable = true; '
                                  'references = </World/Left>) {} '))
    scene = _Session(nested, _Pass(nested, **collections)).Scene()
    assert [path for path in scene.instancers if path in ("/I1", "/I2")] == ["/I1", "/I2"]
