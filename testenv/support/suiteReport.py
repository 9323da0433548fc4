# SPDX-License-Identifier: Apache-2.0
"""What the suite's test programs report, and the closing block that names every area that was not run and why."""

import collections
import pathlib
import re
import xml.etree.ElementTree

Counts = collections.namedtuple("Counts", "passed failed skipped")
CPU_SECONDS = "cpuSeconds"  # a property of tests in the reports of pytest

# Areas that are a part of a stage: name, a pattern of the reason with which their tests are skipped. A test whose reason
# matches none belongs to the area that has its stage's name.
AREAS = (("live oracles", "[Mm]itsuba"), ("MaterialX", "MaterialX"), ("usdview", "usdview|xvfb|X server"),
         ("OpenUSD's programs", "No OpenUSD|no OpenUSD|plug-in"), ("OpenCL device", "OpenCL device"))


def ReadJUnit(path: pathlib.Path) -> tuple[Counts, list]:
    """Counts the cases of a JUnit file as GoogleTest and pytest write it; the reasons of those that were skipped."""
    passed = failed = 0
    reasons = []
    for case in xml.etree.ElementTree.parse(path).iter("testcase"):
        kinds = {child.tag: child for child in case}
        if kinds.keys() & {"failure", "error"}:
            failed += 1
        elif "skipped" in kinds:
            reasons.append(_Reason(kinds["skipped"]))
        elif case.get("status") == "notrun":
            reasons.append("it is disabled")
        else:
            passed += 1
    return Counts(passed, failed, len(reasons)), reasons


def CpuSecondsByFile(stage: str, path: pathlib.Path) -> dict:
    """"STAGE/FILE" -> the CPU seconds that the tests of a pytest file said they took, their processes too (conftest.py), or
    "STAGE/SUITE" -> the seconds of a suite of GoogleTest, which are those of a clock."""
    seconds = collections.Counter()
    for case in xml.etree.ElementTree.parse(path).iter("testcase"):
        said = [entry.get("value") for entry in case.iter("property") if entry.get("name") == CPU_SECONDS]
        seconds[f"{stage}/{case.get('classname', '').rpartition('.')[2]}"] += float(said[0] if said else case.get("time", 0))
    return dict(seconds)


def _Reason(skipped) -> str:
    """One line. GoogleTest writes the place of the skip first; where pytest skips a whole file, the message says only so,
    and the text is a tuple that ends with the reason."""
    text = re.sub(r"^\S+:\d+\n", "", skipped.get("message", ""))
    if text == "collection skipped":
        text = re.sub(r"^.*?Skipped: |.\)$", "", skipped.text or "", flags=re.DOTALL)
    text = " ".join(text.split())
    return text.removeprefix("SKIPPED LOUDLY: ").removeprefix("SKIPPED: ") or skipped.get("type", "no reason given")


def AreaOf(stage: str, reason: str) -> str:
    return next((area for area, pattern in AREAS if re.search(pattern, reason)), stage)


def NotRunLines(absent: dict, skips: dict) -> list:
    """The block: one line an area and reason. absent: stage -> why it was not run; skips: stage -> reasons of its tests."""
    stages = {}
    for stage, reason in absent.items():
        stages.setdefault(reason, []).append(stage)
    lines = [f"  {', '.join(names)}: {reason}" for reason, names in stages.items()]
    groups = collections.Counter((AreaOf(stage, reason), stage, reason)
                                 for stage, reasons in skips.items() for reason in reasons)
    for (area, stage, reason), number in sorted(groups.items()):
        place = "" if area == stage else f" of {stage}"
        lines.append(f"  {area}: {number} test{'s' if number > 1 else ''}{place}: {reason}")
    return ["Not run:", *lines] if lines else ["Not run: nothing, every area was."]
