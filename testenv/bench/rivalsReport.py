# SPDX-License-Identifier: Apache-2.0
"""What was measured of renderers on a stage, as tables, CSV, charts and pictures beside each other."""

import csv
import pathlib

import numpy as np

import rivalsLadder
from rivalsLadder import Ladder, Ratio
from stages import imageFile
from support.svgChart import Chart

_GAP = 4  # pixels between two pictures


def _Row(cells) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _Number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _Median(values: list | None) -> float | None:
    return None if values is None else float(np.median(values))


def _Interval(ratio: tuple | None) -> str:
    """Median (least to largest)."""
    return "-" if ratio is None else f"{ratio[0]:.2f} ({ratio[1]:.2f} to {ratio[2]:.2f})"


def _Title(text: str) -> str:
    return "\n" + text + "\n"


def PrintStage(name: str, results: list, errors: list) -> None:
    """Tables of one stage. The first result is what ratios are of."""
    mine = results[0]
    print(_Title(f"{name}: seconds to a relMSE, medians; -: not within twice the samples of the highest rung"))
    head = ["renderer", "Msamples/s", *(f"{what} to {error:g}" for error in errors for what in ("samples", "s", "s of sampling")),
            "first pixel s", "of it building", "fixed s a render", "peak MB"]
    print(_Row(head) + "\n" + "|---" * len(head) + "|")
    for result in results:
        ladder = result.ladder
        cells = [result.renderer, f"{result.pixels / np.median(ladder.perSample) / 1e6:.3f}"]
        for error in errors:
            cells += [_Number(value) for value in (ladder.SamplesTo(error), _Median(ladder.SecondsTo(error)),
                                                   _Median(ladder.SamplingSecondsTo(error)))]
        cells += [f"{result.FirstPixelSeconds():.2f}", f"{result.worker['buildSeconds']:.2f}", f"{np.median(ladder.fixed):.2f}",
                  f"{result.worker['peakBytes'] / 1e6:.0f}"]
        print(_Row(cells))
    print(_Title(f"{name}: rungs, relMSE (without the worst 0.1 % of pixels), seconds as measured, medians"))
    for result in results:
        rungs = zip(result.ladder.samples, result.ladder.errors, result.trimmed, np.median(result.ladder.seconds, 0))
        print(f"* {result.renderer}: " + ", ".join(f"{n}: {e:.3g} ({t:.3g}) {s:.2f} s" for n, e, t, s in rungs))
    print(_Title(f"{name}: references, {mine.renderer} against the others; noise is that of the reference itself"))
    print(_Row(["renderer", "mean radiance", "ratio of means", "relMSE of the difference", "noise"]) + "\n" + "|---" * 5 + "|")
    for result in results:
        a, b = result.reference
        ratio, difference = rivalsLadder.Bias(mine.reference, result.reference)
        noise = np.mean((a - b) ** 2 / 4 / (((a + b) / 2) ** 2 + 0.01))
        print(_Row([result.renderer, f"{(a + b).mean() / 2:.5f}", f"{ratio:.4f}", f"{max(difference, 0):.2e}", f"{noise:.1e}"]), flush=True)


def Save(name: str, results: list, out: pathlib.Path) -> None:
    """NAME.svg with NAME.csv (the curves, seconds as measured), NAME-sheet.png (the references in the order of the results)."""
    chart = Chart(f"{name}: error against time", "seconds", "relMSE")
    for result in results:
        chart.Add(result.renderer, np.median(result.ladder.seconds, 0).tolist(), result.ladder.errors)
    chart.Save(out / f"rivals-{name}")
    pictures = {}
    for result in results:  # modes of hdStream have the same bits
        drawnBy = "hdstream" if result.renderer.startswith("hdstream") else result.renderer
        pictures.setdefault(drawnBy, sum(result.reference) / 2)
    SaveSheet(list(pictures.values()), out / f"rivals-{name}-sheet.png")


def SaveSheet(pictures: list, path) -> None:
    """Linear pictures beside each other, in sRGB."""
    strips = []
    for picture in pictures:
        linear = np.clip(picture, 0, 1)
        coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        strips += [np.round(255 * coded).astype(np.uint8), np.full((picture.shape[0], _GAP, 3), 255, np.uint8)]
    imageFile.WritePng(path, np.concatenate(strips[:-1], 1))


def SaveTable(rows: list, path) -> None:
    """The rungs of all stages as CSV: rows of (stage, result)."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["stage", "renderer", "repeat", "samples", "seconds", "relMSE", "relMSE trimmed", "build seconds",
                         "first render seconds", "peak bytes"])
        for stage, result in rows:
            ladder, worker = result.ladder, result.worker
            for repeat, seconds in enumerate(ladder.seconds):
                for rung in zip(ladder.samples, seconds, ladder.errors, result.trimmed):
                    writer.writerow([stage, result.renderer, repeat, *(f"{v:.6g}" for v in rung), f"{worker['buildSeconds']:.6g}",
                                     f"{worker['firstSeconds']:.6g}", worker["peakBytes"]])


def PrintSummary(rows: list, error: float) -> None:
    """Ratios of equal-error seconds, one row a stage: of sampling alone, and as measured."""
    renderers = list(dict.fromkeys(result.renderer for _, result in rows))
    for what, seconds in (("seconds of sampling, without what a render costs by itself", Ladder.SamplingSecondsTo),
                          ("seconds as measured", Ladder.SecondsTo)):
        print(_Title(f"{renderers[0]} / the others at relMSE {error:g} (below 1: {renderers[0]} is faster), {what}: "
                     "median (least to largest) of the repeats"))
        print(_Row(["stage", *renderers[1:]]) + "\n" + "|---" * len(renderers) + "|")
        for stage in dict.fromkeys(stage for stage, _ in rows):
            own = {result.renderer: seconds(result.ladder, error) for at, result in rows if at == stage}
            print(_Row([stage, *(_Interval(Ratio(own.get(renderers[0]), own.get(other))) for other in renderers[1:])]))
