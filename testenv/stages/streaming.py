# SPDX-License-Identifier: Apache-2.0
"""Stages that are hard on geometry streaming: what the benches have (one huge mesh, many small ones, many
instances, a grove), chunks that lie inside each other, deep nesting, textures. Deterministic."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from . import author, bench, grove, shapes, textured


def WriteOverlap(path, meshes: int = 24, rings: int = 32) -> None:
    """Crumpled balls about one centre, so that every ray meets chunks of all of them; every third is half
    transparent, one shines."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(11)
    looks = [author.AddMaterial(stage, "/World/Looks/Clay", diffuseColor=(0.6, 0.5, 0.4), roughness=0.5),
             author.AddMaterial(stage, "/World/Looks/Metal", diffuseColor=(0.7, 0.7, 0.8), metallic=1.0, roughness=0.2),
             author.AddMaterial(stage, "/World/Looks/Veil", diffuseColor=(0.2, 0.5, 0.7), opacity=0.4)]
    glow = author.AddMaterial(stage, "/World/Looks/Glow", diffuseColor=(0.1, 0.1, 0.1), emissiveColor=(2.0, 1.2, 0.4))
    for i in range(meshes):
        ball = shapes.Sphere(1.0, rings, 2 * rings)
        phase = rng.uniform(0, 6, 3)
        swell = 1.0 + 0.25 * np.sin(5 * ball.points + phase).prod(1, keepdims=True) + 0.01 * i
        crumpled = shapes.Shape(ball.points * swell, ball.counts, ball.indices)
        look = glow if i == meshes // 2 else looks[i % 3]
        author.AddMesh(stage, f"/World/Ball{i}", crumpled, material=look, doubleSided=True)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.4, 0.4, 0.4), translate=(0, -1.5, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.5)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(2, 3, 2)), intensity=20.0, radius=0.4)
    author.AddCamera(stage, eye=(0, 0.6, 3.6))
    stage.GetRootLayer().Save()


def WriteNested(path, depth: int = 4, copies: int = 6, rings: int = 48) -> None:
    """Instancers of instancers, `copies` a level, over one crumpled ball: copies^depth instances."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(2)
    prim = "/World"
    for level in range(depth):
        instancer = UsdGeom.PointInstancer.Define(stage, f"{prim}/Level{level}")
        prim = f"{instancer.GetPath()}/Prototype"
        UsdGeom.Xform.Define(stage, prim)
        turn = np.linspace(0, 2 * np.pi, copies, endpoint=False)
        radius = 2.6 * 0.42**level
        positions = np.stack([radius * np.cos(turn), 0.3 * radius * np.sin(3 * turn), radius * np.sin(turn)], 1)
        scales = rng.uniform(0.75, 1.0, (copies, 1)).repeat(3, 1)
        instancer.CreatePrototypesRel().SetTargets([Sdf.Path(prim)])
        instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.zeros(copies, np.int32)))
        instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions.astype(np.float32)))
        instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(scales.astype(np.float32)))
    ball = shapes.Sphere(0.16, rings, 2 * rings)
    bumps = 1.0 + 0.2 * np.sin(60 * ball.points).prod(1, keepdims=True)
    author.AddMesh(stage, f"{prim}/Ball", shapes.Shape(ball.points * bumps, ball.counts, ball.indices), color=(0.7, 0.4, 0.3))
    author.AddMesh(stage, "/World/Ground", shapes.Plane(16, 16, 40, 40), color=(0.4, 0.4, 0.4), translate=(0, -1.2, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.7)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=2.0, normalize=True)
    author.AddCamera(stage, eye=(0, 3.4, 7.0))
    stage.GetRootLayer().Save()


# Small forms, each of hundreds of chunks of 4 KiB.
CASES = {
    "hugeMesh": lambda path: bench.WriteTerrain(path, cells=140),
    "manyMeshes": lambda path: bench.WriteMeshes(path, meshes=1500),
    "manyInstances": lambda path: bench.WriteForest(path, instances=3000, species=5),
    "overlap": WriteOverlap,
    "nested": WriteNested,
    "grove": lambda path: grove.WriteGrove(path, 60_000, 6_000),
    "textured": textured.WriteTextured,
}
