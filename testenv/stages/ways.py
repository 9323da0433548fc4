# SPDX-License-Identifier: Apache-2.0
"""What goes along in the stages of stages/motion.py, from frame 0 to frame 2."""

from pxr import Gf, UsdGeom

from . import author, shapes


def AddWay(prim, first, last, degrees=0.0):
    """A translation, and a rotation about z, from frame 0 to frame 2."""
    xformable = UsdGeom.Xformable(prim)
    translate = xformable.AddTranslateOp()
    for time, value in ((0.0, first), (2.0, last)):
        translate.Set(Gf.Vec3d(*map(float, value)), time)
    if degrees:
        rotate = xformable.AddRotateZOp()
        rotate.Set(0.0, 0.0)
        rotate.Set(float(degrees), 2.0)


def AddBox(stage, path, **placement):
    return author.AddMesh(stage, path, shapes.Box(1.4, 0.8, 0.3), color=(0.8, 0.5, 0.2), **placement)
