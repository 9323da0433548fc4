# SPDX-License-Identifier: Apache-2.0
"""Layers that are MaterialX files. PyPI's usd-core cannot open them: the package MaterialX reads them here.

A file becomes a layer in memory with a UsdShade material for each of its materials, at the paths that OpenUSD's own
plug-in gives them, /MaterialX/Materials/NAME. Layers that refer to the file are pointed to it, in memory only.
"""

import functools
import os

from pxr import Gf, Sdf, Tf, Usd, UsdShade

_TYPES = {
    "float": Sdf.ValueTypeNames.Float, "integer": Sdf.ValueTypeNames.Int, "boolean": Sdf.ValueTypeNames.Bool,
    "string": Sdf.ValueTypeNames.String, "filename": Sdf.ValueTypeNames.Asset,
    "color3": Sdf.ValueTypeNames.Color3f, "color4": Sdf.ValueTypeNames.Color4f,
    "vector2": Sdf.ValueTypeNames.Float2, "vector3": Sdf.ValueTypeNames.Vector3f,
    "vector4": Sdf.ValueTypeNames.Float4,
    # What has no value, and is connected only.
    "BSDF": Sdf.ValueTypeNames.Token, "EDF": Sdf.ValueTypeNames.Token, "VDF": Sdf.ValueTypeNames.Token,
    "surfaceshader": Sdf.ValueTypeNames.Token,
}
_VECTORS = {"color3": Gf.Vec3f, "color4": Gf.Vec4f, "vector2": Gf.Vec2f, "vector3": Gf.Vec3f, "vector4": Gf.Vec4f}
_COLORS = ("color3", "color4")
_FALLBACK_SPACES = ("lin_rec709", "lin_rec709_scene")  # USD's, which goes without saying
_TERMINALS = {"surfaceshader": "surface", "displacementshader": "displacement"}
_layers = {}  # path -> layer as read last; an anonymous layer lives as long as someone holds it


def ReplaceFiles(stage):
    """Points the stage's layers to what its .mtlx files say now. Returns (file, problem) of those it cannot read."""
    problems = []
    read = set()
    updates = []
    for layer, dependency in _Dependencies(stage):
        path = layer.ComputeAbsolutePath(dependency)
        try:
            if path not in read:
                _layers[path] = _ReadLayer(path)
                read.add(path)
            updates.append((layer, dependency, _layers[path].identifier))
        except ImportError:
            problems.append((dependency, "needs the package MaterialX: pip install MaterialX"))
        except Exception as error:  # MaterialX's own errors have no common base
            problems.append((dependency, f"cannot be read: {str(error).splitlines()[0] if str(error) else error!r}"))
    with Sdf.ChangeBlock():  # the stage is composed again once, not for each file
        for layer, dependency, identifier in updates:
            layer.UpdateCompositionAssetDependency(dependency, identifier)
    return problems


def UnreadFiles(stage):
    """The .mtlx files that a stage opened elsewhere refers to and nothing reads: OpenUSD without usdMtlx."""
    return [] if Sdf.FileFormat.FindByExtension("mtlx") else sorted({dependency for _, dependency in _Dependencies(stage)})


def _Dependencies(stage):
    """(layer, file as it names it)"""
    return [(layer, dependency) for layer in stage.GetUsedLayers() for dependency in layer.GetCompositionAssetDependencies()
            if dependency.lower().endswith(".mtlx")]


def IsRead(path):
    """Whether a file, by its resolved path, was read here: what OpenUSD said of it before does not hold."""
    return path in _layers


@functools.lru_cache(maxsize=None)
def _Library():
    """MaterialX's definitions of nodes: 50 ms to read, the same for all files."""
    import MaterialX as mx
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    return library


def _ReadLayer(path):
    import MaterialX as mx
    document = mx.createDocument()
    mx.readFromXmlFile(document, path)
    if hasattr(document, "setDataLibrary"):  # from 1.39 on a document refers to it
        document.setDataLibrary(_Library())
    else:
        document.importLibrary(_Library())
    layer = Sdf.Layer.CreateAnonymous(os.path.basename(path) + ".usda")
    stage = Usd.Stage.Open(layer)
    stage.SetDefaultPrim(stage.DefinePrim("/MaterialX"))
    stage.DefinePrim("/MaterialX/Materials")
    for material in document.getMaterialNodes():
        if material.getSourceUri() == "" or os.path.samefile(material.getSourceUri(), path):
            _Material(stage, material, mx, os.path.dirname(path)).Write()
    return layer


class _Material:
    """Writes one material: all nodes above its terminals, without node graphs, as shaders below it."""

    def __init__(self, stage, node, mx, folder):
        self._stage, self._node, self._mx, self._folder = stage, node, mx, folder
        self._path = f"/MaterialX/Materials/{Tf.MakeValidIdentifier(node.getName())}"
        self._shaders = {}

    def Write(self):
        material = UsdShade.Material.Define(self._stage, self._path)
        for kind, terminal in _TERMINALS.items():
            for node in self._mx.getShaderNodes(self._node, kind):
                output = material.CreateOutput(f"mtlx:{terminal}", Sdf.ValueTypeNames.Token)
                output.ConnectToSource(self._Shader(node).CreateOutput("out", Sdf.ValueTypeNames.Token))

    def _Shader(self, node):
        known = self._shaders.get(node.getNamePath())
        if known is not None:
            return known
        path = f"{self._path}/{Tf.MakeValidIdentifier(node.getNamePath())}"
        shader = self._shaders[node.getNamePath()] = UsdShade.Shader.Define(self._stage, path)
        definition = node.getNodeDef()
        shader.SetShaderId(definition.getName() if definition else f"ND_{node.getCategory()}_{node.getType()}")
        for source in node.getInputs():
            self._WriteInput(shader, source)
        return shader

    def _WriteInput(self, shader, source):
        name, value = source.getName(), source
        passed = {value.getNamePath()}
        while value.hasInterfaceName():
            outer = value.getInterfaceInput()
            if outer is None or outer.getNamePath() in passed:
                break
            passed.add(outer.getNamePath())
            value = outer
        upstream = value.getConnectedNode()
        kind = _TYPES.get(source.getType())
        if upstream is not None and kind is not None:
            target = self._Shader(upstream)
            output = value.getConnectedOutput()
            outputName = (value.getOutputString() if not value.hasNodeGraphString() else "") or \
                (output.getOutputString() if output is not None else "") or "out"
            upstreamKind = _TYPES.get(upstream.getType(), kind)
            shader.CreateInput(name, kind).ConnectToSource(target.CreateOutput(outputName, upstreamKind))
        elif kind is not None and value.hasValueString():
            self._WriteValue(shader.CreateInput(name, kind), value)

    def _WriteValue(self, target, source):
        kind = source.getType()
        if kind == "filename":
            target.Set(Sdf.AssetPath(os.path.join(self._folder, source.getResolvedValueString())))
            space = source.getActiveColorSpace()
            if space:
                target.GetAttr().SetColorSpace(space)
            return
        try:
            value = source.getValue()
        except Exception:  # MaterialX's own errors have no common base
            value = None
        if value is None:
            raise ValueError(f'{source.getNamePath()}: "{source.getValueString()}" is no {kind}')
        space = source.getActiveColorSpace() if kind in _COLORS else ""
        if space and space not in _FALLBACK_SPACES:
            target.GetAttr().SetColorSpace(space)
        target.Set(_VECTORS[kind](*(value[i] for i in range(_VECTORS[kind].dimension))) if kind in _VECTORS else value)
