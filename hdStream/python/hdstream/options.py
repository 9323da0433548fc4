# SPDX-License-Identifier: Apache-2.0
"""Values of command-line options: parsed and checked, with errors that say what is expected.

Functions that argparse calls raise argparse.ArgumentTypeError; it adds the option's name.
"""

import argparse
import math

# As kMaxImageSize of hdStream/session/settingsCheck.h, checked here before a stage is opened.
MAX_IMAGE_SIZE = 32768
_SUFFIXES = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}
PURPOSES = ("default", "render", "proxy", "guide")


def _Number(text, kind):
    try:
        return kind(text)
    except ValueError:
        noun = "a whole number" if kind is int else "a number"
        raise argparse.ArgumentTypeError(f"{text!r} is not {noun}") from None


def IntegerIn(low, high):
    """A parser of whole numbers in a range."""

    def Parse(text):
        value = _Number(text, int)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{value} is not in {low}..{high}")
        return value

    return Parse


ImageSize = IntegerIn(1, MAX_IMAGE_SIZE)


def NotNegative(text):
    """A finite number, 0 or more."""
    value = _Number(text, float)
    if not (value >= 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number of 0 or more")
    return value


def Bytes(text):
    """A size in bytes with an optional suffix K, M, G or T (powers of 1024)."""
    number, suffix = (text[:-1], text[-1].upper()) if text[-1:].isalpha() else (text, "")
    try:
        value = float(number) * _SUFFIXES[suffix]
    except (ValueError, KeyError):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 512M or 2G") from None
    if not (value >= 1 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size above 0")
    return int(value)


def BytesOrPercent(text):
    """Bytes, or a percentage as a negative fraction of no unit: ("percent", 30.0)."""
    if not text.endswith("%"):
        return "bytes", Bytes(text)
    value = _Number(text[:-1], float)
    if not 0.0 < value <= 100.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a percentage in 0..100")
    return "percent", value


def BytesOrMesh(text):
    """Bytes, or None for "mesh": a chunk is a whole mesh."""
    return None if text == "mesh" else Bytes(text)


def Names(text):
    """Names separated by commas and blanks, each once, in order."""
    return list(dict.fromkeys(text.replace(",", " ").split()))


def Purposes(text):
    """UsdGeomImageable purposes; "default" is always among them."""
    names = Names(text)
    for name in names:
        if name not in PURPOSES:
            raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(PURPOSES)}")
    return ["default"] + [name for name in names if name != "default"]
