# SPDX-License-Identifier: Apache-2.0
"""Ten balls of MaterialX surfaces (OpenPBR and Standard Surface) on a dark table below softboxes."""

import numpy as np
from pxr import Sdf, UsdShade

from stages import author, materialX, shapes

from . import landscape

_TYPES = Sdf.ValueTypeNames
_STANDARD, _OPEN_PBR = materialX.STANDARD, materialX.OPEN_PBR


def _ShaderBall() -> list[shapes.Shape]:
    """A shell with a window cut all around, the core that it shows, a foot; each with coordinates."""
    def Turned(profile, segments=160):
        profile = np.asarray(profile, float)
        steps = np.gradient(profile, axis=0)
        shape = shapes.Lathe(np.maximum(profile[:, 0], 1e-4), profile[:, 1], segments, steps[:, 1], -steps[:, 0])
        around = np.arctan2(shape.points[:, 0], shape.points[:, 2]) / (2 * np.pi)
        return shapes.Shape(shape.points, shape.counts, shape.indices, shape.normals,
                            np.stack([abs(2 * around), shape.points[:, 1]], 1))
    angle = np.linspace(-np.pi / 2, np.pi / 2, 96)
    core = np.stack([0.72 * np.cos(angle), 1.05 + 0.72 * np.sin(angle)], 1)
    arc = lambda low, high, radius: np.stack([radius * np.cos(t := np.linspace(low, high, 64)), 1.05 + radius * np.sin(t)], 1)
    lower = np.concatenate([arc(-1.35, -0.2, 1.0), arc(-0.2, -1.35, 0.86)])
    upper = np.concatenate([arc(0.2, np.pi / 2, 1.0), arc(np.pi / 2, 0.2, 0.86)])
    foot = np.array([[0.0, 0.0], [0.62, 0.0], [0.66, 0.02], [0.66, 0.06], [0.62, 0.08], [0.3, 0.1], [0.24, 0.16], [0.0, 0.2]])
    close = lambda loop: np.concatenate([loop, loop[:1]])
    return [Turned(core), Turned(close(lower)), Turned(close(upper)), Turned(foot)]


def _Surfaces(stage) -> list:
    """Inputs and identifiers of ten surfaces, front row first."""
    root = "/World/Looks/Patterns"
    UsdShade.Material.Define(stage, root)
    position = materialX.AddNode(stage, f"{root}/Position", "ND_position_vector3", _TYPES.Vector3f)
    scaled = materialX.AddNode(stage, f"{root}/Scaled", "ND_multiply_vector3FA", _TYPES.Vector3f, in1=position, in2=2.6)
    fractal = materialX.AddNode(stage, f"{root}/Fractal", "ND_fractal3d_float", _TYPES.Float, position=scaled, octaves=6)
    bent = materialX.AddNode(stage, f"{root}/Bent", "ND_absval_float", _TYPES.Float, **{"in": fractal})
    share = materialX.AddNode(stage, f"{root}/Share", "ND_remap_float", _TYPES.Float, inlow=0.0, inhigh=0.22, **{"in": bent})
    clamped = materialX.AddNode(stage, f"{root}/Clamped", "ND_clamp_float", _TYPES.Float, **{"in": share})
    marble = materialX.AddNode(stage, f"{root}/Marble", "ND_mix_color3", fg=(0.012, 0.05, 0.035), bg=(0.8, 0.72, 0.5), mix=clamped)
    st = materialX.AddNode(stage, f"{root}/St", "ND_texcoord_vector2", _TYPES.Float2)
    checks = materialX.AddNode(stage, f"{root}/Checks", "ND_checkerboard_color3", color1=(0.75, 0.66, 0.5), color2=(0.09, 0.012, 0.01),
                               uvtiling=(26.0, 13.0), texcoord=st)
    glass = dict(transmission_weight=1.0, specular_roughness=0.0, specular_ior=1.5)
    return [
        (_OPEN_PBR, dict(base_color=(0.55, 0.004, 0.01), base_metalness=0.6, specular_roughness=0.35, coat_weight=1.0,
                         coat_roughness=0.01)),
        (_OPEN_PBR, dict(glass)),
        (_OPEN_PBR, dict(base_color=(1.0, 0.71, 0.29), base_metalness=1.0, specular_roughness=0.13)),
        (_OPEN_PBR, dict(glass, transmission_color=(0.25, 0.75, 0.55), transmission_depth=0.35, specular_roughness=0.12)),
        (_OPEN_PBR, dict(base_color=marble, specular_roughness=0.25, coat_weight=1.0, coat_roughness=0.0)),
        (_STANDARD, dict(base_color=(0.06, 0.015, 0.12), specular=0.1, sheen=1.0, sheen_color=(0.85, 0.5, 1.0), sheen_roughness=0.3)),
        (_STANDARD, dict(base_color=(0.75, 0.76, 0.78), metalness=1.0, specular_roughness=0.35, specular_anisotropy=0.85)),
        (_OPEN_PBR, dict(base_color=checks, specular_roughness=0.08)),
        (_OPEN_PBR, dict(base_color=(0.95, 0.5, 0.36), base_metalness=1.0, specular_roughness=0.42)),
        (_OPEN_PBR, dict(base_color=(0.03, 0.16, 0.42), base_diffuse_roughness=0.8, specular_roughness=0.5, coat_weight=1.0,
                         coat_color=(0.5, 0.8, 1.0), coat_roughness=0.04)),
    ]


def Write(folder, size: float = 1.0) -> None:
    stage = landscape.NewStage(folder)
    table = author.AddMaterial(stage, "/World/Looks/Table", diffuseColor=(0.055, 0.05, 0.047), roughness=0.22)
    landscape.AddSweep(stage, table)
    rubber = author.AddMaterial(stage, "/World/Looks/Foot", diffuseColor=(0.03, 0.03, 0.03), roughness=0.5)
    grey = author.AddMaterial(stage, "/World/Looks/Core", diffuseColor=(0.5, 0.48, 0.45), roughness=0.6)
    core, lower, upper, foot = _ShaderBall()
    for i, (identifier, inputs) in enumerate(_Surfaces(stage)):
        look = materialX.AddSurface(stage, f"/World/Looks/Surface{i}", identifier, **inputs)
        row, column = divmod(i, 5)
        place = ((2.25 - 0.1 * row) * (column - 2), 0, 1.2 - 2.7 * row)
        name = f"/World/Ball{i}"
        isGlass = "transmission_weight" in inputs
        author.AddMesh(stage, f"{name}Foot", foot, material=rubber, translate=place)
        author.AddMesh(stage, f"{name}Core", core, material=grey if isGlass else look, translate=place, rotate=(0, -20, 0))
        for part, shape in (("Lower", lower), ("Upper", upper)):
            author.AddMesh(stage, name + part, shape, material=look, translate=place, rotate=(0, -20, 0))
    box = lambda name, place, turn, width, height, intensity, colour=(1, 1, 1): author.AddLight(
        stage, f"/World/{name}", "Rect", dict(translate=place, rotate=turn), width=width, height=height, intensity=intensity, color=colour)
    box("Key", (-7, 8, 5), (-45, -52, 0), 5.0, 4.0, 12.0, (1.0, 0.94, 0.86))
    box("Strip", (7.5, 5, 1), (-25, 85, 0), 1.2, 7.0, 16.0, (0.8, 0.9, 1.0))
    box("Back", (0, 7.5, -6), (-50, 180, 0), 12.0, 2.0, 9.0)
    author.AddLight(stage, "/World/Fill", "Dome", intensity=0.12, color=(0.8, 0.9, 1.0))
    author.AddCamera(stage, "/World/Camera", eye=(0.0, 4.9, 12.6), target=(0, 0.85, -0.3), focalLength=41.0, width=36.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
