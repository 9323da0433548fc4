# SPDX-License-Identifier: Apache-2.0
"""The wide form of the kernels' formulas (kernels/math/lanes.clh) beside the form of one path: seconds, and whether the bits are equal.

    wideForm.py STAGE... [--samples 48] [--imageWidth 640] [--repeats 3] [--lanes 0,8,16]

Renders each stage with kernels of each number of lanes, interleaved, after a run that makes them and prepares the stage: 0 is the form
of one path, 8 what is shipped. 16 needs no other text than the vectors' names and their members, and has no packets of camera rays.
Prints medians of `time.shade`, `time.trace` (with the rays that the camera sends) and `time.render`, each over that of the first
number of lanes, and the range of the quotients over the repeats. Geometry and textures are resident. Run it with PYTHONPATH=build/release/python on a quiet machine with a CPU as its device."""

import argparse
import pathlib
import re
import shutil
import statistics
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import Record  # noqa: E402

KERNELS = pathlib.Path(__file__).resolve().parents[2] / "kernels"
KEYS = ("shade", "trace", "render")


def MakeKernels(folder: pathlib.Path, lanes: int) -> pathlib.Path:
    """A copy of the kernels with another number of lanes."""
    shutil.copytree(KERNELS, folder)
    path = folder / "math/lanes.clh"
    text = path.read_text()
    changed = text.replace("#define HDS_WIDE (HDS_ITEMS_PER_WORK_ITEM >= HDS_LANES)", "#define HDS_WIDE 0") if lanes == 0 else \
        text.replace("#define HDS_LANES 8", f"#define HDS_LANES {lanes}")
    if lanes != 8 and changed == text:
        raise SystemExit(f"wideForm.py: {path} has not the text that is to be replaced")
    path.write_text(changed)
    if lanes not in (0, 8):
        for path in folder.rglob("*.cl*"):
            path.write_text(re.sub(r"\b((?:u?int|float|v(?:load|store)))8\b|(##)8\b", lambda m: f"{m[1] or m[2]}{lanes}",
                                   path.read_text()) if _IsWide(path) else path.read_text())
        _SpellOut(folder / "math/wideBegin.clh", "table[index.s7]", [f"table[index.s{lane:x}]" for lane in range(7, lanes)])
        _SpellOut(folder / "integrator/generate.cl", "6u, 7u", [f"{lane}u" for lane in range(6, lanes)])
        _TakePacketsOut(folder / "integrator/intersect.cl")
    return folder


def _SpellOut(path: pathlib.Path, last: str, more: list) -> None:
    """Lists of members have as many as there are lanes."""
    text = path.read_text()
    if last not in text:
        raise SystemExit(f"wideForm.py: {path} has not the text that is to be replaced")
    path.write_text(text.replace(last, ", ".join(more)))


def _TakePacketsOut(path: pathlib.Path) -> None:
    """Packets of camera rays have eight rays, whatever the number of lanes."""
    text = path.read_text()
    changed = text.replace("#define HDS_INTERSECT_PACKETS (HDS_FEATURE_FLAT && HDS_WIDE)", "#define HDS_INTERSECT_PACKETS 0")
    if changed == text:
        raise SystemExit(f"wideForm.py: {path} has not the text that is to be replaced")
    path.write_text(changed)


def _IsWide(path: pathlib.Path) -> bool:
    """Whether the file names vectors of as many lanes."""
    return path.name in ("lanes.clh", "wideBegin.clh", "wideEnd.clh", "shadeBatch.clh", "shadeHits.clh", "generate.cl")


def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", nargs="+", metavar="STAGE")
    parser.add_argument("--samples", type=int, default=48)
    parser.add_argument("--imageWidth", type=int, default=640)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--lanes", default="0,8")
    args = parser.parse_args()
    lanes = [int(number) for number in args.lanes.split(",")]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        kernels = {number: MakeKernels(folder / f"kernels{number}", number) for number in lanes}
        for stage in args.stages:
            _Compare(args, stage, kernels, folder / "cache")


def _Compare(args, stage, kernels: dict, cache) -> None:
    def Render(number: int, samples: int) -> dict:
        return Record(stage, cache, environment={"HDSTREAM_KERNEL_DIR": str(kernels[number])}, residency="resident", samples=samples,
                      imageWidth=args.imageWidth)

    for number in kernels:
        Render(number, 1)
    runs = {number: [] for number in kernels}
    for _ in range(args.repeats):
        for number in kernels:
            runs[number].append(Render(number, args.samples))
    pictures = {run["pictureBytes"] for values in runs.values() for run in values}
    first = next(iter(kernels))
    print(f"{stage}: {'equal bits' if len(pictures) == 1 else f'{len(pictures)} PICTURES DIFFER'}")
    for number, values in runs.items():
        cells = []
        for key in KEYS:
            ratios = [run["time"][key] / base["time"][key] for run, base in zip(values, runs[first])]
            median = statistics.median(run["time"][key] for run in values)
            cells.append(f"{key} {median:6.2f} s  {statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")
        print(f"  lanes {number:2}: " + "   ".join(cells), flush=True)


if __name__ == "__main__":
    Main()
