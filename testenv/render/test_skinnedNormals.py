# SPDX-License-Identifier: Apache-2.0
"""Normals of skinned surfaces: those of the points where joints carry them, as the inverse transpose maps them."""

import numpy as np
import pytest
from pxr import Gf, UsdSkel, Vt

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

_SCALE = np.array([1.6, 0.8, 0.5])


def _Write(path, scheme: str, hasNormals: bool) -> None:
    """A ball of radius 1, with its normals where asked for, carried by one joint that scales it along the axes and turns it by 30 degrees about z."""
    stage = author.NewStage(str(path))
    root = UsdSkel.Root.Define(stage, "/World/Figure")
    skeleton = UsdSkel.Skeleton.Define(stage, "/World/Figure/Skeleton")
    identity = Vt.Matrix4dArray([Gf.Matrix4d(1)])
    skeleton.CreateJointsAttr(["joint"])
    skeleton.CreateBindTransformsAttr(identity)
    skeleton.CreateRestTransformsAttr(identity)
    animation = UsdSkel.Animation.Define(stage, "/World/Figure/Pose")
    animation.CreateJointsAttr(["joint"])
    animation.CreateTranslationsAttr([Gf.Vec3f(0)])
    animation.CreateRotationsAttr([Gf.Quatf(Gf.Rotation(Gf.Vec3d(0, 0, 1), 30).GetQuat())])
    animation.CreateScalesAttr([Gf.Vec3h(*map(float, _SCALE))])
    mesh = author.AddMesh(stage, "/World/Figure/Ball", shapes.Sphere(1.0, 48, 96))
    mesh.CreateSubdivisionSchemeAttr(scheme)
    count = len(mesh.GetPointsAttr().Get())
    if not hasNormals:
        mesh.GetPrim().RemoveProperty("normals")
    for prim in (skeleton, mesh):
        UsdSkel.BindingAPI.Apply(prim.GetPrim())
    UsdSkel.BindingAPI(skeleton).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding = UsdSkel.BindingAPI(mesh)
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 1).Set(Vt.IntArray(count, 0))
    binding.CreateJointWeightsPrimvar(False, 1).Set(Vt.FloatArray(count, 1.0))
    author.AddCamera(stage, eye=(0, 0, 10), width=36.0, aspect=1.0, orthographic=True)
    assert root
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("scheme, hasNormals, degrees", [("catmullClark", False, 0.5), ("none", False, 6.0), ("none", True, 0.6)],
                         ids=["subdivided", "flat", "smooth"])
def test_normals_are_those_of_the_ellipsoid(tmp_path, scheme, hasNormals, degrees):
    """The ball becomes an ellipsoid, whose normal at p is D^-2 p in its own axes. Flat facets are 4 by 4 degrees of the
    ball, which the scales stretch; normals that are authored at rest go with them, and are blended across a facet. At 0.5
    also the facets of the cage, which lies inside, are no matter."""
    _Write(tmp_path / "stage.usda", scheme, hasNormals)
    picture = ours.Render(tmp_path / "stage.usda", 48, 48, ("normal", "position"), samples=1, maxDepth=0)
    normals, positions = (picture.layers[name][..., :3].reshape(-1, 3).astype(float) for name in ("normal", "position"))
    hit = np.linalg.norm(normals, axis=1) > 0.5
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])  # of row vectors
    own = positions[hit] @ turn.T
    expected = (own / _SCALE**2) @ turn
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    facing = expected[:, 2] > 0.3  # at the rim an error of the position turns the normal most
    cosine = np.clip(np.sum(expected * normals[hit], 1), -1, 1)[facing]
    assert hit.sum() > 500 and facing.sum() > 300
    assert np.degrees(np.arccos(cosine)).max() < degrees
    unscaled = positions[hit] / np.linalg.norm(positions[hit], axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip(np.sum(unscaled * expected, 1), -1, 1))).max() > 20  # the test can fail
