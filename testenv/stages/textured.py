# SPDX-License-Identifier: Apache-2.0
"""Textured materials, and a stage that reads textures in every way: near and far, through mirrors, as colours, bumps,
roughness and masks, of odd sizes, 8 and 16 bits, one channel to four."""

import pathlib

import numpy as np
from pxr import Sdf, UsdShade

from . import author, imageFile, photograph, shapes


def AddTexturedMaterial(stage, path: str, textures: dict, wrap: str = "repeat", **inputs) -> UsdShade.Material:
    """A UsdPreviewSurface with inputs that read textures at `st`. `textures` maps an input to (file, output) or
    (file, output, inputs of the texture by name)."""
    material = author.AddMaterial(stage, path, **inputs)
    reader = UsdShade.Shader.Define(stage, path + "/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    st = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    surface = UsdShade.Shader(stage.GetPrimAtPath(path + "/Surface"))
    for name, (file, output, *others) in textures.items():
        texture = UsdShade.Shader.Define(stage, f"{path}/Texture_{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(file))
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(st)
        for key, value in dict(wrapS=wrap, wrapT=wrap, **(others[0] if others else {})).items():
            kind = Sdf.ValueTypeNames.Token if isinstance(value, str) else Sdf.ValueTypeNames.Float4
            texture.CreateInput(key, kind).Set(value)
        color = output == "rgb"
        target = surface.GetInput(name) or surface.CreateInput(
            name, author._INPUT_TYPES.get(name, Sdf.ValueTypeNames.Float))
        target.ConnectToSource(texture.CreateOutput(
            output, Sdf.ValueTypeNames.Float3 if color else Sdf.ValueTypeNames.Float))
    return material


def _WriteImages(folder: pathlib.Path) -> None:
    folder.mkdir(exist_ok=True)
    photographs = photograph.Photographs(256)
    for index in range(4):
        imageFile.WritePng(folder / f"photo{index}.png", photographs.Make(index)[: (256, 200, 177, 31)[index]])
    x, y = np.meshgrid(np.linspace(-1, 1, 96), np.linspace(-1, 1, 64))
    holes = 0.5 + 0.5 * np.sin(14 * x) * np.cos(11 * y)
    imageFile.WritePng(folder / "holes.png", (holes * 65535).astype(np.uint16)[..., None])
    turn = np.stack([0.4 * np.sin(20 * x), 0.4 * np.sin(17 * y), np.ones_like(x)], -1)
    turn /= np.linalg.norm(turn, axis=-1, keepdims=True)
    imageFile.WritePng(folder / "bumps.png", ((0.5 + 0.5 * turn) * 255 + 0.5).astype(np.uint8))
    imageFile.WriteExr(folder / "rough.exr", {"Y": (0.15 + 0.5 * holes).astype(np.float32)})


def _Ball() -> shapes.Shape:
    """A ball with coordinates: twice around, once up."""
    ball = shapes.Sphere(0.7, 48, 96)
    x, y, z = ball.points.T / 0.7
    st = np.stack([np.arctan2(z, x) / np.pi, np.arcsin(np.clip(y, -1, 1)) / np.pi + 0.5], 1)
    return shapes.Shape(ball.points, ball.counts, ball.indices, ball.normals, st)


def WriteTextured(path) -> None:
    """The stage, and its images in the folder `images` beside it."""
    _WriteImages(pathlib.Path(path).parent / "images")
    stage = author.NewStage(str(path))
    floor = shapes.Plane(12, 12, 4, 4)
    floor = shapes.Shape(floor.points, floor.counts, floor.indices, floor.normals, 7 * floor.texcoords)
    look = AddTexturedMaterial(stage, "/World/Looks/Floor", dict(diffuseColor=("./images/photo0.png", "rgb"),
                                                                 roughness=("./images/rough.exr", "r")))
    author.AddMesh(stage, "/World/Floor", floor, material=look, translate=(0, -1, 0))
    look = AddTexturedMaterial(stage, "/World/Looks/Wall", dict(diffuseColor=("./images/photo1.png", "rgb")),
                               wrap="mirror", roughness=0.8)
    author.AddMesh(stage, "/World/Wall", shapes.Plane(12, 8), material=look, translate=(0, 1, -4), rotate=(90, 0, 0))
    for index, threshold in enumerate((0.0, 0.5, 0.7)):
        look = AddTexturedMaterial(
            stage, f"/World/Looks/Card{index}", dict(diffuseColor=(f"./images/photo{index + 1}.png", "rgb"),
                                                     opacity=("./images/holes.png", "r", dict(sourceColorSpace="raw"))),
            opacityThreshold=threshold)
        author.AddMesh(stage, f"/World/Card{index}", shapes.Plane(1.6, 1.6), material=look, doubleSided=True,
                       translate=(1.5 * index - 1.8, 0.3, 0.4 * index - 0.5), rotate=(80, 0, 15 * index))
    look = AddTexturedMaterial(
        stage, "/World/Looks/Bumpy", dict(diffuseColor=("./images/photo2.png", "rgb"), normal=(
            "./images/bumps.png", "rgb", dict(sourceColorSpace="raw", scale=(2.0, 2.0, 2.0, 1.0),
                                              bias=(-1.0, -1.0, -1.0, 0.0)))), roughness=0.3)
    author.AddMesh(stage, "/World/Bumpy", _Ball(), material=look, translate=(-1.9, -0.3, 1.0))
    mirror = author.AddMaterial(stage, "/World/Looks/Mirror", metallic=1.0, roughness=0.02, diffuseColor=(0.9, 0.9, 0.9))
    author.AddMesh(stage, "/World/Mirror", shapes.Sphere(0.7, 48, 96), material=mirror, translate=(1.7, -0.3, 1.2))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.4)
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(0, 3, 2), rotate=(-90, 0, 0)), intensity=6.0, width=2.0,
                    height=2.0)
    author.AddCamera(stage, eye=(0, 0.9, 4.6), target=(0, 0, 0))
    stage.GetRootLayer().Save()


def WriteImageLights(path, isTextured: bool = False, isPrecise: bool = False) -> None:
    """A stage lit by images: on a dome with a small bright sun, of an odd size, and on two panels with one image between
    them. They are seen by the camera, in a mirror and through holes. The surfaces have no textures unless asked for.
    `isPrecise`: the lights' images have the same values 2^17 times over, which are stored as floats, and the lights are as
    much weaker."""
    folder = pathlib.Path(path).parent / "images"
    _WriteImages(folder)
    random = np.random.default_rng(5)
    sky = 0.2 + 0.3 * random.random((151, 301, 3)).astype(np.float32)
    sky[30:33, 200:204] = (400, 350, 250)
    images, intensity = {"sky": sky}, 1.0
    if isPrecise:
        codes = photograph.Photographs(256).Make(1)[:200] / 255
        images["panel"] = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        images, intensity = {f"{name}Floats": image * 2.0**17 for name, image in images.items()}, 2.0**-17
    for name, image in images.items():
        imageFile.WriteExr(folder / f"{name}.exr", {c: np.float32(image[..., i]) for i, c in enumerate("RGB")}, half=False)
    skyFile, panelFile = ("skyFloats.exr", "panelFloats.exr") if isPrecise else ("sky.exr", "photo1.png")
    stage = author.NewStage(str(path))
    textures = dict(diffuseColor=("./images/photo0.png", "rgb")) if isTextured else {}
    look = AddTexturedMaterial(stage, "/World/Looks/Floor", textures, roughness=0.4)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(6, 6, 4, 4), material=look, translate=(0, -1, 0))
    holes = author.AddMaterial(stage, "/World/Looks/Holes", opacity=0.4)
    author.AddMesh(stage, "/World/Card", shapes.Plane(1.6, 1.6), material=holes, doubleSided=True,
                   translate=(-1.2, 0.2, 0.5), rotate=(80, 0, 15))
    mirror = author.AddMaterial(stage, "/World/Looks/Mirror", metallic=1.0, roughness=0.02, diffuseColor=(0.9, 0.9, 0.9))
    author.AddMesh(stage, "/World/Mirror", shapes.Sphere(0.7, 24, 48), material=mirror, translate=(1.1, -0.3, 0.6))
    author.AddLight(stage, "/World/Dome", "Dome", dict(rotate=(0, 40, 10)), intensity=intensity,
                    textureFile=f"./images/{skyFile}")
    for index, x in enumerate((-1.5, 1.8)):
        author.AddLight(stage, f"/World/Panel{index}", "Rect", dict(translate=(x, 0.9, -1.5), rotate=(5, 180, 30 * index)),
                        intensity=3.0 * intensity, width=1.5, height=1.0, textureFile=f"./images/{panelFile}")
    author.AddCamera(stage, eye=(0, 0.9, 4.6), target=(0, 0, 0))
    stage.GetRootLayer().Save()
