# SPDX-License-Identifier: Apache-2.0
"""A stage that shows media and subsurface scattering: rings and balls between a lamp behind them and a window in front."""

from . import author, shapes
from .materialX import OPEN_PBR, STANDARD, AddSurface, Ball

_FOG = dict(base=0.0, transmission=1.0, specular_roughness=0.0)


def _Looks() -> list[tuple[str, str, dict]]:
    """(shape, identifier, inputs), from the left: diffuse, wax, skin, marble; milk, honey, fog with a lamp in it."""
    red = (0.8, 0.25, 0.12)
    return [
        ("ring", STANDARD, dict(base_color=red, specular_roughness=0.35)),
        ("ring", STANDARD, dict(subsurface=1.0, subsurface_color=red, subsurface_radius=(0.25, 0.12, 0.08), specular_roughness=0.35)),
        ("ring", OPEN_PBR, dict(subsurface_weight=1.0, subsurface_color=(0.85, 0.6, 0.5), subsurface_radius=0.12,
                                subsurface_scatter_anisotropy=0.3, specular_roughness=0.4)),
        ("ring", OPEN_PBR, dict(subsurface_weight=1.0, subsurface_color=(0.85, 0.9, 0.88), subsurface_radius=0.3,
                                subsurface_radius_scale=(0.9, 1.0, 1.0), coat_weight=1.0)),
        ("ball", STANDARD, dict(_FOG, transmission_color=(0.02, 0.015, 0.01), transmission_depth=0.25, transmission_scatter=(3.905, 4.19, 4.58))),
        ("ball", STANDARD, dict(_FOG, transmission_color=(0.85, 0.45, 0.06), transmission_depth=0.35, transmission_scatter=(0.12, 0.2, 0.3),
                                transmission_scatter_anisotropy=0.6)),
        ("ball", STANDARD, dict(_FOG, specular_IOR=1.0, transmission_color=(0.5, 0.5, 0.5), transmission_depth=0.35,
                                transmission_scatter=(0.66, 0.68, 0.69))),
    ]


def WriteMedia(path: str) -> None:
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(30, 30), color=(0.25, 0.25, 0.25))
    for k, (shape, identifier, inputs) in enumerate(_Looks()):
        material = AddSurface(stage, f"/World/Looks/L{k}", identifier, **inputs)
        isRing = shape == "ring"
        place = (1.15 * (k - 1.5), 0.46, 0.0) if isRing else (1.2 * (k - 5), 0.42, 1.1)
        author.AddMesh(stage, f"/World/Shape{k}", shapes.Torus(0.32, 0.14) if isRing else Ball(0.42), material=material,
                       translate=place, rotate=(75, 0, 0) if isRing else (0, 0, 0))
        if k == len(_Looks()) - 1:
            author.AddLight(stage, "/World/Spark", "Sphere", dict(translate=place), radius=0.03, intensity=60.0, color=(1.0, 0.8, 0.5))
    author.AddLight(stage, "/World/Rim", "Rect", dict(translate=(0.5, 2.2, -3.2), rotate=(-148, 0, 0)), width=3.0, height=1.0, intensity=22.0)
    author.AddLight(stage, "/World/Window", "Rect", dict(translate=(-3, 4, 4), rotate=(-40, -35, 0)), width=2.0, height=2.0, intensity=5.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.12)
    author.AddCamera(stage, eye=(0, 2.4, 6.2), target=(0, 0.42, 0.3), aspect=2.0, width=27.0)
    stage.GetRootLayer().Save()
