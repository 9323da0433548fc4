# SPDX-License-Identifier: Apache-2.0
"""Primvars of a mesh are those that UsdGeomPrimvarsAPI finds, with its interpolation and values."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from translateCase import StageOf, Translate

NAMES = ["a", "b", "c:d"]
INTERPOLATIONS = ["constant", "uniform", "varying", "vertex", "faceVarying"]
TYPES = {"float": 1, "float2": 2, "double3": 3, "half4": 4, "color3f": 3, "int": 1}


def RandomStage(seed):
    """A chain of prims with random primvars of the same few names at every level."""
    rng = np.random.default_rng(seed)
    stage = Usd.Stage.CreateInMemory()
    path = ""
    for level in range(4):
        path += f"/p{level}"
        isMesh = level == 3
        prim = (UsdGeom.Mesh if isMesh else UsdGeom.Xform).Define(stage, path).GetPrim()
        for name in NAMES:
            if rng.random() < 0.4:
                continue
            typeName = str(rng.choice(list(TYPES)))
            interpolation = str(rng.choice(INTERPOLATIONS if isMesh else INTERPOLATIONS[:2]))
            AddPrimvar(prim, name, typeName, interpolation, rng)
    mesh = UsdGeom.Mesh(prim)
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    return stage, prim


def AddPrimvar(prim, name, typeName, interpolation, rng):
    size = TYPES[typeName]
    rows = rng.integers(0, 9, (3, size))
    values = [int(row[0]) if size == 1 else tuple(map(float, row)) for row in rows]
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        name, Sdf.ValueTypeNames.Find(typeName + "[]"), interpolation)
    case = rng.random()
    if case < 0.15:
        return  # declared without a value: neither a primvar nor in the way of an inherited one
    primvar.Set(values)
    if case > 0.7:
        primvar.SetIndices([2, 0, 1, 1])


@pytest.mark.parametrize("seed", range(60))
def test_primvars_are_what_usd_finds(seed):
    stage, prim = RandomStage(seed)
    mesh = Translate(stage).Scene().geometry[str(prim.GetPath())].geometry
    found = {primvar.name: primvar for primvar in mesh.primvars}
    expected = {primvar.GetPrimvarName(): primvar
                for primvar in UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance()
                if primvar.HasValue()}
    assert found.keys() == expected.keys()
    for name, primvar in expected.items():
        assert found[name].interpolation.name.lower() == primvar.GetInterpolation().lower()
        values = found[name].values
        if found[name].indices.size:
            values = values[found[name].indices]
        flat = np.asarray(primvar.ComputeFlattened(), np.float32)
        np.testing.assert_array_equal(values.reshape(flat.shape), flat)


@pytest.mark.parametrize("authored, expected", [
    ("normal3f[] normals = [(0,0,1),(0,0,1),(0,0,1)]", "Vertex"),
    ('normal3f[] normals = [(0,0,1)] (interpolation = "constant")', "Constant"),
    ('normal3f[] normals = [(1,0,0)]\nnormal3f[] primvars:normals = [(0,0,1)] (interpolation = "uniform")', "Uniform"),
])
def test_primvars_normals_have_precedence(authored, expected):
    stage = StageOf(f"""def Mesh "M" {{
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        {authored}
    }}""")
    primvars = Translate(stage).Scene().geometry["/M"].geometry.primvars
    assert [(p.name, p.interpolation.name) for p in primvars] == [("normals", expected)]
    assert (primvars[0].values == [0, 0, 1]).all()


def test_arrays_without_values_are_no_primvars():
    session = Translate(StageOf("""
        def Sphere "S" {
            color3f[] primvars:displayColor = []
            texCoord2f[] primvars:st = [] (interpolation = "vertex")
            float[] primvars:f = []
            float4[] primvars:four = [(1, 2, 3, 4)] (interpolation = "constant")
        }"""))
    assert [primvar.name for primvar in session.Scene().geometry["/S"].geometry.primvars] == ["four"]


@pytest.mark.parametrize("above", ["Mesh", "Points", "Sphere", "BasisCurves"])
def test_gprims_below_gprims_inherit_as_usd_finds(above):
    """Discouraged, but the text of FindPrimvarsWithInheritance has no exception for gprims."""
    stage = StageOf(f"""def {above} "A" {{
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        int[] faceVertexCounts = [3]
        int[] curveVertexCounts = [3]
        uniform token type = "linear"
        int[] faceVertexIndices = [0, 1, 2]
        color3f[] primvars:displayColor = [(1, 0, 0)]
        float[] primvars:perPoint = [1, 2, 3] (interpolation = "vertex")
        float primvars:own = 1
        def Xform "Group" {{ def Mesh "B" {{
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            float primvars:own = 2
        }} }}
    }}""")
    session = Translate(stage)
    found = {primvar.name: primvar.values.ravel().tolist() for primvar in session.Scene().geometry["/A/Group/B"].geometry.primvars}
    expected = {primvar.GetPrimvarName(): np.ravel(primvar.Get()).tolist() for primvar in UsdGeom.PrimvarsAPI(
        stage.GetPrimAtPath("/A/Group/B")).FindPrimvarsWithInheritance()}
    assert found == expected and found == {"displayColor": [1, 0, 0], "own": [2]}
