# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of OpenVDB files: damaged ones, and whole ones with values, places and motion that are none; materials that compute."""

import pathlib

import byteMutation
import numpy as np
from fuzzKind import Kind

_SMALL = ["--imageWidth", 16, "--samples", 2, "--maxDepth", 3, "--time", 5]
_FIELDS = ("density", "temperature", "motion")
_ODD = (np.nan, np.inf, -np.inf, -1.0, 1e38, 1e-40, -1e38)
_LOOK = """def Material "Look"
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
LOOK
""".replace("LOOK", _LOOK)
_FIELD = """def OpenVDBAsset "NAME"
    {
        asset filePath = @./FILE@
        token fieldName = "GRID"
    }
"""


# Of one operand and of two.
_FUNCTIONS = (("sin", "ln", "sqrt", "tan", "exp", "floor", "acos"), ("multiply", "add", "divide", "power", "modulo", "max", "atan2"))


def _Computed(rng) -> str:
    """A material whose coefficients are networks of random functions of fields, positions and noises, cycles included."""
    shaders = [("N0", "ND_geompropvalue_float", dict(geomprop='"density"')), ("N1", "ND_geompropvalue_float", dict(geomprop='"temperature"')),
               ("N2", "ND_position_vector3", {}), ("N3", "ND_extract_vector3", {"in": "N2", "index": rng.randrange(4)}),
               ("N4", "ND_fractal3d_float", dict(octaves=rng.choice([1, 3, 1 << 20]), lacunarity=rng.choice([2.0, 1e30])))]
    count = rng.randrange(5, 14)
    while len(shaders) < count:
        numOperands = rng.randrange(2)
        operands = {name: rng.choice([f"N{rng.randrange(count if rng.random() < 0.05 else len(shaders))}", rng.uniform(-2, 2), 0.0, 1e30])
                    for name in (("in",), ("in1", "in2"))[numOperands]}
        shaders.append((f"N{len(shaders)}", f"ND_{rng.choice(_FUNCTIONS[numOperands])}_float", operands))
    last = [f"N{rng.randrange(len(shaders))}" for _ in range(4)]
    shaders += [("Medium", "ND_anisotropic_vdf", dict(zip(("absorption", "scattering", "anisotropy"), last))),
                ("Glow", "ND_uniform_edf", dict(color=last[3])), ("Volume", "ND_volume", dict(vdf="Medium", edf="Glow"))]
    lines = ['def Material "Look" {', "    token outputs:mtlx:volume.connect = </Look/Volume.outputs:out>"]
    for name, identifier, inputs in shaders:
        lines += [f'    def Shader "{name}" {{', f'        uniform token info:id = "{identifier}"', "        float outputs:out"]
        for key, value in inputs.items():
            isPath = isinstance(value, str) and not value.startswith('"')
            kind = "int" if isinstance(value, int) else "string" if isinstance(value, str) and not isPath else "float"
            lines.append(f"        float inputs:{key}.connect = </Look/{value}.outputs:out>" if isPath else
                         f"        {kind} inputs:{key} = {value}")
        lines.append("    }")
    return "\n".join([*lines, "}", ""])


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
        text = _STAGE.replace("FIELDS", fields)
        if rng.random() < 0.3:
            text = text.replace(_LOOK, _Computed(rng))
        return self.Record(self.Write("stage.usda", text), *_SMALL, *budget)
