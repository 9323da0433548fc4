# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of OpenVDB files: damaged ones, and whole ones with values, places and motion that are none."""

import pathlib

import byteMutation
import numpy as np
from fuzzKind import Kind

_SMALL = ["--imageWidth", 16, "--samples", 2, "--maxDepth", 3, "--time", 5]
_FIELDS = ("density", "temperature", "motion")
_ODD = (np.nan, np.inf, -np.inf, -1.0, 1e38, 1e-40, -1e38)
_STAGE = """#usda 1.0
def Camera "Camera"
{
    float2 clippingRange = (0.01, 100)
    double shutter:open = -1
    double shutter:close = 2
    double3 xformOp:translate = (0, 0, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def DomeLight "Sky" {}
def Mesh "Wall"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-2, -2, -2), (2, -2, -2), (2, 2, -2), (-2, 2, -2)]
}
def Volume "Smoke" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    rel field:density = </Smoke/density>
    rel field:temperature = </Smoke/temperature>
    rel field:velocities = </Smoke/motion>
    rel material:binding = </Look>
    FIELDS
}
def Material "Look"
{
    token outputs:volume.connect = </Look/Volume.outputs:out>
    def Shader "Volume"
    {
        uniform token info:id = "arnold:standard_volume"
        float inputs:density = 4
        string inputs:emission_mode = "blackbody"
        float inputs:temperature = 0.3
        string inputs:temperature_channel = "temperature"
        token outputs:out
    }
}
"""
_FIELD = """def OpenVDBAsset "NAME"
    {
        asset filePath = @./FILE@
        token fieldName = "GRID"
    }
"""


class Volume(Kind):
    """Mutated files below a stage that reads a density, a temperature and a velocity from each."""

    def _File(self, rng) -> bytes:
        """A whole file; half of them have numbers in their voxels that mean nothing."""
        from stages.smoke import WriteVdb

        numbers = np.random.default_rng(rng.randrange(1 << 30))
        shape = tuple(rng.choice([1, 7, 8, 17]) for _ in range(3))
        grids = {name: numbers.uniform(-1, 1, shape + ((3,) if name == "motion" else ())) for name in _FIELDS}
        if rng.random() < 0.5:
            for values in grids.values():
                values[numbers.random(values.shape) < 0.2] = rng.choice(_ODD)
        path = pathlib.Path(self.folder) / f"whole{self.number}.vdb"
        voxel = rng.choice([0.1, 0.1, 0.1, 1e-3, 1e8])
        first = tuple(rng.choice([-4, -4, -4, 0, 1 << 19, -(1 << 24)]) for _ in range(3))
        WriteVdb(path, voxel, first, **grids)
        self._written.append(path)
        return path.read_bytes()

    def RunCase(self, rng) -> str:
        data = self._File(rng)
        if rng.random() < 0.8:
            data = byteMutation.Mutated(data, rng)
        file = self.Write("smoke.vdb", data)
        grids = rng.choice([_FIELDS, _FIELDS, rng.sample(_FIELDS, 3)])
        fields = "".join(_FIELD.replace("NAME", name).replace("GRID", grid).replace("FILE", file)
                         for name, grid in zip(_FIELDS, grids))
        budget = rng.choice([[], ["--residency", "stream", "--volumeMemory", "16K"]])
        return self.Record(self.Write("stage.usda", _STAGE.replace("FIELDS", fields)), *_SMALL, *budget)
