# SPDX-License-Identifier: Apache-2.0
"""The demo scene of the README: a still life made from formulas, without one texture.

Shows what the renderer does: metal, glossy, clearcoat, rough, emissive and see-through materials, two
PointInstancers, concave n-gons, GeomSubsets, a lens, and sphere, rect and dome lights. Fewer than
200 000 triangles; framed for 960 x 540. Y up, one unit is a decimetre.
"""

import numpy as np
from pxr import Sdf, UsdGeom, UsdShade, Vt

from . import author, shapes


def WriteDemo(path) -> None:
    """Writes the scene; the camera is /World/main_cam, usdrecord's default."""
    stage = author.NewStage(path)
    materials = _Materials(stage)
    _AddBackdrop(stage, materials)
    _AddVessels(stage, materials)
    _AddSculpture(stage, materials)
    _AddBeads(stage, materials)
    _AddLights(stage, materials)
    camera = author.AddCamera(stage, "/World/main_cam", eye=(0.6, 3.1, 13.0), target=(0.15, 1.28, 0), focalLength=50.0, width=32.0, aspect=16 / 9)
    camera.CreateFStopAttr(16.0)  # lens radius 0.16 units
    camera.CreateFocusDistanceAttr(12.6)
    stage.GetRootLayer().Save()


def _Materials(stage) -> dict:
    make = lambda name, **inputs: author.AddMaterial(stage, f"/World/Materials/{name}", **inputs)
    return {
        "paper": make("Paper", diffuseColor=(0.44, 0.38, 0.32), roughness=0.9),
        "glaze": make("Glaze", diffuseColor=(0.015, 0.09, 0.16), roughness=0.45, clearcoat=1.0, clearcoatRoughness=0.04, ior=1.6),
        "celadon": make("Celadon", diffuseColor=(0.32, 0.46, 0.36), roughness=0.28),
        "lacquer": make("Lacquer", diffuseColor=(0.5, 0.022, 0.015), roughness=0.5, clearcoat=1.0, clearcoatRoughness=0.03),
        "brass": make("Brass", diffuseColor=(0.91, 0.66, 0.27), metallic=1.0, roughness=0.22),
        "copper": make("Copper", diffuseColor=(0.93, 0.52, 0.38), metallic=1.0, roughness=0.36),
        "steel": make("Steel", diffuseColor=(0.75, 0.76, 0.78), metallic=1.0, roughness=0.1),
        "clay": make("Clay", diffuseColor=(0.62, 0.27, 0.15), roughness=0.85),
        "ivory": make("Ivory", diffuseColor=(0.78, 0.72, 0.6), roughness=0.35),
        "ink": make("Ink", diffuseColor=(0.025, 0.027, 0.035), roughness=0.3),
        "wax": make("Wax", diffuseColor=(0.85, 0.78, 0.62), roughness=0.5),
        "flame": make("Flame", diffuseColor=(0.0, 0.0, 0.0), emissiveColor=(42.0, 17.0, 4.2), roughness=1.0),
        "veil": make("Veil", diffuseColor=(0.35, 0.6, 0.62), opacity=0.35, roughness=0.12, ior=1.4),
    }


def _Turned(profile, segments: int = 128, samples: int = 72) -> shapes.Shape:
    """A lathe whose profile is a smooth curve through control points (radius, height), bottom to top.
    Catmull-Rom, with normals from its tangents."""
    control = np.asarray(profile, float)
    control = np.concatenate([2 * control[:1] - control[1:2], control, 2 * control[-1:] - control[-2:-1]])
    t = np.linspace(0, len(profile) - 1 - 1e-9, samples)
    i, f = np.floor(t).astype(int), (t % 1.0)[:, None]
    p0, p1, p2, p3 = (control[i + k] for k in range(4))
    curve = 0.5 * (2 * p1 + (p2 - p0) * f + (2 * p0 - 5 * p1 + 4 * p2 - p3) * f**2 + (3 * p1 - p0 - 3 * p2 + p3) * f**3)
    slope = 0.5 * ((p2 - p0) + 2 * (2 * p0 - 5 * p1 + 4 * p2 - p3) * f + 3 * (3 * p1 - p0 - 3 * p2 + p3) * f**2)
    radii = np.maximum(curve[:, 0], 1e-4)
    return shapes.Lathe(radii, curve[:, 1], segments, slope[:, 1], -slope[:, 0])


def _Knot(radius: float, tube: float, segments: int = 320, sides: int = 40) -> shapes.Shape:
    """A (2,3) torus knot standing upright, with exact normals by parallel transport of its frame."""
    t = 2 * np.pi * np.arange(segments) / segments
    r = 1 + 0.42 * np.cos(3 * t)
    path = radius * np.stack([r * np.cos(2 * t), r * np.sin(2 * t), 0.55 * np.sin(3 * t)], 1)
    tangent = np.roll(path, -1, 0) - np.roll(path, 1, 0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent, path)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent)
    angle = 2 * np.pi * np.arange(sides) / sides
    normals = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * up[:, None]
    points = path[:, None] + tube * normals
    i, j = np.meshgrid(np.arange(segments), np.arange(sides), indexing="ij")
    i, j, ii, jj = i.ravel(), j.ravel(), (i.ravel() + 1) % segments, (j.ravel() + 1) % sides
    quads = np.stack([i * sides + j, ii * sides + j, ii * sides + jj, i * sides + jj], 1)
    return shapes.Shape(points.reshape(-1, 3), np.full(len(quads), 4), quads.ravel(), normals.reshape(-1, 3))


def _AddBackdrop(stage, materials) -> None:
    """A sheet of paper that runs from the table up the wall in one curve."""
    angle = np.linspace(0, np.pi / 2, 24)
    z = np.concatenate([[14.0], -5 - 4 * np.sin(angle), [-9.0]])
    y = np.concatenate([[0.0], 4 - 4 * np.cos(angle), [16.0]])
    normals = np.concatenate([[[0, 1, 0]], np.stack([0 * angle, np.cos(angle), np.sin(angle)], 1), [[0, 0, 1]]])
    points = np.concatenate([np.stack([np.full_like(z, x), y, z], 1) for x in (-20.0, 20.0)])
    n = len(z)
    quads = np.array([[k, n + k, n + k + 1, k + 1] for k in range(n - 1)])
    sheet = shapes.Shape(points, np.full(n - 1, 4), quads.ravel(), np.concatenate([normals, normals]))
    author.AddMesh(stage, "/World/Backdrop", sheet, material=materials["paper"])


def _AddVessels(stage, materials) -> None:
    vase = [(0.0, 0.0), (0.55, 0.02), (0.62, 0.12), (0.95, 0.75), (1.0, 1.35), (0.62, 2.1), (0.32, 2.55), (0.3, 2.9), (0.46, 3.15),
            (0.42, 3.16), (0.26, 2.9), (0.27, 2.55), (0.5, 2.1)]
    author.AddMesh(stage, "/World/Vase", _Turned(vase, 144, 110), material=materials["glaze"], translate=(-2.55, 0, -0.9))
    bowl = [(0.0, 0.0), (0.45, 0.0), (0.5, 0.08), (0.9, 0.35), (1.25, 0.85), (1.27, 0.9), (1.22, 0.9), (0.85, 0.42), (0.4, 0.2),
            (0.0, 0.16)]
    author.AddMesh(stage, "/World/Bowl", _Turned(bowl, 144, 90), material=materials["celadon"], translate=(2.75, 0, -0.5))
    apple = [(0.0, 0.1), (0.25, 0.02), (0.55, 0.2), (0.78, 0.72), (0.7, 1.15), (0.35, 1.32), (0.08, 1.2), (0.0, 1.12)]
    for i, (x, z, turn, scale) in enumerate([(-0.95, 1.75, 0, 0.72), (0.15, 2.35, 0, 0.6)]):
        author.AddMesh(stage, f"/World/Apple{i}", _Turned(apple, 112, 64), material=materials["lacquer"], translate=(x, 0, z),
                       rotate=(0, turn, 0), scale=scale)
        stem = _Turned([(0.03, 0.0), (0.025, 0.2), (0.045, 0.42), (0.0, 0.43)], 16, 12)
        author.AddMesh(stage, f"/World/Stem{i}", stem, material=materials["ink"], translate=(x, 1.1 * scale, z), rotate=(0, turn, 9),
                       scale=scale)
    veil = [(0.52, 0.0), (0.58, 0.1), (0.6, 1.0), (0.56, 1.9), (0.58, 2.0)]
    author.AddMesh(stage, "/World/Lantern", _Turned(veil, 96, 24), material=materials["veil"], doubleSided=True,
                   translate=(0.95, 0.0, -1.4))
    candle = [(0.0, 0.0), (0.3, 0.0), (0.31, 0.02), (0.3, 1.0), (0.24, 1.08), (0.0, 1.02)]
    author.AddMesh(stage, "/World/Candle", _Turned(candle, 96, 40), material=materials["wax"], translate=(0.95, 0, -1.4))
    flame = [(0.0, 0.0), (0.055, 0.05), (0.075, 0.13), (0.045, 0.27), (0.0, 0.42)]
    author.AddMesh(stage, "/World/Flame", _Turned(flame, 32, 24), material=materials["flame"], translate=(0.95, 1.12, -1.4))


def _AddSculpture(stage, materials) -> None:
    """A knot on a painted cube, a star, steel balls."""
    cube = author.AddMesh(stage, "/World/Cube", shapes.Box(1.5, 1.1, 1.5), material=materials["ivory"], translate=(-0.6, 0.55, -0.7),
                          rotate=(0, 24, 0))
    for name, faces, material in (("top", [3], "ink"), ("front", [5], "clay")):
        subset = UsdShade.MaterialBindingAPI.Apply(cube.GetPrim()).CreateMaterialBindSubset(name, Vt.IntArray(faces))
        author.Bind(subset, materials[material])
    author.AddMesh(stage, "/World/Knot", _Knot(0.62, 0.17), material=materials["brass"], translate=(-0.6, 2.13, -0.7),
                   rotate=(0, 28, 0))
    star = shapes.Prism(shapes.StarOutline(7, 0.75, 0.36), 0.3)
    author.AddMesh(stage, "/World/Star", star, material=materials["clay"], translate=(1.62, 0.0, 1.85), rotate=(0, 15, 0))
    author.AddMesh(stage, "/World/StarTop", star, material=materials["ivory"], translate=(1.62, 0.3, 1.85), rotate=(0, 42, 0), scale=0.62)
    ball = shapes.Sphere(1.0, 64, 128)
    for i, (x, y, z, radius, material) in enumerate([(1.62, 0.86, 1.85, 0.37, "steel"), (-2.35, 0.4, 1.25, 0.4, "copper"),
                                                     (-3.3, 0.28, 1.5, 0.28, "steel")]):
        author.AddMesh(stage, f"/World/Ball{i}", ball, material=materials[material], translate=(x, y, z), scale=radius)


def _AddInstancer(stage, path: str, prototypes: list, kinds, positions, scales) -> UsdGeom.PointInstancer:
    """A PointInstancer of shapes: prototypes are (name, shape, material)."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    for name, shape, material in prototypes:
        author.AddMesh(stage, f"{path}/Prototypes/{name}", shape, material=material)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(f"{path}/Prototypes/{p[0]}") for p in prototypes])
    instancer.CreateProtoIndicesAttr(Vt.IntArray([int(k) for k in kinds]))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(positions, np.float32)))
    instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(np.repeat(np.asarray(scales, np.float32)[:, None], 3, 1)))
    return instancer


def _AddBeads(stage, materials) -> None:
    """Berries heaped in the bowl, and beads on the table along a sunflower spiral."""
    bead = shapes.Sphere(1.0, 20, 40)
    golden = np.pi * (3 - np.sqrt(5))
    k = np.arange(220)
    radius, angle = 0.16 * np.sqrt(k + 0.5), golden * k
    keep = (radius < 2.5) & (radius > 0.5)
    positions = np.stack([0.5 + 2.2 * radius * np.cos(angle), np.full(220, 0.055), 3.6 + 0.62 * radius * np.sin(angle)], 1)[keep]
    kinds = (k % 3)[keep]
    _AddInstancer(stage, "/World/Beads", [("Brass", bead, materials["brass"]), ("Ivory", bead, materials["ivory"]),
                                          ("Ink", bead, materials["ink"])], kinds, positions, np.full(len(kinds), 0.055))
    rng = np.random.default_rng(11)
    heap, number = [], 0
    while len(heap) < 70 and number < 20000:  # rejection: drop where it touches nothing
        number += 1
        r, a = 0.92 * np.sqrt(rng.random()), 2 * np.pi * rng.random()
        p = np.array([r * np.cos(a), 0.42 + 0.42 * r * r + 0.5 * rng.random() * (1 - r), r * np.sin(a)])
        if all(np.linalg.norm(p - q) > 0.235 for q in heap):
            heap.append(p)
    instancer = _AddInstancer(stage, "/World/Berries", [("Red", bead, materials["lacquer"]), ("Dark", bead, materials["glaze"])],
                              rng.integers(0, 2, len(heap)), heap, 0.11 + 0.02 * rng.random(len(heap)))
    author.Place(instancer, translate=(2.75, 0.05, -0.5))


def _AddLights(stage, materials) -> None:
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-6.5, 7.5, 5.0), rotate=(-45, -48, 0)), width=4.5, height=3.2,
                    intensity=15.0, color=(1.0, 0.93, 0.84))
    author.AddLight(stage, "/World/Rim", "Sphere", dict(translate=(7.0, 5.5, -4.0)), radius=0.7, intensity=70.0,
                    color=(0.62, 0.8, 1.0))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.16, color=(0.75, 0.86, 1.0))
