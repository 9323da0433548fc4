# SPDX-License-Identifier: Apache-2.0
"""Values of command-line options: parsed and checked, with errors that say what is expected.

Functions that argparse calls raise argparse.ArgumentTypeError; it adds the option's name.
"""

import argparse
import math
import re

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


def NotNegative(text):
    """A finite number, 0 or more."""
    value = _Number(text, float)
    if not (value >= 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number of 0 or more")
    return value


def _ParsedByCore(name, text):
    from hdstream import _core
    try:
        return getattr(_core, name)(text)
    except _core.UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def Bytes(text):
    """A size in bytes with an optional suffix K, M, G or T (powers of 1024)."""
    return _ParsedByCore("ParseBytes", text)


def MemorySize(text):
    """A size, or a percentage in 0..100: checked here, and given to the core as it is."""
    _ParsedByCore("ParseMemorySize", text)
    return text


def ChunkBytes(text):
    """Bytes, or "mesh" for the largest chunk there is: a chunk is a whole mesh."""
    if text != "mesh":
        return Bytes(text)
    from hdstream import _core
    return next(int(row.maximum) for row in _core.SettingTable() if row.name == "chunkBytes")


def Names(text):
    """Names separated by commas and blanks, each once, in order. Commas and blanks in quotes or in braces, as light path
    expressions have them, are part of a name."""
    return list(dict.fromkeys(re.findall(r"(?:'[^']*'|\{[^{}]*\}|[^\s,])+", text)))


def Purposes(text):
    """UsdGeomImageable purposes; "default" is always among them."""
    names = Names(text)
    for name in names:
        if name not in PURPOSES:
            raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(PURPOSES)}")
    return ["default"] + [name for name in names if name != "default"]


def AddSetting(group, info, *aliases, **overrides):
    """Adds the option of a row of the core's table of settings; None when it is not given."""
    from hdstream import _core
    keywords = {"dest": info.name, "default": None, "help": _HelpOf(info)}
    kind = info.kind
    if kind == _core.SettingKind.Bool:
        keywords.update(action="store_true")
    elif kind == _core.SettingKind.Choice:
        # Former spellings are taken, with a warning of the core's, and not shown.
        keywords.update(choices=(*info.choices, *info.formerChoices), metavar="{" + ",".join(info.choices) + "}")
    else:
        parsers = {
            _core.SettingKind.Integer: (_IntegerOf(info), "N"),
            _core.SettingKind.Number: (_NumberOf(info), "T"),
            _core.SettingKind.Bytes: (Bytes, "SIZE"),
            _core.SettingKind.Memory: (MemorySize, "SIZE|N%"),
            _core.SettingKind.Names: (Names, "NAME[,NAME...]"),
            _core.SettingKind.Text: (str, "NAME"),
        }
        parse, metavar = parsers[kind]
        keywords.update(type=parse, metavar=metavar)
    keywords.update(overrides)
    group.add_argument(info.option, *aliases, **keywords)


def _HelpOf(info):
    from hdstream import _core
    default = _core.GetSetting(_core.Settings(), info.name)
    if isinstance(default, list):
        default = ",".join(default)
    isShown = default not in ("", False, 0, 0.0)
    # argparse formats help with %.
    return (info.description + (f" (default {default})" if isShown else "")).replace("%", "%%")


def _IntegerOf(info):
    return IntegerIn(int(info.minimum), int(info.maximum))


def _NumberOf(info):
    """Numbers in the setting's range."""

    def Parse(text):
        value = NotNegative(text) if info.minimum == 0.0 else _Number(text, float)
        if not info.minimum <= value <= info.maximum:
            raise argparse.ArgumentTypeError(f"{text!r} is not in {info.minimum:g}..{info.maximum:g}")
        return value

    return Parse
