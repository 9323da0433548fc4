# SPDX-License-Identifier: Apache-2.0
"""A stage, read by the tests' stageReader, as a Blender scene for Cycles on the CPU (bench only).

Lights are rebuilt by hand, because Blender's USD import changes their energy: an area light of power
P has radiance P / (pi A), a point light of radius r has P / (4 pi^2 r^2), a sun's strength is its
irradiance. Lambert parts only: anything else is drawn with its diffuse colour.
"""

import math
import time

import bpy
import mathutils
import numpy as np


def Build(scene, width: int, height: int, maxDepth: int, threads: int) -> None:
    """Replaces Blender's scene and sets Cycles up for an honest comparison: box filter, no adaptive
    sampling, no denoiser, no clamping, no roulette before the last bounce."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    target.render.engine = "CYCLES"
    cycles = target.cycles
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy, cycles.caustics_reflective, cycles.caustics_refractive = 0.0, True, True
    # Cycles counts scattering events after the first hit; direct light at the last one included.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transparent_max_bounces = maxDepth
    cycles.min_light_bounces = maxDepth
    target.render.threads_mode, target.render.threads = "FIXED", threads
    target.render.resolution_x, target.render.resolution_y, target.render.resolution_percentage = width, height, 100
    target.render.image_settings.file_format, target.render.image_settings.color_depth = "OPEN_EXR", "32"
    target.view_settings.view_transform = "Standard"
    for i, part in enumerate(scene.parts):
        _AddPart(target, part, i)
    _AddLights(target, scene.lights)
    _AddCamera(target, scene.camera)


def _AddPart(target, part, index: int) -> None:
    mesh = bpy.data.meshes.new(f"part{index}")
    corners = part.positions.reshape(-1, 3)
    points, indices = np.unique(corners.astype(np.float32), axis=0, return_inverse=True)
    count = len(part.positions)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", indices.ravel().astype(np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.polygons.foreach_set("use_smooth", np.full(count, part.normals is not None))
    if part.normals is not None:
        mesh.normals_split_custom_set(part.normals.reshape(-1, 3).astype(np.float32))
    color = part.material["diffuseColor"] if part.material else part.primvars.get("displayColor", np.full((1, 1, 3), 0.18))[0, 0]
    material = bpy.data.materials.new(f"material{index}")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (*map(float, color), 1.0)
    material.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    target.collection.objects.link(bpy.data.objects.new(f"part{index}", mesh))


def _AddLights(target, lights) -> None:
    for i, light in enumerate(lights):
        strength = float(light.radiance.max())
        color = [float(c) / strength for c in light.radiance]
        if light.kind == "Dome":
            world = bpy.data.worlds.new("world")
            world.use_nodes = True
            background = world.node_tree.nodes["Background"]
            background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (*color, 1.0), strength
            target.world = world
            continue
        inputs, matrix = light.inputs, light.matrix
        if light.kind == "Distant":
            data = bpy.data.lights.new(f"light{i}", "SUN")
            half = math.radians(inputs["angle"] / 2)
            data.angle = 2 * half
            data.energy = strength * (math.pi * math.sin(half) ** 2 if half > 0 else 1.0)
        elif light.kind == "Sphere":
            data = bpy.data.lights.new(f"light{i}", "POINT")
            data.shadow_soft_size = inputs["radius"] * float(np.linalg.norm(matrix[0, :3]))
            data.energy = strength * 4 * math.pi**2 * data.shadow_soft_size**2
        elif light.kind == "Rect":
            data = bpy.data.lights.new(f"light{i}", "AREA")
            data.shape, data.size, data.size_y = "RECTANGLE", inputs["width"], inputs["height"]
            scale = np.linalg.norm(matrix[:2, :3], axis=1)
            data.energy = strength * math.pi * inputs["width"] * scale[0] * inputs["height"] * scale[1]
        else:
            raise ValueError(f"{light.kind} light is not handled")
        data.color = color
        item = bpy.data.objects.new(f"light{i}", data)
        item.visible_camera = True
        item.matrix_world = mathutils.Matrix(matrix.T.tolist())
        target.collection.objects.link(item)


def _AddCamera(target, camera: dict) -> None:
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.sensor_width, data.lens = "HORIZONTAL", camera["width"] * 10, camera["focal"] * 10
    data.clip_start, data.clip_end = 0.001, 1e6
    item = bpy.data.objects.new("camera", data)
    item.matrix_world = mathutils.Matrix(camera["matrix"].T.tolist())
    target.collection.objects.link(item)
    target.camera = item


def Render(samples: int, path: str) -> tuple[float, float]:
    """(seconds, mean radiance) of one render."""
    target = bpy.context.scene
    target.cycles.samples, target.render.filepath = samples, path
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - start
    image = bpy.data.images.load(path, check_existing=False)
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return seconds, float(pixels.reshape(-1, 4)[:, :3].mean())
