# SPDX-License-Identifier: Apache-2.0
"""Many small tests in one picture: cards side by side, each with a material of its own.

An orthographic camera looks along -z at cards that are one unit wide and fill the picture's height. A card takes four
pixels, of which the inner ones count. Cards may be tilted about the x axis; they stand in a row along x, so that light
from the y-z plane reaches each of them.
"""

from dataclasses import dataclass

import numpy as np

import ours
from stages import author, shapes

_PIXELS = 4  # of a card's width, and the picture's height


@dataclass
class Card:
    """What a strip knows of a card: its number, and prims to build it with."""

    number: int
    material: object
    mesh: object


class Strip:
    """A stage of cards, added one by one, rendered once."""

    def __init__(self, path):
        self.path, self.cards = str(path), {}
        self.stage = author.NewStage(self.path)
        self.picture = None

    def Add(self, name: str, build=None, st=None, tilt: float = 0.0, **inputs) -> Card:
        """A card with a UsdPreviewSurface of constant `inputs`; `build(card)` does the rest. `st` is the same on all of
        it, by default (0, 0) to (1, 1). `tilt`: degrees from the camera's direction towards +y."""
        number = len(self.cards)
        material = author.AddMaterial(self.stage, f"/World/M{number}", **inputs)
        mesh = self.AddPlate(f"/World/Card{number}", number, material, st=st, tilt=tilt)
        self.cards[name] = card = Card(number, material, mesh)
        if build is not None:
            build(card)
        return card

    def AddPlate(self, path, number, material, st=None, tilt: float = 0.0, depth: float = 0.0):
        """The plate of a card, or one `depth` behind it."""
        plane = shapes.Plane(1, 6)
        if st is not None:
            plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, np.tile(st, (4, 1)))
        return author.AddMesh(self.stage, path, plane, material=material, translate=(number + 0.5, 0, -depth),
                              rotate=(90 - tilt, 0, 0))

    def Render(self, aovs=("color",), **settings) -> "Strip":
        width = len(self.cards)
        author.AddCamera(self.stage, eye=(width / 2, 0, 50), target=(width / 2, 0, 0), width=10.0 * width, aspect=width,
                         orthographic=True)
        self.stage.GetRootLayer().Save()
        self.picture = ours.Render(self.path, _PIXELS * width, _PIXELS, aovs, maxDepth=0, **settings)
        return self

    def Pixels(self, name: str, layer: str = "color") -> np.ndarray:
        """The inner pixels [n][channels] of a card."""
        first = _PIXELS * self.cards[name].number
        pixels = self.picture.layers[layer].astype(np.float64)
        return pixels[1:-1, first + 1 : first + _PIXELS - 1].reshape(4, -1)
