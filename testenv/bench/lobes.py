# SPDX-License-Identifier: Apache-2.0
"""Lobes of layered surfaces beside Cycles' Principled BSDF and Mitsuba's microfacet plug-ins: lobes.py [--csv FILE].

A ball with one surface, seen along -z without perspective, so that a pixel's distance from the middle is the sine of the
angle to the viewer. Under a dome of radiance 1 a pixel is the directional albedo; under a sun of 20 degrees, which stands
45 degrees to the side, bands also depend on the lobe's shape. Printed: means of three bands of the cosine, and the ratios
rival / hdStream. What differs and why: docs/comparison.md.

Needs, in this Python: hdstream on the path, usd-core, bpy and mitsuba; a missing rival is left out.
"""

import argparse
import csv
import importlib.util
import math
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

import numpy as np  # noqa: E402

_BANDS = ((0.9, 1.0), (0.5, 0.9), (0.1, 0.5))  # of the cosine
_RED, _GOLD = (0.6, 0.3, 0.2), (0.9, 0.6, 0.3)
_GLASS = dict(base=0.0, transmission=1.0)
_SUN_DEGREES = 20.0

# Case: (inputs of Standard Surface, inputs of Principled, a BSDF of Mitsuba or none).
CASES = {
    **{f"dielectric {r}": (dict(base_color=_RED, specular_roughness=r), {"Base Color": _RED, "Roughness": r}, None)
       for r in (0.1, 0.5, 1.0)},
    **{f"metal {r}": (dict(base_color=_GOLD, metalness=1.0, specular_roughness=r), {"Base Color": _GOLD, "Metallic": 1.0, "Roughness": r},
                      None) for r in (0.2, 0.8)},
    "anisotropic": (dict(base_color=_GOLD, metalness=1.0, specular_roughness=0.4, specular_anisotropy=0.8),
                    {"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.4, "Anisotropic": 0.8 / 0.9}, None),
    "rough diffuse": (dict(base_color=_RED, specular=0.0, diffuse_roughness=1.0),
                      {"Base Color": _RED, "Diffuse Roughness": 1.0, "Specular IOR Level": 0.0}, None),
    "coat 0.1": (dict(base_color=_RED, specular_roughness=0.6, coat=1.0, coat_roughness=0.1),
                 {"Base Color": _RED, "Roughness": 0.6, "Coat Weight": 1.0, "Coat Roughness": 0.1}, None),
    "coat 0.5": (dict(base_color=_RED, specular_roughness=0.6, coat=1.0, coat_roughness=0.5),
                 {"Base Color": _RED, "Roughness": 0.6, "Coat Weight": 1.0, "Coat Roughness": 0.5}, None),
    "coat tinted": (dict(base_color=_RED, specular_roughness=0.6, coat=1.0, coat_roughness=0.1, coat_color=(0.3, 0.6, 1.0)),
                    {"Base Color": _RED, "Roughness": 0.6, "Coat Weight": 1.0, "Coat Roughness": 0.1, "Coat Tint": (0.3, 0.6, 1.0)}, None),
    **{f"sheen {r}": (dict(base_color=_RED, specular=0.0, sheen=1.0, sheen_roughness=r),
                      {"Base Color": _RED, "Specular IOR Level": 0.0, "Sheen Weight": 1.0, "Sheen Roughness": r}, None)
       for r in (0.3, 0.8)},
    "film": (dict(base_color=(0.02,) * 3, specular_roughness=0.2, thin_film_thickness=400.0, thin_film_IOR=1.8),
             {"Base Color": (0.02,) * 3, "Roughness": 0.2, "Thin Film Thickness": 400.0, "Thin Film IOR": 1.8}, None),
    "film on metal": (dict(base_color=_GOLD, metalness=1.0, specular_roughness=0.2, thin_film_thickness=400.0, thin_film_IOR=1.8),
                      {"Base Color": _GOLD, "Metallic": 1.0, "Roughness": 0.2, "Thin Film Thickness": 400.0, "Thin Film IOR": 1.8}, None),
    "glass": (dict(_GLASS, specular_roughness=0.0), {"Base Color": (1.0, 1.0, 1.0), "Transmission Weight": 1.0, "Roughness": 0.0},
              {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}),
    **{f"glass {r}": (dict(_GLASS, specular_roughness=r), {"Base Color": (1.0, 1.0, 1.0), "Transmission Weight": 1.0, "Roughness": r},
                      {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0, "alpha": r * r, "distribution": "ggx"})
       for r in (0.3, 0.6)},
}


def Bands(picture: np.ndarray) -> list:
    """Mean luminance [band] of a ball that fills a square picture."""
    size = len(picture)
    at = (np.arange(size) + 0.5) / size * 2 - 1
    sine2 = at[:, None] ** 2 + at[None, :] ** 2
    cosine = np.sqrt(np.maximum(1 - sine2, 0))
    luminance = picture @ [0.2126, 0.7152, 0.0722]
    return [float(luminance[(cosine >= low) & (cosine < high)].mean()) for low, high in _BANDS]


def _SunRadiance() -> float:
    """Of a sun whose irradiance is pi."""
    return 1 / math.sin(math.radians(_SUN_DEGREES / 2)) ** 2


def _HdStream(surface: dict, isSun: bool, size: int, samples: int, folder: str) -> np.ndarray:
    import ours
    from stages import author
    from stages.materialX import AddSurface, Ball

    path = f"{folder}/stage.usda"
    pathlib.Path(path).unlink(missing_ok=True)
    stage = author.NewStage(path)
    material = AddSurface(stage, "/World/Look", **surface)
    author.AddMesh(stage, "/World/Ball", Ball(1.0), material=material)
    if isSun:
        author.AddLight(stage, "/World/Light", "Distant", dict(rotate=(0, 45, 0)), angle=_SUN_DEGREES, intensity=_SunRadiance())
    else:
        author.AddLight(stage, "/World/Light", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 10), width=20.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(path, size, size, samples=samples, maxDepth=16).rgb


def _Cycles(inputs: dict, isSun: bool, size: int, samples: int) -> np.ndarray:
    import bpy
    import rivalsCycles

    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    rivalsCycles.Configure(target, dict(width=size, height=size, maxDepth=16, threads=2))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=1.0)
    ball = bpy.context.object
    ball.rotation_euler = (-math.pi / 2, 0, 0)  # poles along y, as the other ball
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(rivalsCycles.PrincipledLook({"IOR": 1.5, "Coat IOR": 1.5, **inputs}))
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0 if isSun else 1.0
    target.world = world
    if isSun:
        sun = bpy.data.lights.new("sun", "SUN")
        sun.angle, sun.energy = math.radians(_SUN_DEGREES), math.pi
        item = bpy.data.objects.new("sun", sun)
        item.rotation_euler = (0, math.pi / 4, 0)
        target.collection.objects.link(item)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 2.0
    item = bpy.data.objects.new("camera", camera)
    item.location = (0, 0, 10)
    target.collection.objects.link(item)
    target.camera = item
    return rivalsCycles.Renderer(target)(samples, 1)


def _Mitsuba(bsdf: dict, size: int, samples: int) -> np.ndarray:
    import mitsubaScene

    mitsubaScene.UseVariant("scalar_rgb")
    mi = mitsubaScene.mi
    place = mi.ScalarTransform4f().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0])
    scene = {"type": "scene", "integrator": {"type": "path", "max_depth": 18, "rr_depth": 1000},
             "sensor": {"type": "orthographic", "to_world": place, "film": {
                 "type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}},
             "light": {"type": "constant", "radiance": 1.0}, "ball": {"type": "sphere", "bsdf": bsdf}}
    return np.array(mi.render(mi.load_dict(scene), spp=samples, seed=1), np.float64)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--only", default="", help="cases whose name has this text")
    parser.add_argument("--size", type=int, default=48)
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args()
    has = {name: importlib.util.find_spec(name) is not None for name in ("bpy", "mitsuba")}
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (surface, principled, bsdf) in CASES.items():
            if options.only not in name:
                continue
            for light in ("dome", "sun") if "glass" not in name else ("dome",):
                own = Bands(_HdStream(surface, light == "sun", options.size, options.samples, folder))
                rivals = {}
                if has["bpy"]:
                    rivals["cycles"] = Bands(_Cycles(principled, light == "sun", options.size, options.samples))
                if has["mitsuba"] and bsdf is not None and light == "dome":
                    rivals["mitsuba"] = Bands(_Mitsuba(bsdf, options.size, options.samples))
                for rival, bands in rivals.items() or {"": own}.items():
                    rows.append([name, light, rival, *(f"{x:.4f}" for x in own), *(f"{b / a:.3f}" for a, b in zip(own, bands))])
                    print("  ".join(f"{cell:<14}" for cell in rows[-1]), flush=True)
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["case", "light", "rival", "middle", "between", "rim", "ratioMiddle", "ratioBetween", "ratioRim"])
            writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
