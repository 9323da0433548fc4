# SPDX-License-Identifier: Apache-2.0
"""Compares both front ends on every stage below a folder: hydraScenes.py FOLDER OUT [options]

For each stage, wrapped so that camera, size and settings are explicit (testenv/hydra/wrapperStage.py):
  scene     the dump of usd-core's translator against the one that the plug-in writes: equal, or a summary
  picture   `hdstream record` against `usdrecord --renderer Stream`, same seed: equal to the bit, or how not
  z-test    with --zSamples N: `record` with one seed against usdrecord with another; z of the difference of
            the mean luminance of 8x8 blocks. Its variance is the sum of both renders' own: the `variance` AOV
            of `record` at either seed, averaged over the block. (Usdrecord's seed is rendered by `record` too:
            its file has no variance.) A block passes within the |z| that 99.9 % of pictures stay below in
            all of their blocks (Sidak); the share of blocks with |z| <= 3, the largest |z| and the standard
            deviation of z stand beside it. Samples count as independent, which overstates the variance of
            stratified ones, so that a deviation below 1 is expected.
OUT gets results.csv, report.md, one folder a stage with dumps, pictures and outputs, and contact sheets
(record | usdrecord). Stages that are done are not done again. Each program runs in a process of its own under
a time limit, two stages at a time at most. Exit code 1 when a front end crashed or hung.
Needs OpenUSD with imaging (docs/hydra.md), the built plug-in and, for sheets, oiiotool.
"""

import argparse
import concurrent.futures
import csv
import json
import pathlib
import subprocess
import sys
import time

import numpy as np

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTENV / "bench"), str(TESTENV / "hydra"), str(TESTENV / "render"), str(TESTENV)]

from compare import Blocks, BlockZ, ZLimit  # noqa: E402
from frontEnds import MODES, CompareDumps, ComparePictures, FrontEnds, ReadColor  # noqa: E402
from hdstream.errors import CommandError  # noqa: E402
from openUsd import FindOpenUsd, FindPlugin, Result, RunProgram  # noqa: E402
from realScenes import FindStages  # noqa: E402
from stages.imageFile import ReadExr  # noqa: E402
from wrapperStage import Wrapper  # noqa: E402

SEEDS = (0, 1)
BLOCK = 8  # pixels
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # as the variance AOV weighs
_FIELDS = ("stage", "status", "scene", "picture", "pixelsUnlike", "maxAbs", "blocks", "passed", "within3", "maxZ",
           "deviationZ", "secondsRecord", "secondsHydra", "remark")
_COLUMNS = 4  # pairs beside each other in a sheet
_ROWS = 8


class StageRun:
    """One stage through both front ends; everything it makes is in one folder."""

    def __init__(self, stage, folder: pathlib.Path, frontEnds: FrontEnds, options):
        self.stage = stage
        self.folder = folder
        self.frontEnds = frontEnds
        self.options = options
        self.row = {"status": "ok", "remark": ""}

    def Run(self) -> dict:
        self.folder.mkdir(parents=True, exist_ok=True)
        wrapper = self._Wrap("wrapper", self.options.samples, SEEDS[0])
        if wrapper is None:
            self._CheckThatBothFail()
            return self.row
        if self._Render(wrapper):
            self._CompareScenes(wrapper)
            self._ComparePictures()
            if self.options.zSamples:
                self._TestBlocks()
        return self.row

    def _Wrap(self, name, samples, seed) -> Wrapper | None:
        """The wrapper, made in a process of its own: opening the stage may crash. None: it does not open."""
        path = self.folder / f"{name}.usda"
        path.unlink(missing_ok=True)
        job = dict(stage=str(self.stage), out=str(path), width=self.options.size, samples=samples, seed=seed,
                   mode=self.options.mode)
        result = RunProgram([sys.executable, __file__, "--wrap", json.dumps(job)], None, self.options.limit)
        (self.folder / f"{name}.log").write_text(result.output)
        if result.code == 0:
            return Wrapper(**json.loads(result.output.splitlines()[-1]))
        if result.code != 2:
            self._Bad(f"wrapping: exit {result.code}")
        return None

    def _Program(self, name, result: Result, seconds=None) -> bool:
        """Notes a program's end; True when it is good."""
        (self.folder / f"{name}.log").write_text(result.output)
        if seconds is not None:
            self.row[f"seconds{name.capitalize()}"] = round(seconds, 2)
        if result.hasCrashed or result.code == 124:
            self._Bad(f"{name}: exit {result.code}")
        elif result.code != 0:
            self._Fail(f"{name}: exit {result.code}")
        return result.code == 0

    def _CheckThatBothFail(self):
        """A stage that does not open must be refused by both, without a crash."""
        record = RunProgram([sys.executable, "-m", "hdstream", "record", self.stage, self.folder / "record.exr"], None,
                            self.options.limit)
        openUsd = self.frontEnds.openUsd
        hydra = RunProgram([*openUsd.Program("usdrecord"), "--disableGpu", "--renderer", self.frontEnds.renderer,
                            self.stage, self.folder / "hydra.exr"], openUsd.Environment(self.frontEnds.plugin),
                           self.options.limit)
        for name, result in (("record", record), ("hydra", hydra)):
            (self.folder / f"{name}.log").write_text(result.output)
        if self.row["status"] == "ok":
            isRefused = record.code == 1 and hydra.code == 1
            self.row["status"] = "refused" if isRefused else "bad"
        self.row["remark"] = f"record exit {record.code}, usdrecord exit {hydra.code}"

    def _Render(self, wrapper) -> bool:
        start = time.monotonic()
        record = self.frontEnds.RunRecord(wrapper, self.folder / "record.exr", self.options.limit)
        isGood = self._Program("record", record, time.monotonic() - start)
        start = time.monotonic()
        (self.folder / "hydra.txt").unlink(missing_ok=True)
        hydra = self.frontEnds.RunUsdrecord(wrapper, self.folder / "hydra.exr", self.folder / "hydra.txt",
                                            self.options.limit)
        return self._Program("hydra", hydra, time.monotonic() - start) and isGood

    def _CompareScenes(self, wrapper):
        if not self._Program("dump", self.frontEnds.RunDump(wrapper, self.folder / "record.txt", self.options.limit)):
            return
        if not (self.folder / "hydra.txt").exists():
            self.row["scene"] = "none"
            return self._Fail("the renderer wrote no dump")
        differences = CompareDumps((self.folder / "record.txt").read_text(), (self.folder / "hydra.txt").read_text(),
                                   wrapper.purposes)
        (self.folder / "scene.diff").write_text("".join(f"{line}\n" for line in differences))
        self.row["scene"] = f"{len(differences)} kinds" if differences else "equal"
        if differences:
            self._Fail("; ".join(differences))

    def _ComparePictures(self):
        difference = ComparePictures(self.folder / "record.exr", self.folder / "hydra.exr")
        self.row.update(picture="equal" if difference.isEqual else "unlike", pixelsUnlike=difference.numUnlike,
                        maxAbs=f"{difference.maxAbs:.4g}")
        if not difference.isEqual:
            self._Fail(f"picture: {difference}")

    def _TestBlocks(self):
        """The z-test of the module's head."""
        layers = []
        for seed in SEEDS:
            wrapper = self._Wrap(f"z{seed}", self.options.zSamples, seed)
            path = self.folder / f"z{seed}.exr"
            if not self._Program("record", self.frontEnds.RunRecord(wrapper, path, self.options.limit,
                                                                    ["--aovs", "color,variance"])):
                return
            layers.append(ReadExr(path))
        path = self.folder / "zHydra.exr"
        if not self._Program("hydra", self.frontEnds.RunUsdrecord(wrapper, path, None, self.options.limit)):
            return
        luminances = [np.stack([layers[0][name] for name in "RGB"], -1) @ LUMINANCE, ReadColor(path)[..., :3] @ LUMINANCE]
        variances = [layer["variance.Y"].astype(np.float64) for layer in layers]
        z = BlockZ(luminances[0], variances[0], luminances[1], variances[1], BLOCK)
        # Where neither picture has any variance (a background), equal means pass and others do not.
        still = (Blocks(variances[0], BLOCK) + Blocks(variances[1], BLOCK)) == 0
        z[still & (np.abs(Blocks(luminances[0] - luminances[1], BLOCK)) < 1e-6)] = 0.0
        passed = float(np.mean(z <= ZLimit(z.size)))
        sign = np.sign(Blocks(luminances[0] - luminances[1], BLOCK))
        self.row.update(blocks=z.size, passed=f"{passed:.5f}", within3=f"{np.mean(z <= 3):.5f}", maxZ=f"{z.max():.2f}",
                        deviationZ=f"{np.std((sign * z)[~still]) if (~still).any() else 0:.3f}")
        if passed < 0.9975:
            self._Fail(f"z-test: {passed:.2%} of blocks")

    def _Fail(self, remark):
        if self.row["status"] == "ok":
            self.row["status"] = "differs"
        self.row["remark"] = "; ".join(filter(None, [self.row["remark"], remark]))

    def _Bad(self, remark):
        self.row["status"] = "bad"
        self.row["remark"] = "; ".join(filter(None, [self.row["remark"], remark]))


def WrapInThisProcess(job: dict) -> int:
    """Exit code 2: the stage does not open."""
    from wrapperStage import WriteWrapper
    try:
        wrapper = WriteWrapper(job.pop("stage"), job.pop("out"), job.pop("width"), **job)
    except CommandError as error:
        print(error)
        return 2
    print(json.dumps(dict(vars(wrapper), path=str(wrapper.path))))
    return 0


def WriteSheets(rows: list[dict], out: pathlib.Path) -> None:
    """record | usdrecord, in the order of the table; stages without both pictures are left out."""
    from hdstream import _core
    pictures = []
    for row in rows:
        pair = [out / row["folder"] / f"{name}.exr" for name in ("record", "hydra")]
        if not all(path.exists() for path in pair) or row["status"] == "refused":
            continue
        for path in pair:
            try:
                pixels = np.ascontiguousarray(ReadColor(path))
            except (ValueError, KeyError):
                continue
            _core.WriteImage(str(path.with_suffix(".png")), [_core.ImageLayer("color", list("RGBA"), pixels)], "sRGB")
        pictures.append([str(path.with_suffix(".png")) for path in pair])
    perSheet = _COLUMNS * _ROWS
    for sheet, first in enumerate(range(0, len(pictures), perSheet)):
        group = sum(pictures[first:first + perSheet], [])
        rowsNeeded = -(-len(group) // (2 * _COLUMNS))
        subprocess.run(["oiiotool", *group, "--mosaic:pad=2", f"{2 * _COLUMNS}x{rowsNeeded}", "-o",
                        str(out / f"sheet{sheet}.png")], check=True)


def WriteTable(rows: list[dict], out: pathlib.Path) -> None:
    with open(out / "results.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, ("number",) + _FIELDS, extrasaction="ignore")
        writer.writeheader()
        for row in rows:
            writer.writerow(dict(row, number=row["folder"]))
    lines = ["| stage | status | scene | picture | blocks passed | remark |", "|---|---|---|---|---|---|"]
    for row in rows:
        remark = row["remark"].replace("|", "\\|")
        lines.append(f"| {row['stage']} | {row['status']} | {row.get('scene', '')} | {row.get('picture', '')} | "
                     f"{row.get('passed', '')} | {remark[:300]} |")
    (out / "report.md").write_text("\n".join(lines) + "\n")


def Main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--renderer", default="Stream", help="display name (default Stream)")
    parser.add_argument("--mode", choices=MODES, default="legacy")
    parser.add_argument("--size", type=int, default=160, help="width in pixels (default 160)")
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--zSamples", type=int, default=0, help="samples of the z-test; 0: none")
    parser.add_argument("--limit", type=float, default=600, help="seconds a program may take (default 600)")
    parser.add_argument("--only", default="", help="stages whose path contains the text")
    options = parser.parse_args()
    openUsd, reason = FindOpenUsd()
    plugin, pluginReason = FindPlugin()
    if not openUsd or (not plugin and options.renderer == "Stream"):
        parser.error(reason or pluginReason)
    frontEnds = FrontEnds(openUsd, plugin, options.renderer, options.mode)
    stages = [(number, stage) for number, stage in enumerate(FindStages(options.folder)) if options.only in str(stage)]

    def Work(entry):
        number, stage = entry
        folder = options.out.resolve() / f"{number:03d}"
        done = folder / "row.json"
        if done.exists():
            return json.loads(done.read_text())
        try:
            row = StageRun(stage.resolve(), folder, frontEnds, options).Run()
        except Exception as error:  # pylint: disable=broad-except
            row = {"status": "bad", "remark": f"{type(error).__name__}: {error}"}
        row.update(stage=str(stage.relative_to(options.folder)), folder=folder.name)
        done.write_text(json.dumps(row))
        print(f"{number:03d} {row['status']:8s} scene {row.get('scene', '-'):8s} picture {row.get('picture', '-'):7s} "
              f"{row['stage']} {row['remark'][:200]}", flush=True)
        return row

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(Work, stages))
    WriteTable(rows, options.out)
    WriteSheets(rows, options.out)
    counts = {status: sum(row["status"] == status for row in rows) for status in ("ok", "refused", "differs", "bad")}
    print(", ".join(f"{count} {status}" for status, count in counts.items()))
    return 1 if counts["bad"] else 0


if __name__ == "__main__":
    sys.exit(WrapInThisProcess(json.loads(sys.argv[2])) if sys.argv[1:2] == ["--wrap"] else Main())
