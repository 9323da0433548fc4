# SPDX-License-Identifier: Apache-2.0
"""Skinned points against closed forms and against UsdSkel's own baking; what follows from time and instances.

The stage is that of the golden case `skinning` with an elbow, at x = 2, that bends by 90 degrees about z instead of
180, while the arm, which lies along x, moves by 2 (t - 2) along z.
"""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdSkel

from translateCase import FOLDER, Translate

STAGE = str(FOLDER / "skinning" / "scene.usda")
ELBOW = np.array([2.0, 0.0, 0.0])


def Bending():
    stage = Usd.Stage.Open(STAGE)
    stage.SetEditTarget(stage.GetSessionLayer())
    half = Gf.Quatf(np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    stage.GetPrimAtPath("/Arm/Skeleton/Bend").GetAttribute("rotations").Set([Gf.Quatf(1), half])
    weights = stage.GetPrimAtPath("/Arm/DualQuaternion").GetAttribute("primvars:skel:jointWeights")
    weights.Set([1, 0, 0.5, 0.5, 0, 1])
    return stage


def Points(name, time=2.5):
    session = Translate(Bending(), time)
    return np.array(session.Scene().geometry[f"/Arm/{name}"].geometry.points)


def Bent(point):
    """Carried by the lower arm: turned by 90 degrees about the elbow."""
    x, y, z = np.asarray(point, float) - ELBOW
    return ELBOW + (-y, x, z)


@pytest.mark.parametrize("time", [2.0, 2.5, 3.0])
def test_linear_blend_of_a_two_bone_arm(time):
    # The mesh's own transform, 5 along z, is no part of where joints carry it (UsdSkel: geomBindTransform is).
    moved = np.array([0, 0, 2 * (time - 2) - 5])
    rest = np.array([(0, 0, 0), (2, 0, 0), (4, 0, 0), (0, 1, 0), (2, 1, 0), (4, 1, 0)], float)
    weights = [0, 0.5, 1, 0, 0.5, 1]
    expected = [(1 - w) * p + w * Bent(p) + moved for p, w in zip(rest, weights)]
    assert Points("Linear", time) == pytest.approx(np.array(expected), abs=2e-6)


def test_dual_quaternions_keep_the_length():
    # Halfway between the joints both turn by 45 degrees: about the elbow, which neither moves.
    half = np.sqrt(0.5)
    expected = [(0, 0, 1), (2 - half, half, 1), tuple(Bent((4, 1, 0)) + (0, 0, 1))]
    assert Points("DualQuaternion") == pytest.approx(np.array(expected), abs=2e-6)


def test_a_rigid_part_follows_its_joint():
    expected = [Bent(p) + (0, 0, 1) for p in ((2, 0, 0), (4, 0, 0), (4, 1, 0))]
    assert Points("Rigid") == pytest.approx(np.array(expected), abs=2e-6)


@pytest.mark.parametrize("time", [2.0, 2.25, 3.0])
def test_blend_shape_weights_vary_with_time(time):
    weight = time - 2
    expected = [(0, 0, 2 * weight), (1, 0, 0), (0, 1, 4 * weight)]
    assert Points("Shape", time) == pytest.approx(np.array(expected), abs=1e-6)


def test_points_are_those_of_usdskel_baking():
    baked = Usd.Stage.Open(Bending().Flatten())  # a layer of its own
    assert UsdSkel.BakeSkinning(baked.Traverse())
    for name in ("Linear", "DualQuaternion", "Shape"):
        for time in (2.0, 3.0):
            expected = np.asarray(baked.GetPrimAtPath(f"/Arm/{name}").GetAttribute("points").Get(time))
            assert Points(name, time) == pytest.approx(expected, abs=1e-5), (name, time)


def test_normals_at_rest_are_left_out():
    meshes = Translate(Usd.Stage.Open(STAGE)).Scene().geometry
    assert [p.name for p in meshes["/Arm/Linear"].geometry.primvars] == []
    assert [p.name for p in meshes["/Arm/Unskinned"].geometry.primvars] == ["normals"]


def test_influences_that_do_not_fit_leave_all_points():
    """UsdSkel has moved the first points when it meets the bad joint."""
    stage = Bending()
    mesh = stage.GetPrimAtPath("/Arm/Linear")
    indices = mesh.GetAttribute("primvars:skel:jointIndices")
    indices.Set([*list(indices.Get())[:-1], 999])
    session = Translate(stage, 2.5)
    assert np.array_equal(session.Scene().geometry["/Arm/Linear"].geometry.points, mesh.GetAttribute("points").Get())
    assert any("/Arm/Linear: its joint influences do not fit" in line for line in session.Warnings())


@pytest.mark.filterwarnings("error")
def test_singular_skeletons_are_quiet():
    """What is not finite is the core's to name, in a line of ours."""
    stage = Bending()
    stage.GetPrimAtPath("/Arm/Skeleton").GetAttribute("bindTransforms").Set([Gf.Matrix4d(0.0)] * 2)
    Translate(stage, 2.5)
