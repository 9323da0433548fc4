# SPDX-License-Identifier: Apache-2.0
"""Runs the whole suite, fast stages first: runSuite.py --build FOLDER [-k PATTERN] [-j JOBS] [STAGE...]

A stage is the layer check, the format check, one GoogleTest program of the build (unit, device, stat)
or one folder of pytest files below testenv/. Every stage reports through a JUnit file, so that all are
counted alike; a program that dies before it writes one counts as one failure.
Stages start in their order, JOBS at a time: one alone leaves cores idle while it translates, compiles and
starts programs. A stage's lines appear when it ends.
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

from suiteReport import Counts, NotRunLines, ReadJUnit

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

MAX_JOBS = 4  # a stage needs up to 2 GB

# text: what is to be shown beside the counts; skips: why tests were skipped.
Outcome = collections.namedtuple("Outcome", "counts text skips", defaults=((),))


def RunQuietly(command: list, environment: dict) -> tuple[int, str]:
    """Runs a command: its exit code, and what it said when it failed."""
    try:
        result = subprocess.run(command, env=environment, cwd=ROOT, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=STAGE_LIMIT_SECONDS)
        code, output = result.returncode, result.stdout.decode(errors="replace")
    except OSError as error:
        code, output = 127, str(error)
    except subprocess.TimeoutExpired as error:
        code, output = 124, (error.stdout or b"").decode(errors="replace") + f"\nstopped after {STAGE_LIMIT_SECONDS} s"
    return code, "" if code in (0, PYTEST_NOTHING_RAN) else output


def RunReporting(command: list, report: pathlib.Path, environment: dict) -> Outcome:
    """Runs a command that writes `report`. A bad end without a counted failure is a failure too."""
    code, text = RunQuietly(command, environment)
    isGood = code in (0, PYTEST_NOTHING_RAN)
    try:
        counts, skips = ReadJUnit(report)
    except (OSError, xml.etree.ElementTree.ParseError):
        return Outcome(Counts(0, 1, 0), f"{text}\nthe test program wrote no complete report")
    if not isGood and counts.failed == 0:
        return Outcome(counts._replace(failed=1), f"{text}\nexit code {code} although no test failed", skips)
    return Outcome(counts, text, skips)


def RunCheck(command: list) -> Outcome:
    code, text = RunQuietly(command, dict(os.environ))
    return Outcome(Counts(int(code == 0), int(code != 0), 0), text)


def RunStages(stages: dict, numJobs: int) -> tuple[Counts, dict]:
    """Runs stages, numJobs at a time; prints each when it ends. Returns the counts of all, and why tests were skipped by
    stage."""
    total = Counts(0, 0, 0)
    skips = {}

    def Run(name: str):
        start = time.monotonic()
        return name, stages[name](), time.monotonic() - start

    executor = concurrent.futures.ThreadPoolExecutor(numJobs)
    try:
        for future in concurrent.futures.as_completed([executor.submit(Run, name) for name in stages]):
            name, (counts, text, skips[name]), seconds = future.result()
            if text.strip():
                print(f"\n{name}:\n{text.strip()}")
            print(f"{name:10s} {counts.passed:5d} passed {counts.failed:3d} failed {counts.skipped:3d} skipped {seconds:7.1f} s",
                  flush=True)
            total = Counts(*map(sum, zip(total, counts)))
    finally:
        executor.shutdown(cancel_futures=True)  # Ctrl-C: those not yet started
    return total, skips


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


def Stages(build: pathlib.Path, pattern: str, environment: dict, reports: pathlib.Path) -> tuple[dict, dict]:
    """Stage name -> function that runs it and returns its outcome, in running order; and stages that cannot be run: why."""
    stages, absent = {}, {}
    if pattern:
        absent = dict.fromkeys(("layers", "format"), "they have no tests whose name could match -k")
    else:
        stages["layers"] = lambda: RunCheck([sys.executable, ROOT / "cmake" / "CheckLayers.py", ROOT])
        formatter = FormatCommand()
        if formatter:
            stages["format"] = lambda: RunCheck(formatter)
        else:
            absent["format"] = f"there is no clang-format {CLANG_FORMAT_MAJOR}"
    for label, place in PROGRAMS.items():
        program = build / place
        report = reports / f"{label}.xml"
        command = [program, "--gtest_brief=1", f"--gtest_output=xml:{report}"]
        if pattern:
            command.append(f"--gtest_filter=*{pattern}*")
        if label == "hydraHost" and not program.exists():
            absent[label] = f"{place} was not built: no OpenUSD with imaging was found (docs/hydra.md)"
        else:
            stages[label] = lambda c=command, r=report: RunReporting(c, r, environment)
    for folder in PytestFolders():
        report = reports / f"{folder}.xml"
        command = [sys.executable, "-m", "pytest", "-q", "-rs", "--no-header", "-p", "no:cacheprovider",
                   f"--junitxml={report}", TESTENV / folder]
        if pattern:
            command += ["-k", pattern]
        stages[folder] = lambda c=command, r=report: RunReporting(c, r, environment)
    return stages, absent


def Main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/test", description="Builds hdStream and runs its tests.")
    parser.add_argument("--build", type=lambda text: pathlib.Path(text).resolve(), required=True, help=argparse.SUPPRESS)
    parser.add_argument("-k", metavar="PATTERN", default="", help="only tests whose name contains PATTERN")
    parser.add_argument("-j", metavar="JOBS", type=int, default=min(os.cpu_count() or 1, MAX_JOBS),
                        help="stages at a time (%(default)s)")
    parser.add_argument("stages", metavar="STAGE", nargs="*", help="only these: layers, format, unit, device, ...")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="hdstream-test-") as folder:
        environment = dict(os.environ, HDSTREAM_REQUIRE_DEVICE="1", HDSTREAM_CACHE_DIR=f"{folder}/cache",
                           PYTHONPATH=str(options.build / "python"), PYTHONDONTWRITEBYTECODE="1",
                           HDSTREAM_TEST_BUILD=str(options.build))
        stages, absent = Stages(options.build, options.k, environment, pathlib.Path(folder))
        unknown = [name for name in options.stages if name not in stages and name not in absent]
        if unknown:
            parser.error(f"no such stage: {' '.join(unknown)}; there are: {' '.join(stages)}")
        chosen = {name: run for name, run in stages.items() if not options.stages or name in options.stages}
        absent.update({name: "not asked for" for name in stages if name not in chosen})
        total, skips = RunStages(chosen, max(options.j, 1))
    print("", *NotRunLines(absent, skips), sep="\n")
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 0 if total.failed == 0 and total.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(Main())
