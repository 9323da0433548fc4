# SPDX-License-Identifier: Apache-2.0
"""Meshes as lights equal closed forms: UsdLuxMeshLightAPI in all its modes, and materials whose emission varies.

A Lambert plate below squares that face it, seen from between them; a square lights it as a rect light would.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, Vt

pytest.importorskip("hdstream._core")

import closedForm
import ours
from stages import author, imageFile, shapes
from textureCases import AddTexture, Connect

WIDTH, HEIGHT, SIZE, ALBEDO = 24, 18, 4.0, 0.5
_UP = np.array([0.0, 1.0, 0.0])
_DOWN = dict(rotate=(180, 0, 0))


def _Plate(tmp_path):
    stage = author.NewStage(f"{tmp_path}/a.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(ALBEDO,) * 3)
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    return stage


def _Glow(stage, **inputs):
    return author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), metallic=1.0, **inputs)


def _MakeLight(mesh, mode=None, **inputs):
    light = UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    api = UsdLux.LightAPI(mesh.GetPrim())
    if mode:
        api.GetMaterialSyncModeAttr().Set(mode)
    for name, value in inputs.items():
        value = Gf.Vec3f(*map(float, value)) if name == "color" else value
        getattr(api, f"Create{name[0].upper()}{name[1:]}Attr")(value)
    return light


def _Points():
    x, z = np.meshgrid(((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * SIZE,
                       ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5) * SIZE * HEIGHT / WIDTH)
    return np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], -1)


def _OfRect(centre, width=1.0, height=1.0):
    """What the plate shows under a rect of radiance 1 that faces it, without its colours."""
    matrix = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 1.0, 0, 0], [*centre, 1.0]])
    return closedForm.IrradianceOfRect(_Points(), _UP, matrix, width, height).reshape(HEIGHT, WIDTH, 1) * ALBEDO / np.pi


def _Check(stage, expected, samples=512, mean=4e-3, block=0.015, **settings):
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, WIDTH, HEIGHT, samples=samples, **{"maxDepth": 0, **settings})
    assert picture.warnings == []
    expected = np.broadcast_to(expected, (HEIGHT, WIDTH, 3))
    np.testing.assert_allclose(picture.rgb.mean((0, 1)), expected.mean((0, 1)), rtol=mean)
    blocks = lambda a: a.reshape(6, HEIGHT // 6, 8, WIDTH // 8, 3).mean((1, 3))
    np.testing.assert_allclose(blocks(picture.rgb), blocks(expected), atol=block * expected.max())
    return picture


_L = np.array([3.0, 1.5, 0.75])
_INPUTS = dict(intensity=1.5, exposure=1.0, color=(1.0, 0.5, 0.25))
_EMISSION = np.array([0.5, 1.0, 2.0])
MODES = {
    "noResponse": ("noMaterialResponse", False, _L),
    "independent": ("independent", True, _L),
    "tints": ("materialGlowTintsLight", True, _L * _EMISSION),
    "unbound": ("materialGlowTintsLight", False, _L),
}


@pytest.mark.parametrize("name", sorted(MODES))
def test_mesh_light_is_a_rect_light(name, tmp_path):
    """Intensity, exposure, colour and the material's glow are factors, as the mode says."""
    mode, isBound, radiance = MODES[name]
    stage = _Plate(tmp_path)
    material = _Glow(stage, emissiveColor=tuple(_EMISSION)) if isBound else None
    _MakeLight(author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), material=material, translate=(0.3, 1, 0), **_DOWN),
               mode, **_INPUTS)
    _Check(stage, _OfRect((0.3, 1, 0)) * radiance)


def test_camera_sees_the_material_or_the_light(tmp_path):
    """Camera rays see what the material emits, and the light itself where there is no response of a material."""
    for mode, expected in (("noMaterialResponse", _L), ("independent", _EMISSION), ("materialGlowTintsLight", _EMISSION)):
        stage = author.NewStage(f"{tmp_path}/{mode}.usda")
        mesh = author.AddMesh(stage, "/World/Square", shapes.Plane(50, 50), material=_Glow(stage, emissiveColor=tuple(_EMISSION)))
        _MakeLight(mesh, mode, **_INPUTS)
        author.AddCamera(stage, eye=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1))
        stage.GetRootLayer().Save()
        picture = ours.Render(stage.GetRootLayer().realPath, 8, 6, samples=4, maxDepth=1)
        np.testing.assert_allclose(picture.rgb, np.broadcast_to(expected, (6, 8, 3)), rtol=1e-5)
        np.testing.assert_array_equal(picture.layers["color"][..., 3], 1.0)


def test_normalize_and_one_side(tmp_path):
    """normalize divides by the world area, also below a reflection; the back of a single-sided mesh is dark."""
    stage = _Plate(tmp_path)
    _MakeLight(author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), translate=(0, 1, 0), scale=(-2, -1, 0.5)),
               "noMaterialResponse", intensity=4.0, normalize=True)
    _MakeLight(author.AddMesh(stage, "/World/Back", shapes.Plane(1, 1), translate=(0, 1.1, 0)), "noMaterialResponse", intensity=9.0)
    _Check(stage, _OfRect((0, 1, 0), 2, 0.5) * 4.0)


def test_dark_mesh_light_lights_nothing(tmp_path):
    """A mesh light of intensity 0: camera rays see the glow of its material, which lights nothing."""
    stage = _Plate(tmp_path)
    mesh = author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), material=_Glow(stage, emissiveColor=(1, 1, 1)),
                          translate=(0, 1, 0), **_DOWN)
    _MakeLight(mesh, intensity=0.0)
    _Check(stage, np.zeros(3), samples=16)


def test_sphere_far_off_is_a_point(tmp_path):
    """A convex closed mesh shows a quarter of its surface on average: intensity area / 4."""
    sphere = shapes.Sphere(0.5, 16, 32)
    ends = np.split(sphere.points[sphere.indices], np.cumsum(sphere.counts)[:-1])
    area = sum(np.linalg.norm(np.cross(p[k] - p[0], p[k + 1] - p[0])) / 2 for p in ends for k in range(1, len(p) - 1))
    stage = _Plate(tmp_path)
    _MakeLight(author.AddMesh(stage, "/World/Ball", sphere, translate=(0, 40, 0)), intensity=1000.0)
    d = np.array([0, 40.0, 0]) - _Points()
    distance = np.linalg.norm(d, axis=-1)
    _Check(stage, (1000 * area / 4 * d[:, 1] / distance**3).reshape(HEIGHT, WIDTH, 1) * ALBEDO / np.pi, samples=4096, mean=0.01, block=0.02)


def test_gprims_that_become_meshes_are_lights(tmp_path):
    """A sphere and a cube with LightAPI, far off: their intensities times the areas that they show. The sphere's radius and the
    cube's size are no inputs of the lights."""
    stage = _Plate(tmp_path)
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.CreateRadiusAttr(0.5)
    author.Place(ball, translate=(0, 40, 0))
    box = UsdGeom.Cube.Define(stage, "/World/Box")
    box.CreateSizeAttr(0.8)
    author.Place(box, translate=(20, 30, 0))
    for gprim, intensity in ((ball, 700.0), (box, 300.0)):
        UsdLux.LightAPI.Apply(gprim.GetPrim())
        UsdLux.LightAPI(gprim.GetPrim()).CreateIntensityAttr(intensity)
    points = _Points()
    ofBall = np.array([0, 40.0, 0]) - points
    ofBall = 700.0 * np.pi * 0.25 * ofBall[:, 1] / np.linalg.norm(ofBall, axis=-1)**3
    ofBox = np.array([20.0, 30.0, 0]) - points
    distance = np.linalg.norm(ofBox, axis=-1)
    ofBox = 300.0 * 0.64 * (np.abs(ofBox).sum(-1) / distance) * ofBox[:, 1] / distance**3
    _Check(stage, (ofBall + ofBox).reshape(HEIGHT, WIDTH, 1) * ALBEDO / np.pi, samples=4096, mean=0.01, block=0.02)


def test_instances_are_lights_of_their_own(tmp_path):
    """Squares apart in one mesh, placed three times: the plate shows the sum of six rects."""
    stage = _Plate(tmp_path)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Lamps")
    two = shapes.Merged([shapes.Plane(0.3, 0.3), shapes.Plane(0.3, 0.3)])
    two.points[4:, 0] += 1.5
    _MakeLight(author.AddMesh(stage, "/World/Lamps/Two", two, **_DOWN), intensity=5.0)
    places = [(-1.5, 1.0, -1), (0.1, 0.8, 0.4), (-0.7, 1.2, 1.1)]
    instancer.CreatePrototypesRel().AddTarget("/World/Lamps/Two")
    instancer.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(*place) for place in places]))
    instancer.CreateProtoIndicesAttr(Vt.IntArray([0, 0, 0]))
    rects = sum(_OfRect((x + dx, y, z), 0.3, 0.3) for x, y, z in places for dx in (0.0, 1.5))
    _Check(stage, 5.0 * rects)


def _VaryingSquares(stage):
    """Two squares side by side whose faces glow by a primvar, and what the plate shows of them."""
    glow = author.AddMaterial(stage, "/World/Glow", {"emissiveColor": ("glow", "float3", (0.0, 0.0, 0.0))}, diffuseColor=(0, 0, 0),
                              metallic=1.0)
    colors = np.array([[4.0, 1.0, 0.0], [0.0, 0.5, 8.0]])
    mesh = author.AddMesh(stage, "/World/Pair", shapes.Plane(2, 1, columns=2), material=glow, translate=(0, 1, 0), **_DOWN)
    author.AddPrimvar(mesh, "glow", Sdf.ValueTypeNames.Color3fArray, "uniform", Vt.Vec3fArray.FromNumpy(colors.astype(np.float32)))
    return mesh, _OfRect((-0.5, 1, 0)) * colors[0] + _OfRect((0.5, 1, 0)) * colors[1]


def test_emission_by_a_primvar(tmp_path):
    stage = _Plate(tmp_path)
    _Check(stage, _VaryingSquares(stage)[1])


def test_varying_emission_tints_a_mesh_light(tmp_path):
    stage = _Plate(tmp_path)
    mesh, expected = _VaryingSquares(stage)
    _MakeLight(mesh, **_INPUTS)
    _Check(stage, expected * _L)


def test_links_of_mesh_lights(tmp_path):
    """One half of the plate is not lit, and a square between lights and plate casts no shadow: lights of constant emission, and of
    emission that varies."""
    stage = author.NewStage(f"{tmp_path}/a.usda")
    for name, x in (("A", -10), ("B", 10)):
        author.AddMesh(stage, f"/World/{name}", shapes.Plane(20, 40), color=(ALBEDO,) * 3, translate=(x, 0, 0))
    author.AddMesh(stage, "/World/Blocker", shapes.Plane(30, 30), color=(0, 0, 0), doubleSided=True, translate=(0, 0.5, 0))
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=SIZE * 10, orthographic=True)
    pair, expected = _VaryingSquares(stage)
    square = author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), translate=(0.3, 1, 1.2), **_DOWN)
    for light in (_MakeLight(pair, **_INPUTS), _MakeLight(square, "noMaterialResponse", **_INPUTS)):
        author.LinkLight(light, "lightLink", excludes=["/World/A"])
        author.LinkLight(light, "shadowLink", excludes=["/World/Blocker"])
    expected = expected + _OfRect((0.3, 1, 1.2))
    expected[:, :WIDTH // 2] = 0.0
    _Check(stage, expected * _L)


def test_bad_mesh_lights_are_named(tmp_path):
    """One line for each, and a finite picture."""
    stage = _Plate(tmp_path)
    shape = {name: shapes.Plane(1, 1) for name in ("Empty", "Flat", "Squeezed", "Unreal")}
    shape["Many"] = shapes.Plane(1, 1, columns=1024, rows=513)
    shape["Flat"].points[:, 0] = 0.0
    shape["Unreal"].points[:] = np.nan
    for name, value in shape.items():
        places = dict(scale=(0, 0, 1)) if name == "Squeezed" else _DOWN  # to a line: what is flat is a thin sheet
        mesh = author.AddMesh(stage, f"/World/{name}", value, translate=(0, 1, 0), **places)
        _MakeLight(mesh, "noMaterialResponse", normalize=True)
        if name == "Empty":
            mesh.GetFaceVertexCountsAttr().Set([])
    stage.GetRootLayer().Save()
    picture = ours.Render(f"{tmp_path}/a.usda", 8, 6, samples=1, maxDepth=0)
    assert [line.split(":")[0] for line in picture.warnings] == [f"/World/{name}" for name in sorted(shape)]
    assert np.isfinite(picture.rgb).all()


def test_emission_by_a_texture(tmp_path):
    """An image of a dark and a bright half, behind a veil that lets half of the light pass."""
    stage = _Plate(tmp_path)
    image = np.zeros((64, 64, 3), np.float32)
    image[:, :32], image[:, 32:] = (0.25, 0.5, 1.0), (8.0, 4.0, 2.0)
    imageFile.WriteExr(f"{tmp_path}/halves.exr", {c: image[..., i] for i, c in enumerate("RGB")}, half=False)
    material = _Glow(stage)
    Connect(material, "emissiveColor", AddTexture(material, "T", file="./halves.exr", wrapS="clamp", wrapT="clamp"), "rgb")
    author.AddMesh(stage, "/World/Pair", shapes.Plane(2, 1), material=material, translate=(0, 1, 0), **_DOWN)
    author.AddMesh(stage, "/World/Veil", shapes.Plane(40, 40), color=(0, 0, 0), translate=(0, 0.7, 0)).CreateDisplayOpacityAttr([0.5])
    _Check(stage, 0.5 * (_OfRect((-0.5, 1, 0)) * image[0, 0] + _OfRect((0.5, 1, 0)) * image[0, -1]), samples=4096)


def test_light_samples_and_rays_agree(tmp_path):
    """A grey sphere seen from inside, whose cap glows by a primvar: the closed form of the enclosure, which light samples and
    rays that find the cap make together."""
    shape = shapes.Sphere(1.0, 24, 48)
    inward = shapes.Shape(shape.points, shape.counts, np.concatenate(
        [face[::-1] for face in np.split(shape.indices, np.cumsum(shape.counts)[:-1])]))
    faces = [inward.points[face] for face in np.split(inward.indices, np.cumsum(inward.counts)[:-1])]
    areas = np.array([sum(np.linalg.norm(np.cross(p[k] - p[0], p[k + 1] - p[0])) / 2 for k in range(1, len(p) - 1)) for p in faces])
    glowing = np.nonzero([p[:, 1].mean() > 0.8 for p in faces])[0]
    stage = author.NewStage(f"{tmp_path}/a.usda")
    glow = author.AddMaterial(stage, "/World/Glow", {"emissiveColor": ("glow", "float3", (0.0, 0.0, 0.0))}, diffuseColor=(0, 0, 0),
                              metallic=1.0)
    mesh = author.AddMesh(stage, "/World/Shell", inward, color=(0.8,) * 3)
    author.Bind(UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(
        "glow", Vt.IntArray.FromNumpy(glowing.astype(np.int32))), glow)
    author.AddPrimvar(mesh, "glow", Sdf.ValueTypeNames.Color3fArray, "constant", Vt.Vec3fArray([Gf.Vec3f(5, 5, 5)]))
    author.AddCamera(stage, eye=(0, 0, 0.3), target=(0, -0.5, -1), focalLength=60.0)
    stage.GetRootLayer().Save()
    expected = closedForm.EnclosureRadiance(5.0, 0.8, areas[glowing].sum() / areas.sum(), 3)
    picture = ours.Render(f"{tmp_path}/a.usda", 32, 24, samples=256, maxDepth=3).rgb
    assert picture.mean() == pytest.approx(expected, rel=4e-3)


def test_streamed_lights_have_the_same_bits(tmp_path):
    """Light samples that end at geometry which streams, of a mesh light that its material tints and of a glow: as resident, to
    the bit."""
    stage = _Plate(tmp_path)
    mesh, _ = _VaryingSquares(stage)
    glowing = author.AddMesh(stage, "/World/Glowing", shapes.Plane(1, 1), translate=(0, 1.5, 1), **_DOWN)
    author.Bind(glowing, UsdShade.Material.Get(stage, "/World/Glow"))
    author.AddPrimvar(glowing, "glow", Sdf.ValueTypeNames.Color3fArray, "vertex", Vt.Vec3fArray([Gf.Vec3f(i, 1, 2) for i in range(4)]))
    _MakeLight(mesh, **_INPUTS)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.2, 48, 96), translate=(0.4, 0.6, 0), color=(0.5,) * 3)
    stage.GetRootLayer().Save()
    pictures = [ours.Render(f"{tmp_path}/a.usda", WIDTH, HEIGHT, samples=8, maxDepth=2, residency=residency, chunkBytes=16384,
                            geometryMemory=memory).rgb
                for residency, memory in (("resident", ""), ("stream", "50%"))]
    np.testing.assert_array_equal(*pictures)
