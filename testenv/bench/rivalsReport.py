# SPDX-License-Identifier: Apache-2.0
"""What was measured of renderers on a stage, as tables, CSV, charts and pictures beside each other."""

import csv
import pathlib

import numpy as np

import rivalsMeasure
from stages import imageFile
from support.svgChart import Chart

_GAP = 4  # pixels between two pictures


def _Row(cells) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _Seconds(result, error: float) -> str:
    return ("~" if result.IsFarFrom(error) else "") + f"{result.SecondsTo(error):.3g}"


def _Title(text: str) -> str:
    return "\n" + text + "\n"


def PrintStage(name: str, results: list, errors: list) -> None:
    """Tables of one stage. The first result is what ratios are of."""
    mine = results[0]
    print(_Title(f"{name}: equal-error seconds; ratio = {mine.renderer} / this one (below 1: {mine.renderer} is faster); "
                 "~: more than 4 times outside of the ladder"))
    head = ["renderer", "Msamples/s", "relMSE at 1 sample", "power"]
    head += [f"{what} {error:g}" for error in errors for what in ("s to", "ratio at")]
    head += ["first pixel s", "of it building", "fixed s a render", "peak MB"]
    print(_Row(head) + "\n" + "|---" * len(head) + "|")
    for result in results:
        cells = [result.renderer, f"{result.pixels / result.perSample / 1e6:.3f}", f"{result.factor:.4g}", f"{result.power:.2f}"]
        for error in errors:
            cells += [_Seconds(result, error), f"{mine.SecondsTo(error) / result.SecondsTo(error):.2f}"]
        cells += [f"{result.FirstPixelSeconds():.2f}", f"{result.worker['buildSeconds']:.2f}", f"{result.fixed:.2f}",
                  f"{result.worker['peakBytes'] / 1e6:.0f}"]
        print(_Row(cells))
    print(_Title(f"{name}: rungs, relMSE (without the worst 0.1 % of pixels), seconds as measured"))
    print(_Row(["renderer", *("samples: relMSE, seconds" for _ in mine.samples)]) + "\n" + "|---" * (1 + len(mine.samples)) + "|")
    for result in results:
        rungs = zip(result.samples, result.errors, result.trimmed, result.seconds)
        print(_Row([result.renderer, *(f"{n}: {e:.3g} ({t:.3g}) {s:.2f} s" for n, e, t, s in rungs)]))
    print(_Title(f"{name}: references, {mine.renderer} against the others; noise is that of the reference itself"))
    print(_Row(["renderer", "mean radiance", "ratio of means", "relMSE of the difference", "noise"]) + "\n" + "|---" * 5 + "|")
    for result in results:
        a, b = result.reference
        ratio, difference = rivalsMeasure.Bias(mine.reference, result.reference)
        noise = np.mean((a - b) ** 2 / 4 / (((a + b) / 2) ** 2 + 0.01))
        print(_Row([result.renderer, f"{(a + b).mean() / 2:.5f}", f"{ratio:.4f}", f"{max(difference, 0):.2e}", f"{noise:.1e}"]), flush=True)


def Save(name: str, results: list, errors: list, out: pathlib.Path) -> None:
    """NAME.svg with NAME.csv (the curves), NAME-sheet.png (the references in the order of the results)."""
    chart = Chart(f"{name}: error against time", "seconds", "relMSE")
    for result in results:
        chart.Add(result.renderer, [n * result.perSample for n in result.samples], result.errors)
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


def SaveTable(rows: list, errors: list, path) -> None:
    """All stages as CSV: rows of (stage, result)."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["stage", "renderer", "samples", "seconds", "relMSE", "relMSE trimmed", "seconds a sample", "fixed seconds",
                         *(f"seconds to {error:g}" for error in errors), "build seconds", "first render seconds", "peak bytes"])
        for stage, result in rows:
            for rung in zip(result.samples, result.seconds, result.errors, result.trimmed):
                writer.writerow([stage, result.renderer, *(f"{v:.6g}" for v in rung), f"{result.perSample:.6g}", f"{result.fixed:.6g}",
                                 *(f"{result.SecondsTo(error):.6g}" for error in errors), f"{result.worker['buildSeconds']:.6g}",
                                 f"{result.worker['firstSeconds']:.6g}", result.worker["peakBytes"]])


def PrintSummary(rows: list, error: float) -> None:
    """Ratios of equal-error seconds, one row a stage."""
    renderers = list(dict.fromkeys(result.renderer for _, result in rows))
    print(_Title(f"equal-error seconds at relMSE {error:g}: {renderers[0]} / the others"))
    print(_Row(["stage", *renderers[1:]]) + "\n" + "|---" * len(renderers) + "|")
    for stage in dict.fromkeys(stage for stage, _ in rows):
        own = {result.renderer: result.SecondsTo(error) for at, result in rows if at == stage}
        if renderers[0] in own:
            print(_Row([stage, *(f"{own[renderers[0]] / own[r]:.2f}" if r in own else "-" for r in renderers[1:])]))
