# SPDX-License-Identifier: Apache-2.0
"""Verification cases of cameras: orthographic, lens, film offset, exposure, pixel aspect."""

from . import author
from .cases import AddBlocks, AddCase


def _AddScene(stage) -> None:
    AddBlocks(stage, camera=False)
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2.5, 5.2, 3.0), rotate=(-55, -35, 0)), width=2.0, height=1.6,
                    intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)


@AddCase(lambert=True)
def CameraOrthographic(stage, folder):
    _AddScene(stage)
    author.AddCamera(stage, eye=(2.0, 3.2, 6.0), target=(0.2, 0.6, 0), width=60.0, orthographic=True, offset=(3.0, -2.0))


@AddCase(lambert=True)
def CameraDepthOfField(stage, folder):
    _AddScene(stage)
    camera = author.AddCamera(stage, eye=(0, 1.6, 3.4), target=(0.3, 0.6, 0), focalLength=50.0, width=60.0)
    camera.CreateFStopAttr(6.0)  # aperture 50/6 tenths of a unit: radius 0.417 units
    camera.CreateFocusDistanceAttr(2.9)


@AddCase(lambert=True)
def CameraOffsets(stage, folder):
    _AddScene(stage)
    author.AddCamera(stage, eye=(0, 2.4, 6.0), target=(0.1, 0.55, 0), offset=(4.5, -3.0))


@AddCase(lambert=True)
def CameraExposure(stage, folder):
    _AddScene(stage)
    camera = author.AddCamera(stage, eye=(0, 2.4, 6.0), target=(0.1, 0.55, 0))
    camera.CreateExposureAttr(-1.5)


@AddCase(lambert=True, width=60, height=90, pixelAspectRatio=2.0)
def CameraPixelAspect(stage, folder):
    _AddScene(stage)
    author.AddCamera(stage, eye=(0, 2.4, 6.0), target=(0.1, 0.55, 0))
