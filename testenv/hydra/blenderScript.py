# SPDX-License-Identifier: Apache-2.0
"""What test_blender.py judges: blenderScript.py EXTENSION WORK NAME ... runs scenarios in Blender's module, with the extension
that lies in the folder EXTENSION, and writes what they found to WORK/NAME.json.

For a Python that can import bpy, for whose OpenUSD the plug-in was built."""

import gc
import importlib
import json
import math
import os
import pathlib
import sys
import traceback

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import bpy  # noqa: E402
import numpy as np  # noqa: E402

SIZE = 64
EXTENSION, WORK = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
sys.path.insert(0, str(EXTENSION.parent))
extension = importlib.import_module(EXTENSION.name)


# --- Scenes and renders ----------------------------------------------------------------------------


def Scene(engine="HYDRA_STREAM", samples=16, world=(0.5, 0.6, 0.8, 1.0)):
    """A ball on a floor under a world and an area light, with a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Scene, "hdstream"):
        extension.register()
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.hdstream.final.samples = scene.cycles.samples = samples
    scene.hdstream.final.pixelFilter, scene.hdstream.final.pixelFilterWidth = "box", 1.0
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.sample_clamp_indirect = 0.0
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = world
    bpy.ops.mesh.primitive_plane_add(size=6)
    Look((0.5, 0.5, 0.5, 1.0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.0, location=(0, 0, 1))
    bpy.ops.object.shade_smooth()
    Look((0.6, 0.3, 0.2, 1.0))
    bpy.ops.object.light_add(type="AREA", location=(-2, -2, 4), rotation=(math.radians(35), 0, math.radians(-45)))
    bpy.context.object.data.energy = 100.0
    bpy.ops.object.camera_add(location=(0, -6, 4), rotation=(math.radians(59), 0, 0))
    scene.camera = bpy.context.object
    scene.view_settings.view_transform = "Raw"
    return scene


def Look(color):
    material = bpy.data.materials.new("Look")
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value, node.inputs["Specular IOR Level"].default_value = color, 0.0
    bpy.context.object.data.materials.clear()
    bpy.context.object.data.materials.append(material)
    return node


def Render(scene, engine=None):
    """Passes by name, [height][width] or [height][width][channels], from the top; and messages that stopped the render."""
    if engine:
        scene.render.engine = engine
    # The result's passes cannot be read from Python; a multilayer file holds them.
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    file = WORK / "result.exr"
    file.unlink(missing_ok=True)
    scene.render.filepath = str(file)
    errors = ""
    try:
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        errors = str(error)
    return Planes(file), errors


def Planes(file):
    from stages import imageFile

    planes = imageFile.ReadExr(file) if file.exists() else {}
    return {name.partition(".")[2]: values.astype(np.float64) for name, values in planes.items()}


def Luminance(planes):
    return sum(weight * planes[f"Combined.{name}"] for weight, name in zip((0.2126, 0.7152, 0.0722), "RGB"))


class Watched:
    """The engine's messages and status lines while it renders."""

    def __init__(self):
        self.engine = sys.modules[f"{EXTENSION.name}.engine"].StreamRenderEngine
        self.reports, self.lines, self.steps, self.stopAt = [], [], 0, None

    def __enter__(self):
        engine, watch = self.engine, self
        self.was = {name: getattr(engine, name) for name in ("_Show", "_Tell", "_IsCancelled")}

        def Tell(this, kind, line):
            watch.reports.append([kind, line])
            watch.was["_Tell"](this, kind, line)

        def Show(this, status, title):
            watch.steps += 1
            if status["fraction"] > 0.0:
                watch.lines.append(sys.modules[f"{EXTENSION.name}.engine"].StatusLine(status))
            watch.status = status
            watch.was["_Show"](this, status, title)

        engine._Tell, engine._Show = Tell, Show
        if self.stopAt is not None:
            engine._IsCancelled = lambda this: watch.steps >= watch.stopAt
        return self

    def __exit__(self, *_):
        for name, function in self.was.items():
            setattr(self.engine, name, function)


# --- Scenarios -------------------------------------------------------------------------------------


def Passes():
    """Each pass beside Cycles': the share of pixels that agree, by export method."""
    found = {}
    scene = Scene(samples=256)
    layer = scene.view_layers[0]
    for name in ("z", "position", "normal", "uv"):
        setattr(layer, f"use_pass_{name}", True)
    layer.hdstream.use_denoising_data = layer.cycles.denoising_store_passes = True
    wanted, _ = Render(scene, "CYCLES")
    for method in ("HYDRA", "USD"):
        scene.hydra.export_method = method
        ours, errors = Render(scene, "HYDRA_STREAM")
        shares = {}
        for name, values in ours.items():
            if name in wanted and not name.startswith("Combined"):
                isGood = np.abs(values - wanted[name]) <= 2e-3 * (1.0 + np.abs(wanted[name]))
                shares[name] = float(isGood.mean())
                shares[f"{name} of hits"] = float(isGood[wanted["Depth.Z"] < 1e9].mean())
        ratio = float(Luminance(ours).mean() / Luminance(wanted).mean())
        found[method] = {"shares": shares, "ratio": ratio, "errors": errors,
                         "channels": sorted(ours)}
    return found


def Framing():
    """Border renders, crops and percentages: ours over Cycles', and where something was drawn."""
    found = {}
    for name, words in {"border": {"use_border": True}, "crop": {"use_border": True, "use_crop_to_border": True},
                        "percentage": {"resolution_percentage": 50}, "wide": {"resolution_x": 2 * SIZE},
                        "odd": {"use_border": True, "use_crop_to_border": True, "border_min_x": 0.13,
                                "border_max_x": 0.71}}.items():
        scene = Scene(samples=64)
        scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
        scene.render.border_min_y, scene.render.border_max_y = 0.25, 0.75
        for key, value in words.items():
            setattr(scene.render, key, value)
        wanted, _ = Render(scene, "CYCLES")
        ours, errors = Render(scene, "HYDRA_STREAM")
        first, second = Luminance(ours), Luminance(wanted)
        isSame = first.shape == second.shape
        found[name] = {"shape": list(first.shape), "wanted": list(second.shape), "errors": errors,
                       "difference": float(np.abs(first - second).mean() / second.mean()) if isSame else None,
                       "drawn": float((first > 0).mean()), "drawnWanted": float((second > 0).mean())}
    return found


def Film():
    """Alpha and colour of the background, with and without a transparent film."""
    found = {}
    for isTransparent in (False, True):
        scene = Scene()
        scene.render.film_transparent = isTransparent
        ours, _ = Render(scene)
        found[str(isTransparent)] = {"alpha": float(ours["Combined.A"][0, 0]), "blue": float(ours["Combined.B"][0, 0]),
                                     "alphaOfBall": float(ours["Combined.A"][SIZE // 2, SIZE // 2])}
    return found


def Exposure():
    """Of the film of Cycles: the means of ours over Cycles', of the picture and of the background."""
    found = {}
    for factor in (3.0, 0.25, 0.0):
        scene = Scene(samples=64)
        scene.cycles.film_exposure = factor
        wanted, _ = Render(scene, "CYCLES")
        ours, errors = Render(scene, "HYDRA_STREAM")
        first, second = Luminance(ours), Luminance(wanted)
        found[str(factor)] = {"errors": errors, "alpha": float(ours["Combined.A"].min()), "brightest": float(first.max()),
                              "wanted": float(second.max())}
        if factor > 0.0:
            found[str(factor)] |= {"ratio": float(first.mean() / second.mean()), "background": float(first[0, 0] / second[0, 0])}
    return found


def Lamp():
    """The brightest pixel of a picture with a lamp in the camera's view, ours over Cycles'."""
    scene = Scene(samples=64, world=(0.0, 0.0, 0.0, 1.0))
    bpy.ops.object.light_add(type="POINT", location=(0.0, -1.5, 2.0))
    bpy.context.object.data.energy, bpy.context.object.data.shadow_soft_size = 20.0, 0.2
    wanted, _ = Render(scene, "CYCLES")
    ours, _ = Render(scene, "HYDRA_STREAM")
    return {"brightest": float(Luminance(ours).max() / Luminance(wanted).max())}


def Status():
    """Status lines of one render of several steps, and whether percentages only grow."""
    scene = Scene(samples=4096)
    scene.hdstream.final.timeLimit = 4.0
    with Watched() as watch:
        Render(scene)
    return {"lines": watch.lines, "steps": watch.steps, "reports": watch.reports, "isDone": watch.status["isDone"]}


def Cancel():
    """A render that is stopped after three steps, and one after it."""
    scene = Scene(samples=1 << 20)
    watch = Watched()
    watch.stopAt = 3
    with watch:
        Render(scene)
    scene.hdstream.final.samples = 4
    with Watched() as after:
        Render(scene)
    return {"isDone": watch.status["isDone"], "steps": watch.steps, "after": after.status["samplesTotal"],
            "afterIsDone": after.status["isDone"]}


def _Reported(change):
    """The messages of a render after `change(scene)`; then of one that is as it was."""
    scene = Scene()
    undo = change(scene)
    with Watched() as watch:
        _, errors = Render(scene)
    if undo:
        undo()
    with Watched() as after:
        planes, _ = Render(Scene())
    return {"reports": watch.reports, "errors": errors, "after": after.reports,
            "afterMean": float(Luminance(planes).mean()) if planes else 0.0}


def Messages():
    plugin = sys.modules[f"{EXTENSION.name}.plugin"]

    def Replace(name, value):
        def Change(scene):
            was = getattr(plugin, name)
            setattr(plugin, name, value)
            plugin.Problem.cache_clear()

            def Undo():
                setattr(plugin, name, was)
                plugin.Problem.cache_clear()

            return Undo

        return Change

    def NoDevice(scene):
        scene.hdstream.machine.device = "no such device"

    def SmallBudget(scene):
        scene.hdstream.machine.residency, scene.hdstream.machine.geometryMemory = "stream", "1K"

    def BadSize(scene):
        scene.hdstream.machine.textureMemory = "many"

    def MissingTexture(scene):
        node = Look((1.0, 1.0, 1.0, 1.0)) if bpy.context.object.type == "MESH" else None
        for item in scene.objects:
            if item.type == "MESH":
                node = item.data.materials[0].node_tree.nodes["Principled BSDF"]
        image = bpy.data.images.load(str(HERE.parent / "stages" / "imageFile.py"))  # a file that is no image
        image.filepath = str(WORK / "missing.png")
        texture = node.id_data.nodes.new("ShaderNodeTexImage")
        texture.image = image
        node.id_data.links.new(texture.outputs["Color"], node.inputs["Base Color"])

    empty = WORK / "empty.so"
    empty.write_text("no library")
    return {"no plug-in": _Reported(Replace("PLUGIN", WORK / "none.so")),
            "damaged plug-in": _Reported(Replace("PLUGIN", empty)),
            "wrong Blender": _Reported(Replace("MADE_FOR", {**plugin.MADE_FOR, "blender": "4.2"})),
            "wrong OpenUSD": _Reported(Replace("MADE_FOR", {**plugin.MADE_FOR, "usd": [0, 24, 5]})),
            "no device": _Reported(NoDevice), "small budget": _Reported(SmallBudget), "bad size": _Reported(BadSize),
            "missing texture": _Reported(MissingTexture)}


def Settings():
    """What reaches the plug-in: pictures of one sample differ by seed and are equal for equal seeds, but for roundings:
    Blender names materials by their addresses, and the order of names is that of sums."""
    pictures = []
    for seed, samples in ((1, 1), (1, 1), (2, 1), (1, 64)):
        scene = Scene(samples=samples)
        scene.hdstream.final.seed = seed
        planes, _ = Render(scene)
        pictures.append(Luminance(planes))
    same, again, other, many = pictures
    return {"isSame": bool(np.allclose(same, again, rtol=1e-4)), "isOther": not np.allclose(same, other, rtol=1e-2),
            "noise": float(np.abs(same - many).mean() / many.mean())}


def LeftOut():
    """What is said of a scene with things that do not come, of one without, and where that cannot be told."""
    scene = Scene(samples=1)
    with Watched() as plain:
        Render(scene)
    balls = [item for item in scene.objects if item.type == "MESH" and item.location.z > 0]
    for i in range(4):
        bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0.5 * i, -2.0, 0.2))
        tree = Look((0.5, 0.5, 0.5, 1.0)).id_data
        bpy.context.object.data.materials[0].name = f"Rock {i}"
        balls.append(bpy.context.object)
        group = bpy.data.node_groups.new("Inside", "ShaderNodeTree")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        cells, end, outer = group.nodes.new("ShaderNodeTexVoronoi"), group.nodes.new("NodeGroupOutput"), tree.nodes.new("ShaderNodeGroup")
        group.links.new(cells.outputs["Color"], end.inputs[0])
        outer.node_tree = group
        link = tree.links.new(outer.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
        link.is_muted = i == 3  # nothing comes of a link that is off
        tree.nodes.new("ShaderNodeTexBrick")  # nor of a node that nothing is made of
    balls[0].visible_camera, balls[1].is_holdout = False, True
    material = balls[1].data.materials[0]
    volume, blend = (material.node_tree.nodes.new(f"ShaderNode{name}") for name in ("VolumeAbsorption", "Mix"))
    blend.data_type, blend.blend_type = "RGBA", "MULTIPLY"
    material.node_tree.links.new(volume.outputs[0], material.node_tree.nodes["Material Output"].inputs["Volume"])
    material.node_tree.links.new(blend.outputs[2], material.node_tree.nodes["Principled BSDF"].inputs["Emission Color"])
    scene.render.use_motion_blur, scene.camera.data.type = True, "PANO"
    sky = scene.world.node_tree.nodes.new("ShaderNodeTexSky")
    scene.world.node_tree.links.new(sky.outputs[0], scene.world.node_tree.nodes["Background"].inputs["Color"])
    light = next(item for item in scene.objects if item.type == "LIGHT").data
    light.use_nodes, light.spread = True, 1.0
    light.node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
    with Watched() as watch:
        Render(scene)
    sys.modules[f"{EXTENSION.name}.leftOut"].Lines = lambda depsgraph: depsgraph.nothing
    with Watched() as failed:
        planes, _ = Render(Scene(samples=1))
    return {"plain": plain.reports, "reports": watch.reports, "failed": failed.reports, "drawn": float(Luminance(planes).mean())}


def ResidentBytes():
    """Memory of this process, and no children's."""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def Life(count=12):
    """Renders and edits in one process: memory after each, and that edits arrive."""
    scene = Scene(samples=4)
    ball = next(item for item in scene.objects if item.type == "MESH" and item.location.z > 0)
    sizes, means = [], []
    for i in range(count):
        ball.location.x = 0.1 * (i % 5)
        ball.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value[0] = 0.2 + 0.6 * (i % 2)
        scene.render.use_persistent_data = i % 4 == 3
        planes, _ = Render(scene)
        means.append(float(planes["Combined.R"].mean()))
        gc.collect()
        sizes.append(ResidentBytes())
    return {"sizes": sizes, "means": means}


def Panels():
    """Which of Blender's panels are shown for us, and that all of ours can be unregistered and registered."""
    Scene()
    shown = sorted(panel.__name__ for panel in bpy.types.Panel.__subclasses__()
                   if "HYDRA_STREAM" in getattr(panel, "COMPAT_ENGINES", ()))
    extension.unregister()
    left = sorted(panel.__name__ for panel in bpy.types.Panel.__subclasses__()
                  if "HYDRA_STREAM" in getattr(panel, "COMPAT_ENGINES", ()))
    wasLeft = hasattr(bpy.types.Scene, "hdstream")
    extension.register()
    return {"shown": shown, "left": [name for name in left if not name.startswith("STREAM")], "propertiesLeft": wasLeft}


def main():
    scenarios = {function.__name__: function for function in
                 (Passes, Framing, Film, Exposure, Lamp, Status, Cancel, Messages, LeftOut, Settings, Life, Panels)}
    extension.register()
    for name in sys.argv[3:] or scenarios:
        found = scenarios[name]()
        (WORK / f"{name}.json").write_text(json.dumps(found, indent=1))


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
