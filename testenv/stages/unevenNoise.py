# SPDX-License-Identifier: Apache-2.0
"""Stages whose pixels differ widely in noise, to judge adaptive sampling: easy and hard regions side by side, nearly dark ones,
rare bright paths. Deterministic."""

from . import author, shapes


def WriteWindow(path) -> None:
    """A bright sky fills half of the view; the other half is a room that is lit through a slit only."""
    stage = author.NewStage(path)
    wall = dict(color=(0.75, 0.72, 0.68))
    for name, size, place in (("Floor", (4, 0.1, 6), (2.1, -1.2, 0)), ("Ceiling", (4, 0.1, 6), (2.1, 1.8, 0)),
                              ("Back", (4, 3, 0.1), (2.1, 0.3, -3)), ("Right", (0.1, 3, 6), (4.1, 0.3, 0)),
                              ("LeftLow", (0.1, 1.6, 6), (0.1, -0.4, 0)), ("LeftHigh", (0.1, 1.1, 6), (0.1, 1.25, 0)),
                              ("Front", (4, 3, 0.1), (2.1, 0.3, 6.0))):
        author.AddMesh(stage, f"/World/{name}", shapes.Box(*size), **wall, translate=place)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.6, 48, 96), color=(0.3, 0.5, 0.7), translate=(2.3, -0.55, -1.4))
    author.AddMesh(stage, "/World/Meadow", shapes.Plane(60, 60), color=(0.4, 0.5, 0.3), translate=(0, -1.3, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0, color=(0.8, 0.9, 1.0))
    author.AddCamera(stage, eye=(0.12, 0.3, 5.5), target=(0.12, 0.2, 0), focalLength=24.0, aspect=16 / 9)
    stage.GetRootLayer().Save()


def WriteNight(path) -> None:
    """Three small lamps behind boards over a wide plate: bright pools, and dark between them that is lit by what bounces."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(0.5, 0.5, 0.5), translate=(0, -1, 0))
    for i, x in enumerate((-3.0, 0.0, 3.0)):
        author.AddMesh(stage, f"/World/Shade{i}", shapes.Box(1.0, 0.05, 1.0), color=(0.1, 0.1, 0.1), translate=(x, 1.5, -2))
        author.AddLight(stage, f"/World/Lamp{i}", "Rect", dict(translate=(x, 1.4, -2), rotate=(-90, 0, 0)), width=0.3, height=0.3,
                        intensity=200.0)
        author.AddMesh(stage, f"/World/Front{i}", shapes.Box(1.0, 0.4, 0.05), color=(0.1, 0.1, 0.1), translate=(x, 1.3, -1.5))
        author.AddMesh(stage, f"/World/Ball{i}", shapes.Sphere(0.4, 48, 96), color=(0.7, 0.5, 0.3), translate=(x + 0.9, -0.6, -1.2))
    author.AddMesh(stage, "/World/Wall", shapes.Box(20, 6, 0.2), color=(0.6, 0.6, 0.65), translate=(0, 1, -6))
    author.AddCamera(stage, eye=(0, 0.6, 5.5), target=(0, 0.1, -2), focalLength=28.0, aspect=16 / 9)
    stage.GetRootLayer().Save()


def WriteFireflies(path) -> None:
    """A small glowing ball whose glints on metal light the floor: paths that are found rarely and are bright; a plain wall behind."""
    stage = author.NewStage(path)
    metal = author.AddMaterial(stage, "/World/Looks/Metal", diffuseColor=(0.9, 0.85, 0.7), metallic=1.0, roughness=0.08)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.5, 0.5, 0.5), translate=(0, -1, 0))
    author.AddMesh(stage, "/World/Wall", shapes.Box(12, 6, 0.2), color=(0.5, 0.55, 0.6), translate=(0, 2, -4))
    author.AddMesh(stage, "/World/Ring", shapes.Torus(1.1, 0.35, 96, 48), material=metal, translate=(-0.4, -0.6, 0))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1.6, 1.6, 1.2)), radius=0.08, intensity=600.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.15)
    author.AddCamera(stage, eye=(0, 1.2, 5.0), target=(0, -0.3, 0), aspect=16 / 9)
    stage.GetRootLayer().Save()


STAGES = {"window": WriteWindow, "night": WriteNight, "fireflies": WriteFireflies}
