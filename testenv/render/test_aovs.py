# SPDX-License-Identifier: Apache-2.0
"""AOVs against ray and plane mathematics of our own in double precision.

First-hit AOVs are seen through the pixel's centre: the tests project positions back and ask that they
lie there and on the surface.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

WIDTH, HEIGHT, NEAR, FAR = 64, 48, 0.5, 40.0
_AOVS = ("color", "alpha", "depth", "cameraDepth", "normal", "Neye", "position", "Peye", "facingRatio", "motionForward",
         "motionBackward", "albedo", "primId", "instanceId", "elementId", "variance", "sampleCount")


def _Write(path: str, orthographic: bool) -> str:
    """A wall (two tilted quads in one mesh), a box and two instances of a small box."""
    stage = author.NewStage(path)
    wall = shapes.Shape(np.array([[-3.0, -2, -1], [0, -2, 0], [0, 2, 0], [-3, 2, -1], [3, -2, -1], [3, 2, -1]]), np.array([4, 4]),
                        np.array([0, 1, 2, 3, 1, 4, 5, 2]))
    author.AddMesh(stage, "/World/A_Wall", wall, color=(0.25, 0.5, 0.75))
    author.AddMesh(stage, "/World/B_Box", shapes.Box(0.8, 0.8, 0.8), color=(0.5, 0.5, 0.5), translate=(-1, -0.6, 1))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/C_Many")
    author.AddMesh(stage, "/World/C_Many/Prototypes/Small", shapes.Box(0.5, 0.5, 0.5), color=(0.1, 0.2, 0.3))
    instancer.CreatePrototypesRel().SetTargets(["/World/C_Many/Prototypes/Small"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(0.6, -0.6, 1.0), (1.5, 0.5, 0.8)])
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    camera = author.AddCamera(stage, eye=(0.4, 0.6, 8.0), target=(0, 0, 0), orthographic=orthographic,
                              width=80.0 if orthographic else 36.0, focalLength=30.0, offset=(2.0, 1.0))
    camera.CreateClippingRangeAttr(Gf.Vec2f(NEAR, FAR))
    stage.GetRootLayer().Save()
    return path


@pytest.fixture(scope="module", params=[False, True], ids=["perspective", "orthographic"])
def Rendered(request, tmp_path_factory):
    path = _Write(f"{tmp_path_factory.mktemp('aov')}/a.usda", request.param)
    layers = ours.Render(path, WIDTH, HEIGHT, _AOVS, samples=16).layers
    stage = Usd.Stage.Open(path)
    view = np.linalg.inv(np.array(UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).ComputeLocalToWorldTransform(0)))
    return layers, view, request.param


def _Hit(layers) -> np.ndarray:
    return layers["primId"] >= 0


def test_position_is_at_the_pixel_centre(Rendered):
    layers, view, orthographic = Rendered
    hit = _Hit(layers)
    local = layers["position"].astype(float)[hit] @ view[:3, :3] + view[3, :3]
    scale = 8.0 if orthographic else 3.6 * -local[:, 2] / 3.0
    x = (local[:, 0] / scale) if orthographic else local[:, 0] / scale
    y = local[:, 1] / scale
    offsetX, offsetY = (0.2 / 8.0, 0.1 / 8.0) if orthographic else (0.2 / 3.6, 0.1 / 3.6)
    column = (x - offsetX + 0.5) * WIDTH
    row = (0.5 - (y - offsetY) * WIDTH / HEIGHT) * HEIGHT
    rows, columns = np.nonzero(hit)
    # 1e-3 pixels: float positions at a distance of 8 units.
    np.testing.assert_allclose(column, columns + 0.5, atol=1e-3)
    np.testing.assert_allclose(row, rows + 0.5, atol=1e-3)


def test_eye_position_and_facing_ratio_belong_to_the_position(Rendered):
    layers, view, orthographic = Rendered
    hit = _Hit(layers)
    eye = layers["position"].astype(float)[hit] @ view[:3, :3] + view[3, :3]
    np.testing.assert_allclose(layers["Peye"][hit], eye, atol=2e-5)
    toCamera = np.broadcast_to([0.0, 0.0, 1.0], eye.shape) if orthographic else -eye / np.linalg.norm(eye, axis=-1, keepdims=True)
    cosine = np.abs((layers["Neye"][hit].astype(float) * toCamera).sum(-1))
    np.testing.assert_allclose(layers["facingRatio"][..., 0][hit], cosine, atol=2e-5)
    assert not layers["Peye"][~hit].any() and not layers["facingRatio"][~hit].any()
    assert cosine.min() < 0.95 < cosine.max()


def test_nothing_moves_without_a_shutter(Rendered):
    layers, _, _ = Rendered
    assert not layers["motionForward"].any() and not layers["motionBackward"].any()


def test_depths_belong_to_the_position(Rendered):
    layers, view, orthographic = Rendered
    hit = _Hit(layers)
    z = -(layers["position"].astype(float)[hit] @ view[:3, :3] + view[3, :3])[:, 2]
    np.testing.assert_allclose(layers["cameraDepth"][hit].ravel(), z, rtol=1e-5)
    projected = (z - NEAR) / (FAR - NEAR) if orthographic else (1 / NEAR - 1 / z) / (1 / NEAR - 1 / FAR)
    np.testing.assert_allclose(layers["depth"][hit].ravel(), projected, rtol=1e-4)
    assert (layers["depth"][~hit] == 1).all() and np.isinf(layers["cameraDepth"][~hit]).all()


def test_normals_are_the_faces(Rendered):
    """Both normals are unit and equal the plane of the face whose id the pixel holds."""
    layers, view, _ = Rendered
    wall = layers["primId"] == 0
    expected = np.array([[-1.0, 0, 3], [1, 0, 3]]) / np.sqrt(10)
    np.testing.assert_allclose(layers["normal"][wall], expected[layers["elementId"][wall]], atol=1e-5)
    hit = _Hit(layers)
    np.testing.assert_allclose(np.linalg.norm(layers["normal"][hit], axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(layers["Neye"][hit], layers["normal"][hit] @ view[:3, :3].astype(np.float32), atol=1e-5)


def test_position_is_on_the_wall(Rendered):
    layers, _, _ = Rendered
    position = layers["position"].astype(float)[layers["primId"] == 0]
    np.testing.assert_allclose(position[:, 2], -np.abs(position[:, 0]) / 3, atol=1e-5)


def test_ids(Rendered):
    """Prims count in path order; instances inside their instancer; faces as authored; -1 elsewhere."""
    layers, _, _ = Rendered
    assert set(np.unique(layers["primId"])) == {-1, 0, 1, 2}
    assert set(np.unique(layers["instanceId"][layers["primId"] == 2])) == {0, 1}
    assert (layers["instanceId"][layers["primId"] < 2] == -1).all()
    assert set(np.unique(layers["elementId"][layers["primId"] == 0])) == {0, 1}
    assert (layers["elementId"][layers["primId"] < 0] == -1).all()
    right = layers["position"][..., 0] > 1.1
    both = layers["primId"] == 2
    assert (layers["instanceId"][both & right] == 1).all() and (layers["instanceId"][both & ~right] == 0).all()


def test_albedo_alpha_and_count(Rendered):
    layers, _, _ = Rendered
    assert (layers["sampleCount"] == 16).all()
    inside = layers["alpha"][..., 0] == 1
    wall = (layers["primId"] == 0) & inside
    pure = wall & _Eroded(wall)
    np.testing.assert_allclose(layers["albedo"][pure], np.broadcast_to([0.25, 0.5, 0.75], (pure.sum(), 3)), rtol=1e-5)
    assert (layers["variance"] >= 0).all()


@pytest.fixture(scope="module")
def Lamp(tmp_path_factory):
    """A tilted square that emits 2 and reflects nothing, before nothing: a sample is 2 or 0."""
    stage = author.NewStage(f"{tmp_path_factory.mktemp('lamp')}/a.usda")
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(2, 2, 2), ior=1.0, roughness=1.0)
    author.AddMesh(stage, "/World/Lamp", shapes.Box(2.0, 2.0, 0.1), material=glow, rotate=(0, 0, 20))
    author.AddCamera(stage, eye=(0, 0, 8))
    stage.GetRootLayer().Save()

    def Pixels(samples):
        """Luminance of the mean, and its variance."""
        layers = ours.Render(stage.GetRootLayer().realPath, WIDTH, HEIGHT, ("color", "variance"), samples=samples, maxDepth=1).layers
        return layers["color"][..., 1].astype(float), layers["variance"].reshape(HEIGHT, WIDTH).astype(float)

    return Pixels


@pytest.mark.parametrize("samples", [2, 7, 16])
def test_variance_of_few_samples_is_that_of_their_two_values(Lamp, samples):
    """Of n samples that are 2 or 0 and have the mean m, the unbiased variance of the mean is m (2 - m) / (n - 1)."""
    mean, variance = Lamp(samples)
    numBoth = ((mean > 0.01) & (mean < 1.99)).sum()
    assert numBoth > 15 and (mean < 0.01).sum() > 100 and (mean > 1.99).sum() > 100
    # 2e-6: sums of squares in floats. The variance at the edge is 0.06 to 2.
    np.testing.assert_allclose(variance, mean * (2.0 - mean) / (samples - 1), rtol=1e-4, atol=2e-6)


def test_variance_of_blocks_is_that_of_their_sums(Lamp):
    """Of two blocks of 16 samples with the sums a and b, that of the mean of 32 is (a - b)^2 / 32^2: stratification inside a block
    makes it smaller than what independent samples have."""
    first, _ = Lamp(16)
    mean, variance = Lamp(32)
    difference = 2 * 16 * first - 32 * mean  # a - b
    np.testing.assert_allclose(variance, (difference / 32) ** 2, rtol=1e-3, atol=2e-6)
    edge = (mean > 0.01) & (mean < 1.99)
    assert variance[edge].mean() > 1e-4, "the test would show little"
    assert variance[edge].mean() < 0.5 * (mean * (2 - mean) / 31)[edge].mean()


def _Eroded(mask: np.ndarray) -> np.ndarray:
    """Pixels whose eight neighbours are in the mask too: no edge runs through them."""
    padded = np.pad(mask, 1)
    return np.all([padded[1 + i : 1 + i + mask.shape[0], 1 + j : 1 + j + mask.shape[1]] for i in (-1, 0, 1) for j in (-1, 0, 1)], 0)


@pytest.mark.parametrize("scheme", ["none", "bilinear", "catmullClark"])
def test_uniform_values_survive_subdivision(scheme, tmp_path):
    """Each face keeps its own colour and its own material subset, whatever it is refined into."""
    colors = [(0.75, 0.25, 0.25), (0.25, 0.75, 0.25), (0.25, 0.25, 0.75)]
    stage = author.NewStage(f"{tmp_path}/a.usda")
    plane = shapes.Plane(4.5, 1.5, 1, 3)
    bare = shapes.Shape(plane.points, plane.counts, plane.indices)
    mesh = author.AddMesh(stage, "/World/A", bare, rotate=(90, 0, 0), translate=(0, 0.9, 0))
    author.AddPrimvar(mesh, "displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform", Vt.Vec3fArray(colors))
    parts = author.AddMesh(stage, "/World/B", bare, rotate=(90, 0, 0), translate=(0, -0.9, 0))
    for face, color in enumerate(colors):
        material = author.AddMaterial(stage, f"/World/M{face}", diffuseColor=color, ior=1.0, roughness=1.0)
        subset = UsdShade.MaterialBindingAPI.Apply(parts.GetPrim()).CreateMaterialBindSubset(f"s{face}", Vt.IntArray([face]))
        author.Bind(subset, material)
    for prim in (mesh, parts):
        prim.GetSubdivisionSchemeAttr().Set(scheme)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 8))
    stage.GetRootLayer().Save()
    layers = ours.Render(f"{tmp_path}/a.usda", 64, 48, ("albedo", "primId", "elementId"), samples=1).layers
    for prim in (0, 1):
        for face, color in enumerate(colors):
            pick = (layers["primId"] == prim) & (layers["elementId"] == face)
            assert pick.sum() > 20
            # 0.1: the specular lobe's small share; the colours are 0.5 apart.
            np.testing.assert_allclose(layers["albedo"][pick], np.broadcast_to(color, (pick.sum(), 3)), atol=0.1 if prim else 1e-5)
