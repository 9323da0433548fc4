# SPDX-License-Identifier: Apache-2.0
"""What of a scene Blender's exporters (4.5) do not hand over, in one line a kind: a picture that lacks something says so.

docs/blender.md has the table. Nodes were found by linking each kind of node to a Principled BSDF and looking at what
MaterialX comes of it; the exporter puts the input's own value in the place of a node that it does not know."""

_NAMED = 3  # names in a line, before "and N more"

# Of ShaderNodeX: no MaterialX comes of them.
_NODES = frozenset((
    "AmbientOcclusion", "Attribute", "BsdfHair", "BsdfHairPrincipled", "BsdfToon", "CameraData", "CombineHSV", "CombineRGB",
    "Displacement", "EeveeSpecular", "HairInfo", "Holdout", "LightPath", "ParticleInfo", "PointInfo", "SeparateHSV",
    "SeparateRGB", "ShaderToRGB", "Squeeze", "TexBrick", "TexGabor", "TexIES", "TexMagic", "TexPointDensity", "TexSky",
    "TexVoronoi", "UVAlongStroke", "ValToRGB", "VectorDisplacement", "VertexColor", "Wavelength", "Wireframe"))
# MaterialX comes of them that draws something else.
_OTHERS = frozenset(("Bevel", "Fresnel", "LayerWeight", "TexChecker", "TexGradient", "TexNoise", "TexWave", "TexWhiteNoise"))
_FULL_SPREAD = 3.1415  # of an area light, in radians
_DRAWN = ("MESH", "CURVES", "CURVE", "SURFACE", "FONT", "META", "VOLUME")


def Lines(depsgraph) -> list[str]:
    """The lines for the scene as it is now."""
    found = _Found(depsgraph.scene)
    for item in depsgraph.objects:
        found.AddObject(item)
    return found.Lines()


class _Found:
    """Names by what is said of them."""

    def __init__(self, scene):
        self._names, self._seen = {}, set()
        camera = scene.camera
        if camera is not None and camera.type == "CAMERA" and camera.data.type == "PANO":
            self._Add("a panoramic camera is drawn as perspective", camera.name)
        if scene.render.use_motion_blur:
            self._Add("motion blur is not drawn: Blender hands over one moment", "")
        if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
            self._Add("pixels that are not square are drawn as square ones", "")
        if scene.world is not None and scene.world.use_nodes:
            self._AddWorld(scene.world)

    def Lines(self):
        return [f"Stream: {text}{_Listed(names)}" for text, names in self._names.items()]

    def AddObject(self, item):
        """Of an object, and of its materials."""
        if item.type == "POINTCLOUD":
            self._Add("point clouds are not drawn", item.name)
        if item.type in _DRAWN and not item.visible_camera:
            self._Add("the camera sees objects that it is not to see", item.name)
        if item.type in _DRAWN and (item.is_holdout or item.is_shadow_catcher):
            self._Add("holdouts and shadow catchers are drawn as other objects", item.name)
        if item.type == "LIGHT" and _HasNodes(item.data):
            self._Add("Blender does not hand over nodes of lights", item.name)
        if item.type == "LIGHT" and item.data.type == "AREA" and item.data.spread < _FULL_SPREAD:
            self._Add("Blender does not hand over the spread of area lights", item.name)
        for slot in item.material_slots:
            material = slot.material
            if material is not None and material.use_nodes and material.name not in self._seen:
                self._seen.add(material.name)
                self._AddMaterial(material)

    def _AddMaterial(self, material):
        output = _Output(material.node_tree)
        if output is None:
            return
        if output.inputs["Volume"].is_linked:
            self._Add("volumes of materials are not drawn", material.name)
        if output.inputs["Displacement"].is_linked and material.displacement_method != "BUMP":
            self._Add("displacement of materials is not drawn", material.name)
        for node in _Reached(output.inputs["Surface"], (), {}):
            kind = node.bl_idname.removeprefix("ShaderNode")
            if kind in _NODES:
                self._Add("Blender does not hand over all nodes of materials", f"{node.bl_label} of {material.name}")
            elif kind in _OTHERS:
                self._Add("Blender hands over as something else nodes of materials", f"{node.bl_label} of {material.name}")
            elif kind == "Mix" and node.data_type == "RGBA" and node.blend_type != "MIX":
                self._Add("Blender hands over all blends of colours as Mix", material.name)

    def _AddWorld(self, world):
        """A colour or an image is handed over, and nothing else."""
        output = _Output(world.node_tree)
        if output is None or not output.inputs["Surface"].is_linked:
            return
        kinds = {"Background", "TexEnvironment", "Mapping", "TexCoord"}
        for node in _Reached(output.inputs["Surface"], (), {}):
            if node.bl_idname.removeprefix("ShaderNode") not in kinds:
                self._Add("of a world Blender hands over a colour or an image alone", node.bl_label)

    def _Add(self, text, name):
        names = self._names.setdefault(text, [])
        if name and name not in names:
            names.append(name)


def _Listed(names):
    if not names:
        return ""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f": {', '.join(names[:_NAMED])}{more}"


def _HasNodes(light):
    """Whether nodes of a light say anything beside its own colour and power."""
    output = _Output(light.node_tree) if light.use_nodes else None
    nodes = list(_Reached(output.inputs["Surface"], (), {})) if output is not None else []
    if [node.bl_idname for node in nodes] != ["ShaderNodeEmission"]:
        return bool(nodes)
    return [*nodes[0].inputs["Color"].default_value[:3], nodes[0].inputs["Strength"].default_value] != [1.0, 1.0, 1.0, 1.0]


def _Output(tree):
    """The output that is drawn; None: there is none."""
    return tree.get_output_node("CYCLES") if tree is not None else None


def _Reached(socket, groups, seen):
    """The nodes that an input depends on, those inside of groups too. groups: the group nodes around, outermost first."""
    for link in socket.links:
        node = link.from_node
        key = (*(group.as_pointer() for group in groups), node.as_pointer(), link.from_socket.identifier)
        if link.is_muted or key in seen:
            continue
        seen[key] = True
        if node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
            for inner in node.node_tree.nodes:
                if inner.bl_idname == "NodeGroupOutput" and inner.is_active_output:
                    for entry in inner.inputs:
                        if entry.identifier == link.from_socket.identifier:
                            yield from _Reached(entry, (*groups, node), seen)
        elif node.bl_idname == "NodeGroupInput" and groups:
            for entry in groups[-1].inputs:
                if entry.identifier == link.from_socket.identifier:
                    yield from _Reached(entry, groups[:-1], seen)
        else:
            if node.bl_idname not in ("NodeReroute", "NodeFrame"):
                yield node
            for entry in node.inputs:
                if entry.enabled:
                    yield from _Reached(entry, groups, seen)
