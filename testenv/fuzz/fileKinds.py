# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of the text files that stages name: light profiles and MaterialX documents."""

import re

from fuzzKind import Kind
from textMutation import SPECIAL

_SMALL = ["--imageWidth", 16, "--samples", 2, "--maxDepth", 3, "--time", 5]
_WORD = re.compile(r"[^\s,]+")
_ELEMENT = re.compile(r"<(\w+)[^<>]*?(/>|>)", re.S)
_ATTRIBUTE = re.compile(r"(\w+)=\"([^\"]*)\"")
_ODD_VALUES = ["", "0", "-1", "nan", "inf, inf, inf", "1e38, 1e38, 1e38", "1, 2", "true", "none", "NG", "image", "../NG", "a" * 300, "&lt;"]


def _Spans(pattern, text, group=0):
    return [match.span(group) for match in pattern.finditer(text)]


def _Line(text, rng):
    """A line is left out or stands twice."""
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    lines[at: at + 1] = [] if rng.random() < 0.5 else [lines[at]] * 2
    return "\n".join(lines)


def _MutateWords(text, rng):
    """A word, mostly a number, is another one, is left out, or stands many times."""
    spans = _Spans(_WORD, text)
    if not spans:
        return text
    begin, end = rng.choice(spans)
    kind = rng.randrange(5)
    if kind < 2:
        word = rng.choice(SPECIAL + ["x", "TILT=NONE", "TILT=INCLUDE", "90", "180", "270", "360"])
    elif kind == 2:
        word = ""
    elif kind == 3:
        word = " ".join([text[begin:end]] * rng.choice([2, 3, 50]))
    else:
        begin2, end2 = rng.choice(spans)
        word = text[begin2:end2]
    return text[:begin] + word + text[end:]


def _MutateValue(text, rng):
    """The value of an attribute is that of another one of its name, a number, or something odd."""
    spans = [(match.group(1), match.span(2)) for match in _ATTRIBUTE.finditer(text)]
    if not spans:
        return text
    name, (begin, end) = rng.choice(spans)
    others = [value for other, value in _ATTRIBUTE.findall(text) if other == name]
    value = rng.choice([rng.choice(others), rng.choice(SPECIAL), rng.choice(_ODD_VALUES)])
    return text[:begin] + value + text[end:]


def _MutateName(text, rng):
    """An attribute's or an element's name is another one's."""
    pattern = rng.choice([_ATTRIBUTE, _ELEMENT])
    matches = list(pattern.finditer(text))
    if not matches:
        return text
    begin, end = rng.choice(matches).span(1)
    return text[:begin] + rng.choice(matches).group(1) + text[end:]


def _MutateElement(text, rng):
    """An element without children is left out, or stands elsewhere too."""
    spans = [match.span() for match in _ELEMENT.finditer(text) if match.group(2) == "/>"]
    if not spans:
        return text
    begin, end = rng.choice(spans)
    if rng.random() < 0.4:
        return text[:begin] + text[end:]
    at = rng.choice(_Spans(_ELEMENT, text))[1]
    return text[:at] + text[begin:end] + text[at:]


def _Mutated(text, rng, mutations) -> bytes:
    """The text after one to eight mutations; one in eight as damaged bytes."""
    import byteMutation

    for _ in range(rng.choice([1, 1, 2, 3, 5, 8])):
        text = rng.choice(mutations)(text, rng)
    data = text.encode()
    return byteMutation.Mutated(data, rng) if rng.random() < 0.125 else data


class Ies(Kind):
    """Mutated light profiles on lights of all shapes."""

    def RunCase(self, rng) -> str:
        from stages import fuzzFiles

        profile = _Mutated(rng.choice(fuzzFiles.PROFILES), rng, [_MutateWords, _MutateWords, _MutateWords, _Line])
        stage = fuzzFiles.LAMPS.replace("@./lamp.ies@", f"@./{self.Write('lamp.ies', profile)}@")
        return self.Record(self.Write("stage.usda", stage), *_SMALL)


class MaterialX(Kind):
    """Mutated MaterialX files, referenced by a stage. Needs the package MaterialX to find anything."""

    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from stages import fuzzBase

        fuzzBase.WriteImages(folder)

    def RunCase(self, rng) -> str:
        from stages import fuzzFiles

        looks = _Mutated(fuzzFiles.MATERIALS, rng, [_MutateValue, _MutateValue, _MutateValue, _MutateName, _MutateElement, _Line])
        stage = fuzzFiles.BALLS.replace("@./looks.mtlx@", f"@./{self.Write('looks.mtlx', looks)}@")
        return self.Record(self.Write("stage.usda", stage), *_SMALL)
