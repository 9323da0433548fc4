# SPDX-License-Identifier: Apache-2.0
"""Four pawns that light goes into: skin, veined marble, milk and honey, on a board with a lamp behind them."""

import numpy as np
from pxr import Sdf, UsdShade

from stages import author, materialX, shapes

from . import landscape

_TYPES = Sdf.ValueTypeNames
_STANDARD, _OPEN_PBR = materialX.STANDARD, materialX.OPEN_PBR


def _Pawn(segments: int) -> shapes.Shape:
    """A closed body of revolution, two units high: foot, collar and head by a smooth profile."""
    at = np.linspace(0, 1, 2 * segments)
    height = 2 * at
    foot = 0.56 * np.exp(-((height - 0.16) / 0.3)**4)
    waist = 0.2 + 0.2 * np.clip(1 - height / 1.2, 0, 1)**2
    collar = 0.2 * np.exp(-((height - 1.18) / 0.07)**2)
    body = np.maximum(foot, waist) + collar
    head = np.sqrt(np.clip(0.36**2 - (height - 1.64)**2, 0, None))
    radius = np.where(height < 1.64, np.maximum(body * np.clip((1.6 - height) / 0.2, 0, 1), head), head)
    radius *= np.sqrt(np.clip(height / 0.05, 0, 1))
    radius[[0, -1]] = 0.0
    return shapes.Lathe(radius, height, segments, np.gradient(height), -np.gradient(radius))


def _Marble(stage) -> dict:
    """Veins by a sine of a place that a fractal bends, as in MaterialX's example of marble; a part of the light goes in."""
    root = "/World/Looks/Veins"
    UsdShade.Material.Define(stage, root)
    add = lambda name, identifier, kind, **inputs: materialX.AddNode(stage, f"{root}/{name}", f"ND_{identifier}", kind, **inputs)
    place = add("Place", "position_vector3", _TYPES.Vector3f)
    sum_ = add("Sum", "dotproduct_vector3", _TYPES.Float, in1=place, in2=(1.0, 1.0, 1.0))
    noise = add("Noise", "fractal3d_float", _TYPES.Float, octaves=3,
                position=add("Scaled", "multiply_vector3FA", _TYPES.Vector3f, in1=place, in2=3.0))
    bent = add("Bent", "add_float", _TYPES.Float, in1=add("Ways", "multiply_float", _TYPES.Float, in1=sum_, in2=5.0),
               in2=add("Bends", "multiply_float", _TYPES.Float, in1=noise, in2=3.0))
    wave = add("Wave", "sin_float", _TYPES.Float, **{"in": bent})
    share = add("Share", "power_float", _TYPES.Float, in2=4.0,
                in1=add("Half", "remap_float", _TYPES.Float, inlow=-1.0, inhigh=1.0, outlow=0.0, outhigh=1.0, **{"in": wave}))
    color = add("Color", "mix_color3", _TYPES.Color3f, bg=(0.86, 0.86, 0.82), fg=(0.1, 0.14, 0.22), mix=share)
    return dict(base=1.0, base_color=color, subsurface=0.7, subsurface_color=color, subsurface_radius=(0.2, 0.19, 0.17),
                specular_roughness=0.12)


def _Looks(stage) -> list[tuple[str, dict]]:
    """From the left. Honey is MaterialX's example, at the size of a pawn; milk scatters all colours, and blue the most."""
    return [
        (_OPEN_PBR, dict(subsurface_weight=1.0, subsurface_color=(0.85, 0.55, 0.43), subsurface_radius=0.14, specular_roughness=0.38,
                         subsurface_radius_scale=(1.0, 0.45, 0.25), subsurface_scatter_anisotropy=0.2)),
        (_STANDARD, _Marble(stage)),
        (_OPEN_PBR, dict(transmission_weight=1.0, transmission_color=(0.02, 0.014, 0.008), transmission_depth=0.4, specular_roughness=0.0,
                         transmission_scatter=(3.88, 4.24, 4.8), specular_ior=1.35)),
        (_OPEN_PBR, dict(transmission_weight=1.0, transmission_color=(0.83, 0.4, 0.04), transmission_depth=0.7, specular_roughness=0.0,
                         transmission_scatter=(0.9, 0.9, 0.9), specular_ior=1.504)),
    ]


def Write(folder, size: float = 1.0) -> None:
    stage = landscape.NewStage(folder)
    paper = author.AddMaterial(stage, "/World/Looks/Paper", diffuseColor=(0.1, 0.1, 0.11), roughness=0.7)
    landscape.AddSweep(stage, paper)
    pawn = _Pawn(max(16, int(96 * size)))
    squares = [author.AddMaterial(stage, f"/World/Looks/Square{k}", diffuseColor=color, roughness=0.25)
               for k, color in enumerate(((0.45, 0.36, 0.25), (0.05, 0.03, 0.025)))]
    for row in range(2):
        for column in range(6):
            author.AddMesh(stage, f"/World/Square{row}{column}", shapes.Box(1.3, 0.1, 1.3), material=squares[(row + column) % 2],
                           translate=(1.3 * (column - 2.5), 0.05, 0.65 - 1.3 * row))
    for k, (identifier, inputs) in enumerate(_Looks(stage)):
        look = materialX.AddSurface(stage, f"/World/Looks/Look{k}", identifier, **inputs)
        author.AddMesh(stage, f"/World/Pawn{k}", pawn, material=look, translate=(1.3 * (k - 1.5), 0.102, 0.1 * (-1)**k))
    light = lambda name, place, turn, width, height, intensity, color=(1, 1, 1): author.AddLight(
        stage, f"/World/{name}", "Rect", dict(translate=place, rotate=turn), width=width, height=height, intensity=intensity, color=color)
    light("Behind", (0.8, 4.9, -4.0), (-137, 0, 0), 5.0, 1.6, 28.0, (1.0, 0.9, 0.75))
    light("Window", (-4.5, 4.5, 4), (-40, -45, 0), 2.5, 2.5, 5.0, (0.85, 0.93, 1.0))
    author.AddLight(stage, "/World/Fill", "Dome", intensity=0.12, color=(0.8, 0.9, 1.0))
    author.AddCamera(stage, "/World/Camera", eye=(0.4, 2.5, 8.6), target=(0, 1.05, 0), focalLength=44.0, width=36.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
