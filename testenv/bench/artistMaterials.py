# SPDX-License-Identifier: Apache-2.0
"""Twelve materials as artists build them, by MaterialX networks, beside Cycles: artistMaterials.py [--only TEXT] [--pictures FOLDER].

Car paint, brushed metal, velvet, skin, frosted glass, a soap film, wet asphalt, marble, leather, wax, a leaf, gold leaf: on a ball or a sheet
below a wide sun and a grey sky. Both renderers read the same images (EXR) at the same coordinates; what a formula of one names otherwise in
the other is computed here. Printed, of means of 8 x 8 pixels: Cycles / hdStream of all, of the block that differs most beyond its noise, and
that noise (one standard deviation). What differs and why: docs/comparison.md.

Needs, in this Python: hdstream on the path, usd-core and bpy.
"""

import argparse
import math
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "render")]

import numpy as np  # noqa: E402
from pxr import Gf, Sdf, UsdShade  # noqa: E402

from stages import author, imageFile, shapes  # noqa: E402
from stages.materialX import OPEN_PBR, STANDARD, AddNode, Ball  # noqa: E402

_T = Sdf.ValueTypeNames
_BLOCK, _SEEDS, _DEPTH = 8, 2, 16
_SUN = dict(angle=30.0, rotate=(-35, 40, 0), irradiance=2.0)
_SKY = 0.4
_CYCLES_RADIUS = 4 * math.pi  # of a random walk, over its mean free path


def _Smooth(seed: int, size: int = 64, cells: int = 8) -> np.ndarray:
    """Periodic noise between 0 and 1, smooth between `cells` values each way."""
    values = np.random.default_rng(seed).random((cells, cells))
    x = np.arange(size) * cells / size
    i, f = x.astype(int), x - x.astype(int)
    f = f * f * (3 - 2 * f)
    rows = values[i] * (1 - f)[:, None] + values[(i + 1) % cells] * f[:, None]
    return rows[:, i] * (1 - f) + rows[:, (i + 1) % cells] * f


def _Normals(heights: np.ndarray, slope: float) -> np.ndarray:
    """Codes of a normal map; rows go down, t goes up."""
    down, right = (np.roll(heights, -1, axis) - np.roll(heights, 1, axis) for axis in (0, 1))
    normal = np.stack([-slope * right, slope * down, np.ones_like(heights)], -1)
    return 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True) + 0.5


def _Between(low, high, share: np.ndarray) -> np.ndarray:
    low, high = np.asarray(low, float), np.asarray(high, float)
    return low + (high - low) * (share[..., None] if low.ndim else share)


class Images:
    """Images that both renderers read."""

    def __init__(self, folder: pathlib.Path):
        self._folder = folder

    def Write(self, name: str, values: np.ndarray) -> str:
        """One channel is written three times."""
        values = values if values.ndim == 3 else np.repeat(values[..., None], 3, 2)
        path = self._folder / f"{name}.exr"
        imageFile.WriteExr(path, {c: values[..., i] for i, c in enumerate("RGB")}, half=False)
        return str(path)


class Network:
    """MaterialX nodes below a material."""

    def __init__(self, stage):
        self._stage, self._count = stage, 0
        self.material = UsdShade.Material.Define(stage, "/World/Look")

    def Node(self, identifier: str, output=_T.Color3f, **inputs):
        self._count += 1
        return AddNode(self._stage, f"/World/Look/Node{self._count}", identifier, output, **inputs)

    def Color(self, file: str):
        return self.Node("ND_image_color3", file=Sdf.AssetPath(file))

    def Number(self, file: str):
        return self.Node("ND_image_float", _T.Float, file=Sdf.AssetPath(file))

    def Normal(self, file: str):
        return self.Node("ND_normalmap_float", _T.Vector3f, **{"in": self.Node("ND_image_vector3", _T.Vector3f, file=Sdf.AssetPath(file))})

    def Surface(self, identifier: str, **inputs) -> None:
        shader, _ = self.Node(identifier, _T.Token, **inputs)
        self.material.CreateSurfaceOutput("mtlx").ConnectToSource(shader.GetOutput("out"))


class Nodes:
    """Blender's nodes of a material."""

    def __init__(self):
        import bpy

        self._bpy = bpy
        self.material = bpy.data.materials.new("look")
        self.material.use_nodes = True
        self.material.cycles.use_bump_map_correction = False
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def Add(self, kind: str, inputs: dict, output=0, **properties):
        """A node's output."""
        node = self._tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in inputs.items():
            port = node.inputs[name]
            if isinstance(value, self._bpy.types.NodeSocket):
                self._tree.links.new(value, port)
            elif isinstance(value, tuple):
                port.default_value = (*value, 1.0)[: len(port.default_value)]
            else:
                port.default_value = value
        return node.outputs[output]

    def Image(self, file: str):
        image = self._bpy.data.images.load(file)
        image.colorspace_settings.name = "Non-Color"
        return self.Add("ShaderNodeTexImage", {}, image=image, interpolation="Linear", extension="REPEAT")

    def Normal(self, file: str):
        return self.Add("ShaderNodeNormalMap", {"Color": self.Image(file)}, uv_map="st")

    def Principled(self, inputs: dict, **properties) -> None:
        inputs = {"IOR": 1.5, "Coat IOR": 1.5, **inputs}
        self.Show(self.Add("ShaderNodeBsdfPrincipled", inputs, distribution="MULTI_GGX", **properties))

    def Show(self, surface) -> None:
        self.Add("ShaderNodeOutputMaterial", {"Surface": surface}, output=slice(0))


def _CarPaint(images, ours, cycles):
    flakes = np.random.default_rng(1).random((64, 64))
    color = images.Write("paint", _Between((0.35, 0.02, 0.02), (0.9, 0.25, 0.15), flakes > 0.8))
    normal = images.Write("flakes", _Normals(_Smooth(2, cells=32), 0.6))
    if ours:
        ours.Surface(OPEN_PBR, base_color=ours.Color(color), base_metalness=1.0, specular_roughness=0.35, geometry_normal=ours.Normal(normal),
                     coat_weight=1.0, coat_roughness=0.0, coat_ior=1.5, coat_darkening=0.0)
    else:
        cycles.Principled({"Base Color": cycles.Image(color), "Metallic": 1.0, "Roughness": 0.35, "Normal": cycles.Normal(normal),
                           "Coat Weight": 1.0, "Coat Roughness": 0.0})


def _BrushedMetal(images, ours, cycles):
    """Cycles stretches by the root of 1 - 0.9 a about the same mean, OpenPBR keeps the mean of the squares. MaterialX turns the other way."""
    stretch, turn = 0.3 + 0.5 * _Smooth(3), 0.25 * _Smooth(4, cells=4)
    roughness = np.full_like(stretch, 0.4)
    mean = roughness**2 * np.sqrt(2 * (1 - stretch) / (1 + (1 - stretch) ** 2))
    if ours:
        degrees = ours.Node("ND_multiply_float", _T.Float, in1=ours.Number(images.Write("turn", turn)), in2=-360.0)
        tangent = ours.Node("ND_rotate3d_vector3", _T.Vector3f, amount=degrees, axis=ours.Node("ND_normal_vector3", _T.Vector3f, space="world"),
                            **{"in": ours.Node("ND_tangent_vector3", _T.Vector3f, space="world")})
        ours.Surface(OPEN_PBR, base_color=(0.8, 0.75, 0.7), base_metalness=1.0, specular_roughness=0.4, geometry_tangent=tangent,
                     specular_roughness_anisotropy=ours.Number(images.Write("stretch", stretch)))
    else:
        cycles.Principled({"Base Color": (0.8, 0.75, 0.7), "Metallic": 1.0, "Roughness": cycles.Image(images.Write("rough", np.sqrt(mean))),
                           "Anisotropic": cycles.Image(images.Write("stretched", stretch / 0.9)),
                           "Anisotropic Rotation": cycles.Image(images.Write("turned", turn)),
                           "Tangent": cycles.Add("ShaderNodeTangent", {}, direction_type="UV_MAP", uv_map="st")})


def _Velvet(images, ours, cycles):
    color = images.Write("cloth", _Between((0.05, 0.01, 0.08), (0.2, 0.03, 0.3), _Smooth(5)))
    if ours:
        ours.Surface(OPEN_PBR, base_color=ours.Color(color), specular_weight=0.0, fuzz_weight=1.0, fuzz_color=(0.9, 0.6, 1.0), fuzz_roughness=0.5)
    else:
        cycles.Principled({"Base Color": cycles.Image(color), "Specular IOR Level": 0.0, "Sheen Weight": 1.0, "Sheen Tint": (0.9, 0.6, 1.0),
                           "Sheen Roughness": 0.5})


def _Below(images, ours, cycles, color, radius, weight=1.0, ior=1.5, roughness=0.4):
    if ours:
        color = ours.Color(color) if isinstance(color, str) else color
        ours.Surface(STANDARD, base=1.0, base_color=color, subsurface=weight, subsurface_color=color, subsurface_radius=radius,
                     specular_IOR=ior, specular_roughness=roughness)
    else:
        color = cycles.Image(color) if isinstance(color, str) else color
        cycles.Principled({"Base Color": color, "Subsurface Weight": weight, "Subsurface Radius": radius, "Subsurface Scale": _CYCLES_RADIUS,
                           "IOR": ior, "Roughness": roughness}, subsurface_method="RANDOM_WALK")


def _Skin(images, ours, cycles):
    _Below(images, ours, cycles, images.Write("skin", _Between((0.75, 0.45, 0.35), (0.85, 0.65, 0.55), _Smooth(6))), (0.12, 0.04, 0.02), ior=1.4)


def _Wax(images, ours, cycles):
    _Below(images, ours, cycles, (0.9, 0.75, 0.5), (0.3, 0.2, 0.1), roughness=0.5)


def _Marble(images, ours, cycles):
    veins = np.abs(2 * _Smooth(7) - 1) ** 0.3
    _Below(images, ours, cycles, images.Write("veins", _Between((0.3, 0.32, 0.35), (0.9, 0.88, 0.85), veins)), (0.03, 0.03, 0.03), weight=0.5,
           roughness=0.15)


def _FrostedGlass(images, ours, cycles):
    """Cycles tints by the root of the base colour each time that light passes."""
    roughness, tint = images.Write("frost", 0.15 + 0.35 * _Smooth(8)), (0.6, 0.9, 0.8)
    if ours:
        ours.Surface(STANDARD, base=0.0, transmission=1.0, transmission_color=tint, specular_roughness=ours.Number(roughness))
    else:
        cycles.Principled({"Base Color": tuple(c * c for c in tint), "Transmission Weight": 1.0, "Roughness": cycles.Image(roughness)})


def _SoapFilm(images, ours, cycles):
    """What a wall reflects, its inside being black: Cycles has no thin walls."""
    nanometres = 200 + 500 * np.tile(np.linspace(0, 1, 64), (64, 1))
    if ours:
        film = ours.Node("ND_multiply_float", _T.Float, in1=ours.Number(images.Write("film", nanometres)), in2=1e-3)
        ours.Surface(OPEN_PBR, transmission_weight=1.0, transmission_color=(0, 0, 0), geometry_thin_walled=True,
                     specular_roughness=0.3, specular_ior=1.5, thin_film_weight=1.0,
                     thin_film_thickness=film, thin_film_ior=1.33)
    else:
        cycles.Principled({"Base Color": (0.0, 0.0, 0.0), "Roughness": 0.3, "Thin Film IOR": 1.33,
                           "Thin Film Thickness": cycles.Image(images.Write("film", nanometres))})


def _WetAsphalt(images, ours, cycles):
    stone, wet = _Smooth(9, cells=24), np.clip(3 * _Smooth(10, cells=4) - 1, 0, 1)
    color, rough = images.Write("stone", _Between((0.03,) * 3, (0.2, 0.19, 0.18), stone)), images.Write("dry", 0.5 + 0.4 * stone)
    mask, normal = images.Write("wet", wet), images.Write("grain", _Normals(stone, 0.5))
    if ours:
        ours.Surface(STANDARD, base=1.0, base_color=ours.Color(color), specular_roughness=ours.Number(rough), normal=ours.Normal(normal),
                     coat=ours.Number(mask), coat_roughness=0.05, coat_IOR=1.33)
    else:
        cycles.Principled({"Base Color": cycles.Image(color), "Roughness": cycles.Image(rough), "Normal": cycles.Normal(normal),
                           "Coat Weight": cycles.Image(mask), "Coat Roughness": 0.05, "Coat IOR": 1.33})


def _Leather(images, ours, cycles):
    normal = images.Write("pores", _Normals(_Smooth(11, cells=20), 0.8))
    if ours:
        ours.Surface(STANDARD, base=1.0, base_color=(0.25, 0.1, 0.05), specular_roughness=0.5, normal=ours.Normal(normal), coat=0.6,
                     coat_roughness=0.2)
    else:
        cycles.Principled({"Base Color": (0.25, 0.1, 0.05), "Roughness": 0.5, "Normal": cycles.Normal(normal), "Coat Weight": 0.6,
                           "Coat Roughness": 0.2})


def _Leaf(images, ours, cycles):
    color = images.Write("leaf", _Between((0.1, 0.3, 0.05), (0.5, 0.6, 0.1), _Smooth(12)))
    if ours:
        front = ours.Node("ND_oren_nayar_diffuse_bsdf", _T.Token, color=ours.Color(color))
        back = ours.Node("ND_translucent_bsdf", _T.Token, color=ours.Color(color))
        mixed = ours.Node("ND_mix_bsdf", _T.Token, fg=back, bg=front, mix=0.4)
        ours.Surface("ND_surface", bsdf=mixed, thin_walled=True)
    else:
        front = cycles.Add("ShaderNodeBsdfDiffuse", {"Color": cycles.Image(color), "Roughness": 0.0})
        back = cycles.Add("ShaderNodeBsdfTranslucent", {"Color": cycles.Image(color)})
        cycles.Show(cycles.Add("ShaderNodeMixShader", {0: 0.4, 1: front, 2: back}))


def _GoldLeaf(images, ours, cycles):
    mask = images.Write("torn", np.clip(4 * _Smooth(13, cells=6) - 1.2, 0, 1))
    normal = images.Write("folds", _Normals(_Smooth(14, cells=10), 0.5))
    if ours:
        ours.Surface(OPEN_PBR, base_color=(0.95, 0.65, 0.3), base_metalness=1.0, specular_roughness=0.25, geometry_normal=ours.Normal(normal),
                     geometry_opacity=ours.Number(mask))
    else:
        cycles.Principled({"Base Color": (0.95, 0.65, 0.3), "Metallic": 1.0, "Roughness": 0.25, "Normal": cycles.Normal(normal),
                           "Alpha": cycles.Image(mask)})


# Name: (what builds it, whether on a sheet).
CASES = {"car paint": (_CarPaint, False), "brushed metal": (_BrushedMetal, False), "velvet": (_Velvet, False), "skin": (_Skin, False),
         "frosted glass": (_FrostedGlass, False), "soap film": (_SoapFilm, True), "wet asphalt": (_WetAsphalt, False),
         "marble": (_Marble, False), "leather": (_Leather, False), "wax": (_Wax, False), "leaf": (_Leaf, True), "gold leaf": (_GoldLeaf, True)}


def _Shape(isSheet: bool):
    """(shape, rotateXYZ in degrees)"""
    return (shapes.Plane(1.9, 1.9, 1, 1), (60, 0, 0)) if isSheet else (Ball(1.0), (20, -70, 0))


def _HdStream(build, isSheet, images, size, samples):
    """([seed][height][width][3], warnings, {prim: its matrix})"""
    import ours

    with tempfile.TemporaryDirectory() as folder:
        stage = author.NewStage(f"{folder}/stage.usda")
        network = Network(stage)
        build(images, network, None)
        shape, rotate = _Shape(isSheet)
        mesh = author.AddMesh(stage, "/World/Shape", shape, material=network.material, rotate=rotate, doubleSided=True)
        sun = author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=_SUN["rotate"]), angle=_SUN["angle"],
                              intensity=_SUN["irradiance"] / (math.pi * math.sin(math.radians(_SUN["angle"] / 2)) ** 2))
        author.AddLight(stage, "/World/Sky", "Dome", intensity=_SKY)
        author.AddCamera(stage, eye=(0, 0, 10), width=20.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        places = {name: np.array(prim.ComputeLocalToWorldTransform(0)) for name, prim in (("shape", mesh), ("sun", sun))}
        pictures = [ours.Render(f"{folder}/stage.usda", size, size, samples=samples, maxDepth=_DEPTH, seed=seed, kernels="general")
                    for seed in range(_SEEDS)]
    return np.stack([one.rgb for one in pictures]), pictures[0].warnings, places


def _Cycles(build, isSheet, images, size, samples, places):
    """[seed][height][width][3]"""
    import bpy
    import mathutils

    import rivalsCycles

    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    rivalsCycles.Configure(target, dict(width=size, height=size, maxDepth=_DEPTH, threads=2))
    nodes = Nodes()
    build(images, None, nodes)
    shape, _ = _Shape(isSheet)
    data = bpy.data.meshes.new("shape")
    data.from_pydata(shape.points.tolist(), [], np.reshape(shape.indices, (-1, 4)).tolist())
    data.uv_layers.new(name="st").uv.foreach_set("vector", shape.texcoords[shape.indices].ravel())
    data.polygons.foreach_set("use_smooth", np.full(len(data.polygons), True))
    data.normals_split_custom_set_from_vertices(shape.normals.tolist())
    data.materials.append(nodes.material)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.angle, sun.energy = math.radians(_SUN["angle"]), _SUN["irradiance"]
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 2.0
    for name, item, matrix in (("shape", data, places["shape"]), ("sun", sun, places["sun"]), ("camera", camera, np.eye(4))):
        thing = bpy.data.objects.new(name, item)
        thing.matrix_world = mathutils.Matrix(matrix.T.tolist())
        if name == "camera":
            thing.location, target.camera = (0, 0, 10), thing
        target.collection.objects.link(thing)
    target.world = bpy.data.worlds.new("world")
    target.world.use_nodes = True
    background = target.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1, 1, 1, 1), _SKY
    render = rivalsCycles.Renderer(target)
    return np.stack([render(samples, seed + 1) for seed in range(_SEEDS)])


def _Blocks(pictures: np.ndarray) -> np.ndarray:
    seeds, size = pictures.shape[:2]
    n = size // _BLOCK
    return pictures.reshape(seeds, n, _BLOCK, n, _BLOCK, 3).mean((2, 4))


def Compare(own: np.ndarray, other: np.ndarray) -> tuple:
    """(ratio of all by colour, ratio of the worst block, its noise)"""
    a, b = _Blocks(own), _Blocks(other)
    scale = a.mean(0) + 0.01 * a.mean()
    difference = (b.mean(0) - a.mean(0)) / scale
    noise = np.sqrt((a.var(0, ddof=1).mean() + b.var(0, ddof=1).mean()) / _SEEDS) / scale  # two seeds: one variance for all blocks
    worst = np.unravel_index(np.argmax(np.abs(difference) - 2 * noise), difference.shape)
    return other.mean((0, 1, 2)) / own.mean((0, 1, 2)), 1 + difference[worst], noise[worst]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="materials whose name has this text")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--samples", type=int, default=64, help="a pixel, of each of two seeds")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures: hdStream, Cycles")
    options = parser.parse_args()
    print("| material | Cycles / hdStream | worst block | its noise |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        images = Images(pathlib.Path(folder))
        for name, (build, isSheet) in CASES.items():
            if options.only not in name:
                continue
            own, warnings, places = _HdStream(build, isSheet, images, options.size, options.samples)
            other = _Cycles(build, isSheet, images, options.size, options.samples, places)
            ratios, worst, noise = Compare(own, other)
            print(f"| {name} | {' '.join(f'{r:.3f}' for r in ratios)} | {worst:.3f} | {noise:.3f} |", flush=True)
            for line in warnings:
                print(f"  {line}")
            if options.pictures:
                options.pictures.mkdir(parents=True, exist_ok=True)
                row = np.concatenate([own.mean(0), other.mean(0)], 1)
                imageFile.WritePng(options.pictures / f"{name}.png", (255 * np.clip(row, 0, 1) ** (1 / 2.2)).astype(np.uint8))
    return 0


if __name__ == "__main__":
    sys.exit(main())
