# SPDX-License-Identifier: Apache-2.0
"""What the documentation promises of any command (docs/command-line.md): exit codes, one line on stderr besides warnings, no
traceback, an image of finite numbers of which none was NaN before it became black."""

import json
import pathlib

EXIT_CODES = (0, 1, 2)  # 130 needs a Ctrl-C
STATISTICS, STATISTICS_PATTERN = "judge.####.json", "judge.*.json"  # of the frames of a command


def Verdict(code, errors: str, arguments) -> str:
    """What is wrong with the outcome of `hdstream ARGUMENTS...` in the present directory; "" when nothing is."""
    lines = [line for line in errors.splitlines() if not line.startswith("warning: ")]
    text = " | ".join(lines)[:500]
    if code not in EXIT_CODES:
        return f"exit code {code}: {text}"
    if "Traceback" in errors or "internal error" in errors:
        return f"internal error: {text}"
    if code == 0 and lines:
        return f"exit code 0 with words on stderr: {text}"
    if code != 0 and len(lines) != 1 and arguments[0] != "compare":
        return f"exit code {code} with {len(lines)} lines on stderr: {text}"
    if code != 0 or arguments[0] != "record":
        return ""
    return _ImageVerdict(arguments) or _StatisticsVerdict(arguments)


def SampleVerdict(statistics: str) -> str:
    """Of statistics as JSON: the film shows a sample that is not finite as black."""
    count = json.loads(statistics)["accuracy"]["nanSamples"]
    return f"{count} samples are not finite" if count > 0 else ""


def _StatisticsVerdict(arguments) -> str:
    files = list(pathlib.Path().glob(STATISTICS_PATTERN))
    if not files and arguments.count("--stats") == 1:
        return "exit code 0 without statistics"
    return next(filter(None, (SampleVerdict(file.read_text()) for file in files)), "")


def _ImageVerdict(arguments) -> str:
    from hdstream import _core

    pattern = arguments[2]
    files = sorted(pathlib.Path().glob(pattern.replace("#", "?"))) if "#" in pattern else [pathlib.Path(pattern)]
    if not files or not all(file.exists() for file in files):
        return "exit code 0 without an image"
    for file in files:
        comparison = _core.CompareImages(str(file), str(file))
        if comparison.error:
            return f"the image cannot be read: {comparison.error}"
        for layer in comparison.layers:
            if layer.numNonFinite > 0:
                return f"layer {layer.name} has {layer.numNonFinite} values that are not finite"
        if "#" in pattern:
            file.unlink()
    return ""
