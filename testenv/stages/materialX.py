# SPDX-License-Identifier: Apache-2.0
"""MaterialX networks as UsdShade prims, and a stage with a row of balls for each lobe and for patterns."""

import numpy as np
from pxr import Gf, Sdf, UsdShade

from . import author, shapes

_TYPES = Sdf.ValueTypeNames
STANDARD = "ND_standard_surface_surfaceshader"
OPEN_PBR = "ND_open_pbr_surface_surfaceshader"


def _Author(shader, name: str, value) -> None:
    """An input by the type of its Python value; a pair (shader, output) is connected."""
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[0], UsdShade.Shader):
        source = value[0].GetOutput(value[1])
        shader.CreateInput(name, source.GetTypeName()).ConnectToSource(source)
    elif isinstance(value, bool):
        shader.CreateInput(name, _TYPES.Bool).Set(value)
    elif isinstance(value, int):
        shader.CreateInput(name, _TYPES.Int).Set(value)
    elif isinstance(value, str):
        shader.CreateInput(name, _TYPES.String).Set(value)
    elif isinstance(value, Sdf.AssetPath):
        shader.CreateInput(name, _TYPES.Asset).Set(value)
    elif isinstance(value, Gf.Vec3f):
        shader.CreateInput(name, _TYPES.Vector3f).Set(value)
    elif isinstance(value, tuple):
        kind = {2: _TYPES.Float2, 3: _TYPES.Color3f, 4: _TYPES.Color4f}[len(value)]
        shader.CreateInput(name, kind).Set(tuple(map(float, value)))
    else:
        shader.CreateInput(name, _TYPES.Float).Set(float(value))


def AddNode(stage, path: str, identifier: str, output=_TYPES.Color3f, **inputs):
    """A node and its output "out", as (shader, "out")."""
    shader = UsdShade.Shader.Define(stage, path)
    shader.SetShaderId(identifier)
    shader.CreateOutput("out", output)
    for name, value in inputs.items():
        _Author(shader, name, value)
    return shader, "out"


def AddSurface(stage, path: str, identifier=STANDARD, **inputs) -> UsdShade.Material:
    """A material with a MaterialX surface; the universal context has none."""
    material = UsdShade.Material.Define(stage, path)
    shader, _ = AddNode(stage, f"{path}/Surface", identifier, _TYPES.Token, **inputs)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(shader.GetOutput("out"))
    return material


def _LobeRows() -> list[list[tuple[str, dict]]]:
    red, gold = (0.7, 0.1, 0.08), (0.95, 0.7, 0.35)
    glass = dict(transmission=1.0, base=0.0, specular_roughness=0.02)
    return [
        [(STANDARD, dict(base_color=red, specular_roughness=r)) for r in (0.05, 0.3, 0.7)]
        + [(STANDARD, dict(base_color=red, diffuse_roughness=1.0, specular=0.0))],
        [(STANDARD, dict(base_color=gold, metalness=1.0, specular_roughness=r)) for r in (0.1, 0.4, 0.9)]
        + [(OPEN_PBR, dict(base_color=gold, base_metalness=1.0, specular_color=(0.3, 0.5, 1.0)))],
        [(STANDARD, dict(base_color=gold, metalness=1.0, specular_roughness=0.4, specular_anisotropy=a,
                         specular_rotation=t)) for a, t in ((0.5, 0.0), (0.9, 0.0), (0.9, 0.25))]
        + [(OPEN_PBR, dict(base_color=gold, base_metalness=1.0, specular_roughness_anisotropy=0.9))],
        [(STANDARD, dict(base_color=red, specular_roughness=0.6, coat=c, coat_color=tint, coat_roughness=r))
         for c, tint, r in ((1.0, (1, 1, 1), 0.02), (1.0, (1, 1, 1), 0.4), (1.0, (0.3, 0.6, 1.0), 0.02))]
        + [(OPEN_PBR, dict(base_color=red, coat_weight=1.0))],
        [(STANDARD, dict(base_color=(0.08, 0.03, 0.1), specular=0.2, sheen=1.0, sheen_color=(0.9, 0.6, 1.0),
                         sheen_roughness=r)) for r in (0.15, 0.4, 0.9)]
        + [(OPEN_PBR, dict(base_color=(0.08, 0.03, 0.1), fuzz_weight=1.0))],
        [(STANDARD, dict(glass)), (STANDARD, dict(glass, specular_roughness=0.3)),
         (STANDARD, dict(glass, transmission_color=(0.3, 0.8, 0.5), transmission_depth=0.6)),
         (STANDARD, dict(glass, thin_walled=True, transmission_color=(1.0, 0.7, 0.3)))],
    ]


def _AddPatterns(stage, root: str) -> list[dict]:
    """Inputs of surfaces whose colours are computed."""
    st = AddNode(stage, f"{root}/St", "ND_texcoord_vector2", _TYPES.Float2)
    placed = AddNode(stage, f"{root}/Place", "ND_place2d_vector2", _TYPES.Float2, texcoord=st, scale=(0.5, 1.0), rotate=30.0)
    checks = AddNode(stage, f"{root}/Checks", "ND_checkerboard_color3", color1=(0.9, 0.8, 0.6), color2=(0.1, 0.15, 0.3),
                     uvtiling=(16.0, 8.0), texcoord=placed)
    fractal = AddNode(stage, f"{root}/Fractal", "ND_fractal3d_float", _TYPES.Float,
                      position=AddNode(stage, f"{root}/Scaled", "ND_multiply_vector3FA", _TYPES.Vector3f,
                                       in1=AddNode(stage, f"{root}/Position", "ND_position_vector3", _TYPES.Vector3f),
                                       in2=6.0))
    share = AddNode(stage, f"{root}/Share", "ND_remap_float", _TYPES.Float, inlow=-0.6, inhigh=0.6, **{"in": fractal})
    veins = AddNode(stage, f"{root}/Veins", "ND_mix_color3", fg=(0.95, 0.93, 0.9), bg=(0.15, 0.2, 0.18), mix=share)
    ramp = AddNode(stage, f"{root}/Ramp", "ND_ramp4_color3", valuetl=(1, 0, 0), valuetr=(0, 1, 0), valuebl=(0, 0, 1),
                   valuebr=(1, 1, 0))
    cells = AddNode(stage, f"{root}/Cells", "ND_cellnoise2d_float", _TYPES.Float,
                    texcoord=AddNode(stage, f"{root}/Tiles", "ND_multiply_vector2", _TYPES.Float2, in1=st, in2=(24.0, 12.0)))
    hue = AddNode(stage, f"{root}/Hue", "ND_combine3_color3", in1=cells, in2=0.7, in3=0.8)
    colors = AddNode(stage, f"{root}/Colors", "ND_hsvtorgb_color3", **{"in": hue})
    return [dict(base_color=checks), dict(base_color=veins, coat=1.0), dict(base_color=ramp),
            dict(base_color=colors, specular_roughness=cells)]


def Ball(radius: float) -> shapes.Shape:
    """A sphere with coordinates: s once around from a seam, t from pole to pole."""
    rings, segments = 48, 96
    t, s = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, rings + 1), np.linspace(0, 1, segments + 1),
                                                 indexing="ij"))
    sine = np.sin(np.pi * t)
    normals = np.stack([sine * np.sin(2 * np.pi * s), -np.cos(np.pi * t), sine * np.cos(2 * np.pi * s)], -1)
    corner = (np.arange(rings)[:, None] * (segments + 1) + np.arange(segments)).ravel()
    faces = np.stack([corner, corner + 1, corner + segments + 2, corner + segments + 1], -1)
    return shapes.Shape(radius * normals, np.full(len(faces), 4), faces.ravel(), normals, np.stack([s, t], -1))


def WriteMaterialBalls(path: str) -> None:
    """Seven rows of four balls, from the front: base, metal, anisotropy, coat, sheen, transmission, patterns."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(30, 30), color=(0.3, 0.3, 0.3))
    rows = [[AddSurface(stage, f"/World/Looks/R{r}C{c}", identifier, **inputs)
             for c, (identifier, inputs) in enumerate(row)] for r, row in enumerate(_LobeRows())]
    UsdShade.Material.Define(stage, "/World/Looks/Patterns")
    rows.append([AddSurface(stage, f"/World/Looks/Patterns/P{c}", **inputs)
                 for c, inputs in enumerate(_AddPatterns(stage, "/World/Looks/Patterns"))])
    for r, row in enumerate(rows):
        for c, material in enumerate(row):
            author.AddMesh(stage, f"/World/Ball{r}{c}", Ball(0.45), material=material,
                           translate=(1.15 * (c - 1.5), 0.45, 3.0 - 1.15 * r), rotate=(0, 200, 0))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-3, 6, 4), rotate=(-52, -30, 0)),
                    width=3.0, height=3.0, intensity=16.0)
    author.AddLight(stage, "/World/Rim", "Sphere", dict(translate=(4, 3, -6)), radius=0.6, intensity=40.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.35)
    author.AddCamera(stage, eye=(0, 6.4, 7.6), target=(0, 0.2, -0.5), aspect=1.0, width=30.0)
    stage.GetRootLayer().Save()
