# SPDX-License-Identifier: Apache-2.0
"""Verification cases of the light types, each alone over the common Lambert set.

Lights stay outside the view and clear of the space between surfaces, because Mitsuba's light shapes
occlude and ours do not; `lightsSeen` shows them on black instead.
"""

import numpy as np

from . import author, imageFile, shapes
from .cases import AddBlocks, AddCase


@AddCase(lambert=True)
def DistantParallel(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-55, 35, 0)), intensity=2.0, angle=0.0)


@AddCase(lambert=True)
def DistantAngle(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-50, -30, 0)), intensity=20.0, angle=20.0,
                    color=(1.0, 0.8, 0.5))


@AddCase(lambert=True)
def DistantNormalized(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-65, 20, 0)), intensity=2.5, angle=8.0, normalize=True,
                    exposure=0.5)


@AddCase(lambert=True)
def SphereLight(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1.0, 4.6, 2.2)), radius=0.5, intensity=40.0,
                    color=(1.0, 0.9, 0.7))


@AddCase(lambert=True)
def SphereLightScaled(stage, folder):
    """A light that inherits a uniform scale of 1/2, normalised: power does not follow the size."""
    AddBlocks(stage)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(-1.6, 4.4, 2.0), scale=0.5), radius=0.8,
                    intensity=70.0, normalize=True)


@AddCase(lambert=True)
def RectLight(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2.5, 4.2, 2.5), rotate=(-55, -35, 15)), width=2.4,
                    height=0.8, intensity=12.0, exposure=0.5)


@AddCase(lambert=True)
def RectLightNormalized(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(1.5, 4.5, 2.0), rotate=(-70, 20, 0), scale=(1, 2, 1)),
                    width=0.7, height=0.6, intensity=30.0, normalize=True)


@AddCase(lambert=True)
def DiskLight(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Disk", "Disk", dict(translate=(2.2, 4.5, 2.4), rotate=(-60, 30, 0)), radius=0.8,
                    intensity=20.0, enableColorTemperature=True, colorTemperature=3500.0)


@AddCase(lambert=True, referenceSamples=16384)
def CylinderLight(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Tube", "Cylinder", dict(translate=(-0.5, 4.3, 1.8), rotate=(0, 25, 10)), radius=0.12,
                    length=3.0, intensity=30.0)


@AddCase(lambert=True)
def DomeUniform(stage, folder):
    AddBlocks(stage)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.9, color=(1.0, 0.9, 0.8))


def SkyImage(width: int = 1024) -> np.ndarray:
    """A smooth lat-long sky [height][width][3]: a gradient, a broad bright lobe toward (+x, up, +z) and
    a coloured one toward -x, so that any wrong turn or mirroring of the map is seen."""
    height = width // 2
    v = (np.arange(height) + 0.5) / height * np.pi
    u = (np.arange(width) + 0.5) / width
    longitude = np.pi - 2 * np.pi * u  # OpenEXR: +z at the centre, +x at the quarter
    y = np.cos(v)[:, None] + 0 * u
    x, z = np.outer(np.sin(v), np.sin(longitude)), np.outer(np.sin(v), np.cos(longitude))
    lobe = lambda d, k: np.exp(k * ((x * d[0] + y * d[1] + z * d[2]) / np.linalg.norm(d) - 1))
    sky = 0.15 + 0.15 * (y[..., None] + 1) * np.array([0.6, 0.8, 1.0])
    sky = sky + lobe((1, 1.2, 0.8), 40)[..., None] * np.array([14, 11, 8.0])
    return sky + lobe((-1, 0.2, 0.3), 12)[..., None] * np.array([0.3, 1.5, 0.5])


@AddCase(lambert=True, samples=256)
def DomeLatlong(stage, folder):
    sky = SkyImage()
    imageFile.WriteExr(f"{folder}/sky.exr", {c: sky[..., i] for i, c in enumerate("RGB")}, half=False)
    AddBlocks(stage)
    author.AddLight(stage, "/World/Dome", "Dome", dict(rotate=(10, 70, 0)), textureFile="./sky.exr", textureFormat="latlong")


@AddCase(lambert=True)
def FiveLights(stage, folder):
    """Selection among lights: one of each kind at once."""
    AddBlocks(stage)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-60, 100, 0)), intensity=0.5, angle=0.5, normalize=True)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(2.8, 4.2, 2.2)), radius=0.3, intensity=25.0)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-3.4, 4.0, 2.5), rotate=(-50, -50, 0)), width=1.0,
                    height=1.0, intensity=8.0, color=(0.6, 0.8, 1.0))
    author.AddLight(stage, "/World/Disk", "Disk", dict(translate=(0, 5.2, 1.0), rotate=(-85, 0, 0)), radius=0.4,
                    intensity=10.0, color=(1.0, 0.7, 0.4))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.1)


@AddCase(lambert=True)
def LightsSeen(stage, folder):
    """Every finite light in view on black: its radiance and its summary in camera rays."""
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(-1.7, 0.9, 0)), radius=0.6, intensity=1.5)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0.1, 0.9, 0), rotate=(15, 200, 20)), width=1.2, height=0.8,
                    intensity=0.8, color=(1, 0.5, 0.2))
    author.AddLight(stage, "/World/Disk", "Disk", dict(translate=(1.8, 0.9, 0), rotate=(0, 150, 0)), radius=0.6, intensity=0.6)
    author.AddLight(stage, "/World/Tube", "Cylinder", dict(translate=(0, -0.8, 0), rotate=(0, 30, 12)), radius=0.3, length=2.6,
                    intensity=2.0, color=(0.4, 0.6, 1))
    author.AddCamera(stage, eye=(0, 0, 6.0))


@AddCase(lambert=True, samples=512)
def EmissiveMesh(stage, folder):
    """Emissive meshes light a Lambert set: a big panel (two triangles) and a dense torus."""
    AddBlocks(stage)
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(36, 32, 24), metallic=1.0)
    ring = author.AddMaterial(stage, "/World/Ring", diffuseColor=(0, 0, 0), emissiveColor=(6, 8, 12), metallic=1.0)
    panel = shapes.Plane(1.6, 0.9)
    author.AddMesh(stage, "/World/Panel", panel, material=glow, translate=(-2.2, 4.3, 2.0), rotate=(215, 0, 20))
    author.AddMesh(stage, "/World/Torus", shapes.Torus(0.8, 0.12), material=ring, translate=(1.6, 4.2, 1.5), rotate=(20, 0, 10))
