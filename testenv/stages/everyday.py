# SPDX-License-Identifier: Apache-2.0
"""Stages of ordinary kinds that nothing is tuned by: a corridor of many small lamps, a room behind curtains, a kitchen of metal, wood
and tiles, a product between softboxes, a bathroom of mirrors and panes, foliage below a sun, a wet street at night. UsdPreviewSurface alone. Camera: /World/Camera.
"""

import pathlib

import numpy as np

from . import author, imageFile, photograph, shapes
from .grove import _Tree
from .textured import AddTexturedMaterial

MAX_DEPTH = {"corridor": 6, "curtains": 6, "kitchen": 6, "product": 6, "bathroom": 8, "foliage": 5,
             "wetStreet": 5}


def _AddRoom(stage, size, looks: dict) -> None:
    """A box of width, height and depth, seen from inside, its floor at y = 0. `looks`: by wall, or for `Walls`."""
    width, height, depth = size
    walls = {"Floor": ((width, depth), (0, 0, 0), (0, 0, 0)), "Ceiling": ((width, depth), (0, height, 0), (180, 0, 0)),
             "Back": ((width, height), (0, height / 2, -depth / 2), (90, 0, 0)),
             "Front": ((width, height), (0, height / 2, depth / 2), (-90, 0, 0)),
             "Left": ((height, depth), (-width / 2, height / 2, 0), (0, 0, -90)),
             "Right": ((height, depth), (width / 2, height / 2, 0), (0, 0, 90))}
    for name, (extent, place, turn) in walls.items():
        look = looks.get(name, looks.get("Walls"))
        if look is not None:
            author.AddMesh(stage, f"/World/{name}", shapes.Plane(*extent), material=look, doubleSided=True, translate=place, rotate=turn)


def WriteCorridor(path: str) -> None:
    """Twelve ceiling lamps and twenty-four wall lamps, all of them small meshes that glow, along a corridor of 3 x 3 x 24."""
    stage = author.NewStage(path)
    plaster = author.AddMaterial(stage, "/World/Looks/Plaster", diffuseColor=(0.7, 0.68, 0.62), roughness=0.8)
    tiles = author.AddMaterial(stage, "/World/Looks/Tiles", diffuseColor=(0.3, 0.3, 0.33), roughness=0.2)
    door = author.AddMaterial(stage, "/World/Looks/Door", diffuseColor=(0.4, 0.2, 0.1), roughness=0.4, clearcoat=0.5)
    brass = author.AddMaterial(stage, "/World/Looks/Brass", diffuseColor=(0.9, 0.7, 0.35), metallic=1.0, roughness=0.3)
    _AddRoom(stage, (3, 3, 24), {"Walls": plaster, "Floor": tiles})
    for number in range(12):
        glow = author.AddMaterial(stage, f"/World/Looks/Glow{number}", diffuseColor=(0, 0, 0), emissiveColor=(22, 20, 17))
        author.AddMesh(stage, f"/World/Ceiling{number}", shapes.Box(0.5, 0.03, 0.12), material=glow, translate=(0, 2.97, -11 + 2 * number))
    for number in range(24):
        side = 1 if number % 2 else -1
        z = -11 + 2 * (number // 2) + 0.7
        glow = author.AddMaterial(stage, f"/World/Looks/Bulb{number}", diffuseColor=(0, 0, 0), emissiveColor=(50, 34, 18))
        author.AddMesh(stage, f"/World/Bulb{number}", shapes.Sphere(0.05, 8, 12), material=glow, translate=(1.35 * side, 1.9, z))
        author.AddMesh(stage, f"/World/Holder{number}", shapes.Box(0.16, 0.04, 0.08), material=brass, translate=(1.42 * side, 1.82, z))
        author.AddMesh(stage, f"/World/Door{number}", shapes.Box(0.06, 2.1, 0.9), material=door, translate=(1.48 * side, 1.05, z - 0.9))
    author.AddCamera(stage, eye=(0.3, 1.6, 11.5), target=(0, 1.4, 0), aspect=4 / 3, width=36.0, focalLength=24.0)
    stage.GetRootLayer().Save()


def _Curtain(width: float, height: float, folds: int) -> shapes.Shape:
    """Upright, in x and y, with folds."""
    columns, rows = 16 * folds, 2
    sheet = shapes.Plane(width, height, rows, columns)
    x, _, z = sheet.points.T
    phase = 2 * np.pi * folds * x / width
    normals = np.stack([-0.1 * np.pi * folds / width * np.cos(phase), np.zeros_like(x), np.ones_like(x)], 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return shapes.Shape(np.stack([x, -z, 0.05 * np.sin(phase)], 1), sheet.counts, sheet.indices, normals, sheet.texcoords)


def WriteCurtains(path: str) -> None:
    """A bedroom of 4 x 2.6 x 4 behind thin curtains, below a plain sky and a sun, with a lamp in a shade."""
    stage = author.NewStage(path)
    plaster = author.AddMaterial(stage, "/World/Looks/Plaster", diffuseColor=(0.72, 0.7, 0.68), roughness=0.9)
    carpet = author.AddMaterial(stage, "/World/Looks/Carpet", diffuseColor=(0.35, 0.25, 0.22), roughness=1.0)
    cloth = author.AddMaterial(stage, "/World/Looks/Cloth", diffuseColor=(0.85, 0.83, 0.78), roughness=0.9, opacity=0.55)
    shade = author.AddMaterial(stage, "/World/Looks/Shade", diffuseColor=(0.9, 0.8, 0.6), roughness=0.9, opacity=0.7)
    wood = author.AddMaterial(stage, "/World/Looks/Wood", diffuseColor=(0.45, 0.28, 0.15), roughness=0.4)
    _AddRoom(stage, (4, 2.6, 4), {"Walls": plaster, "Floor": carpet, "Back": None})
    for name, size, place in (("Sill", (4, 0.7, 0.2), (0, 0.35, -2.1)), ("Lintel", (4, 0.4, 0.2), (0, 2.4, -2.1)),
                              ("Post0", (0.8, 1.5, 0.2), (-1.6, 1.45, -2.1)), ("Post1", (0.8, 1.5, 0.2), (1.6, 1.45, -2.1))):
        author.AddMesh(stage, f"/World/{name}", shapes.Box(*size), material=plaster, translate=place)
    for number, x in enumerate((-0.75, 0.75)):
        author.AddMesh(stage, f"/World/Curtain{number}", _Curtain(1.5, 2.2, 8), material=cloth, doubleSided=True, translate=(x, 1.35, -1.85))
    author.AddMesh(stage, "/World/Bed", shapes.Box(1.6, 0.5, 2.0), color=(0.6, 0.62, 0.7), translate=(0.9, 0.25, 0.2))
    author.AddMesh(stage, "/World/Pillow", shapes.Sphere(1.0, 24, 48), color=(0.75, 0.75, 0.75), translate=(0.9, 0.6, -0.5), scale=(0.6, 0.14, 0.3))
    author.AddMesh(stage, "/World/Stand", shapes.Box(0.45, 0.55, 0.45), material=wood, translate=(-0.6, 0.275, -0.7))
    author.AddMesh(stage, "/World/Shade", shapes.Lathe([0.2, 0.12], [0.8, 1.05], 48, [1, 1], [0.3, 0.3]), material=shade, doubleSided=True,
                   translate=(-0.6, 0, -0.7))
    author.AddLight(stage, "/World/Bulb", "Sphere", dict(translate=(-0.6, 0.92, -0.7)), radius=0.04, intensity=60.0, color=(1.0, 0.8, 0.55))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=1.2, color=(0.6, 0.8, 1.0))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-35, 165, 0)), angle=0.53, intensity=40000.0, color=(1.0, 0.93, 0.8))
    author.AddCamera(stage, eye=(-1.5, 1.5, 1.8), target=(0.4, 0.9, -0.8), aspect=4 / 3, width=36.0, focalLength=20.0)
    stage.GetRootLayer().Save()


def _Bumps(folder: pathlib.Path) -> None:
    folder.mkdir(exist_ok=True)
    photographs = photograph.Photographs(256)
    for index in range(2):
        imageFile.WritePng(folder / f"photo{index}.png", photographs.Make(index))
    x, y = np.meshgrid(np.linspace(0, 1, 256), np.linspace(0, 1, 256))
    turn = np.stack([0.25 * np.sin(2 * np.pi * 12 * x), 0.25 * np.sin(2 * np.pi * 12 * y), np.ones_like(x)], -1)
    turn /= np.linalg.norm(turn, axis=-1, keepdims=True)
    imageFile.WritePng(folder / "bumps.png", ((0.5 + 0.5 * turn) * 255 + 0.5).astype(np.uint8))
    rough = 0.15 + 0.2 * (0.5 + 0.5 * np.sin(2 * np.pi * (3 * x + 2 * y)))
    imageFile.WritePng(folder / "rough.png", (rough * 255 + 0.5).astype(np.uint8)[..., None])


def _Stretched(shape: shapes.Shape, times: float) -> shapes.Shape:
    return shapes.Shape(shape.points, shape.counts, shape.indices, shape.normals, times * shape.texcoords)


def WriteKitchen(path: str) -> None:
    """Brushed metal, coated wood and bumped tiles with textures, below two panels and three spots."""
    folder = pathlib.Path(path).parent / "kitchenImages"
    _Bumps(folder)
    stage = author.NewStage(path)
    bumps = (f"{folder}/bumps.png", "rgb", dict(sourceColorSpace="raw", scale=(2.0, 2.0, 2.0, 1.0), bias=(-1.0, -1.0, -1.0, 0.0)))
    rough = (f"{folder}/rough.png", "r", dict(sourceColorSpace="raw"))
    plaster = author.AddMaterial(stage, "/World/Looks/Plaster", diffuseColor=(0.75, 0.74, 0.7), roughness=0.7)
    tiles = AddTexturedMaterial(stage, "/World/Looks/Tiles", dict(diffuseColor=(f"{folder}/photo1.png", "rgb"), normal=bumps), roughness=0.15)
    wood = AddTexturedMaterial(stage, "/World/Looks/Wood", dict(diffuseColor=(f"{folder}/photo0.png", "rgb"), roughness=rough),
                               clearcoat=1.0, clearcoatRoughness=0.05)
    steel = AddTexturedMaterial(stage, "/World/Looks/Steel", dict(roughness=rough), diffuseColor=(0.75, 0.75, 0.78), metallic=1.0)
    copper = author.AddMaterial(stage, "/World/Looks/Copper", diffuseColor=(0.9, 0.55, 0.4), metallic=1.0, roughness=0.15)
    enamel = author.AddMaterial(stage, "/World/Looks/Enamel", diffuseColor=(0.6, 0.1, 0.08), roughness=0.3, clearcoat=1.0)
    _AddRoom(stage, (4, 2.6, 4), {"Walls": plaster})
    author.AddMesh(stage, "/World/Boards", _Stretched(shapes.Plane(3.98, 3.98), 3.0), material=wood, translate=(0, 0.01, 0))
    author.AddMesh(stage, "/World/Splash", _Stretched(shapes.Plane(3.9, 0.8), 2.0), material=tiles, translate=(0, 1.3, -1.98), rotate=(90, 0, 0))
    author.AddMesh(stage, "/World/Bench", shapes.Box(3.6, 0.85, 0.6), color=(0.75, 0.75, 0.72), translate=(0, 0.43, -1.65))
    author.AddMesh(stage, "/World/Top", _Stretched(shapes.Plane(3.7, 0.65), 2.0), material=steel, translate=(0, 0.87, -1.64))
    author.AddMesh(stage, "/World/Island", shapes.Box(1.4, 0.86, 0.7), color=(0.2, 0.25, 0.35), translate=(0.4, 0.43, 0.0))
    author.AddMesh(stage, "/World/IslandTop", _Stretched(shapes.Plane(1.6, 0.9), 1.5), material=wood, translate=(0.4, 0.875, 0.0))
    for number in range(5):
        look = (copper, steel, enamel)[number % 3]
        author.AddMesh(stage, f"/World/Pot{number}", shapes.Sphere(0.13, 24, 48), material=look if look is not steel else copper,
                       translate=(-1.4 + 0.6 * number, 1.0, -1.6))
    author.AddMesh(stage, "/World/Bowl", shapes.Torus(0.16, 0.06), material=enamel, translate=(0.2, 0.94, 0.0))
    author.AddMesh(stage, "/World/Kettle", shapes.Sphere(0.15, 32, 64), material=copper, translate=(0.7, 1.03, -0.05))
    author.AddMesh(stage, "/World/Fridge", shapes.Box(0.7, 1.9, 0.7), material=copper, translate=(-1.6, 0.95, -0.7))
    for number, x in enumerate((-0.9, 0.9)):
        author.AddLight(stage, f"/World/Panel{number}", "Rect", dict(translate=(x, 2.58, 0.2), rotate=(-90, 0, 0)), width=0.9, height=0.3,
                        intensity=9.0)
    for number in range(3):
        author.AddLight(stage, f"/World/Spot{number}", "Sphere", dict(translate=(-1.2 + 1.2 * number, 1.75, -1.8)), radius=0.03, intensity=70.0,
                        color=(1.0, 0.85, 0.65))
    author.AddCamera(stage, eye=(-0.9, 1.6, 1.8), target=(0.2, 0.9, -0.8), aspect=4 / 3, width=36.0, focalLength=20.0)
    stage.GetRootLayer().Save()


def WriteProduct(path: str) -> None:
    """A bottle, a tin, a box and a watch's parts on a cyclorama, between three softboxes, below a faint dome."""
    stage = author.NewStage(path)
    paper = author.AddMaterial(stage, "/World/Looks/Paper", diffuseColor=(0.65, 0.65, 0.65), roughness=0.6)
    lacquer = author.AddMaterial(stage, "/World/Looks/Lacquer", diffuseColor=(0.03, 0.1, 0.25), roughness=0.3, clearcoat=1.0)
    chrome = author.AddMaterial(stage, "/World/Looks/Chrome", diffuseColor=(0.92, 0.92, 0.92), metallic=1.0, roughness=0.01)
    satin = author.AddMaterial(stage, "/World/Looks/Satin", diffuseColor=(0.9, 0.75, 0.45), metallic=1.0, roughness=0.25)
    card = author.AddMaterial(stage, "/World/Looks/Card", diffuseColor=(0.7, 0.15, 0.1), roughness=0.45)
    angle = np.linspace(0, np.pi / 2, 17)
    profile = np.concatenate([[[6.0, 0.0]], np.stack([-2 - 2 * np.sin(angle), 2 - 2 * np.cos(angle)], 1), [[-4.0, 7.0]]])
    sheet = shapes.Plane(14, 1, len(profile) - 1, 1)
    points = np.stack([sheet.points[:, 0], np.repeat(profile[:, 1], 2), np.repeat(profile[:, 0], 2)], 1)
    author.AddMesh(stage, "/World/Paper", shapes.Shape(points, sheet.counts, sheet.indices), material=paper, doubleSided=True)
    radii, heights = [0.0, 0.35, 0.35, 0.3, 0.12, 0.12, 0.0], [0.0, 0.0, 1.1, 1.25, 1.4, 1.75, 1.75]
    author.AddMesh(stage, "/World/Bottle", shapes.Lathe(radii, heights, 96, [0, 1, 1, 0.8, 0.8, 1, 0], [-1, 0, 0, 0.6, 0.6, 0, 1]),
                   material=lacquer, translate=(-0.9, 0, 0))
    author.AddMesh(stage, "/World/Tin", shapes.Lathe([0.0, 0.4, 0.4, 0.0], [0.0, 0.0, 0.7, 0.7], 96, [0, 1, 1, 0], [-1, 0, 0, 1]),
                   material=satin, translate=(0.3, 0, 0.4))
    author.AddMesh(stage, "/World/Box", shapes.Box(0.7, 1.0, 0.4), material=card, translate=(1.2, 0.5, -0.4), rotate=(0, 30, 0))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.3), material=chrome, translate=(-0.1, 0.3, 1.1))
    author.AddMesh(stage, "/World/Ring", shapes.Torus(0.25, 0.07), material=chrome, translate=(0.9, 0.07, 1.1))
    for name, place, turn, size in (("Key", (-3.0, 2.8, 2.0), (-40, -55, 0), (1.6, 2.2)), ("Fill", (3.4, 2.2, 1.5), (-30, 65, 0), (1.2, 2.0)),
                                    ("Top", (0, 4.0, 0), (-90, 0, 0), (2.5, 1.2))):
        author.AddLight(stage, f"/World/{name}", "Rect", dict(translate=place, rotate=turn), width=size[0], height=size[1], intensity=6.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.1)
    author.AddCamera(stage, eye=(0, 1.6, 6.5), target=(0, 0.6, 0), aspect=4 / 3, width=24.0)
    stage.GetRootLayer().Save()


def WriteBathroom(path: str) -> None:
    """Mirrors and panes: a wall of mirrors without roughness, chrome, a shower's panes, glossy tiles, below a panel and a strip."""
    stage = author.NewStage(path)
    plaster = author.AddMaterial(stage, "/World/Looks/Plaster", diffuseColor=(0.75, 0.75, 0.73), roughness=0.8)
    tiles = author.AddMaterial(stage, "/World/Looks/Tiles", diffuseColor=(0.35, 0.45, 0.5), roughness=0.1)
    mirror = author.AddMaterial(stage, "/World/Looks/Mirror", diffuseColor=(0.92, 0.92, 0.92), metallic=1.0, roughness=0.0)
    chrome = author.AddMaterial(stage, "/World/Looks/Chrome", diffuseColor=(0.85, 0.85, 0.87), metallic=1.0, roughness=0.0)
    pane = author.AddMaterial(stage, "/World/Looks/Pane", diffuseColor=(0.9, 0.95, 0.93), opacity=0.0, roughness=0.0)
    china = author.AddMaterial(stage, "/World/Looks/China", diffuseColor=(0.8, 0.8, 0.8), roughness=0.2, clearcoat=1.0)
    _AddRoom(stage, (3, 2.5, 3), {"Walls": plaster, "Floor": tiles, "Left": tiles})
    author.AddMesh(stage, "/World/Mirror", shapes.Plane(2.8, 1.3), material=mirror, translate=(0, 1.6, -1.49), rotate=(90, 0, 0))
    author.AddMesh(stage, "/World/Opposite", shapes.Plane(1.4, 2.2), material=mirror, translate=(0.5, 1.2, 1.49), rotate=(-90, 0, 0))
    author.AddMesh(stage, "/World/Basin", shapes.Torus(0.25, 0.08), material=china, translate=(0.3, 0.85, -1.1))
    author.AddMesh(stage, "/World/Cupboard", shapes.Box(1.8, 0.76, 0.6), color=(0.3, 0.2, 0.12), translate=(0.2, 0.38, -1.15))
    author.AddMesh(stage, "/World/Tap", shapes.Torus(0.1, 0.025), material=chrome, translate=(0.3, 0.98, -1.35), rotate=(0, 0, 90))
    for number in range(4):
        author.AddMesh(stage, f"/World/Knob{number}", shapes.Sphere(0.07, 24, 48), material=chrome, translate=(-0.5 + 0.45 * number, 0.84, -0.95))
    author.AddMesh(stage, "/World/Shower0", shapes.Plane(1.0, 2.0), material=pane, doubleSided=True, translate=(-1.0, 1.0, 0.2), rotate=(90, 0, 0))
    author.AddMesh(stage, "/World/Shower1", shapes.Plane(2.0, 1.2), material=pane, doubleSided=True, translate=(-0.5, 1.0, 0.8), rotate=(0, 0, -90))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0.2, 2.48, 0), rotate=(-90, 0, 0)), width=0.8, height=0.8, intensity=6.0)
    author.AddLight(stage, "/World/Strip", "Rect", dict(translate=(0, 2.3, -1.4), rotate=(-30, 180, 0)), width=1.6, height=0.06, intensity=30.0)
    author.AddCamera(stage, eye=(1.1, 1.5, 1.3), target=(-0.3, 1.1, -1.2), aspect=4 / 3, width=36.0, focalLength=20.0)
    stage.GetRootLayer().Save()


def WriteFoliage(path: str) -> None:
    """Nine trees of 20 000 triangles on rough ground, below a sun and a plain sky."""
    stage = author.NewStage(path)
    random = np.random.default_rng(5)
    ground = shapes.HeightField(60.0, 96, lambda x, z: 0.2 * np.sin(0.9 * x) * np.cos(0.7 * z))
    author.AddMesh(stage, "/World/Ground", ground, color=(0.3, 0.24, 0.14))
    for number in range(9):
        tree = _Tree(random, 20_000)
        author.AddMesh(stage, f"/World/Tree{number}", tree, color=(0.12 + 0.02 * (number % 3), 0.3, 0.08), doubleSided=True,
                       translate=(-4 + 4 * (number % 3), 0, -4 + 4 * (number // 3)))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.6, color=(0.55, 0.75, 1.0))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, 40, 0)), angle=0.53, intensity=45000.0, color=(1.0, 0.95, 0.85))
    author.AddCamera(stage, eye=(0.5, 1.7, 11.0), target=(0, 2.6, 0), aspect=4 / 3, width=30.0)
    stage.GetRootLayer().Save()


def WriteWetStreet(path: str) -> None:
    """Ten small lamps along a road that mirrors them, between houses with smooth windows."""
    stage = author.NewStage(path)
    road = author.AddMaterial(stage, "/World/Looks/Road", diffuseColor=(0.06, 0.06, 0.065), roughness=0.2, clearcoat=0.8, clearcoatRoughness=0.08)
    brick = author.AddMaterial(stage, "/World/Looks/Brick", diffuseColor=(0.4, 0.2, 0.15), roughness=0.9)
    pane = author.AddMaterial(stage, "/World/Looks/Pane", diffuseColor=(0.05, 0.05, 0.06), roughness=0.05)
    author.AddMesh(stage, "/World/Road", shapes.Plane(80, 80), material=road)
    for number in range(10):
        side, z = (-1, 1)[number % 2], -8.0 * (number // 2)
        author.AddMesh(stage, f"/World/House{number}", shapes.Box(6, 8, 7.4), material=brick, translate=(9 * side, 4, z))
        for window in range(6):
            place = (6 * side, 2.2 + 2.6 * (window % 2), z - 2 + 2 * (window // 2))
            author.AddMesh(stage, f"/World/Pane{number}_{window}", shapes.Box(0.1, 1.2, 1), material=pane, translate=place)
        author.AddLight(stage, f"/World/Lamp{number}", "Sphere", dict(translate=(4 * side, 4.6, z + 2)), radius=0.12, intensity=300.0,
                        color=(1.0, 0.75, 0.45))
    author.AddCamera(stage, eye=(0, 1.7, 7), target=(0, 2.4, -10), aspect=4 / 3, width=26.0)
    stage.GetRootLayer().Save()


WRITERS = {"corridor": WriteCorridor, "curtains": WriteCurtains, "kitchen": WriteKitchen, "product": WriteProduct, "bathroom": WriteBathroom,
           "foliage": WriteFoliage, "wetStreet": WriteWetStreet}
