# SPDX-License-Identifier: Apache-2.0
"""Layers that are MaterialX files. PyPI's usd-core cannot open them: the package MaterialX reads them here.

A file becomes a layer in memory with a UsdShade material for each of its materials, at the paths that OpenUSD's own
plug-in gives them, /MaterialX/Materials/NAME. Layers that refer to the file are pointed to it, in memory only.
"""

import functools
import os
import pathlib

from pxr import Gf, Sdf, Tf, Usd, UsdShade

_TYPES = {
    "float": Sdf.ValueTypeNames.Float, "integer": Sdf.ValueTypeNames.Int, "boolean": Sdf.ValueTypeNames.Bool,
    "string": Sdf.ValueTypeNames.String, "filename": Sdf.ValueTypeNames.Asset,
    "color3": Sdf.ValueTypeNames.Color3f, "color4": Sdf.ValueTypeNames.Color4f,
    "vector2": Sdf.ValueTypeNames.Float2, "vector3": Sdf.ValueTypeNames.Vector3f,
    "vector4": Sdf.ValueTypeNames.Float4,
    "matrix33": Sdf.ValueTypeNames.Matrix3d, "matrix44": Sdf.ValueTypeNames.Matrix4d,
    # What has no value, and is connected only.
    "BSDF": Sdf.ValueTypeNames.Token, "EDF": Sdf.ValueTypeNames.Token, "VDF": Sdf.ValueTypeNames.Token,
    "surfaceshader": Sdf.ValueTypeNames.Token,
}
_VECTORS = {"color3": Gf.Vec3f, "color4": Gf.Vec4f, "vector2": Gf.Vec2f, "vector3": Gf.Vec3f, "vector4": Gf.Vec4f}
_MATRICES = {"matrix33": Gf.Matrix3d, "matrix44": Gf.Matrix4d}
_COLORS = ("color3", "color4")
_FALLBACK_SPACES = ("lin_rec709", "lin_rec709_scene")  # USD's, which goes without saying
_TERMINALS = {"surfaceshader": "surface", "displacementshader": "displacement"}
# Streams of geometry that inputs of definitions take where nothing is connected.
_GEOMETRY = ("texcoord", "position", "normal", "tangent", "bitangent", "viewdirection")
_STUDIO_FOLDERS = "PXR_MTLX_PLUGIN_SEARCH_PATHS"
_MOST_SHADERS = 1 << 12  # of a material: definitions of definitions may multiply without end
_layers = {}  # path -> layer as read last; an anonymous layer lives as long as someone holds it


def ReplaceFiles(stage):
    """Points the stage's layers to what its .mtlx files say now. Returns (file, problem) of those it cannot read."""
    dependencies = _Dependencies(stage)
    try:
        definitions, problems = _StudioDefinitions() if dependencies else ([], [])
    except ImportError:
        return [(file, "needs the package MaterialX: pip install MaterialX") for _, _, file in dependencies]
    read = set()
    updates = []
    for layer, dependency, file in dependencies:
        path = layer.ComputeAbsolutePath(file)
        try:
            if path not in read:
                _layers[path], left = _ReadLayer(path, definitions)
                read.add(path)
                problems += [(file, problem) for problem in left]
            updates.append((layer, dependency, _layers[path].identifier))
        except Exception as error:  # MaterialX's own errors have no common base
            problems.append((file, f"cannot be read: {_LineOf(error)}"))
    with Sdf.ChangeBlock():  # the stage is composed again once, not for each file
        for layer, dependency, identifier in updates:
            layer.UpdateCompositionAssetDependency(dependency, identifier)
    return problems


def UnreadFiles(stage):
    """The .mtlx files that a stage opened elsewhere refers to and nothing reads: OpenUSD without usdMtlx."""
    return [] if Sdf.FileFormat.FindByExtension("mtlx") else sorted({file for _, _, file in _Dependencies(stage)})


def _Dependencies(stage):
    """(layer, the text that names a file there, the file)"""
    found = []
    for layer in stage.GetUsedLayers():
        for dependency in layer.GetCompositionAssetDependencies():
            file = dependency
            if Sdf.VariableExpression.IsExpression(dependency):
                file = Sdf.VariableExpression(dependency).Evaluate(_Variables(stage, layer)).value
            if isinstance(file, str) and file.lower().endswith(".mtlx"):
                found.append((layer, dependency, file))
    return found


def _Variables(stage, layer):
    """The expression variables that a layer's expressions see: those of the stage count before its own."""
    layers = [layer, stage.GetRootLayer(), stage.GetSessionLayer()]
    return {name: value for one in layers if one for name, value in one.expressionVariables.items()}


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


def _LineOf(error):
    return str(error).splitlines()[0] if str(error) else repr(error)


def _ReadDocument(path):
    """A document whose elements know the files that they come from, those of files that it includes too."""
    import MaterialX as mx

    def Include(included, file, folders, options):  # MaterialX's own leaves the name as it is written there
        folders.append(mx.getEnvironmentPath())
        mx.readFromXmlFile(included, file, folders, options)
        included.setSourceUri(os.path.abspath(folders.find(file).asString()))

    if os.path.exists(path) and not os.path.isfile(path):
        raise OSError("it is not a file")  # of a pipe the reader would wait for the writer
    options = mx.XmlReadOptions()
    options.readXIncludeFunction = Include
    document = mx.createDocument()
    mx.readFromXmlFile(document, path, mx.FileSearchPath(), options)
    return document


def _StudioDefinitions():
    """The documents in the folders that usdMtlx looks in for a studio's own nodes, those that count first before
    others, and (file, problem) of those that cannot be read."""
    import MaterialX  # noqa: F401 - the lack of it is no problem of one file
    folders = [folder for folder in os.environ.get(_STUDIO_FOLDERS, "").split(os.pathsep) if folder]
    paths = [str(path) for folder in folders for path in sorted(pathlib.Path(folder).absolute().rglob("*.mtlx"))]
    documents, problems = [], []
    for path in dict.fromkeys(paths):  # a folder may lie in another
        try:
            documents.append(_ReadDocument(path))
        except Exception as error:  # MaterialX's own errors have no common base
            problems.append((path, f"of {_STUDIO_FOLDERS} cannot be read: {_LineOf(error)}"))
    return documents, problems


def _ReadLayer(path, studio=()):
    """(layer, what is said and not read)"""
    import MaterialX as mx
    document = _ReadDocument(path)
    materials = document.getMaterialNodes()  # without the studio's
    for definitions in studio:
        document.importLibrary(definitions)  # of one name the first stays
    if hasattr(document, "setDataLibrary"):  # from 1.39 on a document refers to it
        document.setDataLibrary(_Library())
    else:
        document.importLibrary(_Library())
    layer = Sdf.Layer.CreateAnonymous(os.path.basename(path) + ".usda")
    stage = Usd.Stage.Open(layer)
    stage.SetDefaultPrim(stage.DefinePrim("/MaterialX"))
    stage.DefinePrim("/MaterialX/Materials")
    left = {}  # in order, each once: materials may share nodes
    for material in materials:
        _Material(stage, material, mx, left).Write()
    return layer, list(left)


class _Call:
    """A node that is replaced by the node graph of its definition, within the call whose graph it stands in."""

    def __init__(self, node, definition, outer, path):
        self.node, self.definition, self.outer, self.path = node, definition, outer, path

    def Contains(self, definition):
        return self.definition.getName() == definition.getName() or (self.outer is not None and self.outer.Contains(definition))


class _Material:
    """Writes one material: all nodes above its terminals, without node graphs, as shaders below it.

    Nodes that the file defines itself by node graphs are written as the nodes of those, as OpenUSD's own plug-in does.
    """

    def __init__(self, stage, node, mx, left):
        """`left`: a dict, which gets what is said and not read as keys."""
        self._stage, self._node, self._mx, self._left = stage, node, mx, left
        self._path = f"/MaterialX/Materials/{Tf.MakeValidIdentifier(node.getName())}"
        self._shaders = {}

    def Write(self):
        material = UsdShade.Material.Define(self._stage, self._path)
        for kind, terminal in _TERMINALS.items():
            for node in self._mx.getShaderNodes(self._node, kind):
                found = self._Inside(node, "", None)
                if found is not None and isinstance(found[0], self._mx.Node):
                    output = material.CreateOutput(f"mtlx:{terminal}", Sdf.ValueTypeNames.Token)
                    output.ConnectToSource(self._Shader(found[0], found[2]).CreateOutput("out", Sdf.ValueTypeNames.Token))

    def _ShaderPath(self, node, call):
        name = node.getNamePath() if call is None else node.getName()
        return (self._path + "/" if call is None else call.path + "_") + Tf.MakeValidIdentifier(name)

    def _Shader(self, node, call):
        path = self._ShaderPath(node, call)
        if path in self._shaders:
            return self._shaders[path]
        if len(self._shaders) == _MOST_SHADERS:
            raise ValueError(f"{self._node.getName()}: more than {_MOST_SHADERS} nodes, with those of its definitions")
        shader = self._shaders[path] = UsdShade.Shader.Define(self._stage, path)
        definition = node.getNodeDef()
        shader.SetShaderId(definition.getName() if definition else f"ND_{node.getCategory()}_{node.getType()}")
        for source in node.getInputs():
            self._WriteInput(shader, source, call)
        return shader

    def _WriteInput(self, shader, source, call):
        name, kind = source.getName(), _TYPES.get(source.getType())
        found = self._Follow(source, call)
        if found is None:
            return
        if kind is None:
            if isinstance(found[0], self._mx.Node) or found[0].hasValueString():
                self._left[f"has {source.getNamePath()} of the type {source.getType()}, which is not read"] = True
            return
        origin, output, call = found
        if isinstance(origin, self._mx.Node):
            upstreamKind = _TYPES.get(origin.getType(), kind)
            shader.CreateInput(name, kind).ConnectToSource(self._Shader(origin, call).CreateOutput(output, upstreamKind))
        elif origin.hasValueString():
            self._WriteValue(shader.CreateInput(name, kind), origin)
        elif origin.hasDefaultGeomPropString():
            self._WriteGeometry(shader.CreateInput(name, kind), origin.getDefaultGeomProp())

    def _Follow(self, port, call):
        """What feeds a port: (node, its output, its call), or (the port with the value, "", None). None: nothing."""
        passed = set()
        while port.hasInterfaceName():
            if (port.getNamePath(), call) in passed:
                break
            passed.add((port.getNamePath(), call))
            outer = port.getInterfaceInput()
            if outer is None and call is not None:
                outer = call.node.getInput(port.getInterfaceName())
                if outer is None:
                    port = call.definition.getActiveInput(port.getInterfaceName())
                    return None if port is None else (port, "", None)
                call = call.outer
            if outer is None:
                break
            port = outer
        upstream = port.getConnectedNode()
        if upstream is None:
            return port, "", None
        output = port.getConnectedOutput()
        name = (port.getOutputString() if not port.hasNodeGraphString() else "") or \
            (output.getOutputString() if output is not None else "")
        return self._Inside(upstream, name, call)

    def _Inside(self, node, output, call):
        """As _Follow, of a node's output. A definition that calls itself is left as a node that is not known."""
        definition = node.getNodeDef()
        graph = None if definition is None else definition.getImplementation()
        isOwn = graph is not None and graph.isA(self._mx.NodeGraph) and _Library().getNodeDef(definition.getName()) is None
        if not isOwn or (call is not None and call.Contains(definition)):
            return node, output or "out", call
        outputs = graph.getOutputs()
        port = graph.getOutput(output) if output else None
        port = port if port is not None else outputs[0] if outputs else None
        inner = _Call(node, definition, call, self._ShaderPath(node, call))
        return None if port is None else self._Follow(port, inner)

    def _WriteGeometry(self, target, prop):
        """What an input of a definition is that nothing is connected to: texture coordinates, a position, a normal..."""
        if prop is None or prop.getGeomProp() not in _GEOMETRY:
            return
        path = f"{self._path}/{Tf.MakeValidIdentifier(prop.getName())}"
        shader = UsdShade.Shader.Define(self._stage, path)
        shader.SetShaderId(f"ND_{prop.getGeomProp()}_{prop.getType()}")
        if prop.getSpace():
            shader.CreateInput("space", Sdf.ValueTypeNames.String).Set(prop.getSpace())
        if prop.getIndex():
            shader.CreateInput("index", Sdf.ValueTypeNames.Int).Set(int(prop.getIndex()))
        target.ConnectToSource(shader.CreateOutput("out", target.GetTypeName()))

    def _WriteValue(self, target, source):
        kind = source.getType()
        if kind == "filename":
            folder = os.path.dirname(source.getActiveSourceUri())  # of the file that says it: an included one, a definition's
            target.Set(Sdf.AssetPath(os.path.join(folder, source.getResolvedValueString())))
            space = source.getActiveColorSpace()
            if space:
                target.GetAttr().SetColorSpace(space)
            return
        try:
            value = _MatrixOf(source) if kind in _MATRICES else source.getValue()
        except Exception:  # MaterialX's own errors have no common base
            value = None
        if value is None:
            raise ValueError(f'{source.getNamePath()}: "{source.getValueString()}" is no {kind}')
        space = source.getActiveColorSpace() if kind in _COLORS else ""
        if space and space not in _FALLBACK_SPACES:
            target.GetAttr().SetColorSpace(space)
        target.Set(_VECTORS[kind](*(value[i] for i in range(_VECTORS[kind].dimension))) if kind in _VECTORS else value)


def _MatrixOf(source):
    """Row by row, as MaterialX writes it and Gf takes it."""
    matrix = _MATRICES[source.getType()]
    items = [float(item) for item in source.getValueString().replace(",", " ").split()]
    return matrix(*items) if len(items) == matrix.dimension[0] ** 2 else None
