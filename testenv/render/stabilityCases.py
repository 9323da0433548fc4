# SPDX-License-Identifier: Apache-2.0
"""Hard cases with an oracle each: a closed form, or the same scene where it is easy. A case gives one figure and the bar
that it must not be above. The table of docs/stability.md is these (testenv/bench/stability.py prints it)."""

import os
from dataclasses import dataclass
from typing import Callable

import numpy as np
from pxr import Gf, UsdGeom, UsdLux

import closedForm
import ours
from compare import RelMse
from stages import author, geometryCases, hardCases, shapes

_SIZE = (64, 48)


@dataclass(frozen=True)
class HardCase:
    """`figure` renders in a folder and measures; what it measures is said by `measure`."""

    name: str
    figure: Callable[[str], float]
    measure: str
    bar: float
    naive: str  # what a naive method does
    ours: str  # what is done instead


CASES: dict[str, HardCase] = {}


def _Add(measure: str, bar: float, naive: str, ours: str, **parameters):
    """Registers a function of (folder, parameters); one case a call."""

    def Register(function):
        values = ", ".join(map(str, parameters.values()))
        suffix = f"[{values}]" if values else ""
        name = function.__name__.strip("_") + suffix
        CASES[name] = HardCase(name, lambda folder: function(folder, **parameters), measure, bar, naive, ours)
        return function

    return Register


def _Picture(path, samples=32, maxDepth=4, camera="/World/Camera", **settings) -> np.ndarray:
    picture = ours.Render(path, *_SIZE, camera=camera, samples=samples, maxDepth=maxDepth, **settings)
    assert np.isfinite(picture.rgb).all() and picture.statistics["accuracy"]["nanSamples"] == 0
    return picture.rgb


# --- Scale and place -----------------------------------------------------------------------------

_PLACE = ("float positions in world space: 1 unit of error at 10^7; acne, gaps, jitter",
          "positions relative to the scene's and each mesh's centre; transforms in double, rounded once")
_SCALE = ("fixed ray offsets of 1e-4: acne at 10^6, light leaks and missing contacts at 10^-6",
          "offsets from error bounds of what was rounded (kernels/math/offset.clh)")


@_Add("relMSE to the scene at the origin", 1e-5, *_PLACE)
def FarFromOrigin(folder) -> float:
    near, far = geometryCases.WriteFarPair(folder)
    return RelMse(_Picture(far, 16), _Picture(near, 16))


@_Add("relMSE to the scene at the origin", 1e-5, "the middle of all there is: a stray at the origin, and 1 unit of error at 10^7",
      "the middle of most (scene/sceneCentre)")
def FarFromAStray(folder) -> float:
    near, far = geometryCases.WriteFarPair(folder, hasStray=True)
    return RelMse(_Picture(far, 16), _Picture(near, 16))


@_Add("relMSE to the scene of scale 1", 1e-5, *_SCALE, scale=1e-6)
@_Add("relMSE to the scene of scale 1", 1e-5, *_SCALE, scale=1e-3)
@_Add("relMSE to the scene of scale 1", 1e-5, *_SCALE, scale=1e6)
def ScaledScene(folder, scale) -> float:
    plain = _Picture(hardCases.Room(f"{folder}/plain.usda"))
    return RelMse(_Picture(hardCases.Room(f"{folder}/scaled.usda", scale)), plain)


@_Add("relMSE to the same on a ground of 100", 1e-4, *_SCALE, size=1.0, ground=1e4)
@_Add("relMSE to the same on a ground of 100", 1e-3, *_SCALE, size=1.0, ground=1e5)
@_Add("relMSE to the same on a ground of 100", 0.05, *_SCALE, size=1.0, ground=1e6)
@_Add("relMSE to the same on a ground of 100", 1e-4, *_SCALE, size=1e-6, ground=1e-2)
def SmallBesideHuge(folder, size, ground) -> float:
    plain = _Picture(hardCases.SmallBesideHuge(f"{folder}/plain.usda", 100.0))
    return RelMse(_Picture(hardCases.SmallBesideHuge(f"{folder}/huge.usda", ground, size)), plain)


@_Add("relMSE to instances of scale 1", 1e-5, "offsets in one space only: acne or leaks in the other",
      "offsets from bounds carried through both transforms of an instance", factor=1e5)
@_Add("relMSE to instances of scale 1", 1e-5, "offsets in one space only: acne or leaks in the other",
      "offsets from bounds carried through both transforms of an instance", factor=1e-5)
def InstanceScale(folder, factor) -> float:
    plain = _Picture(hardCases.InstancedRoom(f"{folder}/plain.usda"))
    return RelMse(_Picture(hardCases.InstancedRoom(f"{folder}/scaled.usda", factor)), plain)


_CAMERA = ("clip planes and film in floats of the scene's unit", "rays from a film at distance 1, clip planes in world space")


@_Add("relMSE to a camera of ordinary size", 1e-5, *_CAMERA, cameraScale=1e-5)
@_Add("relMSE to a camera of ordinary size", 1e-5, *_CAMERA, cameraScale=1e5)
def CameraSize(folder, cameraScale) -> float:
    plain = _Picture(hardCases.Room(f"{folder}/plain.usda"))
    return RelMse(_Picture(hardCases.Room(f"{folder}/other.usda", cameraScale=cameraScale)), plain)


@_Add("relMSE to ordinary clip planes", 1e-5, *_CAMERA)
def ClipRange(folder) -> float:
    plain = _Picture(hardCases.Room(f"{folder}/plain.usda"))
    return RelMse(_Picture(hardCases.Room(f"{folder}/other.usda", clip=(1e-30, 1e30))), plain)


# --- Lights --------------------------------------------------------------------------------------


def _PlatePicture(folder, light, samples=64, **plate) -> np.ndarray:
    path = hardCases.Plate(f"{folder}/plate{len(os.listdir(folder))}.usda", light, **plate)
    return _Picture(path, samples, 0, camera="/World/Turned/Camera")


_GRAZING = ("shadow rays at a fixed offset, or shading in another place than visibility: speckles, black triangles",
            "hit points from barycentrics, offset along the face's normal by its error bound")


@_Add("most relative error of a pixel to the closed form", 1e-3, *_GRAZING, degrees=0.1)
@_Add("most relative error of a pixel to the closed form", 5e-3, *_GRAZING, degrees=0.001)
def GrazingLight(folder, degrees) -> float:
    """A distant light on a plate of 200 x 200 quads that is turned in space."""
    light = ("Distant", dict(rotate=(-degrees, 20, 0)), dict(angle=0.0, intensity=1000.0))
    picture = _PlatePicture(folder, light, 16, cells=200, turn=(13, 29, 47))
    expected = 0.5 / np.pi * 1000.0 * np.sin(np.radians(degrees))
    return float(np.abs(picture / expected - 1).max())


@_Add("part of pixels that are darker than half of the closed form", 0.0, *_GRAZING, degrees=0.01)
def SelfShadow(folder, degrees) -> float:
    light = ("Distant", dict(rotate=(-degrees, 20, 0)), dict(angle=0.0, intensity=1000.0))
    picture = _PlatePicture(folder, light, 16, cells=1000, turn=(71, 5, 23))
    return float((picture < 0.5 * 0.5 / np.pi * 1000.0 * np.sin(np.radians(degrees))).mean())


_SMALL = ("1 / solid angle overflows or cancels; sampling by area makes fireflies", "the cone's sampling in forms that do not cancel")


@_Add("relative error of the mean to the closed form", 1e-3, *_SMALL, radius=1e-3)
@_Add("relative error of the mean to the closed form", 1e-3, *_SMALL, radius=1e-6)
@_Add("relative error of the mean to the closed form", 1e-3, *_SMALL, radius=1e-10)
def TinyBrightSphere(folder, radius) -> float:
    """Its power is that of a sphere of radius 0.05."""
    light = ("Sphere", dict(translate=(-0.5, 2.0, 0.3)), dict(radius=float(radius), intensity=float(360.0 * (0.05 / radius) ** 2)))
    picture = _PlatePicture(folder, light)
    points = _PlatePoints()
    expected = closedForm.IrradianceOfSphere(points, np.array([0.0, 1.0, 0.0]), np.array([-0.5, 2.0, 0.3]), 1e-3)
    expected = expected * 360.0 * (0.05 / 1e-3) ** 2 * 0.5 / np.pi
    return float(abs(picture.mean() / expected.mean() - 1))


def _PlatePoints() -> np.ndarray:
    """Centres of the pixels of Plate()'s picture."""
    width, height = _SIZE
    x, z = np.meshgrid(((np.arange(width) + 0.5) / width - 0.5) * 4, ((np.arange(height) + 0.5) / height - 0.5) * 4 * height / width)
    return np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], -1)


@_Add("relative error of the mean to the closed form", 1e-3, *_SMALL)
def LampVeryFar(folder) -> float:
    """A sphere 10^6 away: the same as a distant light."""
    distance, radius = 1e6, 1e3
    light = ("Sphere", dict(translate=(0, distance, 0)), dict(radius=radius, intensity=1e6))
    expected = 0.5 / np.pi * 1e6 * np.pi * (radius / distance) ** 2
    return float(abs(_PlatePicture(folder, light).mean() / expected - 1))


_ZERO = ("division by the area: NaN, which spreads to neighbours through the filter",
         "left out with a warning, as it emits nothing; `normalize` divides by the area only where there is one")


@_Add("most absolute value of a pixel", 0.0, *_ZERO, kind="Sphere", normalize=False)
@_Add("most absolute value of a pixel", 0.0, *_ZERO, kind="Rect", normalize=False)
@_Add("most absolute value of a pixel", 0.0, *_ZERO, kind="Disk", normalize=True)
def LightOfZeroSize(folder, kind, normalize) -> float:
    size = dict(Sphere=dict(radius=0.0), Rect=dict(width=0.0, height=1.0), Disk=dict(radius=0.0))[kind]
    light = (kind, dict(translate=(0, 2, 0), rotate=(-90, 0, 0)), dict(intensity=5.0, normalize=normalize, **size))
    return float(np.abs(_PlatePicture(folder, light, 8)).max())


_EXPOSURE = ("intensity x 2^exposure overflows in floats at one factor", "factors are multiplied in double, rounded once")


@_Add("most relative difference of a pixel to exposure 0", 1e-6, *_EXPOSURE, exposure=100)
@_Add("most relative difference of a pixel to exposure 0", 1e-6, *_EXPOSURE, exposure=-100)
def Exposure(folder, exposure) -> float:
    """Intensity 2^-exposure: their product is 1."""
    def Light(exposure):
        return ("Rect", dict(translate=(0.3, 2.0, 0), rotate=(-90, 0, 0)),
                dict(width=1.0, height=1.0, intensity=2.0**-exposure, exposure=float(exposure)))

    plain = _PlatePicture(folder, Light(0), 8)
    return float(np.abs(_PlatePicture(folder, Light(exposure), 8) / plain - 1).max())


# --- Surfaces ------------------------------------------------------------------------------------

_THIN = ("a fixed offset is larger than the wall: light leaks", "offsets are a few rounding errors of the hit point")


@_Add("part of pixels with any light", 0.0, *_THIN, thickness=1e-3)
@_Add("part of pixels with any light", 0.0, *_THIN, thickness=1e-5)
@_Add("part of pixels with any light", 0.0, *_THIN, thickness=0.0)
def ThinWalls(folder, thickness) -> float:
    picture = _Picture(hardCases.ClosedBox(f"{folder}/box.usda", thickness), 64, 8)
    return float((picture > 0).mean())


_EDGES = ("edges computed in each triangle's own way: rays pass between", "watertight test with shared edges (Woop, Benthin, Wald 2013)")


@_Add("part of pixels with any light", 0.0, *_EDGES, shape="needles", scale=1.0)
@_Add("part of pixels with any light", 0.0, *_EDGES, shape="needles", scale=1e-6)
@_Add("part of pixels with any light", 0.0, *_EDGES, shape="needles", scale=1e6)
@_Add("part of pixels with any light", 0.0, *_EDGES, shape="sphere", scale=1e6)
@_Add("part of pixels with any light", 0.0, *_EDGES, shape="sphere", scale=1e-6)
def ClosedShell(folder, shape, scale) -> float:
    mesh = hardCases.NeedleDrum(6000) if shape == "needles" else shapes.Sphere(2.0, 200, 400)
    picture = _Picture(hardCases.ClosedShell(f"{folder}/shell.usda", mesh, scale), 64, 8)
    return float((picture > 0).mean())


@_Add("relMSE to one of them", 0.0, "hits go to one or the other by chance, shadow rays hit the twin: speckles",
      "ties are decided by (t, path index, primitive), offsets leave both behind", copies=3)
def CoplanarDuplicates(folder, copies) -> float:
    light = ("Rect", dict(translate=(0.3, 2.0, 0), rotate=(-90, 0, 0)), dict(width=1.0, height=1.0, intensity=5.0))
    plain = _PlatePicture(folder, light, turn=(20, 40, 60), cells=50)
    return RelMse(_PlatePicture(folder, light, turn=(20, 40, 60), cells=50, copies=copies), plain)


def _WithDegenerates(stage) -> None:
    """Points, needles of no area, and triangles of one vertex, all over the picture."""
    rng = np.random.default_rng(3)
    points = rng.uniform(-2, 2, (300, 3)).astype(np.float32)
    points[1::3], points[2::3] = points[::3], np.where(np.arange(100)[:, None] % 2, points[::3], points[2::3])
    points[5] = np.nan
    author.AddMesh(stage, "/World/Nothing", shapes.Shape(points, np.full(100, 3), np.arange(300)))


@_Add("relMSE to the scene without them", 0.0, "division by an area of 0: NaN normals, lost boxes", "dropped and counted in one warning a mesh")
def DegenerateTriangles(folder) -> float:
    plain = _Picture(hardCases.Blocks(f"{folder}/plain.usda"), 8)
    return RelMse(_Picture(hardCases.Blocks(f"{folder}/degenerate.usda", _WithDegenerates), 8), plain)


def _Singular(matrix):
    def Edit(stage):
        author.AddMesh(stage, "/World/Flat", shapes.Sphere(1.0, 12, 24), color=(1, 0, 0), matrix=matrix)

    return Edit


_MATRIX = ("the inverse is infinite: NaN rays", "the placement is left out with a warning")


@_Add("relMSE to the scene without it", 0.0, *_MATRIX, diagonal=(1.0, 0.0, 0.0))
@_Add("relMSE to the scene without it", 0.0, *_MATRIX, diagonal=(0.0, 0.0, 0.0))
@_Add("relMSE to the scene without it", 0.0, *_MATRIX, diagonal=(1.0, float("nan"), 1.0))
@_Add("relMSE to the scene without it", 0.0, *_MATRIX, diagonal=(1.0, float("inf"), 1.0))
def SingularTransform(folder, diagonal) -> float:
    plain = _Picture(hardCases.Blocks(f"{folder}/plain.usda"), 8)
    matrix = [[diagonal[0], 0, 0, 0], [0, diagonal[1], 0, 0], [0, 0, diagonal[2], 0], [0, 1, 1, 1]]
    return RelMse(_Picture(hardCases.Blocks(f"{folder}/singular.usda", _Singular(matrix)), 8), plain)


_FLAT = ("the inverse is infinite: left out, or NaN rays", "a thickness of 2^-16 of the plane's scale, along its normal")


@_Add("relMSE to a disc with the ball's outline", 1e-6, *_FLAT, scale=0.0)
@_Add("relMSE to a disc with the ball's outline", 1e-6, *_FLAT, scale=1e-9)
@_Add("relMSE to a disc with the ball's outline", 1e-6, *_FLAT, scale=1e-40)
def FlatTransform(folder, scale) -> float:
    """A ball by a scale along one axis, behind a turn."""
    matrix = np.diag([1.0, 1.0, scale, 1.0]) @ np.array(Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 0.5), 35)))
    matrix[3, :3] = (0.3, 1.0, 1.2)
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    disc = shapes.Shape(np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), np.array([24]), np.arange(24))

    def Picture(name, shape, place):
        def Edit(stage):
            author.AddMesh(stage, "/World/Flat", shape, color=(0.7, 0.3, 0.2), matrix=place.tolist())

        return _Picture(hardCases.Blocks(f"{folder}/{name}.usda", Edit), 64)

    unflattened = matrix.copy()
    unflattened[2, :3] = np.cross(matrix[0, :3], matrix[1, :3])
    ball = shapes.Sphere(1.0, 12, 24)
    ball = shapes.Shape(ball.points[:, [0, 2, 1]] * (1, -1, 1), ball.counts, ball.indices)  # its equator in the plane that stays
    return RelMse(Picture("flat", ball, matrix), Picture("disc", disc, unflattened))


@_Add("relMSE to a scale of 1", 1e-10, *_FLAT)
def FlatPlanes(folder) -> float:
    """Planes by a scale of 0 along their normals: a panel that glows, a mesh light, and instances."""
    def Picture(name, scale):
        def Edit(stage):
            glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(8, 6, 4))
            author.AddMesh(stage, "/World/Glowing", shapes.Plane(1, 0.6), material=glow, doubleSided=True,
                           translate=(-0.6, 2.4, 1.0), rotate=(160, 0, 0), scale=scale)
            light = author.AddMesh(stage, "/World/MeshLight", shapes.Plane(0.5, 0.5), translate=(1.4, 1.6, 1.4),
                                   rotate=(0, 0, 120), scale=scale).GetPrim()
            UsdLux.MeshLightAPI.Apply(light)
            UsdLux.LightAPI(light).CreateIntensityAttr(5.0)
            instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
            author.AddMesh(stage, "/World/Many/One", shapes.Plane(0.4, 0.4), color=(0.2, 0.8, 0.2))
            instancer.CreatePositionsAttr([(x, 0.3, 1.8) for x in (-0.6, 0.0, 0.6)])
            instancer.CreateScalesAttr([scale] * 3)
            instancer.CreateProtoIndicesAttr([0] * 3)
            instancer.CreatePrototypesRel().AddTarget("/World/Many/One")

        return _Picture(hardCases.Blocks(f"{folder}/{name}.usda", Edit), 16)

    return RelMse(Picture("flat", (1.0, 0.0, 1.0)), Picture("whole", (1.0, 1.0, 1.0)))


# --- Materials -----------------------------------------------------------------------------------

_SPECULAR = ("densities of 1e8 times weights of 1e-8: energy is lost or made, NaN at 0",
             "the narrowest lobe is as wide as floats resolve; weights are computed as ratios")


@_Add("relative error of the mean to 1", 1e-3, *_SPECULAR, roughness=0.0)
@_Add("relative error of the mean to 1", 1e-3, *_SPECULAR, roughness=1e-3)
@_Add("relative error of the mean to 1", 1e-3, *_SPECULAR, roughness=1e-2)
def SpecularChain(folder, roughness) -> float:
    """Two mirrors that face each other in a white dome; as many bounces as it takes to leave."""
    return float(abs(_Picture(hardCases.Corridor(f"{folder}/corridor.usda", roughness), 16, 400).mean() - 1))


_ODD = ("NaN or infinite values, which stay in the film for ever", "inputs are clamped as UsdPreviewSurface says; what is not finite is the default")


def OddInput(folder, name, value, meant) -> float:
    other = dict(opacity=0.6) if name in ("ior", "metallic") else dict(metallic=0.5)
    odd = _Picture(hardCases.OddMaterial(f"{folder}/odd.usda", **{name: value}, **other), 8)
    return RelMse(odd, _Picture(hardCases.OddMaterial(f"{folder}/meant.usda", **{name: meant}, **other), 8))


for _name, _values in (("roughness", [(-1.0, 0.0), (2.0, 1.0), ("inf", 0.5), ("-inf", 0.5), ("nan", 0.5)]),
                       ("ior", [("nan", 1.5), ("inf", 1.5), ("-inf", 1.5)]), ("clearcoat", [("nan", 0.0), (5.0, 1.0)]),
                       ("metallic", [("nan", 0.0), (-3.0, 0.0), (3.0, 1.0)]), ("opacity", [("nan", 1.0), (7.0, 1.0), (-1.0, 0.0)])):
    for _value, _meant in _values:
        _Add(f"relMSE to {_name} {_meant:g}", 0.0, *_ODD, name=_name, value=_value, meant=_meant)(OddInput)


@_Add("part of pixels that are not finite", 0.0, *_ODD, ior=0.0)
@_Add("part of pixels that are not finite", 0.0, *_ODD, ior=1.0)
@_Add("part of pixels that are not finite", 0.0, *_ODD, ior=-1.0)
@_Add("part of pixels that are not finite", 0.0, *_ODD, ior=1e30)
def OddIor(folder, ior) -> float:
    path = hardCases.OddMaterial(f"{folder}/odd.usda", ior=ior, opacity=0.5, clearcoat=1.0, roughness=0.0)
    return float((~np.isfinite(_Picture(path, 16, 8))).mean())
