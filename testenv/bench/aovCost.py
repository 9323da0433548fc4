# SPDX-License-Identifier: Apache-2.0
"""What outputs cost: a stage rendered with and without each set of AOVs, in turn, in one process.

    python testenv/bench/aovCost.py STAGE [--width 480] [--samples 16] [--repeats 3] [--sets NAME,...]

Seconds are `time.render` and `time.transfer`: medians over the repeats, and their ratio to those of the first set. The first
render of each set, which compiles kernels and loads pages, is not counted.
"""

import argparse
import statistics

import hdstream

SETS = {
    "color": (),
    "first hits": ("depth", "normal", "position", "albedo", "primId"),
    "crypto_object": ("crypto_object",),
    "three Cryptomattes": ("crypto_object", "crypto_material", "crypto_instance"),
    "ambient occlusion": ("ambientOcclusion",),
    "one lpe": ("diffuse",),
    "four lobes": ("emission", "diffuse", "specular", "transmission"),
    "nine lpe": ("emission", "directDiffuse", "indirectDiffuse", "directSpecular", "indirectSpecular", "directTransmission",
                 "indirectTransmission", "direct", "indirect"),
}


def Measure(stage, width, samples, repeats, names, device=""):
    """{set: (seconds of render, bytes of path state)} by repeat."""
    renderers = {name: hdstream.Renderer(stage) for name in names}
    rows = {name: [] for name in names}
    for repeat in range(repeats + 1):
        for name in names:
            image = renderers[name].Render(aovs=["color", *SETS[name]], imageWidth=width, samples=samples, device=device)
            if repeat > 0:
                times = image.statistics["time"]
                rows[name].append((times["render"] + times["transfer"], image.statistics["memory"]["pathState"]))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stage")
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--device", default="")
    parser.add_argument("--sets", default=",".join(SETS))
    args = parser.parse_args()
    names = args.sets.split(",")
    rows = Measure(args.stage, args.width, args.samples, args.repeats, names, args.device)
    base = statistics.median(seconds for seconds, _ in rows[names[0]])
    print("| outputs beside color | seconds | over color | path state MB |")
    print("|---|---|---|---|")
    for name in names:
        seconds = sorted(value for value, _ in rows[name])
        median = statistics.median(seconds)
        print(f"| {name} | {median:.3f} ({seconds[0]:.3f} to {seconds[-1]:.3f}) | {median / base:.2f} | {rows[name][0][1] / 1e6:.1f} |")


if __name__ == "__main__":
    main()
