# SPDX-License-Identifier: Apache-2.0
"""What bounds on fireflies, and shadows of glass, bring and cost: noise, bias and time of a stage under each of them.

    python testenv/bench/fireflies.py STAGE [--camera PATH] [--width 160] [--samples 16] [--seeds 8] [--reference 4096] [--rows NAME,...]

Every row renders the stage with all seeds, in turn with the other rows. The error is the mean over pixels and channels of
the squared difference to a render of many samples without bounds, over the square of that plus 0.01 (relMSE): `error` of a
picture of one seed, `bias` of the mean of all seeds less what of it is noise, `noise` the rest. `mean`: of the picture over
the reference's. Seconds: `time.render` of one picture, the median.
"""

import argparse
import statistics

import numpy as np

import hdstream

ROWS = {
    "none": {},
    "clampIndirect 10": dict(clampIndirect=10.0),
    "clampIndirect 1": dict(clampIndirect=1.0),
    "clampIndirect 0.3": dict(clampIndirect=0.3),
    "clampDirect 1, clampIndirect 1": dict(clampDirect=1.0, clampIndirect=1.0),
    "filterGlossy 0.1": dict(filterGlossy=0.1),
    "filterGlossy 1": dict(filterGlossy=1.0),
    "maxGlossyDepth 1": dict(maxGlossyDepth=1),
    "maxDiffuseDepth 2": dict(maxDiffuseDepth=2),
    "glassShadows": dict(glassShadows=True),
}


def Color(renderer, options, **settings):
    image = renderer.Render(**options, **settings)
    return image.aovs["color"][..., :3].astype(np.float64), image.statistics["time"]["render"]


def Measure(renderer, options, samples, seeds, reference):
    """(name, error, bias, noise, mean, seconds) of each row."""
    wanted, _ = Color(renderer, options, samples=reference, seed=1 << 20)
    pictures = {name: [] for name in ROWS}
    for seed in range(seeds + 1):
        for name, settings in ROWS.items():
            made = Color(renderer, options, samples=samples, seed=seed, **settings)
            if seed > 0:  # the first compiles kernels
                pictures[name].append(made)
    weight = 1.0 / (wanted**2 + 0.01)
    for name, made in pictures.items():
        colors = np.array([color for color, _ in made])
        noise = (weight * colors.var(0, ddof=1)).mean()
        bias = (weight * (colors.mean(0) - wanted) ** 2).mean() - noise / seeds
        error = np.mean([(weight * (color - wanted) ** 2).mean() for color in colors])
        yield name, error, bias, noise, colors.mean() / wanted.mean(), statistics.median(seconds for _, seconds in made)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("--camera", default="")
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--reference", type=int, default=4096, help="samples of the reference")
    parser.add_argument("--rows", help="names, with commas between them; all")
    args = parser.parse_args()
    for name in set(ROWS) - set(args.rows.split(",") if args.rows else ROWS):
        del ROWS[name]
    options = dict(imageWidth=args.width, pixelFilter="box", pixelFilterWidth=1.0)
    if args.camera:
        options["camera"] = args.camera
    print("| bound | error | bias | noise | mean | seconds |\n|---|---|---|---|---|---|")
    for name, error, bias, noise, mean, seconds in Measure(hdstream.Renderer(args.stage), options, args.samples, args.seeds, args.reference):
        print(f"| {name} | {error:.2e} | {bias:.1e} | {noise:.2e} | {mean:.3f} | {seconds:.2f} |", flush=True)


if __name__ == "__main__":
    main()
