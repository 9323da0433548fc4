# SPDX-License-Identifier: Apache-2.0
"""A flower of glazed beads seen through a wide aperture, lamps far behind it."""

import numpy as np

from stages import author, shapes

from . import landscape

_GOLDEN = np.pi * (3 - np.sqrt(5))


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(6)
    stage = landscape.NewStage(folder)
    count = max(60, int(2600 * size))
    k = np.arange(count) + 0.5
    radius, turn = 2.6 * np.sqrt(k / count), _GOLDEN * k
    height = 0.95 * np.cos(radius / 2.6 * np.pi * 0.5) ** 0.8 - 0.42 * np.exp(-((radius / 0.55) ** 2))
    beads = 1.15 * 2.6 / np.sqrt(count) * (0.55 + 0.45 * radius / 2.6) * np.sqrt(np.pi) / 2
    places = np.stack([radius * np.cos(turn), height, radius * np.sin(turn)], 1)
    glaze = lambda name, colour: author.AddMaterial(stage, f"/World/Looks/{name}", diffuseColor=colour, roughness=0.35, clearcoat=1.0,
                                                    clearcoatRoughness=0.03)
    looks = [glaze("Cream", (0.85, 0.72, 0.48)), glaze("Amber", (0.8, 0.3, 0.02)), glaze("Coral", (0.75, 0.09, 0.03)),
             glaze("Plum", (0.26, 0.015, 0.07)), glaze("Night", (0.012, 0.02, 0.09)),
             author.AddMaterial(stage, "/World/Looks/Gold", diffuseColor=(1.0, 0.72, 0.32), metallic=1.0, roughness=0.15)]
    targets = []
    for i, look in enumerate(looks):
        targets.append(f"/World/Flower/Bead{i}")
        author.AddMesh(stage, targets[-1], shapes.Sphere(1.0, 24, 48), material=look)
    kinds = np.clip(np.floor(radius / 2.6 * 4.7 + rng.normal(0, 0.25, count)), 0, 4)
    kinds[rng.random(count) < 0.07] = 5
    landscape.AddInstances(stage, "/World/Flower", targets, kinds, places, beads)
    base = author.AddMaterial(stage, "/World/Looks/Base", diffuseColor=(0.02, 0.015, 0.02), roughness=0.4)
    author.AddMesh(stage, "/World/Base", shapes.Sphere(1.0, 32, 64), material=base, translate=(0, -0.25, 0), scale=(2.7, 0.9, 2.7))
    author.AddMesh(stage, "/World/Table", shapes.Plane(80, 80), material=base, translate=(0, -0.45, 0))
    lamps = max(10, int(130 * size))
    x, y, z = rng.uniform(-17, 17, lamps), rng.uniform(-0.2, 9, lamps), rng.uniform(-24, -9, lamps)
    tints = np.array([(1.0, 0.6, 0.25), (1.0, 0.8, 0.55), (0.45, 0.65, 1.0), (1.0, 0.35, 0.4)])
    for i in range(lamps):
        author.AddLight(stage, f"/World/Lamps/Lamp{i}", "Sphere", dict(translate=(x[i], y[i], z[i])), radius=0.06,
                        intensity=float(rng.uniform(50, 160)), color=tints[rng.integers(0, 4)])
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-4, 5, 3), rotate=(-50, -50, 0)), width=3.0, height=2.0, intensity=17.0,
                    color=(1.0, 0.95, 0.9))
    author.AddLight(stage, "/World/Rim", "Rect", dict(translate=(4, 3, -4), rotate=(-30, 135, 0)), width=2.0, height=3.0, intensity=14.0,
                    color=(0.6, 0.8, 1.0))
    author.AddLight(stage, "/World/Fill", "Dome", intensity=0.03, color=(0.5, 0.6, 1.0))
    camera = author.AddCamera(stage, "/World/Camera", eye=(0.5, 2.75, 5.0), target=(0.05, 0.85, 0), focalLength=50.0, aspect=16 / 9)
    camera.CreateFStopAttr(25.0)  # lens radius 0.1 units: a tenth of 50 / (2 * 25)
    camera.CreateFocusDistanceAttr(4.2)
    stage.GetRootLayer().Save()
