# SPDX-License-Identifier: Apache-2.0
"""Cages of Catmull-Clark surfaces with curved, glossy limits, on which a level that is too low is seen. Deterministic."""

import numpy as np
from pxr import Sdf, UsdGeom

from . import author, materialX, shapes


def _AddCage(stage, path: str, shape: shapes.Shape, **look) -> None:
    cage = shapes.Shape(shape.points, shape.counts, shape.indices)
    author.AddMesh(stage, path, cage, **look).GetSubdivisionSchemeAttr().Set(UsdGeom.Tokens.catmullClark)


def WriteSubdivided(path, copies: int = 3) -> None:
    """`copies` rows of a coarse ring, a cube and a crumpled ball over a ground."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(17)
    clay = author.AddMaterial(stage, "/World/Looks/Clay", diffuseColor=(0.6, 0.35, 0.25), roughness=0.4)
    metal = author.AddMaterial(stage, "/World/Looks/Metal", diffuseColor=(0.8, 0.75, 0.6), metallic=1.0, roughness=0.25)
    ball = shapes.Sphere(0.7, 10, 20)
    ball = shapes.Shape(ball.points * (1 + 0.25 * np.sin(5 * ball.points + 1).prod(1, keepdims=True)), ball.counts, ball.indices)
    for row in range(copies):
        cages = ((shapes.Torus(0.6, 0.25, 10, 6), clay), (shapes.Box(1.1, 1.1, 1.1), metal), (ball, clay))
        for column, (shape, look) in enumerate(cages):
            _AddCage(stage, f"/World/Row{row}/Cage{column}", shape, material=look, rotate=tuple(rng.uniform(0, 90, 3)),
                     translate=(1.7 * (column - 1), 0.8, -1.9 * row))
    author.AddMesh(stage, "/World/Ground", shapes.Plane(16, 16), color=(0.45, 0.45, 0.45))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2, 5, 3), rotate=(-55, -25, 0)), width=3.0, height=2.0,
                    intensity=10.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    author.AddCamera(stage, eye=(0, 2.4, 5.2), target=(0, 0.6, -1.2), aspect=16 / 9)
    stage.GetRootLayer().Save()


def WriteDisplacedBall(path) -> None:
    """A coarse ball that a graph displaces: fractal noise of the position in object space."""
    stage = author.NewStage(path)
    look, types = "/World/Looks/Rock", Sdf.ValueTypeNames
    material = materialX.AddSurface(stage, look, base_color=(0.5, 0.4, 0.3), specular_roughness=0.4)
    at = materialX.AddNode(stage, f"{look}/Place", "ND_position_vector3", types.Vector3f)
    scaled = materialX.AddNode(stage, f"{look}/Scaled", "ND_multiply_vector3FA", types.Vector3f, in1=at, in2=2.5)
    noise = materialX.AddNode(stage, f"{look}/Noise", "ND_fractal3d_float", types.Float, position=scaled, octaves=4, amplitude=1.0)
    moved, _ = materialX.AddNode(stage, f"{look}/Displacement", "ND_displacement_float", types.Token, displacement=noise, scale=0.2)
    material.CreateDisplacementOutput("mtlx").ConnectToSource(moved.GetOutput("out"))
    _AddCage(stage, "/World/Ball", shapes.Sphere(1.0, 8, 16), material=material)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2, 4, 3), rotate=(-50, -30, 0)), width=2.0, height=2.0,
                    intensity=15.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 0.8, 3.4), target=(0, 0, 0), aspect=1.0)
    stage.GetRootLayer().Save()
