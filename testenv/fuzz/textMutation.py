# SPDX-License-Identifier: Apache-2.0
"""Mutations of .usda text: values, types, arrays, targets, structure. Each takes a text and a random.Random and returns
another text; most results can still be parsed, which is where the bugs are."""

import re

_NUMBER = re.compile(r"(?<![\w.#@<\"/])-?(?:\d+\.?\d*(?:e[-+]?\d+)?|inf|nan)(?![\w.@>\"])")
_ARRAY = re.compile(r"= (\[[^\[\]]*\])")
_TARGET = re.compile(r"</[\w/.:]*>")
_STRING = re.compile(r"\"[\w:.]+\"")
_TYPE = re.compile(r"^\s*(?:uniform )?([a-z]\w*(?:\[\])?) (?=[\w:]+(?: =|\.connect))", re.M)
_PROPERTY = re.compile(r"^\s*(?:uniform |custom |prepend )*[a-z]\w*(?:\[\])? [\w:.]+ = .*$", re.M)
_PRIM = re.compile(r"^\s*(?:def|over|class) (\w+) \"(\w+)\"[^{]*?\{", re.M | re.S)

SPECIAL = ["0", "-0", "1", "-1", "2", "3", "0.5", "100", "-100", "65", "1000", "65536", "1000000", "-2147483648", "2147483647",
           "16777217", "1e7", "-1e7", "1e-6", "1e-30", "1e-45", "1e20", "1e30", "-1e30", "3.4e38", "-3.4e38", "1e300", "inf", "-inf",
           "nan"]
_TYPES = ["int", "float", "double", "half", "bool", "token", "string", "asset", "float2", "float3", "float4", "color3f", "normal3f",
          "point3f", "vector3f", "matrix4d", "texCoord2f", "quath", "int64", "double3", "int[]", "float[]", "double[]", "token[]",
          "float2[]", "texCoord2f[]", "float3[]", "color3f[]", "point3f[]", "normal3f[]", "quath[]", "matrix4d[]", "int64[]"]
_METADATA = ["instanceable = true", "active = false", "kind = \"component\"", "references = {}", "prepend inherits = {}",
             "specializes = {}", "payload = {}", "references = @none.usda@", "hidden = true",
             "prepend apiSchemas = [\"MaterialBindingAPI\"]", "prepend apiSchemas = [\"GeomModelAPI\"]",
             "prepend apiSchemas = [\"MeshLightAPI\"]"]


def _Choose(pattern, text, rng, group=0):
    """The span of a random match, or None."""
    spans = [match.span(group) for match in pattern.finditer(text)]
    return rng.choice(spans) if spans else None


def _Replace(text, span, by):
    return text if span is None else text[: span[0]] + by + text[span[1]:]


def _Number(text, rng):
    return _Replace(text, _Choose(_NUMBER, text, rng), rng.choice(SPECIAL))


def _Items(array):
    """The items of an array's text; tuples stay whole."""
    items, depth, start = [], 0, 1
    for at in range(1, len(array)):
        depth += (array[at] == "(") - (array[at] == ")")
        if depth == 0 and array[at] == "," or at == len(array) - 1:
            items.append(array[start:at].strip())
            start = at + 1
    return [item for item in items if item]


def _Array(text, rng):
    span = _Choose(_ARRAY, text, rng, 1)
    if span is None:
        return text
    items = _Items(text[span[0]: span[1]])
    kind = rng.randrange(7) if items else 0
    if kind == 0:
        items = items[: rng.randrange(len(items) + 1)]
    elif kind == 1:
        items.pop(rng.randrange(len(items)))
    elif kind == 2:
        items.insert(rng.randrange(len(items) + 1), rng.choice(items))
    elif kind == 3:
        items *= rng.choice([2, 3, 10, 70])
    elif kind == 4:
        items.reverse()
    elif kind == 5:
        rng.shuffle(items)
    else:
        items = [rng.choice(items)] * len(items)
    return _Replace(text, span, f"[{', '.join(items)}]")


def _ManyNumbers(text, rng):
    """All or many numbers of an array."""
    span = _Choose(_ARRAY, text, rng, 1)
    if span is None:
        return text
    value, part = rng.choice(SPECIAL), rng.choice([0.1, 0.5, 1.0])
    array = _NUMBER.sub(lambda match: value if rng.random() < part else match.group(), text[span[0]: span[1]])
    return _Replace(text, span, array)


def _PathsOf(text):
    """Paths of all prims, guessed from names, and all targets that are in the text."""
    names = [match.group(2) for match in _PRIM.finditer(text)]
    return [match.group() for match in _TARGET.finditer(text)] + [f"</{name}>" for name in names] + ["</None>", "</>"]


def _Target(text, rng):
    return _Replace(text, _Choose(_TARGET, text, rng), rng.choice(_PathsOf(text)))


def _String(text, rng):
    strings = _STRING.findall(text) + ["\"\"", "\"none\"", "\"catmullClark\"", "\"faceVarying\"", "\"uniform\"", "\"raw\""]
    return _Replace(text, _Choose(_STRING, text, rng), rng.choice(strings))


def _Type(text, rng):
    return _Replace(text, _Choose(_TYPE, text, rng, 1), rng.choice(_TYPES))


def _Line(text, rng):
    lines = text.split("\n")
    at = rng.randrange(1, len(lines))
    if rng.random() < 0.5:
        lines.pop(at)
    else:
        lines.insert(rng.randrange(1, len(lines)), lines[at])
    return "\n".join(lines)


def _Metadata(text, rng):
    """Metadata of a prim that has none."""
    span = _Choose(re.compile(r"^\s*def \w+ \"\w+\"(?=\s*\{)", re.M), text, rng)
    return _Replace(text, span and (span[1], span[1]), f" ({rng.choice(_METADATA).format(rng.choice(_PathsOf(text)))})")


def _BlockEnd(text, begin):
    depth = 0
    for at in range(begin, len(text)):
        depth += (text[at] == "{") - (text[at] == "}")
        if depth == 0 and text[at] == "}":
            return at + 1
    return len(text)


def _Prim(text, rng):
    """A prim is removed, or copied into another one."""
    span = _Choose(_PRIM, text, rng)
    if span is None:
        return text
    end = _BlockEnd(text, span[1] - 1)
    block = text[span[0]: end]
    if rng.random() < 0.4:
        return text[: span[0]] + text[end:]
    into = _Choose(_PRIM, text, rng)[1]
    return text[:into] + "\n" + block + "\n" + text[into:]


def _Splice(text, rng, corpus):
    """A property of any stage in any prim."""
    other = rng.choice(corpus)
    line = _Choose(_PROPERTY, other, rng)
    into = _Choose(_PRIM, text, rng)
    if line is None or into is None:
        return text
    return text[: into[1]] + "\n" + other[line[0]: line[1]] + "\n" + text[into[1]:]


def Mutated(text, rng, corpus) -> str:
    """The text after one to eight mutations. `corpus`: texts whose properties may be put into this one."""
    kinds = [_Number, _Number, _Number, _ManyNumbers, _Array, _Array, _Target, _String, _Type, _Line, _Metadata, _Prim,
             lambda text, rng: _Splice(text, rng, corpus)]
    for _ in range(rng.choice([1, 1, 2, 3, 5, 8])):
        text = rng.choice(kinds)(text, rng)
    return text
