# SPDX-License-Identifier: Apache-2.0
"""Error against time of what changes textures: mip bias, shade iterations."""

from bench import textureQuality
from bench.curves import CurveChart, CurveTable
from bench.sceneRun import REFERENCE_SEED, Curve, Point, Scene
from stages import textureStress


def _Filtering(bench) -> list:
    """Glowing cards, so that the error is that of filtering and of where samples fall in a pixel."""
    sizes = bench.Pick(dict(width=480, count=208, size=512, sampleCounts=(4, 16, 64), referenceSamples=512),
                       dict(width=64, count=4, size=64, sampleCounts=(1, 4), referenceSamples=16))
    biases = bench.Pick((-1.0, -0.5, 0.0, 0.5, 1.0), (0.0, 1.0))
    rows = list(textureQuality.Measure(bench.folder / "quality", biases=biases, **sizes))

    def Points(bias):
        return [Point(row["samples"], row["seconds"], row["error"], {}) for row in rows if row["bias"] == bias]

    bias = {f"bias {value:+g}" if value else "bias 0": Points(value) for value in sorted(biases, key=abs)}
    return ["Mip bias. Cards that glow; the reference reads the finest mips:", CurveTable("knob-mip-bias", bias),
            ("knob-mip-bias", CurveChart("mip bias", bias))]


def _ShadeIterations(bench) -> list:
    """A pool that a pass overflows: exact (0) shades until all texels are there, others take coarser mips after so many times."""
    width, count, size = bench.Pick((320, 208, 256), (64, 4, 64))
    path = bench.Stage(f"stress{count}x{size}", lambda path: textureStress.WriteTextureStress(path, count, size))

    def Open():
        return Scene(path, "/World/Camera", imageWidth=width, imageHeight=width * 9 // 16, maxDepth=2)

    reference, _ = Open().Render(bench.Pick(512, 16), seed=REFERENCE_SEED, residency="resident")
    curves = {}
    for iterations in bench.Pick((0, 1, 2, 4, 8), (0, 1)):
        label = f"{iterations} iterations" if iterations else "until all are there"
        curves[label] = Curve(Open(), reference, bench.Pick((4, 16, 64), (1, 4)), residency="stream", prepare="eager",
                              textureMemory=bench.Pick("256K", "64K"), shadeIterations=iterations)
    table = CurveTable("knob-shade-iterations", curves)
    table.head = [*table.head, "texels from coarser mips, of all"]
    for name, points in curves.items():
        for row, point in zip((row for row in table.rows if row[0] == name), points):
            texture = point.statistics["texture"]
            row.append(texture["fallbackTexels"] / max(1, texture["lookups"]))
    return ["Shade iterations, a texture pool that is too small for one pass:", table,
            ("knob-shade-iterations", CurveChart("shade iterations", curves))]


def Run(bench) -> list:
    return [*_Filtering(bench), *_ShadeIterations(bench)]
