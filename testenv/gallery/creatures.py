# SPDX-License-Identifier: Apache-2.0
"""Three creatures of nothing but fur and eyes, on a sweep of paper: hairs as B-splines that curl, clump and hang."""

import numpy as np

from stages import author, curves, shapes

from . import landscape


def _Directions(count: int) -> np.ndarray:
    """Points of a sphere, evenly spread."""
    k = np.arange(count) + 0.5
    y, turn = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - y * y)
    return np.stack([radius * np.cos(turn), y, radius * np.sin(turn)], 1)


def _Fur(rng, count: int, length: float, eyes, colours):
    """(points [count][8][3], widths [count][8], colours) on a ball of radius 1; short around the eyes."""
    roots = _Directions(count) + rng.normal(0, 0.004, (count, 3))
    roots /= np.linalg.norm(roots, axis=1, keepdims=True)
    clumps = _Directions(max(8, count // 60))
    nearest = np.zeros(count, int)
    for start in range(0, count, 4096):
        nearest[start:start + 4096] = (roots[start:start + 4096] @ clumps.T).argmax(1)
    lean = clumps[nearest] + 0.25 * rng.normal(size=(len(clumps), 3))[nearest]
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    along = np.linspace(0, 1, 8)[None, :, None]
    towardsEye = np.max([roots @ (eye / np.linalg.norm(eye)) for eye in eyes], axis=0)
    short = landscape.Smooth(0.99, 0.86, towardsEye) * 0.9 + 0.1
    reach = (length * short * rng.uniform(0.65, 1.1, count))[:, None, None]
    direction = roots[:, None] + along * (lean - roots)[:, None] * 1.5 + along * [0, -0.55, 0] * (0.4 + reach)
    wave = 0.05 * along**1.5 * reach * np.sin(11 * along + rng.uniform(0, 6, (len(clumps), 1, 1))[nearest])
    points = roots[:, None] * 0.97 + direction * along * reach + wave * np.cross(roots, lean + [0.01, 0.02, 0.03])[:, None]
    widths = 0.0075 * (1 - 0.85 * along[..., 0]) * rng.uniform(0.7, 1.2, (count, 1))
    dark, light = np.array(colours[0]), np.array(colours[1])
    stripes = landscape.Smooth(-0.35, 0.35, np.sin(7 * roots[:, 1] + 1.6 * np.sin(3 * np.arctan2(roots[:, 0], roots[:, 2]))))
    share = np.clip(stripes[:, None, None] * 0.8 + 0.35 * along + rng.normal(0, 0.08, (count, 1, 1)), 0, 1)
    return points, widths, dark + (light - dark) * share


def _AddCreature(stage, rng, path: str, radius: float, place, turn: float, count: int, length: float, colours) -> None:
    eyes = [np.array([side * 0.36, 0.26, 0.9]) for side in (-1, 1)]
    points, widths, shades = _Fur(rng, count, length, eyes, colours)
    look = dict(translate=place, rotate=(0, turn, 0), scale=radius)
    skin = author.AddMaterial(stage, f"/World/Looks/{path}Skin", diffuseColor=tuple(0.5 * np.array(colours[0])), roughness=0.9)
    author.AddMesh(stage, f"/World/{path}Body", shapes.Sphere(0.985, 32, 64), material=skin, **look)
    curves.AddCurves(stage, f"/World/{path}Fur", list(points), widths.reshape(-1), wrap="pinned", color=shades.reshape(-1, 3), **look)
    white = author.AddMaterial(stage, f"/World/Looks/{path}Eye", diffuseColor=(0.85, 0.83, 0.78), roughness=0.12, clearcoat=1.0,
                               clearcoatRoughness=0.02)
    black = author.AddMaterial(stage, f"/World/Looks/{path}Pupil", diffuseColor=(0.01, 0.008, 0.006), roughness=0.05, clearcoat=1.0,
                               clearcoatRoughness=0.01)
    turned = np.radians(turn)
    for i, eye in enumerate(eyes):
        world = lambda p: np.array(place) + radius * np.array([p[0] * np.cos(turned) + p[2] * np.sin(turned), p[1],
                                                              p[2] * np.cos(turned) - p[0] * np.sin(turned)])
        author.AddMesh(stage, f"/World/{path}Eye{i}", shapes.Sphere(0.21, 32, 64), material=white, translate=world(eye), scale=radius)
        gaze = eye + 0.1 * np.array([0.1, 0.15, 1.0]) / 1.02
        author.AddMesh(stage, f"/World/{path}Pupil{i}", shapes.Sphere(0.135, 32, 64), material=black, translate=world(gaze), scale=radius)


def Write(folder, size: float = 1.0) -> None:
    rng = np.random.default_rng(21)
    stage = landscape.NewStage(folder)
    paper = author.AddMaterial(stage, "/World/Looks/Paper", diffuseColor=(0.34, 0.44, 0.46), roughness=0.8)
    landscape.AddSweep(stage, paper)
    hairs = lambda count: max(500, int(count * size))
    _AddCreature(stage, rng, "Fox", 1.35, (-0.2, 1.75, 0.0), -4.0, hairs(220_000), 0.42, ((0.16, 0.035, 0.008), (0.85, 0.36, 0.08)))
    _AddCreature(stage, rng, "Mint", 0.8, (2.45, 1.0, 0.9), -24.0, hairs(130_000), 0.34, ((0.02, 0.12, 0.14), (0.25, 0.7, 0.62)))
    _AddCreature(stage, rng, "Snow", 0.62, (-2.25, 0.78, 1.35), 22.0, hairs(100_000), 0.5, ((0.5, 0.42, 0.36), (0.92, 0.88, 0.82)))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-6, 8, 6), rotate=(-45, -45, 0)), width=5.0, height=5.0,
                    intensity=11.0, color=(1.0, 0.93, 0.85))
    author.AddLight(stage, "/World/Rim", "Rect", dict(translate=(6, 6, -4), rotate=(-35, 125, 0)), width=3.0, height=5.0,
                    intensity=22.0, color=(0.75, 0.88, 1.0))
    author.AddLight(stage, "/World/Fill", "Dome", intensity=0.35, color=(0.85, 0.93, 1.0))
    camera = author.AddCamera(stage, "/World/Camera", eye=(0.1, 2.4, 12.4), target=(0.1, 1.6, 0), focalLength=50.0, width=32.0,
                              aspect=16 / 9)
    camera.CreateFStopAttr(22.0)
    camera.CreateFocusDistanceAttr(11.2)
    stage.GetRootLayer().Save()
