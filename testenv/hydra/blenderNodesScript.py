# SPDX-License-Identifier: Apache-2.0
"""Which shader nodes Blender's exporter hands over, as MaterialX that something flows through: blenderNodesScript.py WORK writes
the names of those that it leaves out to WORK/nodes.json. packaging/blender/leftOut.py has the same from the list it keeps.

For a Python that can import bpy."""

import json
import os
import pathlib
import sys
import traceback

import bpy

bpy.utils.expose_bundled_modules()

from pxr import Usd, UsdShade  # noqa: E402

WORK = pathlib.Path(sys.argv[1])
# Of other trees than materials', no node of a picture's colour, or replaced by others when they are loaded.
_APART = {"Background", "LightFalloff", "MixRGB", "Script", "TexEnvironment", "TexImage"}
_count = 0


def Tree():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    material = bpy.data.materials.new("Look")
    material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    return material.node_tree


def IsExported(isShader):
    """Whether anything comes to the surface (a shader), or to its base colour, but a constant."""
    global _count
    _count += 1
    file = WORK / f"nodes{_count}.usda"
    bpy.ops.wm.usd_export(filepath=str(file), generate_materialx_network=True, generate_preview_surface=False)
    stage = Usd.Stage.Open(str(file))
    shaders = [UsdShade.Shader(prim) for prim in stage.Traverse() if prim.GetTypeName() == "Shader"]
    names = [str(shader.GetIdAttr().Get()) for shader in shaders]
    file.unlink()
    if isShader:
        return any(name.endswith("_bsdf") or name.endswith("_edf") or "open_pbr" in name for name in names)
    return any(bool(shader.GetInput("base_color").GetConnectedSources()[0])
               for shader, name in zip(shaders, names) if "open_pbr" in name)


def Comes(kind):
    """Whether one of the outputs of a node is handed over, when places in the world flow into all its inputs."""
    tree = Tree()
    node, place = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeNewGeometry")
    output, surface = tree.nodes["Material Output"], tree.nodes["Principled BSDF"]
    for entry in node.inputs:
        if entry.enabled and entry.type in ("VALUE", "VECTOR", "RGBA"):
            tree.links.new(place.outputs["Position"], entry)
    found = False
    for source in node.outputs:
        if not source.enabled or found:
            continue
        isShader = source.type == "SHADER"
        tree.links.new(source if isShader else surface.outputs[0], output.inputs["Surface"])
        if not isShader:
            tree.links.new(source, surface.inputs["Base Color"])
        found = IsExported(isShader)
    return found


def main():
    kinds = sorted(name.removeprefix("ShaderNode") for name in dir(bpy.types) if name.startswith("ShaderNode"))
    left = []
    for kind in kinds:
        if kind in _APART or kind.startswith(("Output", "Volume")) or kind in ("", "Tree", "Group", "CustomGroup"):
            continue
        try:
            if not Comes(kind) and kind not in ("AddShader", "MixShader"):  # of two shaders, and here they have none
                left.append(kind)
        except RuntimeError as error:  # of Blender's operators
            left.append(f"{kind}: {error}")
    (WORK / "nodes.json").write_text(json.dumps(left))


if __name__ == "__main__":
    status = 0
    try:
        main()
    except BaseException:  # pylint: disable=broad-except
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)  # Blender's own clean-up may wait for ever
