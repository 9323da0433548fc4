# SPDX-License-Identifier: Apache-2.0
"""Time of streamed textures over resident ones: textureCost.py STAGE CAMERA [--samples 64] [--budgets 10%,1%]

One process, modes take turns: `resident` has all lines, `100 %` and the budgets stream them; each of those begins with an
empty pool, `warm` is a second render with a pool of 100 %. Least of the repeats, without preparing and compiling. Geometry is
resident in all of them (`auto` with `prepare eager`, which streams textures alone where geometry fits).
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.sceneRun import Scene  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("camera")
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--budgets", type=lambda text: text.split(","), default=["10%", "1%"])
    args = parser.parse_args()
    scene = Scene(args.stage, args.camera, imageWidth=args.width)
    streamed = lambda budget: dict(residency="auto", prepare="eager", textureMemory=budget)
    modes = {"resident": dict(residency="resident"), "100 %": streamed("100%"), "warm": streamed("100%"),
             **{budget: streamed(budget) for budget in args.budgets}}
    seconds, textures = {name: [] for name in modes}, {}
    for turn in range(args.repeats + 1):
        for name, settings in modes.items():
            if name == "warm":
                scene.Render(args.samples, **settings)
            _, statistics = scene.Render(args.samples, **settings)
            time, textures[name] = statistics["time"], statistics["texture"]
            if turn > 0:  # the first prepares and compiles
                seconds[name].append((time["render"] - time["prepare"] - time["compile"], time["shade"]))
    least = {name: tuple(map(min, zip(*values))) for name, values in seconds.items()}
    print("| textures | render s | over resident | shade over resident | lines loaded | MB uploaded | misses per texel read |")
    print("|---" * 7 + "|")
    for name, (render, shade) in least.items():
        texture = textures[name]
        print(f"| {name} | {render:.2f} | {render / least['resident'][0]:.3f} | "
              f"{shade / least['resident'][1]:.3f} | {texture['linesLoaded']} | {texture['uploadedBytes'] / 1e6:.1f} | "
              f"{texture['misses'] / max(1, texture['lookups']):.1e} |")


if __name__ == "__main__":
    main()
