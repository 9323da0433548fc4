# SPDX-License-Identifier: Apache-2.0
"""Renderers of one stage by turns: relMSE times CPU seconds of the first, "here", over each other's."""

import os

import numpy as np

import rivalsLadder


def Compare(name: str, renderers: dict, job: dict, args) -> None:
    """Renders each by turns and prints a line for each; closes them. Errors are against a reference of the renderer's own, "before"
    against that of "here". renderers: name -> what has Render(samples, seed), the picture and its CPU seconds, and Close()."""
    halves = {}
    for who, renderer in renderers.items():
        renderer.Render(args.samples, 998)
        halves[who] = [renderer.Render(args.reference // 2, seed)[0] for seed in (101, 102)]  # `before` too: it leaves what it has built
    halves["before"] = halves["here"]
    figures = {who: [] for who in renderers}
    for repeat in range(args.repeats):
        for who, renderer in renderers.items():
            picture, seconds = renderer.Render(args.samples, 1 + repeat)
            figures[who].append((seconds, *rivalsLadder.Errors(picture, halves[who])))
    print(f"\n{name}: {args.samples} samples, {job['width']} x {job['height']}, load {os.getloadavg()[0]:.1f}")
    here = np.array(figures["here"])
    for who, rows in figures.items():
        rows = np.array(rows)
        cells = [f"{np.median(rows[:, 0]):.2f} s", f"relMSE {rows[:, 1].mean():.3e}", f"trimmed {rows[:, 2].mean():.3e}"]
        ratios = here[:, 0] / rows[:, 0]
        cells.append(f"here/it: seconds {np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})")
        cells += [f"{what} {np.mean(here[:, i]) / np.mean(rows[:, i]):.2f}" for i, what in ((1, "relMSE"), (2, "trimmed"))]
        cells += [f"product {np.median(ratios) * here[:, i].mean() / rows[:, i].mean():.2f}" for i in (1, 2)]
        print(f"  {who:8}" + "  ".join(cells) + f"  mean {np.mean(halves[who]):.4f}", flush=True)
    for renderer in renderers.values():
        renderer.Close()
