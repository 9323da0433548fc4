# SPDX-License-Identifier: Apache-2.0
"""Materials of MaterialX files with the surface model as they say it, or as that model's own node graph of MaterialX's library."""

import os
import tempfile

import MaterialX
from pxr import Sdf, UsdShade


def _Library():
    library = MaterialX.createDocument()
    MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library)
    return library


def NewDocument():
    """An empty document with MaterialX's library of definitions."""
    document = MaterialX.createDocument()
    document.setDataLibrary(_Library())
    return document


def ReadDocument(path: str):
    """The document of a file. Images are named by their whole paths."""
    document = NewDocument()
    MaterialX.readFromXmlFile(document, str(path))
    for element in document.traverseTree():
        if element.getAttribute("type") == "filename" and element.hasValueString():
            source = os.path.join(os.path.dirname(os.path.abspath(path)), element.getActiveSourceUri())
            element.setValueString(os.path.join(os.path.dirname(source), element.getResolvedValueString()))
    for element in [document, *document.traverseTree()]:
        element.removeAttribute("fileprefix")
    return document


def SurfaceNodes(document):
    """{name of the material: its surface shader's node}"""
    found = {}
    for material in document.getMaterialNodes():
        for node in MaterialX.getShaderNodes(material, "surfaceshader"):
            found[material.getName()] = node
    return found


def ReplaceSurfaces(document):
    """Surface shaders become the nodes of their definitions' node graphs; other nodes stay as they are."""
    document.flattenSubgraphs("", lambda node: node.getType() == "surfaceshader")


def ReadLayer(document):
    """The layer that hdStream makes of a document; its materials are at /MaterialX/Materials."""
    from hdstream import materialXFiles

    options = MaterialX.XmlWriteOptions()
    options.writeXIncludeEnable = False
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "document.mtlx")
        MaterialX.writeToXmlFile(document, path, options)
        layer, _ = materialXFiles._ReadLayer(path)
        return layer


def CopyMaterial(layer, name: str, stage, path: str) -> UsdShade.Material:
    """A material of such a layer as a prim of a stage."""
    Sdf.CopySpec(layer, f"/MaterialX/Materials/{name}", stage.GetRootLayer(), path)
    return UsdShade.Material.Get(stage, path)
