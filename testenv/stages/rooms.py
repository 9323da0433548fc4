# SPDX-License-Identifier: Apache-2.0
"""Rooms: what interiors are lit by, each alone. A table, a bowl, books and a mirror stand in a room of 5 x 3 x 4, whose right
wall has a window: below a sky that is an image (`skyRoom`), without and with a sun that comes in (`sunRoom`), or shut, lit by
panels that are meshes (`panelRoom`). Camera: /World/Camera.
"""

import pathlib

import numpy as np

from . import author, imageFile, shapes

MAX_DEPTH = 6
_WALLS = {  # size, place, turn: planes lie in x and z, and look to y
    "Floor": ((5, 4), (0, 0, 0), (0, 0, 0)),
    "Ceiling": ((5, 4), (0, 3, 0), (180, 0, 0)),
    "Back": ((5, 3), (0, 1.5, -2), (90, 0, 0)),
    "Front": ((5, 3), (0, 1.5, 2), (-90, 0, 0)),
    "Left": ((3, 4), (-2.5, 1.5, 0), (0, 0, -90)),
    "Sill": ((1, 4), (2.5, 0.5, 0), (0, 0, 90)),
    "Lintel": ((0.8, 4), (2.5, 2.6, 0), (0, 0, 90)),
    "Beside": ((1.2, 1.2), (2.5, 1.6, -1.4), (0, 0, 90)),
    "Near": ((1.2, 1.2), (2.5, 1.6, 1.4), (0, 0, 90)),
}
_SUN_AZIMUTH = 0.08  # from the window's middle
_SUN_ELEVATION = 0.5


def _WriteSky(path: pathlib.Path, hasSun: bool) -> None:
    """A clear sky of 512 x 256: blue above, brighter at the horizon, brown ground. The sun, of 3 degrees, brings more
    light than all the rest. +x of the world is longitude pi/2."""
    height, width = 256, 512
    y, x = np.mgrid[0:height, 0:width]
    elevation = np.pi / 2 - np.pi * (y + 0.5) / height
    longitude = np.pi - 2 * np.pi * (x + 0.5) / width
    sky = (0.6 + 1.2 * np.exp(-3 * np.abs(elevation)))[..., None] * np.array([0.5, 0.7, 1.2])
    image = np.where(elevation[..., None] > 0, sky, np.array([0.25, 0.22, 0.18]))
    if hasSun:
        away = np.hypot(elevation - _SUN_ELEVATION, (longitude - np.pi / 2 - _SUN_AZIMUTH) * np.cos(_SUN_ELEVATION))
        image = image + (away < 0.026)[..., None] * np.array([6000.0, 5400.0, 4200.0])
    imageFile.WriteExr(path, dict(zip("RGB", np.moveaxis(image.astype(np.float32), -1, 0))))


def _NewRoom(path: str, leaveOut=()):
    stage = author.NewStage(path)
    plaster = author.AddMaterial(stage, "/Looks/Plaster", diffuseColor=(0.75, 0.72, 0.66), roughness=0.9)
    boards = author.AddMaterial(stage, "/Looks/Boards", diffuseColor=(0.35, 0.22, 0.12), roughness=0.35)
    for name, (size, place, turn) in _WALLS.items():
        author.AddMesh(stage, f"/World/{name}", shapes.Plane(*size), material=boards if name == "Floor" else plaster, doubleSided=True,
                       translate=place, rotate=turn)
    wood = author.AddMaterial(stage, "/Looks/Wood", diffuseColor=(0.5, 0.32, 0.18), roughness=0.5)
    china = author.AddMaterial(stage, "/Looks/China", diffuseColor=(0.7, 0.7, 0.75), roughness=0.15, clearcoat=0.5)
    brass = author.AddMaterial(stage, "/Looks/Brass", diffuseColor=(0.9, 0.7, 0.35), metallic=1.0, roughness=0.25)
    mirror = author.AddMaterial(stage, "/Looks/Mirror", diffuseColor=(0.9, 0.9, 0.9), metallic=1.0, roughness=0.02)
    author.AddMesh(stage, "/World/Table", shapes.Box(1.6, 0.06, 0.9), material=wood, translate=(0.6, 0.75, -0.5))
    for number, (x, z) in enumerate(((-0.1, -0.85), (1.3, -0.85), (-0.1, -0.15), (1.3, -0.15))):
        author.AddMesh(stage, f"/World/Leg{number}", shapes.Box(0.06, 0.72, 0.06), material=wood, translate=(x, 0.36, z))
    author.AddMesh(stage, "/World/Bowl", shapes.Torus(0.18, 0.07), material=china, translate=(0.4, 0.85, -0.5))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.14), material=brass, translate=(1.0, 0.92, -0.55))
    author.AddMesh(stage, "/World/Mirror", shapes.Box(0.03, 1.1, 0.8), material=mirror, translate=(-2.47, 1.5, -0.6))
    for number in range(8):
        color = (0.2 + 0.08 * number, 0.15 + 0.5 * (number % 3 == 1), 0.2 + 0.4 * (number % 3 == 2))
        author.AddMesh(stage, f"/World/Book{number}", shapes.Box(0.05, 0.3 + 0.02 * (number % 4), 0.22), color=color,
                       translate=(-1.9 + 0.06 * number, 0.17, -1.75))
    author.AddCamera(stage, eye=(-2.0, 1.6, 1.8), target=(0.9, 0.9, -0.9), width=36.0, focalLength=20.0)
    return stage


def _UnderSky(path: str, hasSun: bool) -> None:
    stage = _NewRoom(path)
    sky = pathlib.Path(path).with_suffix(".exr")
    _WriteSky(sky, hasSun)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=1.0, textureFile=str(sky))
    stage.GetRootLayer().Save()


def WriteSkyRoom(path: str) -> None:
    _UnderSky(path, hasSun=False)


def WriteSunRoom(path: str) -> None:
    _UnderSky(path, hasSun=True)


def WritePanelRoom(path: str) -> None:
    stage = _NewRoom(path)
    glow = author.AddMaterial(stage, "/Looks/Glow", diffuseColor=(0.0, 0.0, 0.0), emissiveColor=(4.0, 3.6, 3.0))
    author.AddMesh(stage, "/World/Window", shapes.Plane(1.2, 1.6), material=glow, translate=(2.4995, 1.6, 0), rotate=(0, 0, 90))
    author.AddMesh(stage, "/World/Panel", shapes.Plane(2.4, 1.2), material=glow, translate=(-0.6, 2.9995, 0), rotate=(180, 0, 0))
    stage.GetRootLayer().Save()
