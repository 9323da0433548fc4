# SPDX-License-Identifier: Apache-2.0
"""Instances that are hard on streaming: a cloud of them about the camera's axis, that overlap, of all kinds. Deterministic."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from . import author, shapes


def _AddInstancer(stage, path: str, prototypes, count: int, spread, rng) -> None:
    """Places each of the prototypes' prims, which lie below the instancer or are instancers."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(prototype) for prototype in prototypes])
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy((np.arange(count) % len(prototypes)).astype(np.int32)))
    positions = (rng.uniform(-1, 1, (count, 3)) * spread).astype(np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions))
    turns = rng.normal(size=(count, 4))
    turns = (turns / np.linalg.norm(turns, axis=1, keepdims=True)).astype(np.float16)
    instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(turns))
    scales = rng.uniform(0.5, 1.5, (count, 3)).astype(np.float32)
    instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(scales))


def WriteCrowd(path, instances: int = 1200, rings: int = 14, copies: int = 0) -> None:
    """`instances` of opaque and half transparent balls and of groups of both, which an instancer places; a ground, balls that are
    placed by none, and some that shine. With `copies` all of it is a prototype of one more instancer, /World/Sea, which places
    so many, all over each other."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(21)
    world = "/World/Sea/Prototype" if copies else "/World"
    if copies:
        UsdGeom.PointInstancer.Define(stage, "/World/Sea")
        UsdGeom.Xform.Define(stage, world)
    clay = author.AddMaterial(stage, f"{world}/Looks/Clay", diffuseColor=(0.6, 0.5, 0.4), roughness=0.5)
    veil = author.AddMaterial(stage, f"{world}/Looks/Veil", diffuseColor=(0.2, 0.5, 0.7), opacity=0.4)
    glow = author.AddMaterial(stage, f"{world}/Looks/Glow", diffuseColor=(0.1, 0.1, 0.1), emissiveColor=(4.0, 2.4, 0.8))

    def AddBall(prim, radius, look, **more):
        ball = shapes.Sphere(radius, rings, 2 * rings)
        bumps = 1.0 + 0.2 * np.sin(rng.uniform(2, 9, 3) * ball.points / radius).prod(1, keepdims=True)
        author.AddMesh(stage, prim, shapes.Shape(ball.points * bumps, ball.counts, ball.indices), material=look, doubleSided=True, **more)

    crowd = f"{world}/Crowd"
    UsdGeom.PointInstancer.Define(stage, crowd)
    AddBall(f"{crowd}/Clay", 0.09, clay)
    AddBall(f"{crowd}/Veil", 0.12, veil)
    group = f"{crowd}/Group"
    UsdGeom.Xform.Define(stage, group)
    AddBall(f"{group}/Core", 0.06, clay)
    UsdGeom.PointInstancer.Define(stage, f"{group}/Ring")
    AddBall(f"{group}/Ring/Bead", 0.05, veil)
    AddBall(f"{group}/Ring/Stone", 0.05, clay)
    _AddInstancer(stage, f"{group}/Ring", [f"{group}/Ring/Bead", f"{group}/Ring/Stone"], 6, (0.15, 0.15, 0.15), rng)
    _AddInstancer(stage, crowd, [f"{crowd}/Clay", f"{crowd}/Veil", group], instances, (2.2, 1.0, 2.2), rng)
    lamps = f"{world}/Lamps"
    UsdGeom.PointInstancer.Define(stage, lamps)
    AddBall(f"{lamps}/Lamp", 0.07, glow)
    _AddInstancer(stage, lamps, [f"{lamps}/Lamp"], 5, (1.5, 0.8, 1.5), rng)
    for i in range(4):
        AddBall(f"{world}/Ball{i}", 0.3, clay if i % 2 else veil, translate=tuple(rng.uniform(-1, 1, 3)))
    author.AddMesh(stage, f"{world}/Ground", shapes.Plane(9, 9, 20, 20), color=(0.4, 0.4, 0.4), translate=(0, -1.2, 0))
    if copies:
        _AddInstancer(stage, "/World/Sea", [world], copies, (1.0, 0.3, 1.0), rng)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.6)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=2.0, normalize=True)
    author.AddCamera(stage, eye=(0, 0.8, 5.0))
    stage.GetRootLayer().Save()
