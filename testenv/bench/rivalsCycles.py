# SPDX-License-Identifier: Apache-2.0
"""A plain scene in Blender's Cycles on the CPU, and its renders.

Surfaces are the Principled BSDF with single-scattering GGX, which is UsdPreviewSurface but for Fresnel (the dielectric's
own) and Principled's compensation of albedo; diffuse without a material. Where opacity is below 1: a mix of transparent
and glossy by Fresnel, mixed with Principled by opacity. Lights are made by hand, because Blender's USD import changes
their energy: an area light of power P has radiance P / (pi A), a point light of radius r has P / (4 pi^2 r^2), a sun's
strength is its irradiance.
"""

import math
import tempfile

import bpy
import mathutils
import numpy as np
from pxr import Usd, UsdGeom

import rivalsMatter
from stages import imageFile


def Build(scene, job: dict):
    """render(samples, seed) -> [height][width][3]; and no counts to warm up. Takes the arrays out of `scene`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    Configure(target, job)
    looks = [_Look(material, i) for i, material in enumerate(scene.materials)]
    while scene.meshes:
        mesh = scene.meshes.pop()
        _AddMesh(target, mesh, looks[mesh.material], len(scene.meshes))
    if rivalsMatter.HasMatter(scene):  # the bounces of surfaces are those of Configure
        cycles = target.cycles
        cycles.max_bounces = cycles.volume_bounces = cycles.min_light_bounces = rivalsMatter.DEPTH
    for volume in scene.volumes:
        rivalsMatter.AddCyclesVolume(target, _Nodes("volume"), volume)
    _AddLights(target, scene.lights)
    _AddCamera(target, scene.camera)
    return Renderer(target), lambda samples: []


def BuildImported(path: str, camera: dict, lights: list, job: dict):
    """render(samples, seed) of a stage that Blender imports itself, under `lights` and `camera`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    Configure(target, job)
    bpy.ops.wm.usd_import(filepath=path, import_cameras=False, import_lights=False, import_subdiv=True, import_usd_preview=True,
                          import_guide=False, import_proxy=False, import_render=True, apply_unit_conversion_scale=False,
                          create_world_material=False, set_frame_range=False)
    for look in bpy.data.materials:
        look.cycles.use_bump_map_correction = False  # as in looks of ours: it takes light away where a normal map meets grazing light
    for item in target.objects:
        if item.type == "MESH" and not any(item.data.materials):
            item.data.materials.clear()
            item.data.materials.append(_DisplayLook("displayColor" in item.data.attributes))
    isYUp = UsdGeom.GetStageUpAxis(Usd.Stage.Open(path)) == UsdGeom.Tokens.y
    toBlender = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float) if isYUp else np.eye(4)
    for item in [*lights, camera]:
        if isinstance(item, dict):
            item["matrix"] = item["matrix"] @ toBlender
        else:
            item.matrix = item.matrix @ toBlender
    _AddLights(target, lights)
    _AddCamera(target, camera)
    return Renderer(target)


def Renderer(target):
    """render(samples, seed) -> [height][width][3]."""
    folder = tempfile.TemporaryDirectory()

    def Render(samples: int, seed: int) -> np.ndarray:
        target.cycles.samples, target.cycles.seed, target.render.filepath = samples, seed, f"{folder.name}/out.exr"
        bpy.ops.render.render(write_still=True)
        planes = imageFile.ReadExr(target.render.filepath)
        return np.stack([planes[name] for name in "RGB"], -1).astype(np.float64)

    return Render


def Configure(target, job: dict) -> None:
    """An honest comparison: box filter, no adaptive sampling, no denoiser, no clamping, no roulette before the last bounce."""
    target.render.engine = "CYCLES"
    cycles, depth = target.cycles, job["maxDepth"]
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.pixel_filter_type, cycles.filter_width, cycles.sampling_pattern = "BOX", 1.0, "TABULATED_SOBOL"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy, cycles.caustics_reflective, cycles.caustics_refractive = 0.0, True, True
    cycles.use_auto_tile = False
    # Cycles counts scattering events after the first hit; direct light at the last one included.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = depth
    cycles.transparent_max_bounces, cycles.min_light_bounces, cycles.min_transparent_bounces = 64, depth, 64
    render = target.render
    render.threads_mode, render.threads, render.use_persistent_data = "FIXED", job["threads"], True
    render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.exr_codec = "ZIP"
    target.view_settings.view_transform = "Standard"


def _AddMesh(target, mesh, look, index: int) -> None:
    data = bpy.data.meshes.new(f"mesh{index}")
    count = len(mesh.triangles)
    data.vertices.add(len(mesh.points))
    data.vertices.foreach_set("co", mesh.points.ravel())
    data.loops.add(3 * count)
    data.loops.foreach_set("vertex_index", mesh.triangles.ravel())
    data.polygons.add(count)
    data.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    data.polygons.foreach_set("use_smooth", np.full(count, mesh.normals is not None))
    if mesh.texcoords is not None:
        layer = data.uv_layers.new(name="st")
        layer.uv.foreach_set("vector", mesh.texcoords[mesh.triangles.ravel()].ravel())
    data.update(calc_edges=True)
    if mesh.normals is not None:
        data.normals_split_custom_set_from_vertices(mesh.normals)
    data.materials.append(look)
    for i, matrix in enumerate(mesh.places):
        item = bpy.data.objects.new(f"mesh{index}_{i}", data)
        item.matrix_world = mathutils.Matrix(matrix.T.tolist())
        item.shadow_terminator_geometry_offset = item.shadow_terminator_shading_offset = 0.0
        target.collection.objects.link(item)


class _Nodes:
    """A material's node tree; values are numbers, colours, Textures or outputs of nodes."""

    def __init__(self, name: str):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.material.cycles.use_bump_map_correction = False
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def Add(self, kind: str, inputs: dict, **properties):
        node = self._tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in inputs.items():
            self._Feed(node.inputs[name], value)
        return node

    def _Feed(self, port, value) -> None:
        if hasattr(value, "file"):
            value = self._Image(value)
        if isinstance(value, bpy.types.NodeSocket):
            self._tree.links.new(value, port)
        elif isinstance(value, tuple):
            port.default_value = (*value, 1.0)[: len(port.default_value)]
        else:
            port.default_value = value

    def _Image(self, texture):
        image = bpy.data.images.load(texture.file, check_existing=True)
        image.alpha_mode = "CHANNEL_PACKED"
        image.colorspace_settings.name = "sRGB" if texture.isSrgb else "Non-Color"
        node = self.Add("ShaderNodeTexImage", {}, image=image, interpolation="Linear", extension="REPEAT")
        if texture.output in ("rgb", "a"):
            return node.outputs["Color" if texture.output == "rgb" else "Alpha"]
        split = self.Add("ShaderNodeSeparateColor", {"Color": node.outputs["Color"]})
        return split.outputs["rgb".index(texture.output)]


def _Look(material: dict, index: int):
    nodes = _Nodes(f"material{index}")
    if "medium" in material or "subsurface" in material:
        return rivalsMatter.CyclesLook(nodes, material)
    if "lambert" in material:
        surface = nodes.Add("ShaderNodeBsdfDiffuse", {"Color": material["lambert"]}).outputs[0]
    else:
        inputs = {"Base Color": material["diffuseColor"], "Metallic": material["metallic"], "Roughness": material["roughness"],
                  "IOR": material["ior"], "Coat Weight": material["clearcoat"], "Coat Roughness": material["clearcoatRoughness"],
                  "Coat IOR": material["ior"], "Emission Color": material["emissiveColor"], "Emission Strength": 1.0}
        if material["normal"] is not None:
            inputs["Normal"] = nodes.Add("ShaderNodeNormalMap", {"Color": material["normal"]}, uv_map="st").outputs[0]
        surface = nodes.Add("ShaderNodeBsdfPrincipled", inputs, distribution="GGX").outputs[0]
        if material["opacity"] != 1.0:
            fresnel = nodes.Add("ShaderNodeFresnel", {"IOR": material["ior"]}).outputs[0]
            inputs = {"Color": (1.0, 1.0, 1.0), "Roughness": material["roughness"]}
            glossy = nodes.Add("ShaderNodeBsdfAnisotropic", inputs, distribution="GGX").outputs[0]
            transparent = nodes.Add("ShaderNodeBsdfTransparent", {}).outputs[0]
            pane = nodes.Add("ShaderNodeMixShader", {0: fresnel, 1: transparent, 2: glossy})
            surface = nodes.Add("ShaderNodeMixShader", {0: material["opacity"], 1: pane.outputs[0], 2: surface}).outputs[0]
    nodes.Add("ShaderNodeOutputMaterial", {"Surface": surface})
    return nodes.material


def _DisplayLook(hasColor: bool):
    """What USD draws without a material: Lambert of displayColor, else of 0.5. Blender's import leaves its own grey."""
    nodes = _Nodes("displayColor")
    color = nodes.Add("ShaderNodeAttribute", {}, attribute_name="displayColor").outputs["Color"] if hasColor else (0.5, 0.5, 0.5)
    surface = nodes.Add("ShaderNodeBsdfDiffuse", {"Color": color}).outputs[0]
    nodes.Add("ShaderNodeOutputMaterial", {"Surface": surface})
    return nodes.material


def PrincipledLook(inputs: dict):
    """A material of the Principled BSDF, which here keeps the energy of light that bounces more than once."""
    nodes = _Nodes("principled")
    surface = nodes.Add("ShaderNodeBsdfPrincipled", inputs, distribution="MULTI_GGX").outputs[0]
    nodes.Add("ShaderNodeOutputMaterial", {"Surface": surface})
    return nodes.material


def _AddLights(target, lights) -> None:
    for i, light in enumerate(lights):
        strength = max(float(light.radiance.max()), 1e-30)
        color = [float(c) / strength for c in light.radiance]
        if light.kind == "Dome":
            target.world = _World(light, color, strength)
            continue
        inputs, matrix = light.inputs, light.matrix
        if light.kind == "Distant":
            data = bpy.data.lights.new(f"light{i}", "SUN")
            half = math.radians(inputs["angle"] / 2)
            data.angle = 2 * half
            data.energy = strength * (math.pi * math.sin(half) ** 2 if half > 0 else 1.0)
        elif light.kind == "Sphere":
            data = bpy.data.lights.new(f"light{i}", "POINT")
            data.use_soft_falloff = False
            data.shadow_soft_size = inputs["radius"] * float(np.linalg.norm(matrix[0, :3]))
            data.energy = strength * 4 * math.pi**2 * data.shadow_soft_size**2
        else:  # Rect
            data = bpy.data.lights.new(f"light{i}", "AREA")
            data.shape, data.size, data.size_y = "RECTANGLE", inputs["width"], inputs["height"]
            scale = np.linalg.norm(matrix[:2, :3], axis=1)
            data.energy = strength * math.pi * inputs["width"] * scale[0] * inputs["height"] * scale[1]
        data.color = color
        item = bpy.data.objects.new(f"light{i}", data)
        item.visible_camera = True
        item.matrix_world = mathutils.Matrix(matrix.T.tolist())
        target.collection.objects.link(item)


def _World(light, color: list, strength: float):
    """USD's latlong image has +y up and +z in its middle, Blender's +z up and +x there."""
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    tree = world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (*color, 1.0), strength
    if light.inputs.get("texture:file"):
        rotation = light.matrix[:3, :3] / np.linalg.norm(light.matrix[:3, :3], axis=1, keepdims=True)
        fromLocal = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]) @ rotation  # rows: the image's axes in the world
        euler = mathutils.Matrix(fromLocal.tolist()).to_euler()
        mapping = tree.nodes.new("ShaderNodeMapping")
        mapping.vector_type, mapping.inputs["Rotation"].default_value = "POINT", euler
        image = tree.nodes.new("ShaderNodeTexEnvironment")
        image.image = bpy.data.images.load(light.inputs["texture:file"])
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], image.inputs["Vector"])
        scaled = tree.nodes.new("ShaderNodeVectorMath")
        scaled.operation, scaled.inputs[1].default_value = "MULTIPLY", color
        tree.links.new(image.outputs["Color"], scaled.inputs[0])
        tree.links.new(scaled.outputs[0], background.inputs["Color"])
    return world


def _AddCamera(target, camera: dict) -> None:
    data = bpy.data.cameras.new("camera")
    scale = 36.0 / (camera["width"] * 10)  # only the ratio counts, and Blender has no lens below 1 mm
    data.sensor_fit, data.sensor_width, data.lens = "HORIZONTAL", 36.0, camera["focal"] * 10 * scale
    data.clip_start, data.clip_end = 0.0001, 1e6
    data.shift_x, data.shift_y = (camera["offset"][axis] / camera["width"] for axis in (0, 1))
    if camera["fStop"] > 0:
        data.dof.use_dof, data.dof.focus_distance = True, camera["focus"]
        data.dof.aperture_fstop = camera["fStop"] / 100 * scale  # the lens counts in millimetres, the scene in metres
    item = bpy.data.objects.new("camera", data)
    item.matrix_world = mathutils.Matrix(camera["matrix"].T.tolist())
    target.collection.objects.link(item)
    target.camera = item
