# SPDX-License-Identifier: Apache-2.0
"""Native instances that lights are linked to differently: Hydra's categories of each instance light what the collections hold,
and give the picture of `hdstream record`, whose instancers are others."""

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

from frontEnds import MODES, FrontEnds, ReadColor
from stages import author, shapes
from wrapperStage import WriteWrapper

WIDTH = 32


def _WriteStage(path):
    """Two instanced halves of the ground, left and right; a sun that leaves out the left one."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Prototype/Tile", shapes.Plane(2, 4), color=(0.5, 0.5, 0.5))
    stage.GetPrimAtPath("/World/Prototype").SetSpecifier(Sdf.SpecifierOver)
    for name, x in (("Left", -1), ("Right", 1)):
        tile = UsdGeom.Xform.Define(stage, f"/World/{name}")
        author.Place(tile, translate=(x, 0, 0))
        tile.GetPrim().GetReferences().AddInternalReference("/World/Prototype")
        tile.GetPrim().SetInstanceable(True)
    sun = author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), intensity=1.0, angle=0.0)
    author.LinkLight(sun, "lightLink", excludes=["/World/Left"])
    author.AddCamera(stage, eye=(0, 2, 0), target=(0, 0, 0), up=(0, 0, -1), width=30.0, orthographic=True)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("mode", MODES)
def test_linked_instances(mode, openUsd, plugin, renderer, isStream, tmp_path):
    if not isStream:
        pytest.skip("other renderers link otherwise")
    frontEnds = FrontEnds(openUsd, plugin, renderer, mode)
    _WriteStage(tmp_path / "stage.usda")
    wrapper = WriteWrapper(tmp_path / "stage.usda", tmp_path / "wrapper.usda", WIDTH, mode=mode, samples=2, maxDepth=0,
                           noCache=True)
    hydra = frontEnds.RunUsdrecord(wrapper, tmp_path / "hydra.exr")
    assert hydra.code == 0, hydra.output
    record = frontEnds.RecordHere(wrapper, tmp_path / "record.exr")
    assert record.code == 0, record.output
    for name in ("hydra.exr", "record.exr"):
        row = ReadColor(tmp_path / name)[8, :, 0]
        np.testing.assert_allclose(row[4:14], 0.0, atol=1e-7, err_msg=name)
        np.testing.assert_allclose(row[18:28], 0.5 / np.pi, rtol=1e-5, err_msg=name)
