# SPDX-License-Identifier: Apache-2.0
"""What of Blender arrives, row by row: blenderRows.py [--rows NAME ...] [--out FOLDER] [--picture FILE].

Builds one small scene a row (kinds of lights, materials, worlds) and renders it by Cycles and by Stream, over both ways in
which Blender hands a scene to Hydra (export methods HYDRA and USD). Printed: the mean luminance of Cycles' picture; ours over
Cycles' by luminance and by red, green and blue, of which the worst decides; the share of 8 x 8 blocks whose means are within
2 % in all three; and the mean alphas where they differ. A channel that Cycles' picture has nothing of is a dash.
docs/blender.md says why rows differ. --picture draws one scene by both, side by side, for that page, and no rows.

Runs in a Python that can import bpy, for whose OpenUSD the plug-in of the build was made. --out keeps the .blend files and
pictures.
"""

import argparse
import importlib
import math
import os
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "hydra")]

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402
from blenderProcess import RunAndExit  # noqa: E402

bpy.utils.expose_bundled_modules()

_SIZE, _BLOCK, _TOLERANCE = 128, 8, 0.02
_METHODS = ("HYDRA", "USD")
_RED, _GOLD = (0.6, 0.3, 0.2, 1.0), (0.9, 0.6, 0.3, 1.0)


# --- Scenes ----------------------------------------------------------------------------------------


def _Start(world=(0.0, 0.0, 0.0, 1.0), strength=1.0):
    """A grey floor and a camera that looks down on it."""
    import rivalsCycles

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    rivalsCycles.Configure(scene, dict(width=_SIZE, height=_SIZE, maxDepth=8, threads=os.cpu_count()))
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.use_persistent_data = False  # an engine that lives on keeps the prims of the other export method
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = world, strength
    bpy.ops.mesh.primitive_plane_add(size=8)
    _Look(bpy.context.object, {"Base Color": (0.5, 0.5, 0.5, 1.0), "Specular IOR Level": 0.0})
    bpy.ops.object.camera_add(location=(0, -6, 4), rotation=(math.radians(59), 0, 0))
    scene.camera = bpy.context.object
    return scene


def _Look(item, inputs):
    """A material of one Principled BSDF; returns the node."""
    material = bpy.data.materials.new("Look")
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    item.data.materials.clear()
    item.data.materials.append(material)
    return node


def _Light(kind, energy, **properties):
    def Build():
        scene = _Start()
        place = properties.pop("location", (0.5, -0.5, 5.0))
        bpy.ops.object.light_add(type=kind, location=place, rotation=(math.radians(15), 0, math.radians(20)))
        light = bpy.context.object.data
        light.energy = energy
        for name, value in properties.items():
            setattr(light, name, value)
        return scene

    return Build


def _World(**words):
    return lambda: _Start(**words)


def _WorldImage():
    """A sky that is bright on one side, turned by its mapping."""
    scene = _Start()
    tree = scene.world.node_tree
    image = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[..., 3] = 1.0
    pixels[16:, :16, :3] = (4.0, 2.0, 1.0)
    pixels[16:, 16:, 2] = 0.5
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = image
    mapping.inputs["Rotation"].default_value[2] = math.radians(70)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    return scene


def _Material(inputs, Edit=None):
    """A ball of the material over the floor, under an area light and a dim world."""
    def Build():
        scene = _Start(world=(0.3, 0.35, 0.4, 1.0))
        bpy.ops.object.light_add(type="AREA", location=(-2.0, -2.0, 4.0), rotation=(math.radians(35), 0, math.radians(-45)))
        bpy.context.object.data.energy, bpy.context.object.data.size = 250.0, 2.0
        bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=1.3, location=(0, 0, 1.3))
        bpy.ops.object.shade_smooth()
        node = _Look(bpy.context.object, inputs)
        if Edit:
            Edit(node.id_data, node)
        return scene

    return Build


def _AddImage(tree, node):
    image = bpy.data.images.new("checks", 64, 64)
    cells = (np.indices((64, 64)) // 8).sum(0) % 2
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[..., :3] = np.where(cells[..., None], (0.8, 0.3, 0.1), (0.1, 0.4, 0.7))
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], node.inputs["Base Color"])


def _Alone(*kinds):
    """One BSDF, or a mix of two, in place of Principled."""
    def Edit(tree, node):
        shaders = [tree.nodes.new(f"ShaderNode{kind}") for kind in kinds]
        if len(shaders) == 2:
            mix = tree.nodes.new("ShaderNodeMixShader")
            for i, shader in enumerate(shaders):
                tree.links.new(shader.outputs[0], mix.inputs[i + 1])
            shaders = [mix]
        tree.links.new(shaders[0].outputs[0], tree.nodes["Material Output"].inputs["Surface"])

    return Edit


def _HalfTransparent(tree, node):
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    for i, shader in enumerate((node, clear)):
        tree.links.new(shader.outputs[0], mix.inputs[i + 1])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def _MixInMix(tree, node):
    """Half of the material, and half of a mix of an emitting glossy BSDF and a transparent one."""
    inner = tree.nodes.new("ShaderNodeBsdfGlossy")
    for kind in ("Emission", "BsdfTransparent"):
        mix, shader = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new(f"ShaderNode{kind}")
        for i, side in enumerate((inner, shader)):
            tree.links.new(side.outputs[0], mix.inputs[i + 1])
        inner = mix
    outer = tree.nodes.new("ShaderNodeMixShader")
    for i, side in enumerate((node, inner)):
        tree.links.new(side.outputs[0], outer.inputs[i + 1])
    tree.links.new(outer.outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def _AddNode(kind, output="Color"):
    def Edit(tree, node):
        tree.links.new(tree.nodes.new(f"ShaderNode{kind}").outputs[output], node.inputs["Base Color"])

    return Edit


def _Film():
    scene = _Material({"Base Color": _RED})()
    scene.render.film_transparent = True
    return scene


def _Changed(Change):
    """The plain ball after `Change(scene, ball)`."""
    def Build():
        scene = _Material({"Base Color": _RED})()
        Change(scene, bpy.context.object)
        return scene

    return Build


def _Focus(scene, ball):
    scene.camera.data.dof.use_dof, scene.camera.data.dof.focus_distance, scene.camera.data.dof.aperture_fstop = True, 4.0, 0.05


def _Shift(scene, ball):
    scene.camera.data.shift_x, scene.camera.data.shift_y = 0.2, -0.1


def _Orthographic(scene, ball):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 5.0


def _Panorama(scene, ball):
    scene.camera.data.type = "PANO"


def _Subdivide(scene, ball):
    bpy.ops.mesh.primitive_cube_add(size=2.0, location=(0, -1.5, 1.0))
    modifier = bpy.context.object.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 3
    _Look(bpy.context.object, {"Base Color": _GOLD})


def _Instances(scene, ball):
    """A ball on each face of a cube."""
    bpy.ops.mesh.primitive_cube_add(size=1.6, location=(0, 0, 1.3))
    cube = bpy.context.object
    ball.scale = (0.3, 0.3, 0.3)
    ball.parent = cube
    cube.instance_type, cube.show_instancer_for_render = "FACES", False


def _Moving(scene, ball):
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    for frame, x in ((0, -1.0), (2, 1.0)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    scene.frame_set(1)


def _Hair(scene, ball):
    curves = bpy.data.hair_curves.new("Hair")
    curves.add_curves([4] * 60)
    for i, curve in enumerate(curves.curves):
        angle = 2.0 * math.pi * i / 60
        for j, point in enumerate(curve.points):
            reach = 1.3 + 0.25 * j
            point.position, point.radius = (reach * math.cos(angle), reach * math.sin(angle), 1.3), 0.05
    item = bpy.data.objects.new("Hair", curves)
    scene.collection.objects.link(item)
    _Look(item, {"Base Color": _GOLD})


def _Points(scene, ball):
    """The ball's vertices as a point cloud, by geometry nodes."""
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    begin, end, points = (tree.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshToPoints"))
    points.inputs["Radius"].default_value = 0.05
    tree.links.new(begin.outputs[0], points.inputs["Mesh"])
    tree.links.new(points.outputs[0], end.inputs[0])
    ball.modifiers.new("Points", "NODES").node_group = tree


def _Volume(scene, ball):
    tree = ball.data.materials[0].node_tree
    volume = tree.nodes.new("ShaderNodeVolumePrincipled")
    tree.links.new(volume.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    for link in list(tree.nodes["Material Output"].inputs["Surface"].links):
        tree.links.remove(link)


def _VolumeObject(scene, ball):
    """A grid of a file in the ball's place, without a material."""
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = str(HERE.parent / "translate" / "volumes" / "grids.vdb")
    smoke = bpy.data.objects.new("Smoke", volume)
    smoke.location, smoke.scale = ball.location.copy(), (2.0, 2.0, 2.0)
    smoke.location -= mathutils.Vector((1.25, 1.25, 1.25))
    scene.collection.objects.link(smoke)
    bpy.data.objects.remove(ball)


def _Unseen(scene, ball):
    ball.visible_camera = False


def _VertexColors(tree, node):
    mesh = bpy.context.object.data
    colors = mesh.color_attributes.new("Colors", "FLOAT_COLOR", "POINT")
    for vertex, color in zip(mesh.vertices, colors.data):
        color.color = (0.5 + 0.5 * vertex.normal.x, 0.5 + 0.5 * vertex.normal.y, 0.2, 1.0)
    attribute = tree.nodes.new("ShaderNodeVertexColor")
    attribute.layer_name = "Colors"
    tree.links.new(attribute.outputs["Color"], node.inputs["Base Color"])


ROWS = {
    "point": _Light("POINT", 200.0, shadow_soft_size=0.2),
    "point, 3000 K": _Light("POINT", 200.0, shadow_soft_size=0.2, use_temperature=True, temperature=3000.0),
    "point, 6500 K": _Light("POINT", 200.0, shadow_soft_size=0.2, use_temperature=True, temperature=6500.0),
    "spot": _Light("SPOT", 800.0, shadow_soft_size=0.1, spot_size=math.radians(50), spot_blend=0.15),
    "spot hard": _Light("SPOT", 800.0, shadow_soft_size=0.1, spot_size=math.radians(50), spot_blend=0.0),
    "lamp in view": _Light("POINT", 200.0, shadow_soft_size=0.2, location=(0.0, 1.0, 1.5)),
    "sun": _Light("SUN", 3.0, angle=math.radians(5)),
    "area": _Light("AREA", 100.0, size=1.0),
    "area disk": _Light("AREA", 100.0, shape="DISK", size=1.0),
    "area rectangle": _Light("AREA", 100.0, shape="RECTANGLE", size=1.0, size_y=0.4),
    "world": _World(world=(0.5, 0.6, 0.8, 1.0)),
    "world strength": _World(world=(0.5, 0.6, 0.8, 1.0), strength=2.0),
    "world image": _WorldImage,
    "plain": _Material({"Base Color": _RED}),
    "rough": _Material({"Base Color": _RED, "Diffuse Roughness": 1.0, "Roughness": 1.0}),
    "metal": _Material({"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.3}),
    "anisotropic": _Material({"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.4, "Anisotropic": 0.6}),
    "anisotropic turned": _Material({"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.4, "Anisotropic": 0.6,
                                     "Anisotropic Rotation": 0.125}),
    "emission": _Material({"Emission Color": _GOLD, "Emission Strength": 2.0}),
    "alpha": _Material({"Base Color": _RED, "Alpha": 0.4}),
    "image": _Material({}, _AddImage),
    "film": _Material({"Base Color": (0.02, 0.02, 0.02, 1.0), "Roughness": 0.2, "Thin Film Thickness": 400.0, "Thin Film IOR": 1.8}),
    "glass": _Material({"Base Color": (1.0, 1.0, 1.0, 1.0), "Roughness": 0.0, "Transmission Weight": 1.0, "IOR": 1.5}),
    "tinted glass": _Material({"Base Color": _RED, "Roughness": 0.3, "Transmission Weight": 1.0, "IOR": 1.5}),
    "coat": _Material({"Base Color": _RED, "Roughness": 0.6, "Coat Weight": 1.0, "Coat Roughness": 0.1}),
    "coat tint": _Material({"Base Color": _RED, "Roughness": 0.6, "Coat Weight": 1.0, "Coat Tint": (0.3, 0.6, 1.0, 1.0)}),
    "sheen": _Material({"Base Color": _RED, "Sheen Weight": 1.0, "Sheen Roughness": 0.5}),
    "subsurface": _Material({"Base Color": _RED, "Subsurface Weight": 1.0, "Subsurface Scale": 0.2}),
    "diffuse": _Material({}, _Alone("BsdfDiffuse")),
    "glossy": _Material({}, _Alone("BsdfGlossy")),
    "emitter": _Material({}, _Alone("Emission")),
    "mix": _Material({}, _Alone("BsdfDiffuse", "BsdfGlossy")),
    "half transparent": _Material({"Base Color": _RED}, _HalfTransparent),
    "diffuse, clear": _Material({}, _Alone("BsdfDiffuse", "BsdfTransparent")),
    "emitter, clear": _Material({}, _Alone("Emission", "BsdfTransparent")),
    "mix in mix": _Material({"Base Color": _RED}, _MixInMix),
    "noise": _Material({}, _AddNode("TexNoise")),
    "checker": _Material({}, _AddNode("TexChecker")),
    "voronoi": _Material({}, _AddNode("TexVoronoi")),
    "vertex colours": _Material({}, _VertexColors),
    "transparent film": _Film,
    "depth of field": _Changed(_Focus),
    "shift": _Changed(_Shift),
    "orthographic": _Changed(_Orthographic),
    "panorama": _Changed(_Panorama),
    "subdivision": _Changed(_Subdivide),
    "instances": _Changed(_Instances),
    "motion blur": _Changed(_Moving),
    "hair curves": _Changed(_Hair),
    "point cloud": _Changed(_Points),
    "volume": _Changed(_Volume),
    "volume object": _Changed(_VolumeObject),
    "unseen by camera": _Changed(_Unseen),
}


# --- Renders ---------------------------------------------------------------------------------------


def MakeEngine(folder: pathlib.Path) -> str:
    """Registers the extension, made in a new folder below `folder`."""
    from blenderCase import MakeExtension

    place = MakeExtension(pathlib.Path(tempfile.mkdtemp(dir=folder)), ".".join(map(str, bpy.app.version[:2])))
    sys.path.insert(0, str(place.parent))
    importlib.import_module(place.name).register()
    return "HYDRA_STREAM"


def Configure(scene, samples: int):
    """Settings that compare."""
    scene.cycles.samples = scene.hdstream.final.samples = samples
    scene.hdstream.final.pixelFilter, scene.hdstream.final.pixelFilterWidth = "box", 1.0


def Render(scene, file: pathlib.Path) -> np.ndarray:
    """[height][width][RGBA]."""
    from stages import imageFile

    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    planes = imageFile.ReadExr(file)
    return np.stack([planes.get(name, np.ones_like(planes["R"])) for name in "RGBA"], -1).astype(np.float64)


def _Luminance(picture):
    return picture[..., :3] @ [0.2126, 0.7152, 0.0722]


def _Blocks(picture):
    count = _SIZE // _BLOCK
    return picture[..., :3].reshape(count, _BLOCK, count, _BLOCK, 3).mean((1, 3))


def Compare(ours, cycles) -> str:
    means = [np.append(_Luminance(picture).mean(), picture[..., :3].mean((0, 1))) for picture in (ours, cycles)]
    ratios = [f"{first / second:6.3f}" if second > 1e-4 else "     -" for first, second in zip(*means)]
    first, second = _Blocks(ours), _Blocks(cycles)
    share = (np.abs(first - second) <= _TOLERANCE * second + 1e-4).all(-1).mean()
    alpha, wanted = ours[..., 3].mean(), cycles[..., 3].mean()
    text = f"{' '.join(ratios)} {100 * share:4.0f} %"
    return text + ("" if abs(alpha - wanted) < 0.005 else f"  alpha {alpha:.2f} for {wanted:.2f}")


def RunRow(name, engine, samples, folder):
    scene = ROWS[name]()
    stem = folder / name.replace(" ", "_")
    bpy.ops.wm.save_as_mainfile(filepath=f"{stem}.blend", check_existing=False)
    Configure(scene, samples)
    scene.render.engine = "CYCLES"
    cycles = Render(scene, stem.with_suffix(".cycles.exr"))
    columns = [f"{name:18s} {_Luminance(cycles).mean():8.4f}"]
    scene.render.engine = engine
    for method in _METHODS:
        scene.hydra.export_method = method
        columns.append(f"{Compare(Render(scene, stem.with_suffix(f'.{method}.exr')), cycles):54s}")
    return " | ".join(columns).rstrip()


def _Showcase():
    """Materials made in Blender, on a table under one lamp and a sky."""
    scene = _Start(world=(0.35, 0.42, 0.55, 1.0))
    scene.render.resolution_x, scene.render.resolution_y = 480, 320
    looks = ({"Base Color": _RED, "Roughness": 0.4}, {"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.2},
             {"Base Color": (1.0, 1.0, 1.0, 1.0), "Roughness": 0.0, "Transmission Weight": 1.0, "IOR": 1.5},
             {"Base Color": (0.02, 0.02, 0.02, 1.0), "Roughness": 0.2, "Thin Film Thickness": 400.0, "Thin Film IOR": 1.8},
             {"Base Color": (0.1, 0.25, 0.6, 1.0), "Sheen Weight": 1.0, "Sheen Roughness": 0.3},
             {"Emission Color": _GOLD, "Emission Strength": 1.5})
    for i, look in enumerate(looks):
        place = (1.5 * (i % 3) - 1.5, 1.4 * (i // 3) - 0.6, 0.6)
        if i == 1:
            bpy.ops.mesh.primitive_monkey_add(size=1.25, location=place, rotation=(math.radians(-20), 0, 0))
            bpy.ops.object.modifier_add(type="SUBSURF")
            bpy.context.object.modifiers[0].levels = bpy.context.object.modifiers[0].render_levels = 2
        else:
            bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.6, location=place)
        bpy.ops.object.shade_smooth()
        _Look(bpy.context.object, look)
    bpy.ops.object.light_add(type="AREA", location=(-2.5, -2.0, 4.0), rotation=(math.radians(35), 0, math.radians(-45)))
    bpy.context.object.data.energy, bpy.context.object.data.size = 350.0, 1.5
    scene.camera.location, scene.camera.rotation_euler = (0.0, -5.2, 2.9), (math.radians(63), 0, 0)
    return scene


def DrawPicture(engine, samples, file: pathlib.Path, folder):
    """Cycles left, Stream right, by Blender's standard display transform."""
    scene = _Showcase()
    Configure(scene, samples)
    scene.view_settings.view_transform = "Standard"
    halves = []
    for name in ("CYCLES", engine):
        scene.render.engine = name
        picture = Render(scene, folder / f"{name}.exr")
        halves.append(picture)
        print(f"{name:14s} mean {_Luminance(picture).mean():.4f}", flush=True)
    height, width = halves[0].shape[:2]
    both = np.ones((height, 2 * width + 8, 4), np.float32)
    both[:, :width], both[:, width + 8:] = halves
    image = bpy.data.images.new("both", 2 * width + 8, height, float_buffer=True)
    image.pixels.foreach_set(np.ascontiguousarray(both[::-1]).ravel())
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.quality = "JPEG", "RGB", 90
    image.save_render(str(file), scene=scene)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=list(ROWS))
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--picture", type=pathlib.Path, help="draw this JPEG in place of the rows")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.out or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        engine = MakeEngine(pathlib.Path(temporary))
        if args.picture:
            DrawPicture(engine, args.samples, args.picture.absolute(), folder)
            return
        heads = [f"{method:>6s}    red  green   blue blocks{'':20s}" for method in _METHODS]
        lines = [" | ".join([f"{'row':18s} {'Cycles':>8s}", *heads]).rstrip()]
        print(lines[0], file=sys.stderr, flush=True)
        for name in args.rows:
            lines.append(RunRow(name, engine, args.samples, folder))
            print(lines[-1], file=sys.stderr, flush=True)
    print("\n".join(lines), flush=True)


if __name__ == "__main__":
    RunAndExit(main)
