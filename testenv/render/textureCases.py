# SPDX-License-Identifier: Apache-2.0
"""Stages with textures, and what pictures of them must show by the definitions of UsdPreviewSurface.

A plate glows with the texture and reflects nothing; an orthographic camera looks at it from above, so a
pixel is the mean of the look-up over its area.
"""

import numpy as np
from pxr import Gf, Sdf, UsdShade

from stages import author, shapes

WIDTH, HEIGHT = 48, 36
_TYPES = {"file": Sdf.ValueTypeNames.Asset, "scale": Sdf.ValueTypeNames.Float4, "bias": Sdf.ValueTypeNames.Float4,
          "fallback": Sdf.ValueTypeNames.Float4, "st": Sdf.ValueTypeNames.Float2}


def AddTexture(material, name: str, st=None, **inputs) -> UsdShade.Shader:
    """A UsdUVTexture below a material; `st` is a shader whose result it reads, by default the primvar st. Wraps repeat
    unless they are given; None leaves an input out."""
    path = material.GetPath()
    texture = UsdShade.Shader.Define(material.GetPrim().GetStage(), path.AppendChild(name))
    texture.CreateIdAttr("UsdUVTexture")
    for key, value in {"wrapS": "repeat", "wrapT": "repeat", **inputs}.items():
        if value is None:
            continue
        value = Gf.Vec4f(*map(float, value)) if isinstance(value, (tuple, list)) else value
        texture.CreateInput(key, _TYPES.get(key, Sdf.ValueTypeNames.Token)).Set(value)
    st = st or AddReader(material, name + "St", "float2", "st")
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(st.ConnectableAPI(), "result")
    return texture


def AddReader(material, name: str, kind: str, primvar: str) -> UsdShade.Shader:
    reader = UsdShade.Shader.Define(material.GetPrim().GetStage(), material.GetPath().AppendChild(name))
    reader.CreateIdAttr("UsdPrimvarReader_" + kind)
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
    return reader


def AddTransform(material, name: str, source: UsdShade.Shader, rotation=0.0, scale=(1, 1), translation=(0, 0)) -> UsdShade.Shader:
    transform = UsdShade.Shader.Define(material.GetPrim().GetStage(), material.GetPath().AppendChild(name))
    transform.CreateIdAttr("UsdTransform2d")
    transform.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(source.ConnectableAPI(), "result")
    transform.CreateInput("rotation", Sdf.ValueTypeNames.Float).Set(float(rotation))
    transform.CreateInput("scale", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*map(float, scale)))
    transform.CreateInput("translation", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*map(float, translation)))
    return transform


def Connect(material, surfaceInput: str, texture: UsdShade.Shader, output: str) -> None:
    """Connects an output of a texture to an input of a material of author.AddMaterial."""
    surface = UsdShade.Shader(material.GetPrim().GetChild("Surface"))
    kind = Sdf.ValueTypeNames.Float3 if output == "rgb" else Sdf.ValueTypeNames.Float
    source = texture.GetOutput(output) or texture.CreateOutput(output, kind)
    existing = surface.GetInput(surfaceInput)
    target = existing or surface.CreateInput(surfaceInput, author._INPUT_TYPES.get(surfaceInput, Sdf.ValueTypeNames.Float))
    target.ConnectToSource(source)


def GlowingPlate(path: str, build, low=(0.0, 0.0), high=(1.0, 1.0)) -> str:
    """A plate of 4 x 3 that fills the picture, with st from `low` at its lower left to `high`. `build(material)`
    adds a texture and connects it to emissiveColor."""
    stage = author.NewStage(path)
    plane = shapes.Plane(4, 3)
    st = np.asarray(low) + plane.texcoords * (np.asarray(high) - low)
    plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, st)
    material = author.AddMaterial(stage, "/World/M", diffuseColor=(0, 0, 0), metallic=1.0)
    build(material)
    author.AddMesh(stage, "/World/Plate", plane, material=material)
    AddTopCamera(stage)
    author.AddLight(stage, "/World/Dark", "Sphere", dict(translate=(0, 50, 0)), intensity=0.0, radius=0.01)
    stage.GetRootLayer().Save()
    return path


def AddTopCamera(stage) -> None:
    author.AddCamera(stage, eye=(0, 2, 0), target=(0, 0, 0), up=(0, 0, -1), width=40.0, orthographic=True)


def Coordinates(low=(0.0, 0.0), high=(1.0, 1.0), steps: int = 8) -> np.ndarray:
    """st at steps x steps points of each pixel: [HEIGHT][steps][WIDTH][steps][2]."""
    s = (np.arange(WIDTH * steps) + 0.5) / (WIDTH * steps)
    t = 1 - (np.arange(HEIGHT * steps) + 0.5) / (HEIGHT * steps)
    gt, gs = np.meshgrid(t, s, indexing="ij")
    st = np.stack([low[0] + gs * (high[0] - low[0]), low[1] + gt * (high[1] - low[1])], -1)
    return st.reshape(HEIGHT, steps, WIDTH, steps, 2)


def PixelMeans(values: np.ndarray) -> np.ndarray:
    return values.mean((1, 3))


def Wrapped(index: np.ndarray, size: int, mode: str) -> tuple[np.ndarray, np.ndarray]:
    """(texel, 1 where it is inside or the mode has no outside)."""
    if mode == "repeat":
        return index % size, np.ones_like(index)
    if mode == "mirror":
        folded = index % (2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded), np.ones_like(index)
    inside = (index >= 0) & (index < size)
    return np.clip(index, 0, size - 1), np.where(mode == "clamp", 1, inside)


def Bilinear(image: np.ndarray, st: np.ndarray, wrapS: str = "repeat", wrapT: str = "repeat") -> np.ndarray:
    """The look-up by definition: texel (x, y) has its centre at s = (x + 0.5) / width, t = 1 - (y + 0.5) / height."""
    height, width = image.shape[:2]
    x, y = st[..., 0] * width - 0.5, (1 - st[..., 1]) * height - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros(st.shape[:-1] + (image.shape[2],))
    for dx in (0, 1):
        for dy in (0, 1):
            column, insideS = Wrapped(x0 + dx, width, wrapS)
            row, insideT = Wrapped(y0 + dy, height, wrapT)
            weight = np.where(dx, x - x0, 1 - (x - x0)) * np.where(dy, y - y0, 1 - (y - y0)) * insideS * insideT
            total += weight[..., None] * image[row, column]
    return total


def KeptCodes(height: int, width: int, channels: int, seed: int, dtype=np.uint8) -> np.ndarray:
    """Random codes that the codec keeps: in a block of 4x4 a channel has two values (docs/texturing.md, section "Codec"). Of
    8 bits one or two channels have them near each other, since wide intervals are coded in steps; more have them far apart,
    since a narrow interval may go without an index."""
    random = np.random.default_rng(seed)
    blocks = (-(-height // 4), -(-width // 4), channels)
    if dtype == np.uint8:
        low, step = random.integers(0, 64, blocks), random.integers(60, 96, blocks) + (80 if channels > 2 else 0)
        ends = low, low + step
    else:
        ends = random.integers(0, np.iinfo(dtype).max + 1, (2, *blocks))
    low, high = (np.repeat(np.repeat(end, 4, 0), 4, 1)[:height, :width] for end in ends)
    return np.where(random.random((height, width, channels)) < 0.5, low, high).astype(dtype)


def FromSrgb(encoded: np.ndarray) -> np.ndarray:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
