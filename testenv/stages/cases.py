# SPDX-License-Identifier: Apache-2.0
"""The registry of verification cases: a named stage with the settings it is judged at.

A case is registered by decorating its build function; `verify.py` imports every module that does so.
"""

from dataclasses import dataclass
from typing import Callable

from pxr import Usd

from . import author, shapes

CAMERA_PATH = "/World/Camera"


@dataclass(frozen=True)
class Case:
    """One verification stage. `maxDepth` counts bounces after the first hit, as --maxDepth does."""

    name: str
    build: Callable[[Usd.Stage, str], None]  # (stage, folder for side files)
    lambert: bool  # judged at 0.2 %, otherwise at 1 %
    width: int = 120
    height: int = 90
    pixelAspectRatio: float = 1.0  # width / height of a pixel
    maxDepth: int = 4
    samples: int = 128  # of hdStream
    referenceSamples: int = 4096
    passThrough: bool = False  # straight-through opacity: Mitsuba counts those events as bounces

    def Write(self, path) -> str:
        """Writes the stage to `path` (its side files next to it) and returns the path."""
        stage = author.NewStage(path)
        self.build(stage, str(path).rsplit("/", 1)[0])
        stage.GetRootLayer().Save()
        return str(path)


CASES: dict[str, Case] = {}


def AddCase(lambert: bool = False, **settings):
    """Registers a build function under its own name."""

    def Register(build):
        name = build.__name__[0].lower() + build.__name__[1:]
        CASES[name] = Case(name, build, lambert, **settings)
        return build

    return Register


def AddBlocks(stage, camera: bool = True) -> None:
    """The common Lambert set: a ground, a turned box, a dense sphere and a slab, displayColor only."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.6, 0.55, 0.5))
    author.AddMesh(stage, "/World/Box", shapes.Box(1.1, 1.4, 1.0), color=(0.7, 0.25, 0.2),
                   translate=(-1.2, 0.7, -0.2), rotate=(0, 30, 0))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.75, 96, 192), color=(0.2, 0.45, 0.75),
                   translate=(0.5, 0.75, 0.6))
    author.AddMesh(stage, "/World/Slab", shapes.Box(0.3, 2.0, 1.6), color=(0.75, 0.7, 0.3),
                   translate=(1.8, 1.0, -0.6), rotate=(0, -20, 0))
    if camera:
        author.AddCamera(stage, eye=(0, 2.4, 6.0), target=(0.1, 0.55, 0))


def AddStudio(stage, eye=(0, 1.7, 6.2), target=(0, 0.62, 0), key=14.0) -> None:
    """Ground, one large key light, a dim dome and the camera, for rows of material samples."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(14, 14), color=(0.35, 0.35, 0.35))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-2, 5, 3.5), rotate=(-52, -24, 0)),
                    width=3.0, height=2.0, intensity=key)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.35, color=(0.8, 0.9, 1.0))
    author.AddCamera(stage, eye=eye, target=target)


def AddBallRow(stage, materials: list, radius: float = 0.62, spacing: float = 1.4) -> None:
    """One dense ball a material, in a row along x on the ground."""
    ball = shapes.Sphere(radius, 96, 192)
    start = -spacing * (len(materials) - 1) / 2
    for i, material in enumerate(materials):
        author.AddMesh(stage, f"/World/Ball{i}", ball, material=material,
                       translate=(start + spacing * i, radius + 0.02, 0))
