# SPDX-License-Identifier: Apache-2.0
"""Time of a resident render against the wave size, as ratios to the fastest in the same run.

    waveSize.py STAGE [--camera NAME] [--imageWidth N] [--samples N] [--runs N]

Sizes are interleaved over the runs and the least time of each counts, so that a noisy machine treats all
alike. All pictures must have the same bits. Run with PYTHONPATH=build/release/python.
"""

import argparse
import json
import subprocess
import sys
import tempfile

_SIZES = [1 << k for k in range(10, 21)]


def RenderOnce(arguments, size: int, folder: str) -> tuple[dict, bytes]:
    picture, statistics = f"{folder}/{size}.exr", f"{folder}/{size}.json"
    command = [sys.executable, "-m", "hdstream", "record", arguments.stage, picture, "--quiet", "--stats", statistics,
               "--imageWidth", str(arguments.imageWidth), "--samples", str(arguments.samples), "--waveSize", str(size)]
    if arguments.camera:
        command += ["--camera", arguments.camera]
    subprocess.run(command, check=True, capture_output=True)
    with open(statistics) as file, open(picture, "rb") as image:
        return json.load(file), image.read()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stage")
    parser.add_argument("--camera")
    parser.add_argument("--imageWidth", type=int, default=480)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    best, pictures = {}, set()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.runs):
            for size in _SIZES:
                statistics, picture = RenderOnce(arguments, size, folder)
                pictures.add(picture)
                if size not in best or statistics["time"]["render"] < best[size]["time"]["render"]:
                    best[size] = statistics
    least = min(s["time"]["render"] for s in best.values())
    print("| wave size | render s | ratio | trace s | shade s | path state MB |")
    print("|---|---|---|---|---|---|")
    for size, s in best.items():
        t = s["time"]
        print(f"| {size} | {t['render']:.2f} | {t['render'] / least:.3f} | {t['trace']:.2f} | {t['shade']:.2f} | "
              f"{s['memory']['pathState'] / 2**20:.1f} |")
    print("same bits" if len(pictures) == 1 else "DIFFERENT BITS")
    return 0 if len(pictures) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
