# SPDX-License-Identifier: Apache-2.0
"""Prims that rays of some kinds do not see.

Oracles: renders of the same stage without the prim, to the bit where nothing else may differ; and that light is linear: what
diffuse and glossy lobes receive adds up.
"""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

WIDTH, HEIGHT = 48, 36
_KINDS = ("camera", "shadow", "diffuse", "reflection", "transmission")


def _Write(path, floor=None, hidden=(), names=("Ball",), namespace="hdstream:visibility:", further=(), isInstanced=False, hasPane=False):
    """A floor under a lamp, and a box above it that rays of the kinds `hidden` do not see."""
    stage = author.NewStage(str(path))
    plane = author.AddMesh(stage, "/World/Floor", shapes.Box(6.0, 0.2, 6.0), color=(0.6, 0.6, 0.6), translate=(0, -0.1, 0))
    if floor:
        material = UsdShade.Material.Define(stage, "/Looks/Floor")
        shader = UsdShade.Shader.Define(stage, "/Looks/Floor/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        for name, value in floor.items():
            kind = Sdf.ValueTypeNames.Color3f if isinstance(value, tuple) else Sdf.ValueTypeNames.Float
            shader.CreateInput(name, kind).Set(value)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(plane.GetPrim()).Bind(material)
    if "Ball" in names:
        place = "/World/Many/Ball" if isInstanced else "/World/Ball"
        if isInstanced:
            instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
            instancer.CreateProtoIndicesAttr([0])
            instancer.CreatePositionsAttr([(0, 0, 0)])
        box = author.AddMesh(stage, place, shapes.Box(1.2, 1.2, 1.2), color=(0.9, 0.3, 0.1), translate=(0, 0.9, 0))
        if isInstanced:
            instancer.CreatePrototypesRel().SetTargets([place])
        api = UsdGeom.PrimvarsAPI(box)
        for kind in hidden:
            api.CreatePrimvar(namespace + kind, Sdf.ValueTypeNames.Bool, UsdGeom.Tokens.constant).Set(False)
        for name in further:
            api.CreatePrimvar(name, Sdf.ValueTypeNames.Bool, UsdGeom.Tokens.constant).Set(True)
    if hasPane:
        pane = author.AddMesh(stage, "/World/Pane", shapes.Box(3.0, 3.0, 0.05), translate=(1.3, 2.1, 4.0))
        glass = UsdShade.Material.Define(stage, "/Looks/Glass")
        shader = UsdShade.Shader.Define(stage, "/Looks/Glass/Surface")
        shader.CreateIdAttr("ND_standard_surface_surfaceshader")
        shader.CreateInput("base", Sdf.ValueTypeNames.Float).Set(0.0)
        shader.CreateInput("transmission", Sdf.ValueTypeNames.Float).Set(1.0)
        shader.CreateInput("specular_roughness", Sdf.ValueTypeNames.Float).Set(0.0)
        glass.CreateSurfaceOutput("mtlx").ConnectToSource(shader.ConnectableAPI(), "out")
        UsdShade.MaterialBindingAPI.Apply(pane.GetPrim()).Bind(glass)
    author.AddLight(stage, "/World/Lamp", "Rect", placement=dict(translate=(0, 4, 0), rotate=(-90, 0, 0)), intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(2.0, 3.0, 6.0), target=(0, 0.4, 0), focalLength=30.0)
    stage.GetRootLayer().Save()
    return str(path)


def _Render(tmp_path, samples=8, maxDepth=2, aovs=("color",), settings=None, **stage):
    picture = ours.Render(_Write(tmp_path / "a.usda", **stage), WIDTH, HEIGHT, aovs, samples=samples, maxDepth=maxDepth,
                          domeVisible=False, **(settings or {}))
    return picture.layers


def _FloorAlone(tmp_path):
    """Pixels that show nothing but the floor, whoever is there."""
    layers = _Render(tmp_path, samples=1, aovs=("color", "primId", "alpha"))
    behind = _Render(tmp_path, samples=1, aovs=("color", "primId"), names=())
    box = np.unique(layers["primId"])[1]
    covered = layers["primId"] == box
    grown = covered.copy()
    for shift in (-1, 1):
        for axis in (0, 1):
            grown |= np.roll(covered, shift, axis)
    return (behind["primId"] >= 0) & ~grown, covered


def test_what_no_ray_sees_is_not_there(tmp_path):
    hidden = _Render(tmp_path, hidden=_KINDS)
    assert hidden["color"].tobytes() == _Render(tmp_path, names=())["color"].tobytes()
    assert hidden["color"].tobytes() != _Render(tmp_path)["color"].tobytes()


@pytest.mark.parametrize("text, hidden", [
    ("", _KINDS), ("*", ()), ("-primary", ("camera",)), ("shadow | diffuse|reflect|refract", ("camera",)),
    ("-diffuse & -reflect&-refract", ("diffuse", "reflection", "transmission")), ("primary", _KINDS[1:]),
    ("primary|-shadow&*", ("shadow",)),
])
def test_karma_says_it_by_an_expression(tmp_path, text, hidden):
    def Karma(primvar):
        path = _Write(tmp_path / "k.usda")
        stage = Usd.Stage.Open(path)
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Ball")).CreatePrimvar(
            "karma:object:rendervisibility", Sdf.ValueTypeNames.String, UsdGeom.Tokens.constant).Set(primvar)
        stage.GetRootLayer().Save()
        return ours.Render(path, WIDTH, HEIGHT, samples=8, maxDepth=2, domeVisible=False)

    expected = _Render(tmp_path, hidden=hidden)
    found = Karma(text)
    assert found.layers["color"].tobytes() == expected["color"].tobytes()
    assert not [line for line in found.warnings if "rendervisibility" in line]


@pytest.mark.parametrize("text", ["primary|", "secondary", "--shadow", "&diffuse"])
def test_an_expression_that_cannot_be_read_is_a_warning(tmp_path, text):
    path = _Write(tmp_path / "k.usda")
    stage = Usd.Stage.Open(path)
    UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Ball")).CreatePrimvar(
        "karma:object:rendervisibility", Sdf.ValueTypeNames.String, UsdGeom.Tokens.constant).Set(text)
    stage.GetRootLayer().Save()
    picture = ours.Render(path, WIDTH, HEIGHT, samples=1)
    assert "/World/Ball: karma:object:rendervisibility cannot be read; it is ignored" in picture.warnings


def test_what_the_camera_does_not_see_still_casts_shadows(tmp_path):
    floor, covered = _FloorAlone(tmp_path)
    seen, hidden = _Render(tmp_path, hidden=()), _Render(tmp_path, hidden=("camera",))
    assert np.array_equal(seen["color"][floor], hidden["color"][floor])
    assert not np.array_equal(seen["color"][covered], hidden["color"][covered])


def test_what_casts_no_shadow_darkens_nothing(tmp_path):
    """Of direct light, at the floor."""
    floor, covered = _FloorAlone(tmp_path)
    alone = _Render(tmp_path, maxDepth=0, names=())
    unshadowed, shadowed = (_Render(tmp_path, maxDepth=0, hidden=hidden) for hidden in (("shadow", "diffuse"), ()))
    assert np.array_equal(unshadowed["color"][floor], alone["color"][floor])
    assert (shadowed["color"][floor] < alone["color"][floor]).any()
    assert not np.array_equal(unshadowed["color"][covered], alone["color"][covered])


def test_mirrors_show_what_reflection_rays_see(tmp_path):
    mirror = {"metallic": 1.0, "roughness": 0.0, "diffuseColor": (0.9, 0.9, 0.9)}
    floor, _ = _FloorAlone(tmp_path)
    hidden = _Render(tmp_path, floor=mirror, hidden=("reflection", "shadow"), samples=4)
    alone = _Render(tmp_path, floor=mirror, names=(), samples=4)
    seen = _Render(tmp_path, floor=mirror, samples=4)
    assert np.array_equal(hidden["color"][floor], alone["color"][floor])
    assert (np.abs(seen["color"][floor] - alone["color"][floor]).max(-1) > 0.02).mean() > 0.05
    diffuse = _Render(tmp_path, floor=mirror, hidden=("diffuse",), samples=4)
    assert np.array_equal(diffuse["color"][floor], seen["color"][floor])  # a mirror has no diffuse rays


def test_lobes_see_each_for_itself(tmp_path):
    """With both hidden and with none, light adds up to that with the one and with the other hidden; and what the glossy lobe
    gains is what it gains where there is no other."""
    plastic = {"roughness": 0.8, "diffuseColor": (0.3, 0.3, 0.3), "ior": 2.5}
    floor, _ = _FloorAlone(tmp_path)

    def Mean(material, *hidden):
        color = _Render(tmp_path, floor=material, hidden=("camera", "shadow", *hidden), samples=256, maxDepth=1)["color"]
        return color[..., :3][floor].astype(float).mean(0)

    means = {hidden: Mean(plastic, *hidden) for hidden in ((), ("diffuse",), ("reflection",), ("diffuse", "reflection"))}
    none, diffuse, glossy, both = means.values()
    black = {**plastic, "diffuseColor": (0.0, 0.0, 0.0)}
    assert np.allclose(none - glossy, Mean(black) - Mean(black, "reflection"), rtol=0.1), means
    gains = none - diffuse, none - glossy
    assert all(abs(gain[0]) > 1e-3 for gain in gains), means  # each of them matters
    assert np.allclose(none + both, diffuse + glossy, atol=1e-4), means


def test_glass_shows_what_transmission_rays_see(tmp_path):
    """Through a pane before the camera: what reflects has no share in it."""
    panes = {hidden: _Render(tmp_path, hasPane=True, hidden=hidden, samples=4)["color"]
             for hidden in ((), ("transmission",), ("reflection",))}
    alone = _Render(tmp_path, hasPane=True, names=(), samples=4)["color"]
    _, covered = _FloorAlone(tmp_path)
    assert not np.array_equal(panes[()][covered], alone[covered])
    # Shadows, and light from the box on the floor, are still there; the box itself is not.
    assert np.abs(panes[("transmission",)] - panes[()])[covered].mean() > 0.05
    assert np.abs(panes[("reflection",)] - panes[()])[covered].mean() < 0.01


def test_holdouts_are_black_and_transparent(tmp_path):
    """What is left is the rest of the picture."""
    floor, covered = _FloorAlone(tmp_path)
    whole = _Render(tmp_path, aovs=("color", "alpha"))
    cut = _Render(tmp_path, aovs=("color", "alpha"), further=("hdstream:holdout",))
    assert np.array_equal(whole["color"][floor], cut["color"][floor])
    inside = covered & np.roll(covered, 1, 0) & np.roll(covered, -1, 0) & np.roll(covered, 1, 1) & np.roll(covered, -1, 1)
    assert inside.sum() > 30 and not cut["color"][inside].any() and not cut["alpha"][inside].any()


@pytest.mark.parametrize("settings", [{"residency": "stream", "geometryMemory": "55%", "chunkBytes": 16384},
                                      {"residency": "stream", "geometryMemory": "55%", "chunkBytes": 16384, "request": "first"},
                                      {"traversal": "scalar"}, {"waveSize": 4096}], ids=["pool", "report", "scalar", "waves"])
def test_bits_depend_on_nothing_else(tmp_path, settings):
    stage = dict(hidden=("shadow", "diffuse"), floor={"roughness": 0.3, "diffuseColor": (0.5, 0.5, 0.5)})
    one, other = _Render(tmp_path, **stage), _Render(tmp_path, settings=settings, **stage)
    assert one["color"].tobytes() == other["color"].tobytes()


def test_names_of_arnold_and_instances(tmp_path):
    ours_ = _Render(tmp_path, hidden=("camera",))
    assert np.array_equal(ours_["color"], _Render(tmp_path, hidden=("camera",), namespace="arnold:visibility:")["color"])
    assert np.array_equal(_Render(tmp_path, hidden=("diffuse",))["color"],
                          _Render(tmp_path, hidden=("diffuse_reflect",), namespace="arnold:visibility:")["color"])
    held = _Render(tmp_path, further=("hdstream:holdout",))["color"]
    for name in ("arnold:matte", "ri:attributes:trace:holdout"):
        assert np.array_equal(held, _Render(tmp_path, further=(name,))["color"])
    namespace = "ri:attributes:visibility:"
    for name, kinds in (("camera", ("camera",)), ("transmission", ("shadow",)), ("indirect", ("diffuse", "reflection", "transmission"))):
        assert np.array_equal(_Render(tmp_path, hidden=kinds)["color"], _Render(tmp_path, hidden=(name,), namespace=namespace)["color"])
    hidden = _Render(tmp_path, hidden=_KINDS, isInstanced=True)
    assert np.array_equal(hidden["color"], _Render(tmp_path, names=())["color"])


def _Many(path, isInstanced, values):
    """Boxes in rows above a floor, as instances or as prims of their own; values: primvar -> one an instance."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Box(12.0, 0.2, 12.0), color=(0.6, 0.6, 0.6), translate=(0, -0.1, 0))
    count = len(next(iter(values.values())))
    places = [(0.5 * (number % 14) - 3.2, 0.3, 0.5 * (number // 14) - 2.5) for number in range(count)]
    box = shapes.Box(0.3, 0.3, 0.3)
    if isInstanced:
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
        author.AddMesh(stage, "/World/Many/Box", box, color=(0.9, 0.3, 0.1))
        author.AddMesh(stage, "/World/Many/Lid", box, color=(0.1, 0.3, 0.9), translate=(0, 0.3, 0))
        group = UsdGeom.Xform.Define(stage, "/World/Many/Two")
        author.AddMesh(stage, "/World/Many/Two/A", box, color=(0.1, 0.9, 0.2))
        author.AddMesh(stage, "/World/Many/Two/B", box, color=(0.9, 0.9, 0.2), translate=(0, 0.4, 0))
        instancer.CreatePrototypesRel().SetTargets(["/World/Many/Box", "/World/Many/Lid", group.GetPath()])
        instancer.CreateProtoIndicesAttr([number % 3 for number in range(count)])
        instancer.CreatePositionsAttr(places)
        for name, rows in values.items():
            UsdGeom.PrimvarsAPI(instancer).CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, "vertex").Set([float(row) for row in rows])
    for number, place in enumerate(() if isInstanced else places):
        parent = UsdGeom.Xform.Define(stage, f"/World/Many/I{number:03}")
        author.Place(parent, translate=place)
        parts = [[("Box", (0.9, 0.3, 0.1), 0.0)], [("Lid", (0.1, 0.3, 0.9), 0.3)], [("A", (0.1, 0.9, 0.2), 0.0), ("B", (0.9, 0.9, 0.2), 0.4)]]
        for name, color, height in parts[number % 3]:
            mesh = author.AddMesh(stage, f"{parent.GetPath()}/{name}", box, color=color, translate=(0, height, 0))
            for primvar, rows in values.items():
                UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(primvar, Sdf.ValueTypeNames.Float, "constant").Set(float(rows[number]))
    author.AddLight(stage, "/World/Lamp", "Rect", placement=dict(translate=(0, 4, 0), rotate=(-90, 0, 0)), intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(2.0, 4.0, 7.0), target=(0, 0.2, 0), focalLength=30.0)
    stage.GetRootLayer().Save()
    return str(path)


def test_instances_are_seen_each_for_itself_however_many_differ(tmp_path):
    """As prims of their own are, and with one geometry: 196 instances, no two with the same values."""
    rng = np.random.default_rng(5)
    count = 196
    values = {f"hdstream:visibility:{kind}": np.where(rng.random(count) < 0.4, 0.0, 1.0 + np.arange(count)) for kind in _KINDS}
    values["hdstream:holdout"] = np.where(rng.random(count) < 0.2, 1.0 + np.arange(count), 0.0)
    pictures = [ours.Render(_Many(tmp_path / f"{isInstanced}.usda", isInstanced, values), WIDTH, HEIGHT, ("color", "alpha", "cameraDepth"),
                            samples=8, maxDepth=2, domeVisible=False) for isInstanced in (True, False)]
    for name, pixels in pictures[0].layers.items():
        assert np.allclose(pixels, pictures[1].layers[name], rtol=2e-4, atol=2e-4), name
    assert pictures[0].statistics["geometry"]["triangles"] == 12 + 4 * 12  # the floor, and each prim once
    assert not [line for line in pictures[0].warnings if "64" in line]
    plain = ours.Render(_Many(tmp_path / "plain.usda", True, {"other": np.ones(count)}), WIDTH, HEIGHT, samples=8, maxDepth=2, domeVisible=False)
    assert np.abs(plain.layers["color"] - pictures[0].layers["color"]).mean() > 0.02
