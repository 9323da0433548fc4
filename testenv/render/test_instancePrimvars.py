# SPDX-License-Identifier: Apache-2.0
"""Primvars that differ between instances.

Oracles: the authored numbers, found by instanceId, to the bit; the same stage with a mesh of its own for each instance,
which has the value as a constant primvar.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

SIZE = (64, 48)
_COLOR, _FLOATS = "primvars:displayColor", Sdf.ValueTypeNames.Color3fArray
_AOVS = (_COLOR, "instanceId", "color")


def _Rows(count, seed=1, components=3):
    return np.random.default_rng(seed).random((count, components), np.float32)


def _Primvar(prim, name, rows, interpolation="vertex"):
    kind = {1: Sdf.ValueTypeNames.FloatArray, 3: _FLOATS}[rows.shape[1]]
    values = Vt.FloatArray.FromNumpy(rows[:, 0].copy()) if rows.shape[1] == 1 else Vt.Vec3fArray.FromNumpy(rows)
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(values)


def _Plane(stage, count, side, path="/World/Many"):
    """A point instancer with `count` small squares side by side, and its camera from above."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    ranks = np.arange(count)
    places = np.stack([ranks % side, ranks // side, np.zeros(count)], 1).astype(np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(places))
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.zeros(count, np.int32)))
    _Square(stage, path + "/Square")
    instancer.CreatePrototypesRel().SetTargets([path + "/Square"])
    return instancer


def _Square(stage, path):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def _Camera(stage, centre, height):
    author.AddCamera(stage, eye=(*centre, height), target=(*centre, 0), up=(0, 1, 0), focalLength=30.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)


def _Stage(tmp_path, name="a"):
    return author.NewStage(str(tmp_path / f"{name}.usda"))


def _Save(stage):
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _AssertRows(layers, rows, aov=_COLOR):
    """The AOV is the authored row of each instance seen. Returns the instances."""
    ids = layers["instanceId"]
    hit = ids >= 0
    shown = layers[aov][hit]
    expected = np.zeros((int(hit.sum()), 3), np.float32)
    expected[:, :rows.shape[1]] = rows[ids[hit]]
    assert shown.tobytes() == expected.tobytes()
    return np.unique(ids[hit])


def test_a_million_instances_show_what_is_authored(tmp_path):
    """As AOV and as what a Lambert surface reflects; tables take 12 bytes an instance beside what the same stage without
    colours takes, and the mesh is there once."""
    side, count = 1000, 1000 * 1000
    rows = _Rows(count)
    stage = _Stage(tmp_path)
    instancer = _Plane(stage, count, side)
    _Camera(stage, (side / 2, side / 2), 900.0)
    plain = ours.Render(_Save(stage), *SIZE, _AOVS, samples=2)
    _Primvar(instancer, "displayColor", rows)
    picture = ours.Render(_Save(stage), *SIZE, _AOVS, samples=2)
    assert len(_AssertRows(picture.layers, rows)) > 2000
    assert not plain.layers[_COLOR].any()
    assert picture.statistics["geometry"]["meshes"] == 1
    more = picture.statistics["memory"]["tables"] - plain.statistics["memory"]["tables"]
    assert abs(more - 12 * count) < 100  # buffers of no bytes take some too
    UsdGeom.Camera.Get(stage, "/World/Camera").CreateFocalLengthAttr(9000.0)
    near = ours.Render(_Save(stage), *SIZE, _AOVS, samples=1, maxDepth=1)
    ids = near.layers["instanceId"]
    inside = (ids == np.roll(ids, 1, 0)) & (ids == np.roll(ids, 1, 1)) & (ids == np.roll(ids, -1, 0)) & (ids == np.roll(ids, -1, 1))
    assert inside.sum() > 100 and len(np.unique(ids[inside])) > 4
    assert np.allclose(near.rgb[inside], rows[ids[inside]], rtol=1e-5)  # under a dome of 1


@pytest.mark.parametrize("settings", [
    {"waveSize": 3001}, {"traversal": "scalar"}, {"traversal": "simd8"},
    {"residency": "stream", "geometryMemory": "8K", "chunkBytes": 1 << 12}, {"residency": "resident"},
], ids=lambda settings: "-".join(str(value) for value in settings.values()))
def test_bits_depend_on_nothing_else(tmp_path, settings):
    stage, count = _Stage(tmp_path), 400
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    author.AddMesh(stage, "/World/Many/Ball", shapes.Sphere(0.5, 24, 48))
    ranks = np.arange(count)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.stack([ranks % 20, ranks // 20, 0 * ranks], 1).astype(np.float32)))
    instancer.CreateProtoIndicesAttr([0] * count)
    instancer.CreatePrototypesRel().SetTargets(["/World/Many/Ball"])
    rows = _Rows(count)
    _Primvar(instancer, "displayColor", rows)
    _Camera(stage, (9.5, 9.5), 22.0)
    path = _Save(stage)
    expected = ours.Render(path, *SIZE, _AOVS, samples=8).layers
    found = ours.Render(path, *SIZE, _AOVS, samples=8, **settings).layers
    assert len(_AssertRows(expected, rows)) == count
    for name in expected:
        assert found[name].tobytes() == expected[name].tobytes(), name


def _AddReader(stage, prim, node):
    """A Lambert material whose colour a node reads from the primvar tint."""
    material = UsdShade.Material.Define(stage, "/Looks/Tint")
    reader = UsdShade.Shader.Define(stage, "/Looks/Tint/Reader")
    surface = UsdShade.Shader.Define(stage, "/Looks/Tint/Surface")
    if node == "UsdPrimvarReader_float3":
        reader.CreateIdAttr(node)
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("tint")
        output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    else:
        reader.CreateIdAttr(node)
        reader.CreateInput("geomprop", Sdf.ValueTypeNames.String).Set("tint")
        output = reader.CreateOutput("out", Sdf.ValueTypeNames.Color3f)
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(output)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


@pytest.mark.parametrize("node", ["displayColor", "UsdPrimvarReader_float3", "ND_geompropvalue_color3"])
@pytest.mark.parametrize("isDeep", [False, True], ids=["direct", "behindGlass"])
def test_materials_read_what_a_mesh_of_its_own_would_have(tmp_path, node, isDeep):
    """Pictures of instances equal those of as many meshes with constant primvars, but for roundings of transforms: the places
    are small integers, so that there are none, and random numbers, which know instances by what is hit."""
    count, rows = 12, _Rows(12)
    pictures = []
    for isInstanced in (True, False):
        stage = _Stage(tmp_path, f"s{isInstanced}{isDeep}{node[:3]}")
        name = "displayColor" if node == "displayColor" else "tint"
        if isInstanced:
            instancer = _Plane(stage, count, 4)
            _Primvar(instancer, name, rows)
            readers = [stage.GetPrimAtPath("/World/Many/Square")]
        else:
            readers = []
            for rank in range(count):
                mesh = _Square(stage, f"/World/Square{rank:02}")
                UsdGeom.XformCommonAPI(mesh).SetTranslate((rank % 4, rank // 4, 0))
                _Primvar(mesh, name, rows[rank:rank + 1], "constant")
                readers.append(mesh.GetPrim())
        for prim in readers if node != "displayColor" else ():
            _AddReader(stage, prim, node)
        if isDeep:
            pane = author.AddMesh(stage, "/World/APane", shapes.Box(20, 20, 0.1), translate=(1.5, 1, 1))
            glass = UsdShade.Material.Define(stage, "/Looks/Glass")
            shader = UsdShade.Shader.Define(stage, "/Looks/Glass/Surface")
            shader.CreateIdAttr("UsdPreviewSurface")
            shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.5)
            shader.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)
            glass.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
            UsdShade.MaterialBindingAPI.Apply(pane.GetPrim()).Bind(glass)
        _Camera(stage, (1.5, 1.0), 5.0)
        pictures.append(ours.Render(_Save(stage), *SIZE, ("color",), samples=1, maxDepth=2).layers["color"])
    assert np.array_equal(*pictures) and pictures[0][..., :3].std() > 0.05


def test_native_instances_share_their_mesh(tmp_path):
    """Colours inherited from above each instance, and from the instance itself; a prim below that has its own keeps it, and
    so does a prototype of a point instancer inside."""
    stage, count = _Stage(tmp_path), 200
    rows = _Rows(count)
    _Square(stage, "/Library/Tile/Square")
    own = _Square(stage, "/Library/Tile/Own")
    UsdGeom.XformCommonAPI(own).SetTranslate((0, 0, -1))
    _Primvar(own, "displayColor", np.full((1, 3), 0.25, np.float32), "constant")
    inner = _Plane(stage, 2, 2, "/Library/Tile/Inner")
    UsdGeom.XformCommonAPI(inner).SetTranslate((0.25, 0.25, 0.5))
    UsdGeom.XformCommonAPI(UsdGeom.Mesh.Get(stage, "/Library/Tile/Inner/Square")).SetScale((0.2, 0.2, 0.2))
    stage.OverridePrim("/Library").SetSpecifier(Sdf.SpecifierClass)
    for rank in range(count):
        group = UsdGeom.Xform.Define(stage, f"/World/Group{rank:03}")
        UsdGeom.XformCommonAPI(group).SetTranslate((2 * (rank % 20), 2 * (rank // 20), 0))
        instance = stage.DefinePrim(f"/World/Group{rank:03}/Instance", "Xform")
        instance.GetReferences().AddInternalReference("/Library/Tile")
        instance.SetInstanceable(True)
        _Primvar(group.GetPrim() if rank % 2 else instance, "displayColor", rows[rank:rank + 1], "constant")
    _Camera(stage, (20, 10), 40.0)
    picture = ours.Render(_Save(stage), 320, 240, (*_AOVS, "primId"), samples=1)
    assert picture.statistics["geometry"]["meshes"] == 3
    for prim in np.unique(picture.layers["primId"][picture.layers["primId"] >= 0]):
        shown = picture.layers["primId"] == prim
        ids = picture.layers["instanceId"][shown]
        values = picture.layers[_COLOR][shown]
        if ids.max() >= count:  # two placements in each instance
            ids = ids // 2
        if not np.array_equal(values, np.full_like(values, 0.25)):
            assert values.tobytes() == rows[ids].tobytes()
            assert len(np.unique(ids)) > count // 2


def test_nested_instancers_are_read_at_each_level(tmp_path):
    """The inner instancer's values win; what it lacks comes from the outer one, by its own instances."""
    stage = _Stage(tmp_path)
    outer = UsdGeom.PointInstancer.Define(stage, "/World/Outer")
    outer.CreatePositionsAttr([(0, 4 * k, 0) for k in range(3)])
    outer.CreateProtoIndicesAttr([0, 0, 0])
    inner = _Plane(stage, 5, 5, "/World/Outer/Inner")
    outer.CreatePrototypesRel().SetTargets(["/World/Outer/Inner"])
    inner.CreateInvisibleIdsAttr([1])  # ranks are not indices
    colors, ages, both = _Rows(3, 1), _Rows(5, 2, 1), (_Rows(3, 3, 1), _Rows(5, 4, 1))
    _Primvar(outer, "displayColor", colors)
    _Primvar(inner, "age", ages, "varying")
    _Primvar(outer, "both", both[0])
    _Primvar(inner, "both", both[1])
    _Camera(stage, (2, 4), 20.0)
    layers = ours.Render(_Save(stage), 96, 96, (_COLOR, "primvars:age", "primvars:both", "instanceId"), samples=1).layers
    drawn = np.array([0, 2, 3, 4])
    n = np.arange(12)
    assert len(_AssertRows(layers, colors[n // 4])) == 12
    _AssertRows(layers, ages[drawn[n % 4]], "primvars:age")
    _AssertRows(layers, both[1][drawn[n % 4]], "primvars:both")


def test_glowing_and_cut_out_instances(tmp_path):
    """Emission and opacity by instance: what a prim seen directly emits, and how much of what is behind it shows."""
    count = 9
    glow, opacity = _Rows(count), np.linspace(0, 1, count, dtype=np.float32).reshape(-1, 1)
    stage = _Stage(tmp_path)
    instancer = _Plane(stage, count, 3)
    _Primvar(instancer, "glow", glow)
    _Primvar(instancer, "cover", opacity)
    material = UsdShade.Material.Define(stage, "/Looks/Glow")
    surface = UsdShade.Shader.Define(stage, "/Looks/Glow/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("opacityMode", Sdf.ValueTypeNames.Token).Set("presence")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0, 0, 0))
    for name, kind, variable in (("emissiveColor", "float3", "glow"), ("opacity", "float", "cover")):
        reader = UsdShade.Shader.Define(stage, f"/Looks/Glow/{variable}")
        reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(variable)
        valueType = Sdf.ValueTypeNames.Float3 if kind == "float3" else Sdf.ValueTypeNames.Float
        surface.CreateInput(name, Sdf.ValueTypeNames.Color3f if kind == "float3" else valueType).ConnectToSource(
            reader.CreateOutput("result", valueType))
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/Many/Square")).Bind(material)
    author.AddCamera(stage, eye=(1, 1, 6), target=(1, 1, 0), up=(0, 1, 0), focalLength=30.0)
    picture = ours.Render(_Save(stage), 90, 90, ("color", "alpha"), samples=1024, domeVisible=False, maxDepth=0)
    for rank in range(count):  # squares of 12 pixels
        x, y = picture.rgb.shape[1] // 2 + int(round((rank % 3 - 1) * _PixelsPerUnit())), \
            picture.rgb.shape[0] // 2 - int(round((rank // 3 - 1) * _PixelsPerUnit()))
        block = (slice(y - 3, y + 4), slice(x - 3, x + 4))
        alpha = picture.layers["color"][..., 3][block].mean()
        assert alpha == pytest.approx(float(opacity[rank, 0]), abs=0.01)
        assert picture.rgb[block].reshape(-1, 3).mean(0) == pytest.approx(alpha * glow[rank], rel=1e-4, abs=1e-6)


def _PixelsPerUnit():
    """Of the camera above: focal length 30, aperture 36 tenths, at 6 units."""
    return 90 * 30.0 / 36.0 / 6.0


def test_what_displaces_cannot_differ(tmp_path):
    stage = _Stage(tmp_path)
    instancer = _Plane(stage, 3, 3)
    _Primvar(instancer, "height", _Rows(3, 1, 1))
    mesh = stage.GetPrimAtPath("/World/Many/Square")
    material = UsdShade.Material.Define(stage, "/Looks/Up")
    surface = UsdShade.Shader.Define(stage, "/Looks/Up/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    reader = UsdShade.Shader.Define(stage, "/Looks/Up/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("height")
    surface.CreateInput("displacement", Sdf.ValueTypeNames.Float).ConnectToSource(
        reader.CreateOutput("result", Sdf.ValueTypeNames.Float))
    for terminal in ("surface", "displacement"):
        material.CreateOutput(terminal, Sdf.ValueTypeNames.Token).ConnectToSource(surface.ConnectableAPI(), terminal)
    UsdShade.MaterialBindingAPI.Apply(mesh).Bind(material)
    _Camera(stage, (1, 0), 5.0)
    picture = ours.Render(_Save(stage), 16, 16, ("color",), samples=1)
    assert any("primvar height differs between instances and cannot displace them" in line for line in picture.warnings)
