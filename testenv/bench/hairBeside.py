# SPDX-License-Identifier: Apache-2.0
"""A ball of hair beside Cycles and Mitsuba: `python testenv/bench/hairBeside.py [--samples N] [--size N] [--count N] [--depth N]
[--apart] [--renderers cycles]`, with a Python that has bpy, mitsuba, pxr and hdstream.

The same straight hairs, lights and camera in all; Cycles draws its Principled Hair BSDF (Chiang, absorption coefficient) on thick
curves, Mitsuba its BSDF `hair` on `bsplinecurve`. Printed are the means of a disk of radius 1.3 that the ball fills nearly, ours
over theirs by channel, and the mean and the greatest difference of blocks of 8 x 8 pixels over the mean. `--apart`: roots are spread
evenly, so that no hair is in another.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1]), str(pathlib.Path(__file__).resolve().parents[1] / "render")]

ABSORPTION, IOR, OFFSET, SKULL = (0.08, 0.25, 0.7), 1.55, 2.0, (0.2, 0.15, 0.1)  # offset: degrees of the cuticles
CASES = {"sky": (0.0, 1.0), "sun": (3.0, 0.0), "both": (2.0, 0.4)}  # irradiance of the sun, radiance of the sky
SUN = (-35.0, 40.0)  # rotations about x and y, degrees


def Ball(count: int, isApart: bool, beyond=0, seed=5):
    """Points [count][9][3] of hairs on a ball of radius 1, and radii [9]. isApart: they do not meet. beyond: points more at either end."""
    if isApart:  # a spiral of golden angles
        step = np.arange(count) + 0.5
        height, angle = 1 - 2 * step / count, np.pi * (3 - np.sqrt(5)) * step
        across = np.sqrt(1 - height**2)
        roots = np.stack([across * np.cos(angle), height, across * np.sin(angle)], -1)[:, None]
    else:
        roots = np.random.default_rng(seed).normal(size=(count, 1, 3))
        roots /= np.linalg.norm(roots, axis=-1, keepdims=True)
    along = np.arange(-beyond, 9 + beyond)[:, None] / 8
    return roots * (1 + 0.5 * along), 0.012 * (1 - 0.7 * along[:, 0])


def RenderCycles(points, radii, roughness, sun, sky, size, samples, depth) -> np.ndarray:
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    hair = bpy.data.hair_curves.new("hair")
    hair.add_curves([points.shape[1]] * len(points))
    hair.position_data.foreach_set("vector", points.reshape(-1).astype(np.float32))
    radius = hair.attributes.get("radius") or hair.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(radii, len(points)).astype(np.float32))
    material = bpy.data.materials.new("hair")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeBsdfHairPrincipled")
    shader.model, shader.parametrization = "CHIANG", "ABSORPTION"
    for name, value in {"Absorption Coefficient": ABSORPTION, "Roughness": roughness[0], "Radial Roughness": roughness[1], "Coat": 0.0,
                        "IOR": IOR, "Offset": np.radians(OFFSET), "Random Roughness": 0.0}.items():
        shader.inputs[name].default_value = value
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs[0])
    hair.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("hair", hair))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=1.0)
    skull = bpy.data.materials.new("skull")
    skull.use_nodes = True
    tree = skull.node_tree
    tree.nodes.clear()
    diffuse, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (*SKULL, 1.0)
    tree.links.new(diffuse.outputs[0], output.inputs[0])
    bpy.context.object.data.materials.append(skull)
    bpy.ops.object.shade_smooth()
    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = sky
    if sun > 0.0:
        light = bpy.data.lights.new("sun", "SUN")
        light.energy, light.angle = sun, 0.0
        placed = bpy.data.objects.new("sun", light)
        placed.rotation_euler = (*np.radians(SUN), 0.0)
        scene.collection.objects.link(placed)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 3.4
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 10)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = samples, False, False
    scene.cycles.pixel_filter_type, scene.cycles.blur_glossy = "BOX", 0.0
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(scene.cycles, name, depth)
    scene.cycles.sample_clamp_indirect = scene.cycles.sample_clamp_direct = 0.0
    scene.cycles_curves.shape = "THICK"
    scene.cycles_curves.subdivisions = 3
    scene.render.film_transparent = False
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = f"{folder}/picture.exr"
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(size * size * 4, np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(size, size, 4)[::-1, :, :3].astype(np.float64)


def RenderMitsuba(count, isApart, roughness, sun, sky, size, samples, depth) -> np.ndarray:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    points, radii = Ball(count, isApart, beyond=1)  # a B-spline through them ends one point before its last
    x, y = np.radians(SUN)
    sunlight = {"type": "directional", "direction": [-np.cos(x) * np.sin(y), np.sin(x), -np.cos(x) * np.cos(y)],
                "irradiance": {"type": "rgb", "value": [sun] * 3}}
    view = mi.ScalarTransform4f().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0]) @ mi.ScalarTransform4f().scale([1.7, 1.7, 1])
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        for curve in points:
            file.writelines("{:.7f} {:.7f} {:.7f} {:.7f}\n".format(*point, radius) for point, radius in zip(curve, radii))
            file.write("\n")
        file.flush()
        scene = {"type": "scene", "integrator": {"type": "path", "max_depth": depth + 2, "rr_depth": 1000},
                 "sensor": {"type": "orthographic", "to_world": view, "sampler": {"type": "independent"},
                            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}},
                 "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [sky] * 3}},
                 "skull": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(SKULL)}}},
                 "hair": {"type": "bsplinecurve", "filename": file.name,
                          "bsdf": {"type": "hair", "longitudinal_roughness": roughness, "azimuthal_roughness": roughness,
                                   "scale_tilt": -OFFSET, "int_ior": IOR, "sigma_a": {"type": "rgb", "value": list(ABSORPTION)}}}}
        return np.array(mi.render(mi.load_dict({**scene, **({"sun": sunlight} if sun > 0.0 else {})}), spp=samples), np.float64)


def RenderOurs(folder, points, radii, roughness, sun, sky, size, samples, depth) -> np.ndarray:
    import ours
    from stages import author, curves, shapes
    from stages.hair import AddHair

    stage = author.NewStage(f"{folder}/ball.usda")
    look = AddHair(stage, "/World/Look", ABSORPTION, roughness, cuticle=0.5 + OFFSET / 180, ior=IOR)
    hair = curves.AddCurves(stage, "/World/Hair", list(points), 2 * np.tile(radii, len(points)), basis="catmullRom", wrap="pinned")
    author.Bind(hair.GetPrim(), look)
    skull = author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 48, 96))
    skull.CreateDisplayColorAttr([SKULL])
    if sun > 0.0:
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(*SUN, 0)), intensity=sun, angle=0.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=sky)
    author.AddCamera(stage, eye=(0, 0, 10), width=34.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(f"{folder}/ball.usda", size, size, samples=samples, maxDepth=depth).rgb


def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--count", type=int, default=4000, help="hairs")
    parser.add_argument("--depth", type=int, default=48, help="bounces")
    parser.add_argument("--renderers", type=lambda text: text.split(","), default=["cycles", "mitsuba"])
    parser.add_argument("--apart", action="store_true", help="no hair is in another")
    parser.add_argument("--worker", nargs=4, metavar=("RENDERER", "CASE", "ROUGHNESS", "OUT"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    size, samples, depth = options.size, options.samples, options.depth
    points, radii = Ball(options.count, options.apart)
    if options.worker:  # in a process of its own: bpy has an OpenUSD of its own
        renderer, name, roughness, out = options.worker
        roughness = float(roughness)
        if renderer == "cycles":
            np.save(out, RenderCycles(points, radii, (roughness,) * 2, *CASES[name], size, samples, depth))
        else:
            np.save(out, RenderMitsuba(options.count, options.apart, roughness, *CASES[name], size, samples, depth))
        sys.stdout.flush()
        os._exit(0)
    x, y = np.meshgrid(*(1.7 * (2 * (np.arange(size) + 0.5) / size - 1),) * 2)
    isBall = x**2 + y**2 < 1.3**2
    with tempfile.TemporaryDirectory() as folder:
        # Above 0.44 MaterialX clamps a variance.
        for name, roughness in ((name, roughness) for name in CASES for roughness in (0.3, 0.4)):
            picture = RenderOurs(folder, points, radii, (roughness, roughness), *CASES[name], size, samples, depth)
            for renderer in options.renderers:
                numbers = [f"--{key}={getattr(options, key)}" for key in ("size", "samples", "depth", "count")]
                numbers += ["--apart"] * options.apart
                subprocess.run([sys.executable, __file__, *numbers, "--worker", renderer, name, str(roughness), f"{folder}/theirs.npy"],
                               check=True, stdout=subprocess.DEVNULL)
                theirs = np.load(f"{folder}/theirs.npy")
                blocks = [image.reshape(size // 8, 8, -1, 8, 3).mean((1, 3)) for image in (picture, theirs)]
                difference = np.abs(blocks[0] - blocks[1]) / blocks[1].mean()
                print(f"{name}, roughness {roughness}: ours / {renderer} {np.round(picture[isBall].mean(0) / theirs[isBall].mean(0), 3)}, "
                      f"blocks {difference.mean():.3f}, at most {difference.max():.3f}", flush=True)


if __name__ == "__main__":
    Main()
