# SPDX-License-Identifier: Apache-2.0
"""Renders the stages of OpenUSD's own usdImagingGL tests and puts them beside OpenUSD's pictures:
usdImagingGLStages.py SOURCE OUT [--renderer NAME] [--only TEXT] [--samples N]

SOURCE is the folder pxr/usdImaging/usdImagingGL of an OpenUSD source tree. Its CMakeLists.txt says which stages
are drawn, with which arguments, and which baseline pictures they must match; testenv/hydra/engineScript.py draws
them in the same way. Writes OUT/NAME.png, OUT/results.csv (exit codes and messages) and contact sheets: baseline | ours,
with the names in a text file each. What Storm's pictures are about and ours are not (shading styles, ambient light) is for the eye that
looks at them: docs/hydra-usdImagingGL.md has what was seen.
Needs OpenUSD with imaging, its PySide6 and PyOpenGL, xvfb-run and oiiotool.
"""

import argparse
import concurrent.futures
import csv
import json
import pathlib
import re
import subprocess
import sys
from dataclasses import dataclass

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTENV / "hydra"), str(TESTENV)]

from openUsd import FindOpenUsd, FindPlugin, RunProgram  # noqa: E402

_PROGRAM = "testUsdImagingGLBasicDrawing"
# Volumes are not this renderer's, and builds without bindless textures draw the same stages once more.
_LEFT_OUT = ("Volume", "NonBindless")
_NOT_OURS = {"wire", "points"}  # -shading: no surfaces
_MAX_VIEWS = 4  # of a stage with many time codes
_FULL = (640, 480)
_HALF = (320, 240)
_COLUMNS, _ROWS = 3, 5


@dataclass
class Test:
    """One registered test."""

    name: str
    folder: pathlib.Path
    arguments: list
    baselines: list
    usesSceneIndex: bool

    @property
    def size(self) -> tuple[int, int]:
        """Windows are in pixels of the full size; all else can be drawn smaller."""
        if "-dataWindow" in self.arguments or "-displayWindow" in self.arguments:
            return _FULL
        return _HALF


def ReadTests(source: pathlib.Path) -> list[Test]:
    text = (source / "CMakeLists.txt").read_text()
    tests = []
    for body in text.split("pxr_register_test(")[1:]:
        name = body.split(None, 1)[0]
        words = re.search(r'COMMAND "(.*?)"', body, re.S).group(1).split()
        comparison = re.search(r"IMAGE_DIFF_COMPARE((?:\s+\S+\.png)+)", body)
        if pathlib.Path(words[0]).name != _PROGRAM or not comparison or any(text in name for text in _LEFT_OUT):
            continue
        if "-shading" in words and words[words.index("-shading") + 1] in _NOT_OURS:
            continue
        folder = re.search(r"TESTENV (\w+)", body)
        folder = source / "testenv" / (folder.group(1) if folder else name).replace("_SceneIndex", "")
        baselines = [folder / "baseline" / picture for picture in comparison.group(1).split()][:_MAX_VIEWS]
        _KeepTimesOf(baselines, words)
        tests.append(Test(name, folder, words[1:], baselines, "ENABLE_SCENE_INDEX=1" in body or "SCENE_INDEX=true" in body))
    return tests


def _KeepTimesOf(baselines: list[pathlib.Path], words: list[str]) -> None:
    """Leaves in the arguments the time codes whose pictures are compared: name_001.png is that of time 1."""
    if "-times" not in words:
        return
    first = words.index("-times") + 1
    end = next((index for index in range(first, len(words)) if words[index][:2].strip("-").isalpha()), len(words))
    compared = [path.stem.rsplit("_", 1)[1] for path in baselines]
    words[first:end] = [time for time in words[first:end] if time.rjust(3, "0") in compared]


class Runner:
    def __init__(self, out: pathlib.Path, renderer: str, samples: int):
        self.out = out.resolve()
        self.renderer = renderer
        self.samples = samples
        self.openUsd, reason = FindOpenUsd()
        self.plugin, pluginReason = FindPlugin()
        if not self.openUsd or (not self.plugin and renderer == "Stream"):
            raise SystemExit(reason or pluginReason)

    def Run(self, test: Test) -> dict:
        pictures = [self.out / f"{test.name}_{index}.png" for index in range(len(test.baselines))]
        row = {"test": test.name, "pictures": len(pictures), "exit": "", "messages": ""}
        done = self.out / f"{test.name}.json"
        if done.exists():
            return json.loads(done.read_text())
        job = self.out / f"{test.name}.job"
        job.write_text(json.dumps({"arguments": test.arguments, "size": test.size, "samples": self.samples,
                                   "renderer": self.renderer, "pictures": [str(picture) for picture in pictures]}))
        more = {"USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX": "1"} if test.usesSceneIndex else {}
        result = RunProgram(["xvfb-run", "-a", self.openUsd.python, TESTENV / "hydra" / "engineScript.py", job],
                            self.openUsd.Environment(self.plugin, **more), 300, cwd=test.folder)
        lines = [line for line in result.output.splitlines() if "Error" in line or "hdStream" in line]
        row.update(exit=result.code, messages=" / ".join(dict.fromkeys(lines))[:500])
        (self.out / f"{test.name}.log").write_text(result.output)
        done.write_text(json.dumps(row))
        print(f"exit {result.code} {test.name} {row['messages'][:160]}", flush=True)
        return row

    def WriteSheets(self, tests: list[Test]) -> None:
        """sheetNN.png: baseline | ours, in rows; sheetNN.txt names the pairs in the same order."""
        pairs = []
        for test in tests:
            for index, baseline in enumerate(test.baselines):
                name = f"{test.name}_{index}"
                tiles = [self._Tile(baseline, self.out / f"{name}.baseline.tile.png"),
                         self._Tile(self.out / f"{name}.png", self.out / f"{name}.tile.png")]
                pairs.append((name.replace("testUsdImagingGL", ""), tiles))
        perSheet = _COLUMNS * _ROWS
        for sheet, first in enumerate(range(0, len(pairs), perSheet)):
            group = pairs[first:first + perSheet]
            rows = -(-len(group) // _COLUMNS)
            subprocess.run(["oiiotool", *(tile for _, tiles in group for tile in tiles), "--mosaic:pad=3",
                            f"{2 * _COLUMNS}x{rows}", "-o", str(self.out / f"sheet{sheet:02d}.png")], check=True)
            names = [name for name, _ in group]
            (self.out / f"sheet{sheet:02d}.txt").write_text("".join(
                " | ".join(names[row * _COLUMNS:(row + 1) * _COLUMNS]) + "\n" for row in range(rows)))

    @staticmethod
    def _Tile(path: pathlib.Path, out: pathlib.Path) -> str:
        """The picture at the size of all tiles; black when there is none."""
        size = f"{_HALF[0]}x{_HALF[1]}"
        source = [str(path), "--ch", "R,G,B", "--fit", size] if path.exists() else ["--create", size, "3"]
        subprocess.run(["oiiotool", *source, "-o", str(out)], check=True)
        return str(out)


def Main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--renderer", default="Stream")
    parser.add_argument("--only", default="", help="tests whose name contains the text")
    parser.add_argument("--samples", type=int, default=16)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    runner = Runner(options.out, options.renderer, options.samples)
    tests = [test for test in ReadTests(options.source) if options.only in test.name]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(runner.Run, tests))
    with open(options.out / "results.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, ("test", "pictures", "exit", "messages"))
        writer.writeheader()
        writer.writerows(rows)
    runner.WriteSheets(tests)
    numBad = sum(row["exit"] != 0 for row in rows)
    print(f"{len(rows)} tests, {numBad} with a bad end")
    return 1 if numBad else 0


if __name__ == "__main__":
    sys.exit(Main())
