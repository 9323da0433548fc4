# SPDX-License-Identifier: Apache-2.0
"""A stage to see and measure shadows of glass by: a lamp behind a pane, a ball, a block of tinted glass and a bowl on a floor."""

from . import author, shapes
from .materialX import AddSurface, Ball

_CLEAR = dict(base=0.0, transmission=1.0, specular_roughness=0.0)


def WriteGlass(path: str) -> None:
    stage = author.NewStage(path)
    clear = AddSurface(stage, "/World/Looks/Clear", **_CLEAR)
    tinted = AddSurface(stage, "/World/Looks/Tinted", **dict(_CLEAR, transmission_color=(0.2, 0.7, 0.5), transmission_depth=0.4))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(12, 12), color=(0.6, 0.6, 0.6))
    author.AddMesh(stage, "/World/Wall", shapes.Plane(12, 6), color=(0.5, 0.45, 0.4), rotate=(90, 0, 0), translate=(0, 2, -2.5))
    author.AddMesh(stage, "/World/Pane", shapes.Box(1.4, 1.4, 0.05), material=clear, rotate=(0, 35, 0), translate=(-1.5, 0.75, 0))
    author.AddMesh(stage, "/World/Ball", Ball(0.5), material=clear, translate=(0.2, 0.5, 0.4))
    author.AddMesh(stage, "/World/Block", shapes.Box(0.6, 0.9, 0.6), material=tinted, rotate=(0, 25, 0), translate=(1.6, 0.46, 0.1))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(-3.5, 2.5, -1.0)), radius=0.08, intensity=900.0, color=(1.0, 0.9, 0.75))
    author.AddLight(stage, "/World/Window", "Rect", dict(translate=(3, 3.5, -1.5), rotate=(-60, 50, 0)), width=1.5, height=1.5, intensity=12.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.05)
    author.AddCamera(stage, eye=(0.3, 2.2, 6.5), target=(0, 0.5, 0), aspect=16 / 9, width=26.0)
    stage.GetRootLayer().Save()
