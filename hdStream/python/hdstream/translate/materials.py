# SPDX-License-Identifier: Apache-2.0
"""UsdShade materials as flat networks of shader nodes, and the materials bound to prims.

Node graphs, interfaces and pass-through connections are followed by UsdShade itself
(GetValueProducingAttributes), so a node sees either a value or the output of another shader.
"""

import typing

import numpy as np
from pxr import Sdf, Usd, UsdShade

from hdstream import _core
from hdstream.diagnostics import MessagesOf, TfError
from hdstream.translate.colorSpaces import ColorSpaceOf, ColorSpaceOfColor

_TERMINALS = ("surface", "displacement", "volume")
# Render contexts of terminals, best first: MaterialX, Karma's (MaterialX as Houdini's Karma Material Builder writes it), the
# universal one, Storm's, where assets for another renderer have their preview, and Arnold's.
_CONTEXTS = {"mtlx:": "the surface of mtlx", "kma:": "the surface of kma", "": "the universal surface",
             "glslfx:": "the surface of glslfx", "arnold:": "the surface of arnold"}
# Nodes that hand a surface on, by how their ids begin: the input that has it.
_HANDING_ON = {"ND_surfacematerial": "surfaceshader", "ND_dot_surfaceshader": "in"}
# Bindings of purpose "full" first, then those for all purposes, as every final renderer.
BINDING_PURPOSE = "full"


class BoundMaterial(typing.NamedTuple):
    """The material that is bound to a prim."""

    path: str = ""  # empty: none is
    prim: Usd.Prim = None
    missing: str = ""  # path of a material that is bound, but does not exist


def BoundMaterials(prims, warn):
    """The BoundMaterial of each prim. `warn(prim, text)` gets bindings that cannot be read.

    One call for all prims: UsdShade shares its caches between them and uses all cores.
    """
    if not prims:
        return []
    found = []
    for material, relationship in zip(*_ComputeBoundMaterials(prims, warn)):
        if material:
            found.append(BoundMaterial(material.GetPath().pathString, material.GetPrim()))
        else:
            targets = relationship.GetTargets() if relationship else ()
            found.append(BoundMaterial(missing=str(targets[0]) if targets else ""))
    return found


def FindBoundMaterials(prims, warn):
    """Paths of the materials bound to `prims`, "" where none is, and the materials by path."""
    bound = BoundMaterials(prims, warn)
    for prim, material in zip(prims, bound):
        if material.missing:
            warn(prim, f"bound material {material.missing} does not exist")
    return [material.path for material in bound], {material.path: material.prim for material in bound if material.prim}


def _ComputeBoundMaterials(prims, warn):
    """As UsdShade's; a binding that it cannot read is none, and costs no other prim its material."""
    try:
        return UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, BINDING_PURPOSE)
    except TfError as error:
        if len(prims) > 1:
            alone = [_ComputeBoundMaterials([prim], warn) for prim in prims]
            return [sum(lists, []) for lists in zip(*alone)]
        warn(prims[0], f"its material binding cannot be read: {'; '.join(MessagesOf(error))}")
        return [UsdShade.Material()], [Usd.Relationship()]


class MaterialReader:
    """Reads material prims as networks. `warn(prim, text)` gets what cannot be read."""

    def __init__(self, timeCode, assets, warn):
        self._timeCode = timeCode
        self._assets = assets
        self._warn = warn
        self.borrowed = {}  # path of a material -> paths of prims outside of it that its network was read from
        self._inside = ""   # what paths inside of the material begin with

    def Read(self, prim):
        """The network of a material; without terminals when it has none of a context that is read."""
        self._inside = f"{prim.GetPath()}/"
        material = UsdShade.Material(prim)
        terminals = {}
        nodes = {}
        pending = []
        for terminal in _TERMINALS:
            source = self._FindTerminal(material, terminal)
            if source is not None:
                # As Hydra, which names the terminal instead of the shader's output.
                terminals[terminal] = _core.Connection(source[0], terminal)
                pending.append(source[2])
        while pending:
            shader = pending.pop()
            path = shader.GetPath().pathString
            if path not in nodes:
                nodes[path] = self._ReadNode(shader, pending)
        if "surface" not in terminals and "volume" not in terminals:
            self._WarnOfOthers(material)
        frame = None if self._timeCode.IsDefault() else self._timeCode.GetValue()
        return _core.MaterialNetwork([nodes[path] for path in sorted(nodes)], terminals, frame)

    def _FindTerminal(self, material, terminal):
        """The best context's source; of surfaces that of the first that is drawn, else of the first."""
        found = {}
        for context in _CONTEXTS:
            output = material.GetOutput(context + terminal)
            if output:
                self._NoteOrigins(output.GetAttr())
            source = _FindSource(output) if output else None
            if source is not None:
                found[context] = source
        if not found:
            return None
        best = next(iter(found))
        drawn = best if terminal != "surface" else next((context for context in found if _IsDrawn(found[context][2])), best)
        if drawn != best:
            identifier = UsdShade.Shader(found[best][2]).GetShaderId() or "without an id"
            self._warn(material.GetPrim(), f"surface shader {identifier} is not supported; {_CONTEXTS[drawn]} is used")
        return found[drawn]

    def _NoteOrigins(self, attribute):
        """The prims of all connections that lead from an attribute of a prim that is noted to what its value comes from, also of
        those that lead nowhere: an edit may let them."""
        pending = [attribute]
        seen = set()
        while pending:
            attribute = pending.pop()
            for path in attribute.GetConnections():
                if path not in seen:
                    seen.add(path)
                    self._NoteOrigin(path.GetPrimPath().pathString)
                    source = attribute.GetStage().GetAttributeAtPath(path)
                    pending += [source] if source else []

    def _NoteOrigin(self, path):
        if not path.startswith(self._inside) and path != self._inside[:-1]:
            self.borrowed.setdefault(self._inside[:-1], set()).add(path)

    def _ReadNode(self, prim, pending):
        shader = UsdShade.Shader(prim)
        parameters = {}
        connections = {}
        for shaderInput in shader.GetInputs():
            name = shaderInput.GetBaseName()
            self._NoteOrigins(shaderInput.GetAttr())
            attributes = UsdShade.Utils.GetValueProducingAttributes(shaderInput)
            source = _SourceOf(attributes[0]) if attributes else None
            if source is not None:
                connections[name] = _core.Connection(*source[:2])
                pending.append(source[2])
                continue
            if missing := _MissingSource(shaderInput):
                self._warn(prim, f"input {name} is connected to {missing}, which does not exist")
            if attributes:
                self._ReadParameter(attributes[0], name, parameters)
        return _core.MaterialNode(prim.GetPath().pathString, shader.GetShaderId() or "", parameters, connections)

    def _ReadParameter(self, attribute, name, parameters):
        value = attribute.Get(self._timeCode)
        if value is None:
            return
        if isinstance(value, Sdf.AssetPath):
            parameters[name] = self._assets.Resolve(attribute, value)
            space = ColorSpaceOf(attribute)
        else:
            converted = ParameterFrom(value)
            if converted is None:
                return
            parameters[name] = converted
            isColor = isinstance(converted, list) and (len(converted) == 4 or len(converted) % 3 == 0)  # or a list of colours
            space = ColorSpaceOfColor(attribute) if isColor else ""
        if space:
            parameters["colorSpace:" + name] = space

    def _WarnOfOthers(self, material):
        """Names the contexts of the surfaces of a material that has none that is read, which commit warns of."""
        ending = "surface"
        contexts = {output.GetBaseName()[:-len(ending)] for output in material.GetOutputs() if output.GetBaseName().endswith(":" + ending)}
        contexts = sorted(context[:-1] for context in contexts.difference(_CONTEXTS))  # those that are read lead nowhere
        if contexts:
            self._warn(material.GetPrim(), "material has no UsdPreviewSurface or MaterialX surface, only "
                                           f"{', '.join(contexts)}: not supported yet")


def ParameterFrom(value):
    """A UsdShade value as the core's: bool, int, float, list of floats or string."""
    if isinstance(value, (bool, int, float, str)):
        return value
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind not in "fiub":
        return None
    return [float(item) for item in array.ravel()]


def _IsDrawn(prim):
    """Whether a surface shader is one that is drawn, behind what only hands it on or not."""
    seen = set()
    while prim.GetPath() not in seen:
        seen.add(prim.GetPath())
        shader = UsdShade.Shader(prim)
        identifier = shader.GetShaderId() or ""
        name = next((own for start, own in _HANDING_ON.items() if identifier.startswith(start)), None)
        if name is None:
            return _core.IsSurfaceShader(identifier)
        inner = shader.GetInput(name)
        source = _FindSource(inner) if inner else None
        if source is None:
            return False
        prim = source[2]
    return False  # a cycle


def _MissingSource(shaderInput):
    """The path of what an input is connected to where there is no such thing; None for others."""
    paths = shaderInput.GetAttr().GetConnections()
    stage = shaderInput.GetPrim().GetStage()
    return next((path for path in paths if not stage.GetAttributeAtPath(path)), None)


def _FindSource(shaderOutput):
    attributes = UsdShade.Utils.GetValueProducingAttributes(shaderOutput)
    return _SourceOf(attributes[0]) if attributes else None


def _SourceOf(attribute):
    """(shader path, output name, shader prim) when the attribute is a shader's output."""
    name, kind = UsdShade.Utils.GetBaseNameAndType(attribute.GetName())
    if kind != UsdShade.AttributeType.Output:
        return None
    prim = attribute.GetPrim()
    return prim.GetPath().pathString, name, prim
