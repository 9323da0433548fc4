# SPDX-License-Identifier: Apache-2.0
"""What the documentation promises of any command (docs/command-line.md): exit codes, one line on stderr besides warnings, no
traceback, an image of finite numbers."""

import pathlib

EXIT_CODES = (0, 1, 2)  # 130 needs a Ctrl-C


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
    return _ImageVerdict(arguments) if code == 0 and arguments[0] == "record" else ""


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
