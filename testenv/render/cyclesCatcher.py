# SPDX-License-Identifier: Apache-2.0
"""cyclesCatcher.py STAGE OUT WIDTH HEIGHT: renders /World/Floor as a shadow catcher of Cycles with the other meshes, the sun and the
camera of a stage of testenv/render/test_shadowCatcher.py."""

import math
import os
import sys

import bpy
import mathutils
from pxr import Usd, UsdGeom, UsdLux

path, out, width, height = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
stage = Usd.Stage.Open(path)
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def Add(name, data, prim):
    item = bpy.data.objects.new(name, data)
    matrix = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    item.matrix_world = mathutils.Matrix([list(row) for row in matrix]).transposed()
    scene.collection.objects.link(item)
    return item


look = bpy.data.materials.new("look")
look.use_nodes = True
look.node_tree.nodes.clear()
diffuse = look.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
diffuse.inputs["Color"].default_value = (0.6, 0.6, 0.6, 1)
output = look.node_tree.nodes.new("ShaderNodeOutputMaterial")
look.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
for prim in stage.Traverse():
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        corners, faces = list(mesh.GetFaceVertexIndicesAttr().Get()), []
        for count in mesh.GetFaceVertexCountsAttr().Get():
            faces.append(corners[:count])
            corners = corners[count:]
        data = bpy.data.meshes.new(prim.GetName())
        data.from_pydata([tuple(point) for point in mesh.GetPointsAttr().Get()], [], faces)
        data.materials.append(look)
        Add(prim.GetName(), data, prim).is_shadow_catcher = prim.GetName() == "Floor"
    elif prim.IsA(UsdLux.DistantLight):
        sun = bpy.data.lights.new("sun", "SUN")
        sun.energy, sun.angle = 3.0, math.radians(UsdLux.DistantLight(prim).GetAngleAttr().Get())
        Add("sun", sun, prim)
    elif prim.IsA(UsdGeom.Camera):
        of = UsdGeom.Camera(prim)
        camera = bpy.data.cameras.new("camera")
        camera.lens, camera.sensor_width = of.GetFocalLengthAttr().Get(), of.GetHorizontalApertureAttr().Get()
        scene.camera = Add("camera", camera, prim)
world = bpy.data.worlds.new("world")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
scene.world = world
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1024, False, False
scene.cycles.max_bounces, scene.cycles.pixel_filter_type, scene.cycles.filter_width = 0, "BOX", 1.0
scene.render.film_transparent = True
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "OPEN_EXR", "RGBA"
scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "ZIP"
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
sys.stdout.flush()
os._exit(0)
