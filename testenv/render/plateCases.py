# SPDX-License-Identifier: Apache-2.0
"""A Lambert plate seen from above by an orthographic camera under one light, with its irradiance.

The closed-form oracle of every light type, used on hdStream and on the Mitsuba harness alike: a pixel's
radiance is albedo * E / pi averaged over the pixel (3 x 3 points, smooth integrands).
"""

from dataclasses import dataclass, field

import numpy as np

import closedForm
from stageReader import ReadStage
from stages import author, imageFile, lightCases, shapes

WIDTH, HEIGHT = 48, 36
_SIZE = 4.0  # width of the picture in units
_UP = np.array([0.0, 1.0, 0.0])
ALBEDO = 0.5


@dataclass(frozen=True)
class Plate:
    """A light by type, placement and inputs."""

    kind: str
    placement: dict
    inputs: dict = field(default_factory=dict)


PLATES = {
    "sphere": Plate("Sphere", dict(translate=(0.5, 3.0, 0.3)), dict(radius=0.6, intensity=3.0)),
    "sphereSmall": Plate("Sphere", dict(translate=(-0.5, 2.0, 0.3)), dict(radius=0.05, intensity=360.0)),
    "rect": Plate("Rect", dict(translate=(0.8, 2.2, -0.5), rotate=(-70, 25, 10)), dict(width=1.4, height=0.7, intensity=6.0)),
    "rectNear": Plate("Rect", dict(translate=(0.1, 0.35, 0.0), rotate=(-90, 0, 0)), dict(width=1.5, height=1.0, intensity=1.0)),
    "rectScaled": Plate("Rect", dict(translate=(0, 2.5, 0), rotate=(-80, 10, 0), scale=(2.0, 0.5, 3.0)),
                        dict(width=1.0, height=1.0, intensity=4.0, normalize=True)),
    "disk": Plate("Disk", dict(translate=(-0.6, 1.8, 0.4), rotate=(-75, -20, 0)), dict(radius=0.7, intensity=5.0)),
    "cylinder": Plate("Cylinder", dict(translate=(0, 1.6, 0), rotate=(0, 35, 12)), dict(radius=0.15, length=2.5, intensity=5.0)),
    "distant": Plate("Distant", dict(rotate=(-60, 20, 0)), dict(angle=0.0, intensity=2.0)),
    "distantSimd8": Plate("Distant", dict(rotate=(-60, -40, 0)), dict(angle=40.0, intensity=8.0)),
    "distantSun": Plate("Distant", dict(rotate=(-50, 10, 0)), dict(angle=0.53, intensity=2.0, normalize=True)),
    "dome": Plate("Dome", dict(), dict(intensity=0.7, color=(1.0, 0.5, 0.25))),
    "domeImage": Plate("Dome", dict(), dict(textureFile="./sky.exr", intensity=1.5)),
    "warm": Plate("Sphere", dict(translate=(0, 3.0, 0)),
                  dict(radius=0.5, intensity=1.0, exposure=2.0, enableColorTemperature=True, colorTemperature=3000.0)),
}


def WritePlate(name: str, folder: str) -> str:
    """Writes the plate's stage; returns its path."""
    plate = PLATES[name]
    stage = author.NewStage(f"{folder}/{name}.usda")
    author.AddMesh(stage, "/World/Plate", shapes.Plane(40, 40), color=(ALBEDO,) * 3)
    author.AddCamera(stage, eye=(0, 0.2, 0), target=(0, 0, 0), up=(0, 0, -1), width=_SIZE * 10,
                     orthographic=True)
    if plate.inputs.get("textureFile"):
        sky = lightCases.SkyImage(1024)
        imageFile.WriteExr(f"{folder}/sky.exr", {c: sky[..., i] for i, c in enumerate("RGB")}, half=False)
    author.AddLight(stage, "/World/Light", plate.kind, plate.placement, **plate.inputs)
    stage.GetRootLayer().Save()
    return f"{folder}/{name}.usda"


def ExpectedPlate(path: str) -> np.ndarray:
    """The picture [HEIGHT][WIDTH][3] of a plate's stage, in double precision."""
    light = ReadStage(path).lights[0]
    sub = (np.arange(3) + 0.5) / 3
    x = ((np.arange(WIDTH)[:, None] + sub).ravel() / WIDTH - 0.5) * _SIZE
    z = ((np.arange(HEIGHT)[:, None] + sub).ravel() / HEIGHT - 0.5) * _SIZE * HEIGHT / WIDTH
    gz, gx = np.meshgrid(z, x, indexing="ij")
    points = np.stack([gx, 0 * gx, gz], -1).reshape(-1, 3)
    inputs, matrix = light.inputs, light.matrix
    if light.kind == "Sphere":
        scalar = closedForm.IrradianceOfSphere(points, _UP, matrix[3, :3], inputs["radius"])
    elif light.kind == "Rect":
        scalar = closedForm.IrradianceOfRect(points, _UP, matrix, inputs["width"], inputs["height"])
    elif light.kind == "Disk":
        scalar = closedForm.IrradianceOfDisk(points, _UP, matrix, inputs["radius"])
    elif light.kind == "Cylinder":
        scalar = closedForm.IrradianceOfCylinder(points, _UP, matrix, inputs["radius"], inputs["length"])
    elif light.kind == "Distant":
        angle = np.radians(inputs["angle"] / 2)
        value = closedForm.IrradianceOfCone(_UP, matrix[2, :3], angle) if angle > 0 else np.dot(_UP, matrix[2, :3])
        scalar = np.full(len(points), value)
    elif inputs.get("texture:file"):
        channels = imageFile.ReadExr(inputs["texture:file"])
        irradiance = closedForm.IrradianceOfLatlong(np.stack([channels[c] for c in "RGB"], -1).astype(float), _UP)
        return np.broadcast_to(irradiance * light.radiance * ALBEDO / np.pi, (HEIGHT, WIDTH, 3))
    else:
        scalar = np.full(len(points), np.pi)
    picture = scalar.reshape(HEIGHT, 3, WIDTH, 3).mean((1, 3))
    return picture[..., None] * light.radiance * ALBEDO / np.pi
