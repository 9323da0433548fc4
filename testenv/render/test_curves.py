# SPDX-License-Identifier: Apache-2.0
"""Curves and points against closed forms and against finely tessellated meshes of the same shape.

First-hit AOVs are seen through the pixel's centre. All pictures share their kernels: each stage has a
material that lets light pass and no textures.
"""

import numpy as np
import pytest
from pxr import UsdGeom

pytest.importorskip("hdstream._core")

import ours
from stages import author, curves, shapes

SIZE = 48
AOVS = ("color", "alpha", "cameraDepth", "normal", "position", "elementId", "primvars:displayColor")


def Stage(folder, fill, width=6.0, centre=(0.0, 0.0, 0.0)):
    """A stage seen from +z by an orthographic camera; `fill(stage)` adds to it."""
    stage = author.NewStage(f"{folder}/a.usda")
    glass = author.AddMaterial(stage, "/World/Glass", diffuseColor=(0.5, 0.5, 0.5), opacity=0.5, ior=1.0)
    far = author.AddMesh(stage, "/World/Far", shapes.Plane(0.01, 0.01), translate=(centre[0] + 3 * width, *centre[1:]))
    author.Bind(far.GetPrim(), glass)
    curves.AddPoints(stage, "/World/FarPoint", [(centre[0] - 3 * width, *centre[1:])], 0.01)
    fill(stage, glass)
    eye = np.array(centre) + (0, 0, 10)
    author.AddCamera(stage, eye=eye, target=centre, orthographic=True, width=10 * width, aspect=1.0)
    stage.GetRootLayer().Save()
    return f"{folder}/a.usda"


def Render(folder, fill, width=6.0, centre=(0.0, 0.0, 0.0), **settings):
    """Layers by AOV name; those of one channel are [height][width]."""
    path = Stage(folder, fill, width, centre)
    layers = ours.Render(path, SIZE, SIZE, AOVS, **settings).layers
    return {name: layer[..., 0] if layer.ndim == 3 and layer.shape[2] == 1 else layer for name, layer in layers.items()}


def Raster(width=6.0):
    """x and y of the pixels' centres."""
    middle = (np.arange(SIZE) + 0.5) / SIZE * width - width / 2
    return np.meshgrid(middle, -middle)


def Dome(stage):
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)


def test_points_and_straight_tubes_are_spheres_and_capsules(tmp_path):
    """Places and normals to float, elementIds, and colours of every vertex of a line."""
    def Fill(stage, glass):
        Dome(stage)
        curves.AddPoints(stage, "/World/Points", [(-1.5, 1.5, 0.2), (-1.5, -1.0, 0)], (1.4, 1.0), color=[(1, 0, 0), (0, 1, 0)])
        curves.AddCurves(stage, "/World/Tube", [np.array([(0.5, 9, 0), (0.5, 9.5, 0)]), np.array([(0.6, -2, 0), (1.8, 1.5, 0.5)])], 0.9,
                         type="linear", color=[(1, 0, 0), (1, 0, 0), (0, 0, 1), (1, 1, 0)])

    layers = Render(tmp_path, Fill, samples=1, maxDepth=0)
    x, y = Raster()
    z, element = np.full((SIZE, SIZE), -np.inf), np.full((SIZE, SIZE), -1)
    normals, margin = np.zeros((SIZE, SIZE, 3)), np.full((SIZE, SIZE), np.inf)
    colours = np.zeros((SIZE, SIZE, 3))

    def AddBalls(centres, radius, index, colour):
        nonlocal z, margin
        for centre, shade in zip(centres, colour):
            squared = radius**2 - (x - centre[0])**2 - (y - centre[1])**2
            margin = np.minimum(margin, np.abs(squared))
            front = np.where(squared >= 0, centre[2] + np.sqrt(np.maximum(squared, 0)), -np.inf)
            isNearer = front > z
            z[isNearer], element[isNearer] = front[isNearer], index
            normals[isNearer] = (np.stack([x, y, front], -1) - centre)[isNearer] / radius
            colours[isNearer] = shade

    AddBalls([(-1.5, 1.5, 0.2)], 0.7, 0, [(1, 0, 0)])
    AddBalls([(-1.5, -1.0, 0)], 0.5, 1, [(0, 1, 0)])
    a, b = np.array((0.6, -2, 0)), np.array((1.8, 1.5, 0.5))
    along = np.linspace(0, 1, 8001)[:, None]
    AddBalls(a + along * (b - a), 0.45, 1, (1 - along) * (0, 0, 1) + along * (1, 1, 0))
    isHit = np.isfinite(z)
    isClear = (margin > 1e-3) | isHit & (normals[..., 2] > 0.1)
    np.testing.assert_array_equal(layers["elementId"][isClear], element[isClear])
    inside = isHit & (normals[..., 2] > 0.1)
    np.testing.assert_allclose(layers["position"][inside][:, 2], z[inside], atol=2e-5)
    np.testing.assert_allclose(layers["normal"][inside], normals[inside], atol=2e-3)
    np.testing.assert_allclose(layers["primvars:displayColor"][inside], colours[inside], atol=2e-3)


@pytest.mark.parametrize("basis", ["bspline", "catmullRom", "bezier"])
def test_primvars_follow_the_basis(tmp_path, basis):
    """Along a curve whose x is its parameter: vertex values by the basis' matrix, varying ones linear."""
    isBezier = basis == "bezier"
    xs = np.arange(7) / (3 if isBezier else 1) - (1 if isBezier else 3)
    rng = np.random.default_rng(3)
    values = rng.uniform(0.2, 0.8, (7, 3))
    rows = {"bspline": np.array([(1, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]) / 6,
            "catmullRom": np.array([(0, 2, 0, 0), (-1, 0, 1, 0), (2, -5, 4, -1), (-1, 3, -3, 1)]) / 2,
            "bezier": np.array([(1, 0, 0, 0), (-3, 3, 0, 0), (3, -6, 3, 0), (-1, 3, -3, 1)])}[basis]
    points = np.stack([xs, 0 * xs, 0 * xs], -1)
    numJoints = 3 if isBezier else 5

    def Fill(stage, glass):
        Dome(stage)
        curves.AddCurves(stage, "/World/Vertex", [points + (0, 0.7, 0)], 0.3, basis=basis, color=values)
        varying = curves.AddCurves(stage, "/World/Varying", [points - (0, 0.7, 0)], 0.3, basis=basis)
        varying.CreateDisplayColorAttr(values[:numJoints].tolist())
        varying.CreateDisplayColorPrimvar("varying")

    layers = Render(tmp_path, Fill, 4.0, samples=1, maxDepth=0)
    x, y = Raster(4.0)
    first = -1.0 if isBezier else -2.0
    for isVertex, row in ((True, np.argmin(np.abs(y[:, 0] - 0.7))), (False, np.argmin(np.abs(y[:, 0] + 0.7)))):
        place = x[row] - first
        isOn = (place > 0.01) & (place < numJoints - 1.01)
        segment = np.floor(place[isOn]).astype(int)
        u = place[isOn] - segment
        if isVertex:
            weights = np.stack([u**0, u, u**2, u**3], -1) @ rows
            step = 3 if isBezier else 1
            expected = np.einsum("ik,ikc->ic", weights, np.stack([values[step * s : step * s + 4] for s in segment]))
        else:
            expected = values[segment] + u[:, None] * (values[segment + 1] - values[segment])
        np.testing.assert_allclose(layers["primvars:displayColor"][row][isOn], expected, atol=2e-4)


@pytest.mark.parametrize("offset", [0.0, 3000.0])
def test_no_surface_shades_itself(tmp_path, offset):
    """Under a distant light from the camera's side every place is lit by its cosine, near 0 and far from it."""
    centre = (offset, 0.0, 0.0)

    def Fill(stage, glass):
        author.AddLight(stage, "/World/Sun", "Distant", intensity=np.pi, angle=0.0)
        curves.AddPoints(stage, "/World/Points", [np.add(centre, (-1.5, 0, 0))], 2.0, color=(0.5, 0.5, 0.5))
        walk = np.array([(0.6, -2, 0), (1.6, -1, 0.3), (0.5, 0.2, 0), (1.5, 1.2, -0.3), (0.8, 2.2, 0)])
        curves.AddCurves(stage, "/World/Tube", [walk + centre], 0.6, wrap="pinned", color=(0.5, 0.5, 0.5))

    layers = Render(tmp_path, Fill, centre=centre, samples=64, maxDepth=0)
    isLit = layers["normal"][..., 2] > 0.4
    # Pixels show the mean over their area, AOVs its centre: silhouettes are left out by neighbours.
    inner = isLit & np.roll(isLit, 1, 0) & np.roll(isLit, -1, 0) & np.roll(isLit, 1, 1) & np.roll(isLit, -1, 1)
    assert inner.sum() > 150
    expected = 0.5 * layers["normal"][..., 2]
    assert np.abs(layers["color"][..., 0] - expected)[inner].max() < 0.03


def test_tubes_equal_tessellated_meshes(tmp_path):
    """Depths and normals of a bent tube of varying width, and of a ribbon, beside fine meshes of them."""
    vertices = np.array([(-2.2, -1.8, 0), (-1.5, 0.5, 0.8), (-0.2, -0.8, -0.4), (0.9, 1.2, 0.3), (2.2, 0.4, 0), (1.6, -1.6, 0.2)])
    widths = np.array([0.5, 0.8, 0.5, 0.7, 0.4, 0.3])
    matrix = np.array([(1, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]) / 6
    u = np.linspace(0, 1, 400)
    powers = np.stack([u**0, u, u**2, u**3], -1)
    path = np.concatenate([powers @ matrix @ np.column_stack([vertices, widths / 2])[i : i + 4] for i in range(3)])
    layers = []
    for isMesh in (False, True):
        def Fill(stage, glass):
            Dome(stage)
            if not isMesh:
                curves.AddCurves(stage, "/World/Tube", [vertices], widths, color=(0.5, 0.5, 0.5))
                return
            ball = shapes.Sphere(1.0, 48, 96)  # the union of balls, as balls
            instancer = UsdGeom.PointInstancer.Define(stage, "/World/Balls")
            author.AddMesh(stage, "/World/Balls/Ball", ball, color=(0.5, 0.5, 0.5))
            instancer.CreatePrototypesRel().SetTargets(["/World/Balls/Ball"])
            instancer.CreateProtoIndicesAttr([0] * len(path))
            instancer.CreatePositionsAttr([tuple(map(float, row[:3])) for row in path])
            instancer.CreateScalesAttr([(float(row[3]),) * 3 for row in path])
        folder = tmp_path / str(isMesh)
        folder.mkdir()
        layers.append(Render(folder, Fill, samples=1, maxDepth=0))
    tube, mesh = layers
    isBoth = np.isfinite(tube["cameraDepth"]) & np.isfinite(mesh["cameraDepth"])
    isOne = np.isfinite(tube["cameraDepth"]) ^ np.isfinite(mesh["cameraDepth"])
    assert isBoth.sum() > 150 and isOne.sum() < 6
    facing = isBoth & (tube["normal"][..., 2] > 0.3)
    assert np.abs(tube["cameraDepth"] - mesh["cameraDepth"])[facing].max() < 4e-3
    assert (tube["normal"] * mesh["normal"]).sum(-1)[facing].min() > 0.99


def test_ribbons_equal_tessellated_meshes(tmp_path):
    """A twisted ribbon is the ruled surface between its borders."""
    vertices = np.array([(-2, -1.5, 0), (-2, -1.5, 0), (-1, 1, 0.4), (0.5, 0, 0), (2, 1.5, -0.2), (2, 1.5, -0.2)])
    angles = np.linspace(-0.8, 0.8, 4)
    joints = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], -1)
    matrix = np.array([(1, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]) / 6
    u = np.linspace(0, 1, 200)[:, None]
    rows = []
    for i in range(3):
        place = np.hstack([u**0, u, u**2, u**3]) @ matrix @ vertices[i : i + 4]
        along = np.hstack([0 * u, u**0, 2 * u, 3 * u**2]) @ matrix @ vertices[i : i + 4]
        normal = joints[i] + u * (joints[i + 1] - joints[i])
        side = np.cross(along, normal)
        side *= 0.35 / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
        rows.append(np.stack([place - side, place + side], 1)[1 if i == 0 else 0 :])
    rows = np.concatenate(rows)
    count = len(rows) - 1
    faces = np.stack([2 * np.arange(count), 2 * np.arange(count) + 1, 2 * np.arange(count) + 3, 2 * np.arange(count) + 2], -1)
    layers = []
    for isMesh in (False, True):
        def Fill(stage, glass):
            Dome(stage)
            if isMesh:
                shape = shapes.Shape(rows.reshape(-1, 3), np.full(count, 4), faces.ravel())
                author.AddMesh(stage, "/World/Ribbon", shape, color=(0.5, 0.5, 0.5))
            else:
                curves.AddCurves(stage, "/World/Ribbon", [vertices], 0.7, normals=joints, normalInterpolation="varying",
                                 color=(0.5, 0.5, 0.5))
        folder = tmp_path / str(isMesh)
        folder.mkdir()
        layers.append(Render(folder, Fill, samples=1, maxDepth=0))
    ribbon, mesh = layers
    isBoth = np.isfinite(ribbon["cameraDepth"]) & np.isfinite(mesh["cameraDepth"])
    isOne = np.isfinite(ribbon["cameraDepth"]) ^ np.isfinite(mesh["cameraDepth"])
    assert isBoth.sum() > 80 and isOne.sum() < 8
    assert np.abs(ribbon["cameraDepth"] - mesh["cameraDepth"])[isBoth].max() < 0.02
    # The mesh turns across the ribbon too, where it twists.
    cosines = (ribbon["normal"] * mesh["normal"]).sum(-1)[isBoth]
    assert cosines.min() > 0.9 and cosines.mean() > 0.98


def test_transparent_tubes_have_no_inner_walls(tmp_path):
    """Half transparent, every ray that meets the tube passes its front and its back, joints or not."""
    walk = np.array([(-2, -1.5, 0), (-1, -0.2, 0.2), (-0.2, 0.5, 0), (0.8, 0.9, -0.2), (2, 1.0, 0)])

    def Fill(stage, glass):
        author.AddLight(stage, "/World/Sun", "Distant", intensity=1.0)  # a dome is seen, with alpha 1
        for y, kind in ((-0.8, "linear"), (0.8, "cubic")):
            tube = curves.AddCurves(stage, f"/World/{kind}", [walk + (0, y, 0)], 0.7, type=kind,
                                    **({} if kind == "linear" else {"wrap": "pinned"}))
            author.Bind(tube.GetPrim(), glass)

    picture = Render(tmp_path, Fill, samples=256, maxDepth=0)
    inner = picture["normal"][..., 2] > 0.5
    assert inner.sum() > 200
    # Means of 256 samples of 0.75; an inner wall gives 0.875: only where straight segments overlap inside a bend.
    assert picture["alpha"][inner].mean() == pytest.approx(0.75, abs=0.005)
    assert np.mean(picture["alpha"][inner] > 0.84) < 0.03


def test_ends_and_joints_where_curves_stand_still(tmp_path):
    """Ends of B-splines whose end points are given three times are half balls; zero handles and repeated points make the
    corners of straight segments."""
    corner = [np.array(point, float) for point in ((-1.5, 0.3, 0), (0, 1.8, 0), (1.5, 0.3, 0))]
    a, b, c = corner

    def Curves(points, **form):
        def Fill(stage, glass):
            author.AddLight(stage, "/World/Sun", "Distant", intensity=1.0)
            author.Bind(curves.AddCurves(stage, "/World/Corner", [np.array(points)], 0.7, **form).GetPrim(), glass)
            tip = [(0, -1.5, -2)] * 3 + [(0, -1.5, 0)] * 3
            author.Bind(curves.AddCurves(stage, "/World/Tip", [np.array(tip, float)], 1.6).GetPrim(), glass)
        return Fill

    cases = {"straight": Curves([a, b, c], type="linear"), "repeated": Curves([a, a, b, b, b, c], type="linear"),
             "handles": Curves([a, a, b, b, b, c, c], basis="bezier"), "still": Curves([a, a, b, b, b, b, b, b, c, c], basis="bezier")}
    pictures = {}
    for name, fill in cases.items():
        (tmp_path / name).mkdir()
        pictures[name] = Render(tmp_path / name, fill, samples=64, maxDepth=0)
    x, y = Raster()
    height = np.sqrt(np.maximum(0.8**2 - x**2 - (y + 1.5)**2, 0))
    inside = height > 0.2
    for name, picture in pictures.items():
        np.testing.assert_allclose(picture["normal"][inside], (np.stack([x, y + 1.5, height], -1) / 0.8)[inside], atol=1e-3)
        assert picture["alpha"][inside].mean() == pytest.approx(0.75, abs=0.01), name
        isCorner = (pictures["straight"]["normal"][..., 2] > 0.3) & ~inside
        assert isCorner.sum() > 150
        np.testing.assert_allclose(picture["normal"][isCorner], pictures["straight"]["normal"][isCorner], atol=1e-3, err_msg=name)
        assert picture["alpha"][isCorner].mean() == pytest.approx(pictures["straight"]["alpha"][isCorner].mean(), abs=0.01), name
