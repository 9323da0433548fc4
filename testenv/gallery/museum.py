# SPDX-License-Identifier: Apache-2.0
"""A hall of paintings of 2048 x 2048 texels, each different: a quarter of a gigabyte of images for a pool of a few megabytes."""

import numpy as np

from stages import author, imageFile, shapes, textured

from . import landscape

_WIDTH, _LENGTH, _HEIGHT = 8.0, 23.0, 4.6
_PALETTES = [
    [(18, 32, 47), (38, 70, 83), (42, 157, 143), (233, 196, 106), (231, 111, 81)],
    [(43, 19, 32), (120, 28, 46), (208, 69, 56), (242, 163, 101), (250, 232, 200)],
    [(9, 21, 64), (29, 68, 140), (95, 143, 196), (214, 226, 233), (247, 240, 220)],
    [(28, 28, 30), (86, 82, 78), (168, 152, 132), (222, 208, 186), (190, 60, 40)],
    [(20, 40, 24), (58, 92, 52), (140, 158, 80), (226, 212, 140), (246, 240, 214)],
    [(36, 18, 66), (98, 44, 120), (196, 80, 132), (246, 154, 120), (254, 224, 170)],
]


class _Painter:
    """Paints square pictures of one size from three fields, which every picture shifts and turns."""

    def __init__(self, size: int):
        self.size = size
        self.shapes, self.folds = landscape.Noise(91, size, 2.3), landscape.Noise(92, size, 1.9)
        self.strokes = landscape.Noise(93, size, 0.9)

    def Paint(self, index: int) -> np.ndarray:
        rng = np.random.default_rng([7, index])
        take = lambda field: np.rot90(np.roll(field, tuple(rng.integers(0, self.size, 2)), (0, 1)), rng.integers(0, 4))
        value = take(self.shapes) + 0.55 * np.sin(rng.uniform(1.5, 4) * take(self.folds)) + 0.05 * (strokes := take(self.strokes))
        value = 2 + 1.15 * value + 0.4 * np.tanh(6 * np.sin(3 * value))
        palette = np.array(_PALETTES[index % len(_PALETTES)], float)
        picture = np.stack([np.interp(value, range(5), palette[:, channel]) for channel in range(3)], -1)
        return np.clip(picture * (1 + 0.06 * strokes[..., None]) + 0.5, 0, 255).astype(np.uint8)


def _Planks(size: int) -> np.ndarray:
    """Oak boards along t."""
    v, u = np.meshgrid(np.arange(size) / size, np.arange(size) / size, indexing="ij")
    board = np.floor(u * 16)
    rng = np.random.default_rng(3)
    shift = rng.random(16)[board.astype(int)]
    joint = np.floor(v * 2 + shift)
    tone = rng.random((16, 4))[board.astype(int), joint.astype(int) % 4]
    grain = landscape.Sample(landscape.Noise(94, 512, 1.1), u * 6 + 0.31 * board, v * 0.35 + 0.2 * joint, 1.0)
    gap = (np.minimum(u * 16 % 1, 1 - u * 16 % 1) < 0.012) | (np.minimum((v * 2 + shift) % 1, 1 - (v * 2 + shift) % 1) < 0.0012)
    colour = np.array([150, 104, 62.0]) * (0.72 + 0.34 * tone + 0.06 * grain)[..., None] * np.where(gap, 0.35, 1.0)[..., None]
    return np.clip(colour, 0, 255).astype(np.uint8)


def _Frame(width: float, height: float, border: float = 0.09, depth: float = 0.07) -> shapes.Shape:
    """Four bars around a picture in the xy plane that stands out towards +z."""
    bar = lambda w, h, x, y: shapes.Box(w, h, depth).Moved((x, y, depth / 2))
    return shapes.Merged([bar(width + 2 * border, border, 0, side * (height + border) / 2) for side in (-1, 1)]
                         + [bar(border, height, side * (width + border) / 2, 0) for side in (-1, 1)])


def _Canvas(width: float, height: float) -> shapes.Shape:
    share = min(1.0, width / height), min(1.0, height / width)
    points = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * [width / 2, height / 2, 1] + [0, 0, 0.02]
    st = np.array([(0, 0), (share[0], 0), share, (0, share[1])])
    return shapes.Shape(points, np.array([4]), np.arange(4), np.tile([0, 0, 1.0], (4, 1)), st)


def _Hangings():
    """(width, height, place, turn) of the paintings: both walls, the end."""
    sizes = [(1.9, 2.5), (2.9, 2.0), (1.7, 1.7), (2.3, 2.9), (3.0, 2.1), (1.8, 2.4), (2.2, 2.2)]
    hangings = [(3.6, 2.8, (0, 2.25, -_LENGTH + 0.01), 0)]
    for side in (-1, 1):
        for i in range(7):
            width, height = sizes[(i + (3 if side > 0 else 0)) % 7]
            hangings.append((width, height, (side * (_WIDTH / 2 - 0.01), 2.1, -1.6 - 3.15 * i), -90 * side))
    return hangings


def Write(folder, size: float = 1.0) -> None:
    stage = landscape.NewStage(folder)
    texels = max(64, int(2048 * size))
    painter = _Painter(texels)
    imageFile.WritePng(folder / "planks.png", _Planks(texels), level=1)
    floor = textured.AddTexturedMaterial(stage, "/World/Looks/Floor", dict(diffuseColor=("./planks.png", "rgb")), roughness=0.24)
    plane = shapes.Plane(_WIDTH, _LENGTH)
    plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, plane.texcoords * [_WIDTH / 3, _LENGTH / 3])
    author.AddMesh(stage, "/World/Floor", plane, material=floor, translate=(0, 0, -_LENGTH / 2))
    plaster = author.AddMaterial(stage, "/World/Looks/Plaster", diffuseColor=(0.72, 0.71, 0.69), roughness=0.9)
    box = lambda name, dimensions, place, look=plaster: author.AddMesh(stage, f"/World/{name}", shapes.Box(*dimensions), material=look,
                                                                       translate=place)
    for side in (-1, 1):
        box(f"Wall{side + 1}", (0.3, _HEIGHT, _LENGTH), (side * (_WIDTH / 2 + 0.15), _HEIGHT / 2, -_LENGTH / 2))
        box(f"Ceiling{side + 1}", (_WIDTH / 3, 0.3, _LENGTH), (side * _WIDTH / 3, _HEIGHT + 0.15, -_LENGTH / 2))
    box("End", (_WIDTH, _HEIGHT, 0.3), (0, _HEIGHT / 2, -_LENGTH - 0.15))
    box("Back", (_WIDTH, _HEIGHT, 0.3), (0, _HEIGHT / 2, 3.5))
    gilt = author.AddMaterial(stage, "/World/Looks/Gilt", diffuseColor=(0.75, 0.55, 0.25), metallic=1.0, roughness=0.35)
    ebony = author.AddMaterial(stage, "/World/Looks/Ebony", diffuseColor=(0.02, 0.018, 0.016), roughness=0.3)
    for i, (width, height, place, turn) in enumerate(_Hangings()):
        imageFile.WritePng(folder / f"painting{i}.png", painter.Paint(i), level=1)
        look = textured.AddTexturedMaterial(stage, f"/World/Looks/Painting{i}", dict(diffuseColor=(f"./painting{i}.png", "rgb")),
                                            roughness=0.5)
        hang = dict(translate=place, rotate=(0, turn, 0))
        author.AddMesh(stage, f"/World/Painting{i}", _Canvas(width, height), material=look, **hang)
        author.AddMesh(stage, f"/World/Frame{i}", _Frame(width, height), material=(gilt, ebony)[i % 2], **hang)
    for i, z in enumerate((-6.5, -13.5)):
        box(f"Bench{i}", (0.7, 0.12, 2.4), (0, 0.46, z), ebony)
        for j, end in enumerate((-0.95, 0.95)):
            box(f"Leg{i}{j}", (0.55, 0.4, 0.1), (0, 0.2, z + end), ebony)
    for i in range(4):
        author.AddLight(stage, f"/World/Skylight{i}", "Rect", dict(translate=(0, _HEIGHT + 0.28, -2.9 - 5.75 * i), rotate=(-90, 0, 0)),
                        width=2.4, height=5.0, intensity=4.2, color=(1.0, 0.98, 0.95))
    author.AddCamera(stage, "/World/Camera", eye=(-0.9, 1.75, 2.6), target=(0.25, 1.8, -12), focalLength=24.0, aspect=16 / 9)
    stage.GetRootLayer().Save()
