# SPDX-License-Identifier: Apache-2.0
"""Stages of curves and points: every basis and wrap side by side, a hair ball, a cloud of points."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from . import author, shapes


def AddCurves(stage, path, curves, widths, type="cubic", basis="bspline", wrap="nonperiodic",
              widthInterpolation="vertex", normals=None, normalInterpolation="vertex", color=None, **placement):
    """UsdGeomBasisCurves of a list of arrays [n][3]; `widths` is a number, or all values."""
    prim = UsdGeom.BasisCurves.Define(stage, path)
    points = np.concatenate(curves).astype(np.float32)
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    prim.CreateCurveVertexCountsAttr(Vt.IntArray([len(curve) for curve in curves]))
    prim.CreateTypeAttr(type)
    if type == "cubic":
        prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(wrap)
    _SetWidths(prim, widths, widthInterpolation)
    if normals is not None:
        prim.CreateNormalsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, normal)) for normal in normals]))
        prim.SetNormalsInterpolation(normalInterpolation)
    return _Finish(prim, color, points, widths, placement)


def AddPoints(stage, path, points, widths, widthInterpolation="vertex", color=None, **placement):
    """UsdGeomPoints; `widths` is a number, or all values."""
    prim = UsdGeom.Points.Define(stage, path)
    points = np.asarray(points, np.float32)
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    _SetWidths(prim, widths, widthInterpolation)
    return _Finish(prim, color, points, widths, placement)


def _SetWidths(prim, widths, interpolation):
    prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.atleast_1d(np.asarray(widths, np.float32))))
    prim.SetWidthsInterpolation("constant" if np.isscalar(widths) else interpolation)


def _Finish(prim, color, points, widths, placement):
    reach = float(np.max(widths)) / 2
    prim.CreateExtentAttr([Gf.Vec3f(*map(float, points.min(0) - reach)), Gf.Vec3f(*map(float, points.max(0) + reach))])
    if color is not None and np.ndim(color) == 1:
        prim.CreateDisplayColorAttr([Gf.Vec3f(*map(float, color))])
    elif color is not None:
        author.AddPrimvar(prim, "displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex",
                          Vt.Vec3fArray.FromNumpy(np.asarray(color, np.float32)))
    author.Place(prim, **placement)
    return prim


def AddLightsAndGround(stage, size=8.0, y=0.0):
    author.AddMesh(stage, "/World/Ground", shapes.Plane(size, size), color=(0.5, 0.5, 0.5), translate=(0, y, 0))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-3, 5, 4), rotate=(-45, -35, 0)), width=2.0, height=2.0,
                    intensity=14.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.4)


def WriteShapes(path) -> str:
    """Every basis and wrap, round and flat, with widths and colours of every interpolation; points."""
    stage = author.NewStage(path)
    AddLightsAndGround(stage, 16.0)
    zigzag = np.array([(0, 0.3, 0), (0.7, 1.2, 0), (0, 2.0, 0.3), (0.7, 2.8, 0), (0, 3.5, 0)], float)
    rainbow = np.array([(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)], float)
    widths = np.array([0.5, 0.4, 0.3, 0.2, 0.05])
    place = lambda x: dict(translate=(x, 0, 0))
    AddCurves(stage, "/World/Linear", [zigzag], widths, type="linear", color=rainbow, **place(-5))
    AddCurves(stage, "/World/BSpline", [zigzag], widths, wrap="pinned", color=rainbow, **place(-3.7))
    AddCurves(stage, "/World/CatmullRom", [zigzag], widths, basis="catmullRom", wrap="pinned", color=rainbow, **place(-2.4))
    bezier = np.array([(0, 0.3, 0), (1, 0.8, 1), (-1, 1.5, 0), (0.4, 1.9, 0), (1.5, 2.2, 0), (0.8, 3, 0), (0, 3.5, 0)], float)
    AddCurves(stage, "/World/Bezier", [bezier], (0.2, 0.6, 0.3), basis="bezier", widthInterpolation="varying",
              color=(0.8, 0.5, 0.2), **place(-1))
    ring = np.array([(0.5, 0.3, 0), (1, 0.8, 0.2), (0.5, 1.3, 0), (0, 0.8, 0.2)], float)
    AddCurves(stage, "/World/Ring", [ring], 0.25, basis="catmullRom", wrap="periodic", color=(0.2, 0.6, 0.9), **place(0.8))
    AddCurves(stage, "/World/Square", [ring + (0, 1.7, 0)], 0.25, type="linear", wrap="periodic", color=(0.9, 0.3, 0.6), **place(0.8))
    ribbon = np.array([(0, 0.3, 0), (0.6, 1.2, 0), (-0.2, 2.1, 0), (0.5, 2.8, 0), (0, 3.5, 0)], float)
    turning = [(np.sin(a), 0, np.cos(a)) for a in np.linspace(0, 2.5, 5)]
    AddCurves(stage, "/World/Ribbon", [ribbon], 0.5, wrap="pinned", normals=turning, color=rainbow, **place(2.7))
    AddCurves(stage, "/World/FlatLinear", [ribbon], 0.4, type="linear", normals=[(0, 0, 1)], normalInterpolation="constant",
              color=(0.3, 0.8, 0.4), **place(4))
    AddPoints(stage, "/World/Points", [(5.2, 0.4 + 0.8 * i, 0) for i in range(4)], (0.8, 0.7, 0.6, 0.5), color=rainbow[:4])
    author.AddCamera(stage, eye=(0, 2.6, 13), target=(0, 1.7, 0), focalLength=42.0, width=36.0)
    stage.GetRootLayer().Save()
    return str(path)


def HairBall(count, numVertices=9, seed=5):
    """(points [count * numVertices][3], widths, colours) of hairs that stand on a ball and curl."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(count, 3))
    roots /= np.linalg.norm(roots, axis=1, keepdims=True)
    aside = np.cross(roots, rng.normal(size=(count, 3)))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    other = np.cross(roots, aside)
    along = np.linspace(0, 1, numVertices)
    length = rng.uniform(0.35, 0.6, (count, 1, 1))
    angle = (along * rng.uniform(3, 9, (count, 1)))[..., None]
    curl = 0.05 * along[None, :, None] * (np.cos(angle) * aside[:, None] + np.sin(angle) * other[:, None])
    points = roots[:, None] * (1 + length * along[None, :, None]) + curl
    points[..., 1] -= 0.25 * along**2
    widths = np.tile(0.012 * (1 - 0.8 * along), count)
    shade = rng.uniform(0.5, 1.0, (count, 1))
    colours = np.repeat(shade * (0.75, 0.45, 0.2), numVertices, axis=0)
    return points.reshape(-1, 3), widths, colours


def WriteHair(path, count: int = 20000) -> str:
    """A ball with hair."""
    stage = author.NewStage(path)
    AddLightsAndGround(stage, 12.0, -1.6)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 48, 96), color=(0.25, 0.16, 0.1))
    points, widths, colours = HairBall(count)
    AddCurves(stage, "/World/Hair", list(points.reshape(count, -1, 3)), widths, wrap="pinned", color=colours)
    author.AddCamera(stage, eye=(0, 0.9, 5.6), target=(0, -0.1, 0), focalLength=45.0, width=36.0)
    stage.GetRootLayer().Save()
    return str(path)


def WritePointCloud(path, count: int = 20000) -> str:
    """A torus of points."""
    stage = author.NewStage(path)
    AddLightsAndGround(stage, 12.0, -1.0)
    rng = np.random.default_rng(8)
    around, tube = rng.uniform(0, 2 * np.pi, (2, count))
    radius = 1.3 + 0.5 * np.cos(tube)
    points = np.stack([radius * np.cos(around), 0.5 * np.sin(tube), radius * np.sin(around)], -1)
    colours = 0.5 + 0.45 * np.cos(around[:, None] + np.array([0, 2.1, 4.2]))
    AddPoints(stage, "/World/Cloud", points, rng.uniform(0.01, 0.05, count), color=colours)
    author.AddCamera(stage, eye=(0, 2.2, 4.6), target=(0, -0.2, 0), focalLength=40.0, width=36.0)
    stage.GetRootLayer().Save()
    return str(path)
