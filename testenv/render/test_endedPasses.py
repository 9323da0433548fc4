# SPDX-License-Identifier: Apache-2.0
"""accuracy.endedPasses: rays that would pass more cut-out surfaces than one ray may (docs/wavefront.md), by the number of
pixels and samples."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

_MOST = 1024  # HDS_MAX_PASSES
_SIZE = (6, 4)
_SAMPLES = 2
_RAYS = _SIZE[0] * _SIZE[1] * _SAMPLES


def _Render(folder, planes, eye, emission=1):
    """A floor that may shine, `planes` invisible sheets above it and a distant light above all."""
    path = folder / "stage.usda"
    stage = author.NewStage(path)
    invisible = author.AddMaterial(stage, "/World/Looks/Hole", opacity=0.2, opacityThreshold=0.5)
    bright = author.AddMaterial(stage, "/World/Looks/Bright", diffuseColor=(0.5, 0.5, 0.5), emissiveColor=(emission,) * 3)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), material=bright)
    sheet = shapes.Plane(2000, 2000)  # so wide that no ray gets out at the side
    sheets = shapes.Merged([sheet.Moved((0, 1 + 0.001 * i, 0)) for i in range(planes)])
    author.AddMesh(stage, "/World/Sheets", sheets, material=invisible, doubleSided=True)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), intensity=1.0, angle=0.0)
    author.AddCamera(stage, eye=eye, target=(0, 0, 0), up=(0, 0, -1), aspect=_SIZE[0] / _SIZE[1])
    stage.GetRootLayer().Save()
    return ours.Render(path, *_SIZE, samples=_SAMPLES, maxDepth=0)


def _Ended(picture) -> int:
    count = picture.statistics["accuracy"]["endedPasses"]
    said = [warning for warning in picture.warnings if "rays ended after passing the most cut-out surfaces" in warning]
    assert len(said) == (1 if count else 0) and all(f"{count} rays" in warning for warning in said)
    assert picture.statistics["accuracy"]["nanSamples"] == 0
    return count


def test_as_many_as_a_ray_may_pass_end_none(tmp_path):
    picture = _Render(tmp_path, _MOST - 1, eye=(0, 15, 0))
    assert _Ended(picture) == 0
    assert (picture.rgb >= 1).all(), "the floor is seen through all of them"


def test_each_camera_ray_ends_that_has_more_before_it(tmp_path):
    picture = _Render(tmp_path, _MOST + 20, eye=(0, 15, 0))
    assert _Ended(picture) == _RAYS
    assert not np.any(picture.rgb), "it sees nothing then"


def test_each_shadow_ray_and_each_ray_on_ends_that_has_more_before_it(tmp_path):
    """The camera is below the sheets. From each hit of the floor, which is no light here, a shadow ray goes up, and a ray that
    only finds lights."""
    picture = _Render(tmp_path, _MOST + 20, eye=(0, 0.5, 0), emission=0)
    assert _Ended(picture) == 2 * _RAYS
    assert not np.any(picture.rgb), "no light comes to it"
    assert np.any(_Render(tmp_path, _MOST - 1, eye=(0, 0.5, 0), emission=0).rgb), "nor is it black itself"
