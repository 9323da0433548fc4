# SPDX-License-Identifier: Apache-2.0
"""Renders every stage below a folder and pastes the pictures together: realScenes.py FOLDER OUT.

Each stage runs in a process of its own, so a crash is seen and the rest goes on. Prints a line a stage
(exit code, seconds, the last line of stderr) and writes OUT/report.txt, OUT/<n>.png and OUT/sheet<k>.png.
Exit code 1 when any process died by a signal or printed a Python traceback.
Needs numpy and, to paste, OpenImageIO's oiiotool.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import time

_COLUMNS, _ROWS = 8, 6
_WIDTH, _HEIGHT = 200, 150


def FindStages(folder: pathlib.Path) -> list[pathlib.Path]:
    return sorted(p for p in folder.rglob("*") if p.suffix in {".usd", ".usda", ".usdc", ".usdz"})


def RenderStage(stage: pathlib.Path, picture: pathlib.Path, options: list[str]) -> tuple[int, float, str]:
    command = [sys.executable, "-m", "hdstream", "record", str(stage), str(picture), "--imageWidth", str(_WIDTH),
               "--imageHeight", str(_HEIGHT), "--quiet", *options]
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
    return done.returncode, time.monotonic() - start, done.stderr


def PasteSheets(pictures: list[pathlib.Path], out: pathlib.Path) -> None:
    perSheet = _COLUMNS * _ROWS
    for sheet, first in enumerate(range(0, len(pictures), perSheet)):
        group = [str(p) for p in pictures[first : first + perSheet]]
        subprocess.run(["oiiotool", *group, f"--mosaic:pad=2", f"{_COLUMNS}x{-(-len(group) // _COLUMNS)}",
                        "-o", str(out / f"sheet{sheet}.png")], check=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--samples", default="8")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    os.environ["PYTHONFAULTHANDLER"] = "1"
    numBad, lines, pictures = 0, [], []
    for number, stage in enumerate(FindStages(arguments.folder)):
        picture = arguments.out / f"{number:03d}.png"
        picture.unlink(missing_ok=True)
        code, seconds, stderr = RenderStage(stage, picture, ["--samples", arguments.samples])
        isBad = code not in (0, 1, 2) or "Traceback" in stderr or "internal error" in stderr
        numBad += isBad
        last = stderr.strip().splitlines()[-1] if stderr.strip() else ""
        line = f"{number:03d} {'BAD ' if isBad else ''}exit {code} {seconds:6.1f} s {stage.relative_to(arguments.folder)} | {last}"
        print(line, flush=True)
        lines.append(line)
        if picture.exists():
            pictures.append(picture)
    (arguments.out / "report.txt").write_text("\n".join(lines) + "\n")
    PasteSheets(pictures, arguments.out)
    print(f"{len(lines)} stages, {len(pictures)} pictures, {numBad} bad")
    return 1 if numBad else 0


if __name__ == "__main__":
    sys.exit(main())
