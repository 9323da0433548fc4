# SPDX-License-Identifier: Apache-2.0
"""MaterialX's example materials by our built-in surfaces and by MaterialX's own node graphs of the same surfaces.

    python testenv/bench/materialExamples.py FOLDER [--only TEXT] [--samples N] [--pictures OUT]
    python testenv/bench/materialExamples.py --random 12 [--seed N] [...]

The second form draws so many materials of each model in stages/randomMaterials.py, which have random inputs. FOLDER: .mtlx files, such as resources/Materials/Examples of the repository AcademySoftwareFoundation/MaterialX beside its
resources/Images. Each material is drawn on a ball below a sky and a wide sun, twice: with its surface shader, which
hdStream has built in, and with the closures that the shader's definition is made of (NG_standard_surface_surfaceshader_100,
NG_open_pbr_surface_surfaceshader, ...). Printed, of means of 8 x 8 pixels and of each colour: the largest difference over
the built-in picture, what of that block is noise (one standard deviation, by renders of other seeds), and the difference of the whole
picture. The definition of UsdPreviewSurface is OpenUSD's text, not MaterialX's node graph: materials of files leave it out, and
random ones are put beside its formula, integrated in double precision (render/previewBall.py). The exit code is 1 where a block
differs by more than 2 % and by more than three times its noise.
"""

import argparse
import pathlib
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / name) for name in ("", "support", "render")]
import builtPackage  # noqa: E402

builtPackage.PutOnPath()
import numpy as np  # noqa: E402

import ours  # noqa: E402
import previewBall  # noqa: E402
from pxr import Gf  # noqa: E402
from stages import author, imageFile, randomMaterials, surfaceGraphs  # noqa: E402
from stages.materialX import Ball  # noqa: E402

SIZE, BLOCK, SEEDS = 64, 8, 4
LIMIT = 0.02
SKY, SUN, SUN_ANGLE, SUN_TURN = 0.5, 4.0, 50.0, (-30, 40, 0)


def Pictures(layer, name: str, samples: int, kernels: str = "auto"):
    """([seed][height][width][channel], warnings) of a material on a ball."""
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/stage.usda"
        stage = author.NewStage(path)
        material = surfaceGraphs.CopyMaterial(layer, name, stage, "/World/Look")
        author.AddMesh(stage, "/World/Ball", Ball(1.0), material=material, rotate=(20, -70, 0))
        author.AddLight(stage, "/World/Sky", "Dome", intensity=SKY)
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=SUN_TURN), angle=SUN_ANGLE, intensity=SUN)
        author.AddCamera(stage, eye=(0, 0, 10), width=20.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        renders = [ours.Render(path, SIZE, SIZE, samples=samples, maxDepth=24, seed=seed, kernels=kernels) for seed in range(SEEDS)]
    return np.stack([render.rgb for render in renders]), renders[0].warnings


def FormulaPictures(inputs: dict):
    """[seed][height][width][channel] of a UsdPreviewSurface on the ball, by its formula."""
    x, y, z = (Gf.Rotation(axis, degrees) for axis, degrees in zip(np.eye(3).tolist(), SUN_TURN))
    toSun = np.array((x * y * z).TransformDir(Gf.Vec3d(0, 0, 1)))
    return np.stack([previewBall.Picture(SIZE, inputs, SKY, SUN, toSun, np.radians(SUN_ANGLE / 2), seed) for seed in range(SEEDS)])


def _Blocks(pictures):
    """[seed][block][channel], of blocks that the ball fills"""
    n = SIZE // BLOCK
    blocks = pictures.reshape(SEEDS, n, BLOCK, n, BLOCK, 3).mean((2, 4))
    at = (np.abs(np.arange(n) - (n - 1) / 2) + 0.5) * 2 / n  # the outer edges, of a ball of radius 1
    return blocks[:, at[:, None] ** 2 + at[None, :] ** 2 < 1]


def Compare(builtIn, graph):
    """(largest relative difference of a block, its noise, relative difference of all), as (graph - built-in) / built-in"""
    one, other = _Blocks(builtIn), _Blocks(graph)
    scale = one.mean(0) + 0.01 * one.mean()  # what is black has no relative difference
    difference = (other.mean(0) - one.mean(0)) / scale
    noise = np.sqrt((one.var(0, ddof=1) + other.var(0, ddof=1)) / SEEDS) / scale
    worst = np.unravel_index(np.argmax(np.abs(difference) - noise), difference.shape)
    return difference[worst], noise[worst], other.mean() / one.mean() - 1


def Materials(folder: pathlib.Path, only: str):
    """(label, layer with built-in surfaces, layer with node graphs, name of the material)"""
    for file in sorted(folder.rglob("*.mtlx")):
        document = surfaceGraphs.ReadDocument(file)
        names = [name for name, node in surfaceGraphs.SurfaceNodes(document).items()
                 if node.getCategory() != "UsdPreviewSurface" and only.lower() in f"{file.stem} {name} {node.getCategory()}".lower()]
        if not names:
            continue
        builtIn = surfaceGraphs.ReadLayer(document)
        surfaceGraphs.ReplaceSurfaces(document)
        graph = surfaceGraphs.ReadLayer(document)
        for name in names:
            yield file.stem if len(names) == 1 else f"{file.stem}: {name}", builtIn, graph, name


def RandomMaterials(count: int, seed: int, only: str):
    """As Materials(); in place of the layer with node graphs the inputs of a UsdPreviewSurface"""
    for model in randomMaterials.MODELS:
        for index in range(count):
            label = f"{model} {index}"
            if only.lower() not in label.lower():
                continue
            inputs = randomMaterials.Inputs(model, seed, index)
            document = randomMaterials.Document(model, inputs)
            builtIn = surfaceGraphs.ReadLayer(document)
            if model == "UsdPreviewSurface":
                yield f"{label}: {', '.join(inputs)}", builtIn, inputs, "Look"
                continue
            surfaceGraphs.ReplaceSurfaces(document)
            yield f"{label}: {', '.join(inputs)}", builtIn, surfaceGraphs.ReadLayer(document), "Look"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, nargs="?")
    parser.add_argument("--random", type=int, default=0, help="materials of each model, in place of a folder's")
    parser.add_argument("--seed", type=int, default=1, help="of random materials")
    parser.add_argument("--only", default="", help="materials whose file, name or surface has this text")
    parser.add_argument("--samples", type=int, default=64, help="a pixel, of each of the seeds")
    parser.add_argument("--kernels", default="auto", help="general: the same bits, compiled once for most materials")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures: built-in, node graph")
    options = parser.parse_args()
    differing = []
    print("| material | largest difference of a block | its noise | of all |\n|---|---|---|---|")
    count = 0
    if (options.folder is None) != (options.random > 0):
        parser.error("either a folder or --random")
    materials = RandomMaterials(options.random, options.seed, options.only) if options.random else Materials(options.folder, options.only)
    for label, builtInLayer, graphLayer, name in materials:
        builtIn, builtInWarnings = Pictures(builtInLayer, name, options.samples, options.kernels)
        if isinstance(graphLayer, dict):
            graph, graphWarnings = FormulaPictures(graphLayer), []
        else:
            graph, graphWarnings = Pictures(graphLayer, name, options.samples, options.kernels)
        worst, noise, whole = Compare(builtIn, graph)
        if abs(worst) > LIMIT and abs(worst) > 3 * noise:
            differing.append(label)
        count += 1
        print(f"| {label} | {worst:+.2%} | {noise:.2%} | {whole:+.2%} |", flush=True)
        for line in sorted({*builtInWarnings, *graphWarnings}):
            print(f"  {'both' if line in builtInWarnings and line in graphWarnings else 'node graph' if line in graphWarnings else 'built-in'}: {line}")
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            row = np.concatenate([builtIn.mean(0), graph.mean(0)], 1)
            file = label.split(",")[0].replace(": ", "-")
            imageFile.WritePng(options.pictures / f"{file}.png",
                               (255.0 * np.clip(row, 0.0, 1.0) ** (1 / 2.2)).astype(np.uint8))
    print(f"{len(differing)} of {count} differ by more than {LIMIT:.0%}: {', '.join(differing) or 'none'}")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
