# SPDX-License-Identifier: Apache-2.0
"""Time of a resident render against the wave size, as ratios to the fastest in the same run.

    waveSize.py STAGE [--camera NAME] [--imageWidth N] [--samples N] [--runs N]

Sizes are interleaved over the runs and the least time of each counts, so that a noisy machine treats all
alike. All pictures must have the same bits. Run with PYTHONPATH=build/release/python.
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.sceneRun import Scene  # noqa: E402

SIZES = [1 << k for k in range(10, 21)]


def Measure(scene: Scene, samples: int, runs: int, sizes=SIZES) -> tuple[dict, bool]:
    """({size: statistics of the fastest run}, all pictures have the same bits)."""
    best, pictures = {}, set()
    for turn in range(runs + 1):
        for size in sizes:
            picture, statistics = scene.Render(samples if turn else 1, residency="resident", waveSize=size)
            if turn == 0:
                continue  # kernels, preparation
            pictures.add(picture.tobytes())
            if size not in best or statistics["time"]["render"] < best[size]["time"]["render"]:
                best[size] = statistics
    return best, len(pictures) == 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stage")
    parser.add_argument("--camera", default="")
    parser.add_argument("--imageWidth", type=int, default=480)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    scene = Scene(arguments.stage, arguments.camera, imageWidth=arguments.imageWidth)
    best, isSame = Measure(scene, arguments.samples, arguments.runs)
    least = min(s["time"]["render"] for s in best.values())
    print("| wave size | render s | ratio | trace s | shade s | path state MB |")
    print("|---|---|---|---|---|---|")
    for size, s in best.items():
        t = s["time"]
        print(f"| {size} | {t['render']:.2f} | {t['render'] / least:.3f} | {t['trace']:.2f} | {t['shade']:.2f} | "
              f"{s['memory']['pathState'] / 2**20:.1f} |")
    print("same bits" if isSame else "DIFFERENT BITS")
    return 0 if isSame else 1


if __name__ == "__main__":
    sys.exit(main())
