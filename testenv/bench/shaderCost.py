# SPDX-License-Identifier: Apache-2.0
"""Cost of shader programs: the stack machine against hard-coded evaluation, kernel compile times, and what a scene
without textures pays.

    shaderCost.py BENCH [--runs N]        BENCH: build/<preset>/testenv/bench/benchShaderCost

1. nanoseconds a point of the machine and of the same material written into the kernel (least of interleaved runs).
2. `time.compile` of `hdstream record` with an empty cache and with a filled one, for a stage with and one without textures.
3. The stage without textures again with one textured speck out of sight: what compiled-in but unused code costs. Its
   pictures must have the same bits.

PoCL keeps kernels too; its folder is fresh for each cold run. Run with PYTHONPATH=build/release/python.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import numpy as np

from bench import recordRun
from stages import author, cases, imageFile, shapes
from render import textureCases


def WriteStage(folder: str, name: str, isTextured: bool, hasSpeck: bool) -> str:
    """Balls on a ground; four inputs from one look-up, or plain with maybe a textured speck below the ground."""
    stage = author.NewStage(f"{folder}/{name}.usda")
    image = (np.random.default_rng(1).random((512, 512, 4)) * 255).astype(np.uint8)
    imageFile.WritePng(f"{folder}/image.png", image)
    material = author.AddMaterial(stage, "/World/M", diffuseColor=(0.4, 0.3, 0.2), roughness=0.4)
    speck = author.AddMaterial(stage, "/World/N", diffuseColor=(0.4, 0.3, 0.2))
    for target, isWanted in ((material, isTextured), (speck, hasSpeck)):
        if isWanted:
            texture = textureCases.AddTexture(target, "T", file="./image.png")
            for surfaceInput, output in (("diffuseColor", "rgb"), ("roughness", "g"), ("metallic", "b"), ("clearcoat", "r")):
                textureCases.Connect(target, surfaceInput, texture, output)
    ball = shapes.Sphere(0.62, 96, 192)
    ball = shapes.Shape(ball.points, ball.counts, ball.indices, ball.normals, ball.points[:, :2] * 2)
    for i in range(4):
        author.AddMesh(stage, f"/World/Ball{i}", ball, material=material, translate=(1.4 * i - 2.1, 0.64, 0))
    author.AddMesh(stage, "/World/Speck", shapes.Plane(0.01, 0.01), material=speck, translate=(0, -20, 0))
    cases.AddStudio(stage)
    stage.GetRootLayer().Save()
    return f"{folder}/{name}.usda"


def Compile(stage: str, folder: str) -> tuple[float, float]:
    """Seconds cold and cached."""
    cache = f"{folder}/cache"
    seconds = []
    with tempfile.TemporaryDirectory() as pocl:
        os.environ["POCL_CACHE_DIR"] = pocl
        recordRun.FreshCache(cache)
        for _ in range(2):
            seconds.append(recordRun.Record(stage, cache, imageWidth=64, samples=1)["time"]["compile"])
        del os.environ["POCL_CACHE_DIR"]
    return seconds[0], seconds[1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench")
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    machine = json.loads(subprocess.run([arguments.bench], check=True, capture_output=True, text=True).stdout)
    print("| | machine ns | hard-coded ns | ratio |\n|---|---|---|---|")
    for suffix, name in (("", "inputs"), ("WithBsdf", "inputs and BSDF")):
        print(f"| {name} | {machine['machine' + suffix]} | {machine['hardCoded' + suffix]} | {machine['ratio' + suffix]} |")
    with tempfile.TemporaryDirectory() as folder:
        stages = {name: WriteStage(folder, name, *what) for name, what in
                  dict(plain=(False, False), textured=(True, True), speck=(False, True)).items()}
        print("\n| kernels | cold s | cached s |\n|---|---|---|")
        for name in ("plain", "textured"):
            cold, cached = Compile(stages[name], folder)
            print(f"| {name} | {cold:.2f} | {cached:.2f} |")
        best = {}
        pictures = {}
        for _ in range(arguments.runs):
            for name in ("plain", "speck"):
                values = recordRun.Record(stages[name], f"{folder}/cache", imageWidth=320, samples=32)
                pictures[name] = values["pictureBytes"]
                shade = values["time"]["shade"]
                best[name] = min(best.get(name, shade), shade)
        isSame = pictures["plain"] == pictures["speck"]
        print(f"\nshading with unused textures / without: {best['speck'] / best['plain']:.3f}, "
              f"{'same bits' if isSame else 'DIFFERENT BITS'}")
    return 0 if isSame else 1


if __name__ == "__main__":
    sys.exit(main())
