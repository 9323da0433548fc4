# SPDX-License-Identifier: Apache-2.0
"""MaterialX's own node graphs, evaluated in numpy: what a node of the standard library is by its definition.

Value("colorcorrect", "color3", gain=2.0, ...) finds the nodedef, follows its node graph of the package MaterialX down to
nodes that no graph defines, and evaluates those by the specification's text. Values are arrays of float64.
"""

import functools
import pathlib

import MaterialX
import numpy as np


@functools.cache
def _Library():
    document = MaterialX.createDocument()
    folder = pathlib.Path(MaterialX.__file__).parent / "libraries"
    for name in ("stdlib", "nprlib", "bxdf", "cmlib"):
        for file in sorted((folder / name).glob("*.mtlx")):
            MaterialX.readFromXmlFile(document, str(file))
    return document


def _Parse(text: str, kind: str):
    if kind in ("string", "filename"):
        return text
    if kind == "boolean":
        return np.array([1.0 if text == "true" else 0.0])
    return np.array([float(part) for part in text.split(",") if part.strip()])


def _Rotate3d(v, degrees, axis):
    axis = axis / np.linalg.norm(axis)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return v * c + np.cross(v, axis) * s + axis * (axis @ v) * (1 - c)


def _Rotate2d(v, degrees):
    c, s = np.cos(np.radians(degrees))[0], np.sin(np.radians(degrees))[0]
    return np.array([c * v[0] + s * v[1], c * v[1] - s * v[0]])


def _Smooth(x, low, high):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def _HsvToRgb(c):
    import colorsys

    return np.array(colorsys.hsv_to_rgb(c[0] % 1, *c[1:3]))


def _RgbToHsv(c):
    import colorsys

    return np.array(colorsys.rgb_to_hsv(*c[:3]))


_LEAVES = {
    "add": lambda i: i["in1"] + i["in2"], "subtract": lambda i: i["in1"] - i["in2"],
    "multiply": lambda i: i["in1"] * i["in2"], "divide": lambda i: i["in1"] / i["in2"],
    "power": lambda i: i["in1"] ** i["in2"], "modulo": lambda i: i["in1"] % i["in2"],
    "min": lambda i: np.minimum(i["in1"], i["in2"]), "max": lambda i: np.maximum(i["in1"], i["in2"]),
    "absval": lambda i: np.abs(i["in"]), "sign": lambda i: np.sign(i["in"]), "ceil": lambda i: np.ceil(i["in"]),
    "sqrt": lambda i: np.sqrt(i["in"]), "magnitude": lambda i: np.atleast_1d(np.linalg.norm(i["in"])),
    "asin": lambda i: np.arcsin(i["in"]), "atan2": lambda i: np.arctan2(i["iny"], i["inx"]),
    "normalize": lambda i: i["in"] / np.linalg.norm(i["in"]), "dot": lambda i: i["in"],
    "dotproduct": lambda i: np.atleast_1d(i["in1"] @ i["in2"]), "crossproduct": lambda i: np.cross(i["in1"], i["in2"]),
    "clamp": lambda i: np.clip(i["in"], i["low"], i["high"]), "invert": lambda i: i["amount"] - i["in"],
    "remap": lambda i: i["outlow"] + (i["in"] - i["inlow"]) * (i["outhigh"] - i["outlow"]) / (i["inhigh"] - i["inlow"]),
    "smoothstep": lambda i: _Smooth(i["in"], i["low"], i["high"]), "mix": lambda i: i["bg"] + (i["fg"] - i["bg"]) * i["mix"],
    "rotate2d": lambda i: _Rotate2d(i["in"], i["amount"]), "rotate3d": lambda i: _Rotate3d(i["in"], i["amount"], i["axis"]),
    "combine2": lambda i: np.concatenate([np.atleast_1d(i["in1"]), np.atleast_1d(i["in2"])]),
    "combine3": lambda i: np.concatenate([i["in1"], i["in2"], i["in3"]]),
    "extract": lambda i: i["in"][[int(i["index"][0])]], "rgbtohsv": lambda i: _RgbToHsv(i["in"]),
    "hsvtorgb": lambda i: _HsvToRgb(i["in"]),
    "luminance": lambda i: np.full(3, i["in"][:3] @ np.array([0.2722287, 0.6740818, 0.0536895])),
    "ifgreater": lambda i: i["in1"] if i["value1"] > i["value2"] else i["in2"],
    "ifgreatereq": lambda i: i["in1"] if i["value1"] >= i["value2"] else i["in2"],
    "ifequal": lambda i: i["in1"] if i["value1"] == i["value2"] else i["in2"],
    "convert": lambda i: i["in"], "constant": lambda i: i["value"],
    "transformmatrix": lambda i: i["in"] @ i["mat"].reshape(3, 3),
}


def _Find(category: str, kinds: str):
    """The nodedef whose id is ND_<category>_<kinds>."""
    return _Library().getNodeDef(f"ND_{category}_{kinds}" if kinds else f"ND_{category}")


def Value(category: str, kinds: str, leaves=None, output="out", **inputs) -> np.ndarray:
    """The node's value. \\param leaves functions of inputs for categories that are given, such as noise."""
    values = {name: value if isinstance(value, str) else np.atleast_1d(np.asarray(value, float)) for name, value in inputs.items()}
    with np.errstate(divide="ignore", invalid="ignore"):  # intervals of ramps that do not count are empty
        return _Evaluate(_Find(category, kinds), values, {**_LEAVES, **(leaves or {})}, output)


def _Evaluate(nodeDef, inputs: dict, leaves: dict, output: str):
    for port in nodeDef.getActiveInputs():
        isText = port.getType() in ("string", "filename")
        if port.getName() not in inputs and (port.getValueString() or isText):
            inputs[port.getName()] = _Parse(port.getValueString(), port.getType())
    category = nodeDef.getNodeString()
    if category in leaves:
        value = leaves[category](inputs)
        width = {"color3": 3, "vector3": 3, "color4": 4, "vector4": 4, "vector2": 2}.get(nodeDef.getType(), 0)
        return np.broadcast_to(value, width) if width and np.size(value) == 1 else value
    if category == "switch":
        which = int(inputs["which"][0])
        return inputs.get(f"in{which + 1}", np.zeros(1))
    if category.startswith("separate"):
        return inputs["in"][["rgbaxyzw".index(output[3]) % 4]]
    graph = nodeDef.getImplementation()
    if graph is None or not graph.isA(MaterialX.NodeGraph):
        raise LookupError(f"{category}: neither a node graph nor known")
    known = {}

    def Port(port):
        if port.getInterfaceName():
            return inputs[port.getInterfaceName()]
        if port.getNodeName():
            return Node(port.getNodeName(), port.getOutputString() or "out")
        return _Parse(port.getValueString(), port.getType())

    def Node(name, wanted):
        if (name, wanted) not in known:
            node = graph.getNode(name)
            definition = node.getNodeDef()
            if definition is None:
                raise LookupError(f"no nodedef of {node.getCategory()} {name}")
            known[name, wanted] = _Evaluate(definition, {port.getName(): Port(port) for port in node.getInputs()}, leaves, wanted)
        return known[name, wanted]

    return Port(graph.getOutput(output))
