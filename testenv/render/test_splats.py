# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats against sums over all splats in double precision.

The oracle composites front to back as Kerbl et al. 2023 do: C = sum of T alpha c with alpha = min(0.99, o exp(-d^2 / 2)), splats
below 1/255 left out. A ray meets a splat where its response is greatest (Moenne-Loccoz et al. 2024), by which they are sorted.
Spherical harmonics are made of Legendre polynomials, with the definition's factorials.
"""

import math

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hdstream
import ours
from pxr import Gf, Sdf, Usd, UsdGeom
from stages import author, shapes, splats

SIZE, WIDTH, SUB = 24, 3.0, 6  # pixels a side, width of the view, points a side of a pixel for the oracle
PLACEMENT = dict(translate=(0.1, -0.2, 0.3), rotate=(20, 35, -10), scale=(1.2, 0.7, 0.9))


def Harmonics(directions, degree):
    """Real spherical harmonics with the Condon-Shortley phase [...][(degree + 1)^2], by degree and order from -l to l."""
    x, y, z = np.moveaxis(directions, -1, 0)
    azimuth = np.arctan2(y, x)
    columns = []
    for l in range(degree + 1):
        legendre = np.polynomial.legendre.Legendre.basis(l)
        for m in range(-l, l + 1):
            k = abs(m)
            derivative = legendre.deriv(k)(z) if k else legendre(z)
            value = (-1) ** k * np.sqrt(np.maximum(1 - z * z, 0)) ** k * derivative
            value = value * math.sqrt((2 * l + 1) / (4 * math.pi) * math.factorial(l - k) / math.factorial(l + k))
            if m:
                value = value * math.sqrt(2) * (np.cos(k * azimuth) if m > 0 else np.sin(k * azimuth))
            columns.append(value)
    return np.stack(columns, -1)


def Matrices(quaternions):
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1).reshape(-1, 3, 3)


def Composite(origins, directions, clouds, far=np.inf):
    """Radiance and alpha [n][4] of rays through clouds, each (cloud, world from object [4][4] on row vectors)."""
    t, alpha, colour = [], [], []
    for cloud, matrix in clouds:
        inverse = np.linalg.inv(matrix)
        o, d = origins @ inverse[:3, :3] + inverse[3, :3], directions @ inverse[:3, :3]
        unit = d / np.linalg.norm(d, axis=1, keepdims=True)
        maps = np.swapaxes(Matrices(cloud["orientations"]), 1, 2) / cloud["scales"][:, :, None]  # rows: axes over scales
        q = np.einsum("sij,nsj->nsi", maps, o[:, None] - cloud["positions"])
        v = np.einsum("sij,nj->nsi", maps, d)
        at = -(q * v).sum(-1) / (v * v).sum(-1)
        distance = ((q + at[..., None] * v) ** 2).sum(-1)
        t.append(at)
        alpha.append(np.minimum(0.99, cloud["opacities"] * np.exp(-distance / 2)))
        degree = int(round(math.sqrt(cloud["coefficients"].shape[1]))) - 1
        colour.append(np.maximum(0, 0.5 + np.einsum("nk,skc->nsc", Harmonics(unit, degree), cloud["coefficients"])))
    t, alpha, colour = np.concatenate(t, 1), np.concatenate(alpha, 1), np.concatenate(colour, 1)
    alpha[(alpha < 1 / 255) | (t <= 0) | (t >= far)] = 0
    order = np.argsort(t, 1)
    alpha, colour = np.take_along_axis(alpha, order, 1), np.take_along_axis(colour, order[..., None], 1)
    left = np.cumprod(1 - alpha, 1)
    weight = np.concatenate([np.ones((len(t), 1)), left[:, :-1]], 1) * alpha
    return np.concatenate([(weight[..., None] * colour).sum(1), 1 - left[:, -1:]], 1)


def Reference(clouds, far=np.inf):
    """The picture [SIZE][SIZE][4] of an orthographic camera at z = 10, by means of SUB x SUB points a pixel."""
    at = (np.arange(SIZE * SUB) + 0.5) / (SIZE * SUB) * WIDTH - WIDTH / 2
    x, y = np.meshgrid(at, -at)
    origins = np.stack([x, y, np.full_like(x, 10.0)], -1).reshape(-1, 3)
    rays = np.concatenate([Composite(part, np.broadcast_to((0.0, 0.0, -1.0), part.shape), clouds, far)
                           for part in np.array_split(origins, 32)])
    return rays.reshape(SIZE, SUB, SIZE, SUB, 4).mean((1, 3))


def NewStage(path):
    stage = author.NewStage(str(path))
    author.AddCamera(stage, eye=(0, 0, 10), target=(0, 0, 0), orthographic=True, width=10 * WIDTH, aspect=1.0)
    author.AddLight(stage, "/World/Dark", "Distant", intensity=0.0)  # a stage without lights gets one
    return stage


def WorldFrom(prim):
    return np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))


def Pictures(path, seeds=8, samples=128, **settings):
    """Colour and alpha of independent renders [seeds][SIZE][SIZE][4]."""
    return np.array([ours.Render(path, SIZE, SIZE, samples=samples, seed=1 + i, **settings).layers["color"] for i in range(seeds)],
                    np.float64)


def AssertAre(pictures, reference, offset=2e-3):
    """By a z-test of blocks of 3 x 3 pixels; `offset`: what the points of the oracle may be off by."""
    blocks = lambda a: a.reshape(*a.shape[:-3], SIZE // 3, 3, SIZE // 3, 3, 4).mean((-4, -2))
    mine, theirs = blocks(pictures), blocks(reference)
    error = np.sqrt(mine.var(0, ddof=1) / len(mine)) + offset * np.maximum(theirs, 0.05)
    scores = (mine.mean(0) - theirs) / error
    assert np.abs(scores).max() < 6.0, np.abs(scores).max()
    means = pictures.reshape(len(pictures), -1).mean(1)
    assert abs(means.mean() - theirs.mean()) < 5 * means.std(ddof=1) / np.sqrt(len(means)) + 1e-3 * theirs.mean()


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_clouds_are_composited_as_the_paper_does(degree, tmp_path):
    cloud = splats.RandomCloud(60, degree, 10 + degree)
    stage = NewStage(tmp_path / "a.usda")
    prim = splats.AddSplats(stage, "/World/Splats", cloud, **PLACEMENT)
    stage.GetRootLayer().Save()
    reference = Reference([(cloud, WorldFrom(prim))])
    assert reference[..., 3].max() > 0.9 and reference[..., 3].min() < 0.4
    AssertAre(Pictures(tmp_path / "a.usda", maxDepth=0), reference)


def test_instances_and_a_card_between(tmp_path):
    """Two clouds in each other, one placed twice, before a card that emits, whose light they dim."""
    first, second = splats.RandomCloud(30, 3, 3), splats.RandomCloud(30, 1, 4)
    stage = NewStage(tmp_path / "a.usda")
    alone = splats.AddSplats(stage, "/World/First", first, rotate=(0, 90, 0))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    splats.AddSplats(stage, "/World/Many/Second", second)
    instancer.CreatePrototypesRel().SetTargets(["/World/Many/Second"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(-0.4, 0, 0.5), (0.4, 0.2, -0.6)])
    instancer.CreateScalesAttr([(1, 1, 1), (0.8, 1.2, 0.5)])
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(0.2, 0.4, 0.8), specularColor=(0, 0, 0),
                              useSpecularWorkflow=1)
    author.Bind(author.AddMesh(stage, "/World/Card", shapes.Plane(8, 8), rotate=(90, 0, 0)).GetPrim(), glow)
    stage.GetRootLayer().Save()
    places = [np.array(m) for m in instancer.ComputeInstanceTransformsAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default())]
    reference = Reference([(first, WorldFrom(alone)), *((second, place) for place in places)], far=10.0)
    reference[..., :3] += (1 - reference[..., 3:]) * np.array((0.2, 0.4, 0.8))
    reference[..., 3] = 1
    AssertAre(Pictures(tmp_path / "a.usda", maxDepth=0), reference)


def test_shadows_are_what_clouds_let_pass(tmp_path):
    """A lamp far above lights a plate through a cloud: the plate is dimmed by the products of 1 - alpha of the rays up."""
    cloud = splats.RandomCloud(25, 0, 5, size=(0.15, 0.6))
    cloud["coefficients"][:] = -0.5 / 0.28209479177387814  # black
    stage = NewStage(tmp_path / "a.usda")
    prim = splats.AddSplats(stage, "/World/Splats", cloud, translate=(0, 0, 5))
    prim.CreateAttribute("primvars:hdstream:visibility:camera", Sdf.ValueTypeNames.Bool).Set(False)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Sun", "Distant", intensity=2.0, angle=0.0)
    stage.GetRootLayer().Save()
    dimmed = Pictures(tmp_path / "a.usda", seeds=2, samples=64, maxDepth=0)
    prim.SetActive(False)
    stage.GetRootLayer().Save()
    bright = Pictures(tmp_path / "a.usda", seeds=1, samples=16, maxDepth=0)[0, ..., :3]
    left = 1 - Reference([(cloud, WorldFrom(prim))])[..., 3:]
    assert bright.min() > 0.01 and left.min() < 0.2
    # Shadow rays are dimmed, not stopped by chance: what differs is where pixels are sampled.
    assert np.abs(dimmed[..., :3].mean(0) / bright - left).max() < 0.02


def _Single(scale, opacity, coefficients):
    return dict(positions=np.zeros((1, 3)), scales=np.full((1, 3), scale), orientations=np.array([(1.0, 0, 0, 0)]),
                opacities=np.array([opacity]), coefficients=coefficients)


def test_no_splat_covers_all(tmp_path):
    """Below the middle of an opaque splat a hundredth of the light of a lamp arrives."""
    stage = NewStage(tmp_path / "a.usda")
    splat = splats.AddSplats(stage, "/World/Splat", _Single(30.0, 1.0, np.full((1, 1, 3), -9.0)), translate=(0, 0, 5))
    splat.CreateAttribute("primvars:hdstream:visibility:camera", Sdf.ValueTypeNames.Bool).Set(False)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Sun", "Distant", intensity=2.0, angle=0.0)
    stage.GetRootLayer().Save()
    dark = ours.Render(tmp_path / "a.usda", SIZE, SIZE, samples=1, maxDepth=0).rgb
    splat.SetActive(False)
    stage.GetRootLayer().Save()
    bright = ours.Render(tmp_path / "a.usda", SIZE, SIZE, samples=1, maxDepth=0).rgb
    assert np.abs(dark / bright - 0.01).max() < 1e-5


@pytest.mark.parametrize("rotate", [(0, 0, 0), (20, 35, -10), (-110, 15, 80), (90, 0, 0), (5, 175, 60)])
def test_colours_are_the_harmonics_of_the_ray_to_float(rotate, tmp_path):
    """All rays of the camera have one direction, and those that end on the splat bring its colour, whatever its alpha: of a deep
    picture, where those that pass it bring nothing."""
    stage = NewStage(tmp_path / "a.usda")
    cloud = _Single(2.0, 0.5, np.random.default_rng(3).normal(size=(1, 16, 3)))
    prim = splats.AddSplats(stage, "/World/Splat", cloud, rotate=rotate)
    stage.GetRootLayer().Save()
    picture = ours.Render(tmp_path / "a.usda", SIZE, SIZE, samples=1, maxDepth=0, deep=True).layers["color"].astype(np.float64)
    direction = np.array((0.0, 0.0, -1.0)) @ np.linalg.inv(WorldFrom(prim)[:3, :3])
    expected = np.maximum(0, 0.5 + np.einsum("k,kc->c", Harmonics(direction, 3), cloud["coefficients"][0]))
    seen = picture[picture[..., 3] == 1]
    assert 50 < len(seen) < SIZE * SIZE - 50 and expected.max() > 0.1
    assert np.abs(seen[:, :3] - expected).max() < 4e-5


def test_first_hits_are_where_the_response_is_greatest(tmp_path):
    stage = NewStage(tmp_path / "a.usda")
    cloud = dict(positions=np.array([(0.3, -0.2, 0.4)]), scales=np.array([(0.9, 0.4, 0.2)]), orientations=np.array([(0.8, 0.2, 0.5, -0.1)]),
                 opacities=np.array([0.9]), coefficients=np.zeros((1, 1, 3)))
    splats.AddSplats(stage, "/World/Splat", cloud)
    stage.GetRootLayer().Save()
    layers = ours.Render(tmp_path / "a.usda", SIZE, SIZE, ("color", "cameraDepth", "elementId", "position"), samples=1).layers
    at = (np.arange(SIZE) + 0.5) / SIZE * WIDTH - WIDTH / 2
    x, y = np.meshgrid(at, -at)
    covariance = (lambda m: m @ m.T)(Matrices(cloud["orientations"])[0] * cloud["scales"][0])
    precision = np.linalg.inv(covariance)
    offset = np.stack([x - 0.3, y + 0.2], -1)
    z = 0.4 - offset @ precision[2, :2] / precision[2, 2]  # of a Gaussian's ridge along z
    distance = np.einsum("...i,ij,...j", offset, np.linalg.inv(covariance[:2, :2]), offset)
    there, sure = distance < 2 * np.log(0.9 * 255), np.abs(distance - 2 * np.log(0.9 * 255)) > 1e-3
    depth = np.squeeze(layers["cameraDepth"])
    assert (np.isfinite(depth) == there)[sure].all() and there.mean() > 0.2
    seen = there & sure
    assert np.abs(depth - (10 - z))[seen].max() < 2e-5
    assert (layers["elementId"].reshape(SIZE, SIZE)[seen] == 0).all()


def test_halfs_are_floats_of_their_values(tmp_path):
    cloud = splats.RandomCloud(20, 2, 6)
    rounded = {name: np.asarray(array, np.float16).astype(np.float32) for name, array in cloud.items()}
    pictures = []
    for isHalf in (False, True):
        stage = NewStage(tmp_path / f"{isHalf}.usda")
        splats.AddSplats(stage, "/World/Splats", cloud if isHalf else rounded, isHalf)
        stage.GetRootLayer().Save()
        pictures.append(ours.Render(tmp_path / f"{isHalf}.usda", SIZE, SIZE, samples=4).layers["color"])
    assert np.array_equal(*pictures) and pictures[0].max() > 0.1


def test_splats_move(tmp_path):
    """Blur of a cloud that goes along x is the mean of the pictures on the way."""
    cloud = splats.RandomCloud(12, 1, 7)
    stage = NewStage(tmp_path / "a.usda")
    prim = splats.AddSplats(stage, "/World/Splats", cloud)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    positions = prim.GetAttribute("positions")
    for time, way in ((0.0, 0.0), (1.0, 0.8)):
        positions.Set([Gf.Vec3f(*map(float, p)) for p in cloud["positions"] + (way, 0, 0)], time)
    stage.GetRootLayer().Save()
    renderer = hdstream.Renderer(str(tmp_path / "a.usda"))
    settings = dict(imageWidth=SIZE, imageHeight=SIZE, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=0,
                    noCache=True, samples=128)
    pictures = np.array([renderer.Render(0.0, seed=1 + i, **settings).aovs["color"] for i in range(6)], np.float64)
    ways = (np.arange(16) + 0.5) / 16 * 0.8
    reference = np.mean([Reference([({**cloud, "positions": cloud["positions"] + (way, 0, 0)}, np.eye(4))]) for way in ways], 0)
    AssertAre(pictures, reference, 5e-3)


@pytest.mark.parametrize("names, times", [
    (("orientations",), (0.0, 0.6, 1.0)), (("scales",), (0.0, 0.6, 1.0)), (("opacities",), (0.0, 0.6, 1.0)),
    (("positions", "orientations", "scales", "opacities"), (0.0, 0.6, 1.0)),
    (("scales",), (0.0, 1.0))])  # one segment, of whose two keys each counts for much
def test_shapes_move(names, times, tmp_path):
    """Blur of a cloud that turns, grows and fades is the mean of the pictures on the way, by OpenUSD's own values of the arrays."""
    cloud = splats.RandomCloud(12, 1, 7, size=(0.1, 0.8), opacity=(0.4, 1.0))
    other = {**splats.OtherShapes(cloud, 8, 150.0), "positions": cloud["positions"] + (0.4, 0.0, 0.0)}
    stage = NewStage(tmp_path / "a.usda")
    prim = splats.AddSplats(stage, "/World/Splats", cloud)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    for time, arrays in zip(times, (cloud, other, cloud)):
        splats.SetArrays(prim, {name: arrays[name] for name in names}, timeCode=time)
    stage.GetRootLayer().Save()
    renderer = hdstream.Renderer(str(tmp_path / "a.usda"))
    settings = dict(imageWidth=SIZE, imageHeight=SIZE, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=0,
                    noCache=True, samples=128)
    pictures = np.array([renderer.Render(0.0, seed=1 + i, **settings).aovs["color"] for i in range(6)], np.float64)
    values = lambda name, time: np.array([(q.real, *q.imaginary) for q in prim.GetAttribute(name).Get(time)]
                                         if name == "orientations" else prim.GetAttribute(name).Get(time), np.float64)
    reference = np.mean([Reference([({**cloud, **{name: values(name, time) for name in names}}, np.eye(4))])
                         for time in (np.arange(24) + 0.5) / 24], 0)
    AssertAre(pictures, reference, 5e-3)
    still = Reference([(cloud, np.eye(4))])
    assert np.abs(still - reference).mean() > 0.01, "the test would show little"


def test_arrays_that_change_in_number_are_at_rest(tmp_path):
    cloud = splats.RandomCloud(6, 1, 7)
    stage = NewStage(tmp_path / "a.usda")
    prim = splats.AddSplats(stage, "/World/Splats", cloud)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    stage.GetRootLayer().Save()
    lines = []
    settings = dict(imageWidth=SIZE, imageHeight=SIZE, camera="/World/Camera", noCache=True, samples=4)
    render = lambda: hdstream.Renderer(str(tmp_path / "a.usda"), onWarning=lines.append).Render(0.0, **settings).aovs["color"]
    still = render()
    splats.SetArrays(prim, {"scales": cloud["scales"]}, timeCode=0.0)
    splats.SetArrays(prim, {"scales": cloud["scales"][:5]}, timeCode=0.5)
    stage.GetRootLayer().Save()
    assert np.array_equal(render(), still)
    assert [line for line in lines if "number" in line] == [
        "/World/Splats: its points change in number while the shutter is open: drawn without motion blur"]


@pytest.mark.parametrize("change, line", [
    (dict(scales=np.ones((3, 3))), "scales ignored: they need 5 x 3 numbers, have 3 x 3"),
    (dict(opacities=np.array([1, 1, 1, 1, 0.001])), "1 splats dropped: no scale or orientation, or an opacity below 1/255"),
    (dict(orientations=np.zeros((5, 4))), "5 splats dropped: no scale or orientation, or an opacity below 1/255"),
    (dict(positions=np.array([(np.nan, 0, 0), *[(0, 0, 0)] * 4])), "1 splats dropped: not finite or beyond 1e18"),
    (dict(coefficients=np.zeros((5, 25, 3))), "radiance:sphericalHarmonicsDegree is none from 0 to 3: the splats are grey"),
    (dict(coefficients=np.full((5, 1, 3), np.inf)), 'primvar "radiance:sphericalHarmonicsCoefficients": 15 floats are not finite, read as 0'),
])
def test_bad_content_is_a_line(change, line, tmp_path):
    stage = NewStage(tmp_path / "a.usda")
    splats.AddSplats(stage, "/World/Splats", {**splats.RandomCloud(5, 0, 8), **change})
    stage.GetRootLayer().Save()
    picture = ours.Render(tmp_path / "a.usda", SIZE, SIZE, samples=1)
    assert picture.warnings == ["/World/Splats: " + line]
    assert np.isfinite(picture.layers["color"]).all()


def test_what_is_not_authored_is_the_fallback(tmp_path):
    """Grey balls of deviation 1 that are not turned."""
    stage = NewStage(tmp_path / "a.usda")
    splats.AddSplats(stage, "/World/Splats", dict(positions=np.array([(0.0, 0.0, 0.0)])))
    stage.GetRootLayer().Save()
    cloud = dict(positions=np.zeros((1, 3)), scales=np.ones((1, 3)), orientations=np.array([(1.0, 0, 0, 0)]), opacities=np.ones(1),
                 coefficients=np.zeros((1, 1, 3)))
    AssertAre(Pictures(tmp_path / "a.usda", maxDepth=0), Reference([(cloud, np.eye(4))]))
