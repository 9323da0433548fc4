# SPDX-License-Identifier: Apache-2.0
"""Runs the whole suite: runSuite.py --build FOLDER [-k PATTERN] [-j JOBS] [--files N] [--changed [COMMIT] | STAGE...]

A stage is the layer check, the format check, one GoogleTest program of the build (unit, device, stat)
or one folder of pytest files below testenv/. Every stage reports through a JUnit file, so that all are
counted alike; a program that dies before it writes one counts as one failure.
JOBS parts of stages run at a time: one alone leaves cores idle while it translates, compiles kernels and starts
programs. A long stage has several parts, and the longest parts start first. A stage's line appears when its last part ends.
Before the last line a block names every area that was not run and why: stages that were not asked for or miss what
they need, and skipped tests.
The last line is `N passed, N failed, N skipped`; the exit code is 1 on a failure or when nothing ran.
Called by scripts/test; explained in docs/testing.md.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

import changedTests
from suiteReport import Counts, CpuSecondsByFile, NotRunLines, ReadJUnit

TESTENV = pathlib.Path(__file__).resolve().parent.parent
ROOT = TESTENV.parent
# GoogleTest programs: stage -> path in the build folder.
PROGRAMS = {"unit": "testenv/testUnit", "device": "testenv/testDevice", "stat": "testenv/testStat",
            "hydraHost": "testenv/hydra/testHydra"}
# pytest folders in running order; folders not named here run before `install`, which builds a wheel.
FOLDERS = ("support", "stages", "translate", "cli", "render", "stream", "hydra")
LAST_FOLDERS = ("install",)
# Other versions of the formatter lay some lines out differently.
CLANG_FORMAT_MAJOR = "14"

PYTEST_NOTHING_RAN = 5  # pytest's exit code when -k matches nothing
STAGE_LIMIT_SECONDS = 3600  # a hanging stage must not hang the suite
POLL_SECONDS = 0.05

MAX_JOBS = 4  # a part needs up to 2 GB

# What takes longest, longest first: whole stages, and tests that are a part of their own: files of a pytest stage, suites of
# a GoogleTest program. They start before all others; the rest of their stage is one more part. Only time depends on it.
LONGEST = ("install", "stream", "stream/test_instanceChunks.py", "stream/test_island.py", "cli/test_performancePage.py", "fuzz",
           "render/test_motionAverage.py", "render", "stream/test_geometryStreaming.py", "stream/test_rereading.py", "device",
           "device/Roots.*", "render/test_closed_form.py", "render/test_libraryNodes.py", "render/test_textureRules.py",
           "render/test_patterns.py", "render/test_identity.py", "render/test_stability.py", "render/test_mitsuba.py",
           "render/test_stages.py", "render/test_media.py", "render/test_meshMedia.py", "render/test_volumes.py",
           "render/test_hairMitsuba.py", "hydra", "farm", "docs", "stat", "cli")

# text: what is to be shown beside the counts; skips: why tests were skipped; cpu: seconds; files: those of each file of tests.
Outcome = collections.namedtuple("Outcome", "counts text skips cpu files", defaults=((), 0.0, {}))


def RunQuietly(command: list, environment: dict) -> tuple[int, str, float]:
    """Runs a command: its exit code, what it said when it failed, and the CPU seconds of all its processes."""
    with tempfile.TemporaryFile() as said:
        try:
            process = subprocess.Popen(command, env=environment, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=said,
                                       stderr=subprocess.STDOUT)
        except OSError as error:
            return 127, str(error), 0.0
        end = time.monotonic() + STAGE_LIMIT_SECONDS
        try:
            while (ended := os.wait4(process.pid, os.WNOHANG))[0] == 0:
                if time.monotonic() > end:
                    said.write(f"\nstopped after {STAGE_LIMIT_SECONDS} s".encode())
                    process.kill()
                    ended = os.wait4(process.pid, 0)
                    break
                time.sleep(POLL_SECONDS)
        except BaseException:
            process.kill()
            raise
        process.returncode = os.waitstatus_to_exitcode(ended[1])
        said.seek(0)
        output = said.read().decode(errors="replace")
    return (process.returncode, "" if process.returncode in (0, PYTEST_NOTHING_RAN) else output,
            ended[2].ru_utime + ended[2].ru_stime)


def RunReporting(command: list, report: pathlib.Path, environment: dict, stage: str = "") -> Outcome:
    """Runs a command that writes `report`. A bad end without a counted failure is a failure too."""
    code, text, cpu = RunQuietly(command, environment)
    isGood = code in (0, PYTEST_NOTHING_RAN)
    try:
        counts, skips = ReadJUnit(report)
    except (OSError, xml.etree.ElementTree.ParseError):
        return Outcome(Counts(0, 1, 0), f"{text}\nthe test program wrote no complete report", (), cpu)
    if not isGood and counts.failed == 0:
        counts, text = counts._replace(failed=1), f"{text}\nexit code {code} although no test failed"
    return Outcome(counts, text, skips, cpu, CpuSecondsByFile(stage, report))


def RunCheck(command: list) -> Outcome:
    code, text, cpu = RunQuietly(command, dict(os.environ))
    return Outcome(Counts(int(code == 0), int(code != 0), 0), text, (), cpu)


def Sum(outcomes: list) -> Outcome:
    """The outcome of a stage from those of its parts."""
    return Outcome(Counts(*map(sum, zip(*(outcome.counts for outcome in outcomes)))),
                   "\n".join(outcome.text for outcome in outcomes if outcome.text.strip()),
                   [reason for outcome in outcomes for reason in outcome.skips], sum(outcome.cpu for outcome in outcomes),
                   {file: seconds for outcome in outcomes for file, seconds in outcome.files.items()})


def InOrder(stages: dict) -> list:
    """(stage, part) in the order in which they start."""
    rank = {name: index for index, name in enumerate(LONGEST)}
    parts = [(stage, part) for stage in stages for part in stages[stage]]
    return sorted(parts, key=lambda names: rank.get(names[1], len(rank)))


def RunStages(stages: dict, numJobs: int) -> tuple[Counts, dict, dict]:
    """Runs the parts of stages, numJobs at a time; prints each stage when its last part ends. stages: name -> {part ->
    function that runs it}. Returns the counts of all, why tests were skipped by stage, and seconds by file."""
    total = Counts(0, 0, 0)
    skips, files = {}, {}
    left = {stage: dict.fromkeys(parts) for stage, parts in stages.items()}
    start = time.monotonic()

    def Run(stage: str, part: str):
        return stage, part, stages[stage][part]()

    executor = concurrent.futures.ThreadPoolExecutor(numJobs)
    try:
        for future in concurrent.futures.as_completed([executor.submit(Run, *names) for names in InOrder(stages)]):
            stage, part, outcome = future.result()
            left[stage][part] = outcome
            if not all(left[stage].values()):
                continue
            counts, text, skips[stage], cpu, ofStage = Sum(list(left[stage].values()))
            files.update(ofStage)
            if text.strip():
                print(f"\n{stage}:\n{text.strip()}")
            print(f"{stage:10s} {counts.passed:5d} passed {counts.failed:3d} failed {counts.skipped:3d} skipped "
                  f"{cpu:7.1f} s of CPU time, ended after {time.monotonic() - start:7.1f} s", flush=True)
            total = Counts(*map(sum, zip(total, counts)))
    finally:
        executor.shutdown(cancel_futures=True)  # Ctrl-C: those not yet started
    return total, skips, files


def FormatCommand() -> list:
    """clang-format over all C++ and kernel files, or nothing where the right version is missing."""
    for name in (f"clang-format-{CLANG_FORMAT_MAJOR}", "clang-format"):
        tool = shutil.which(name)
        if tool and f"version {CLANG_FORMAT_MAJOR}." in subprocess.run(
                [tool, "--version"], capture_output=True, text=True).stdout:
            return [sys.executable, str(TESTENV / "support" / "checkFormat.py"), tool]
    return []


def PytestFolders() -> list:
    found = sorted({path.relative_to(TESTENV).parts[0] for path in TESTENV.glob("*/**/test*.py")}
                   - set(PROGRAMS) - {"bench"})
    rank = {name: index for index, name in enumerate(FOLDERS)}
    rank.update({name: len(FOLDERS) + 1 + index for index, name in enumerate(LAST_FOLDERS)})
    return sorted(found, key=lambda name: (rank.get(name, len(FOLDERS)), name))


def Parts(stage: str) -> tuple[dict, list]:
    """Part -> the tests it runs, for the parts that LONGEST takes out of a stage; and all these tests, which the rest leaves
    out."""
    taken = {part: part.partition("/")[2] for part in LONGEST if part.startswith(f"{stage}/")}
    return taken, list(taken.values())


def ProgramParts(stage: str, program: pathlib.Path, pattern: str, only: list = None) -> dict:
    """Part -> command, for a GoogleTest program; -k and a choice of suites leave it in one piece."""
    command = [program, "--gtest_brief=1"]
    if pattern or only:
        return {stage: [*command, f"--gtest_filter={':'.join(only) if only else f'*{pattern}*'}"]}
    taken, names = Parts(stage)
    parts = {part: [*command, f"--gtest_filter={name}"] for part, name in taken.items()}
    return {**parts, stage: [*command, f"--gtest_filter=-{':'.join(names)}"]}


def FolderParts(stage: str, pattern: str, only: list = None) -> dict:
    """Part -> command, for a folder of pytest files; -k and a choice of files leave it in one piece."""
    command = [sys.executable, "-m", "pytest", "-q", "--no-header", "-p", "no:cacheprovider"]
    folder = TESTENV / stage
    if only:
        return {stage: [*command, *(folder / name for name in only)]}
    if pattern:
        return {stage: [*command, folder, "-k", pattern]}
    taken, names = Parts(stage)
    parts = {part: [*command, folder / name] for part, name in taken.items()}
    return {**parts, stage: [*command, folder, *(f"--ignore={folder / name}" for name in names)]}


def Environment(build: pathlib.Path, folder: str) -> dict:
    """That of all parts. Python keeps its bytecode, whatever the caller says: hundreds of processes would compile our modules.
    Other threads of numpy would spin beside the renders of the tests."""
    environment = dict(os.environ, HDSTREAM_REQUIRE_DEVICE="1", HDSTREAM_CACHE_DIR=f"{folder}/cache",
                       PYTHONPATH=str(build / "python"), HDSTREAM_TEST_BUILD=str(build), OPENBLAS_NUM_THREADS="1")
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    return environment


def Stages(build: pathlib.Path, pattern: str, environment: dict, reports: pathlib.Path, only: dict) -> tuple[dict, dict]:
    """Stage name -> {part -> function that runs it and returns its outcome}; and stages that cannot be run: why. only: stage
    -> the tests to run of it, where that is not all."""
    stages, absent = {}, {}
    if pattern:
        absent = dict.fromkeys(("layers", "format"), "they have no tests whose name could match -k")
    else:
        stages["layers"] = {"layers": lambda: RunCheck([sys.executable, ROOT / "cmake" / "CheckLayers.py", ROOT])}
        formatter = FormatCommand()
        if formatter:
            stages["format"] = {"format": lambda: RunCheck(formatter)}
        else:
            absent["format"] = f"there is no clang-format {CLANG_FORMAT_MAJOR}"

    def Add(stage: str, parts: dict, reportOption: str):
        stages[stage] = {}
        for index, (part, command) in enumerate(parts.items()):
            report = reports / f"{stage}{index}.xml"
            words = [*command, f"{reportOption}{report}"]
            stages[stage][part] = lambda w=words, r=report: RunReporting(w, r, environment, stage)

    for label, place in PROGRAMS.items():
        program = build / place
        if label == "hydraHost" and not program.exists() and not environment.get("HDSTREAM_REQUIRE_HYDRA"):
            absent[label] = f"{place} was not built: no OpenUSD with imaging was found (docs/hydra.md)"
        else:
            Add(label, ProgramParts(label, program, pattern, only.get(label)), "--gtest_output=xml:")
    for folder in PytestFolders():
        Add(folder, FolderParts(folder, pattern, only.get(folder)), "--junitxml=")
    return stages, absent


def Main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/test", description="Builds hdStream and runs its tests.")
    parser.add_argument("--build", type=lambda text: pathlib.Path(text).resolve(), required=True, help=argparse.SUPPRESS)
    parser.add_argument("-k", metavar="PATTERN", default="", help="only tests whose name contains PATTERN")
    parser.add_argument("-j", metavar="JOBS", type=int, default=min((os.cpu_count() or 1) + 1, MAX_JOBS),
                        help="parts of stages at a time (%(default)s)")
    parser.add_argument("--changed", metavar="COMMIT", nargs="?", const="",
                        help="only what files can break that differ from COMMIT (where this branch left main)")
    parser.add_argument("--files", metavar="N", type=int, default=0, help="also list the N files that took the most CPU time")
    parser.add_argument("stages", metavar="STAGE", nargs="*", help="only these: layers, format, unit, device, ...")
    options = parser.parse_args()
    only, whyNot = {}, "not asked for"
    if options.changed is not None:
        if options.stages or options.k:
            parser.error("--changed chooses by itself: give no -k and no stages")
        paths = changedTests.Files(options.changed or changedTests.Base())
        print("changed: " + (" ".join(paths) or "nothing"))
        only, whyNot = changedTests.Selection(paths), "nothing that was changed has its tests there"
    with tempfile.TemporaryDirectory(prefix="hdstream-test-") as folder:
        environment = Environment(options.build, folder)
        stages, absent = Stages(options.build, options.k, environment, pathlib.Path(folder), only)
        unknown = [name for name in options.stages if name not in stages and name not in absent]
        if unknown:
            parser.error(f"no such stage: {' '.join(unknown)}; there are: {' '.join(stages)}")
        asked = options.stages or only or stages
        chosen = {name: run for name, run in stages.items() if name in asked}
        absent.update({name: whyNot for name in stages if name not in chosen})
        total, skips, files = RunStages(chosen, max(options.j, 1))
    for file in sorted(files, key=files.get, reverse=True)[:options.files]:
        print(f"  {files[file]:7.1f} s  {file}")
    print("", *NotRunLines(absent, skips), sep="\n")
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 0 if total.failed == 0 and total.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(Main())
