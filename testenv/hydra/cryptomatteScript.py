# SPDX-License-Identifier: Apache-2.0
"""In Blender's Python: cryptomatteScript.py FILE WIDTH HEIGHT NAMES OUT: mattes of an EXR as the compositor's Cryptomatte node makes them.

NAMES is a JSON list; OUT gets a .npz of an array [height][width] for each.
"""

import json
import os
import sys

import bpy
import numpy as np

file, width, height, names, out = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), json.loads(sys.argv[4]), sys.argv[5]
image = bpy.data.images.load(file)
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = os.path.splitext(out)[0] + ".exr"
scene.use_nodes = True
tree = scene.node_tree
tree.nodes.clear()
node = tree.nodes.new("CompositorNodeCryptomatteV2")
node.source, node.image = "IMAGE", image
node.layer_name = "crypto_object"
output = tree.nodes.new("CompositorNodeComposite")
output.use_alpha = False
tree.links.new(node.outputs["Matte"], output.inputs["Image"])
mattes = {}
for name in names:
    node.matte_id = name
    assert [entry.name for entry in node.entries] == [name], "the manifest does not know the name"
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    picture.colorspace_settings.name = "Non-Color"
    mattes[name] = np.array(picture.pixels[:]).reshape(height, width, 4)[::-1, :, 0]
    bpy.data.images.remove(picture)
np.savez(out, **mattes)
