# SPDX-License-Identifier: Apache-2.0
"""Stages made by others, drawn by hdStream, Cycles and Mitsuba side by side: comparison.py SCENES OUT [--only TEXT].

Every stage gets one camera, its own or one that frames it, and one light where it has none. hdStream reads the stage, Blender
imports it with its own reader (its lights and camera are ours, since its import changes energies), Mitsuba is handed the
plain scene of rivalsScene.py, which refuses with a line what it cannot say. Each renderer works in a process of its own, and
goes on with the next stage when it fails.

Writes OUT/GROUP.png, a sheet with a row a stage and a column a renderer, tone-mapped alike, and OUT/comparison.csv: mean
luminance of each, its ratio to hdStream's, and the block error, the relative RMS difference of the means of 8 x 8 pixels.
Explained in docs/comparison.md.

Needs, in this Python: hdstream on the path, usd-core, bpy and mitsuba (docs/performance.md), and oiiotool for the sheets.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
from dataclasses import asdict, dataclass

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

import numpy as np  # noqa: E402

RENDERERS = ("hdstream", "cycles", "mitsuba")
_BLOCK = 8
_SCHEMA = "usdwg/schemaTests/usdGeom/"
_CARS = "usdwg/Vehicles/USD_Mini_Car_Kit/assets/"
# Group -> files, each with its camera or none. Parts of assets and stages that are meant to fail to open are left out.
STAGES = {
    "scenes": [("coffee/coffee.usdc", "/World/camera"), ("bookstore/bookstore.usda", "/World/camera1_0"),
               ("chess/chess_preview.usda", "/Lights/camera"), ("chess/chess_set.usda", ""),
               ("ycb/ycb.usda", "/World/close")],
    "luxtest": [(f"luxtest/usd/{name}.usda", "/cameras/camera1") for name in ("rect", "sphere", "distant", "dome")],
    "materials": [("usdwg/RoughnessTest/RoughnessTest.usdz", ""), ("usdwg/Teapot/Teapot.usd", ""),
                  ("usdwg/Teapot/Teapot_Materials.usd", ""), ("usdwg/TextureCoordinateTest/TextureCoordinateTest.usda", ""),
                  ("usdwg/TextureCoordinateTest/TextureCoordinateTestMaterialX.usda", ""),
                  ("usdwg/TextureTransformTest/TextureTransformTest.usd", ""),
                  ("usdwg/TextureFileFormatTests/all_files.usda", ""), ("usdwg/primvar_interpolation.usda", "")],
    "meshes": [(f"{_SCHEMA}meshes/{name}.usda", "") for name in (
        "5_face/5_face", "doubleSided/doubleSided_quad", "mixed_faceVertexCounts/mixed", "normals_types/normalsTypes",
        "points_types/pointsTypes", "quad_mesh/quads", "singleSided/singleSided", "subdiv_bilinear/subdiv_bilinear",
        "subdiv_catmullClark/subdiv_catmullClark", "subdiv_loop_quads/subdiv_loop_quads",
        "subdiv_loop_triangles/subdiv_loop_triangles", "subdiv_none/subdiv_none", "triangled_mesh/triangles")],
    "shapes": [(f"{_SCHEMA}primitives/{name}.usda", "") for name in ("all_primitives", "capsule", "cone", "cube", "cylinder", "sphere")]
    + [(f"{_SCHEMA}transforms/{name}.usda", "") for name in (
        "complex_transform", "matrix_transform", "scopes_and_xforms_nested", "simple_transform", "weird_matrix_transform",
        "xforms_nested")],
    "cars": [(f"{_CARS}vehicles/vehicleVariants.usda", ""), (f"{_CARS}wheels/wheelVariants.usda", "")]
    + [(f"{_CARS}vehicles/{name}/asset/{name}FullAsset.usda", "") for name in (
        "4wd", "ambulance", "formula", "sedan", "tractor", "truckFlat", "van")],
}


@dataclass
class Entry:
    """A stage to draw; `stage` is the file with camera and light added."""

    group: str
    name: str
    stage: str
    camera: str
    width: int
    height: int


def _Luminance(picture: np.ndarray) -> float:
    return float((picture @ [0.2126, 0.7152, 0.0722]).mean())


def BlockError(a: np.ndarray, b: np.ndarray) -> float:
    """Relative RMS difference of block means: sqrt(mean((a - b)^2) / mean(((a + b) / 2)^2))."""
    def Blocks(picture):
        rows, columns = (n // _BLOCK * _BLOCK for n in picture.shape[:2])
        return picture[:rows, :columns].reshape(rows // _BLOCK, _BLOCK, columns // _BLOCK, _BLOCK, 3).mean((1, 3))

    x, y = Blocks(a), Blocks(b)
    return float(np.sqrt(np.mean((x - y) ** 2) / max(np.mean(((x + y) / 2) ** 2), 1e-12)))


def _Run(renderer: str, entries: list, out: pathlib.Path, samples: int, threads: int) -> dict:
    """{number of an entry: what went wrong}; the pictures are OUT/pictures/<number>-<renderer>.npy."""
    wrong, first = {}, 0
    while first < len(entries):
        job = out / f"{renderer}.json"
        job.write_text(json.dumps(dict(renderer=renderer, samples=samples, threads=threads, out=str(out / "pictures"), first=first,
                                       entries=[asdict(entry) for entry in entries])))
        run = subprocess.run([sys.executable, str(HERE / "comparisonWorker.py"), str(job)], stdout=subprocess.PIPE,
                             stderr=subprocess.DEVNULL, text=True)
        reached = first - 1
        for line in run.stdout.splitlines():
            if line.startswith("ENTRY "):
                reached, text = json.loads(line.removeprefix("ENTRY "))
                if text:
                    wrong[reached] = text
        if reached < len(entries) - 1:  # it died in the one behind
            wrong[reached + 1] = f"the process ended with {run.returncode}"
        first = reached + 2 if reached < len(entries) - 1 else len(entries)
    return wrong


def _Sheet(group: str, rows: list, out: pathlib.Path) -> None:
    """A row a stage: the renderers' pictures with one exposure, grey where there is none."""
    from stages import imageFile

    strips = []
    for pictures in rows:
        known = next(p for p in pictures if p is not None)
        mean = np.mean([_Luminance(p) for p in pictures if p is not None])
        scale = 0.35 / mean if mean > 1e-9 else 1.0
        cells = [np.full(known.shape, 0.5) if p is None else np.clip(p * scale, 0, 1) ** (1 / 2.2) for p in pictures]
        strips.append(np.concatenate([np.pad(cell, ((2, 2), (2, 2), (0, 0))) for cell in cells], 1))
    width = max(strip.shape[1] for strip in strips)
    sheet = np.concatenate([np.pad(s, ((0, 0), (0, width - s.shape[1]), (0, 0))) for s in strips], 0)
    imageFile.WritePng(out / f"{group}.png", (255 * sheet + 0.5).astype(np.uint8))


def _Report(entries: list, wrong: dict, out: pathlib.Path) -> None:
    table, sheets = [], {}
    for number, entry in enumerate(entries):
        pictures = []
        for renderer in RENDERERS:
            path = out / "pictures" / f"{number}-{renderer}.npy"
            isThere = number not in wrong.get(renderer, {}) and path.exists()
            pictures.append(np.load(path).astype(np.float64) if isThere else None)
        own = pictures[0]
        for renderer, picture in zip(RENDERERS, pictures):
            text = wrong.get(renderer, {}).get(number, "")
            if picture is None:
                table.append([entry.group, entry.name, renderer, "", "", "", text or "not drawn"])
            else:
                ratio = _Luminance(picture) / _Luminance(own) if own is not None and _Luminance(own) > 0 else float("nan")
                error = BlockError(picture, own) if own is not None else float("nan")
                table.append([entry.group, entry.name, renderer, f"{_Luminance(picture):.4g}", f"{ratio:.3f}", f"{error:.3f}", ""])
        if any(p is not None for p in pictures):
            sheets.setdefault(entry.group, []).append(pictures)
    with open(out / "comparison.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["group", "stage", "renderer", "luminance", "ratio", "blockError", "message"])
        writer.writerows(table)
    for group, rows in sheets.items():
        _Sheet(group, rows, out)
    for row in table:
        print(" ".join(f"{cell:>10}" if i > 1 else f"{cell:<34}" for i, cell in enumerate(row[1:], 1)))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", default="", help="stages whose group or file has one of these texts, with commas between")
    parser.add_argument("--renderers", default=",".join(RENDERERS))
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    import comparisonStage

    (options.out / "pictures").mkdir(parents=True, exist_ok=True)
    entries = []
    for group, files in STAGES.items():
        for file, camera in files:
            if any(text in f"{group}/{file}" for text in options.only.split(",")) and (options.scenes / file).exists():
                entries.append(Entry(group, file, *comparisonStage.Write(options.scenes / file, camera, options.width, options.out,
                                                                         len(entries))))
    if not entries:
        print(f"comparison.py: no stage below {options.scenes} has '{options.only}' in its name", file=sys.stderr)
        return 2
    wrong = {}
    for renderer in options.renderers.split(","):
        print(f"{renderer} ...", file=sys.stderr, flush=True)
        wrong[renderer] = _Run(renderer, entries, options.out, options.samples, options.threads)
    _Report(entries, wrong, options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
