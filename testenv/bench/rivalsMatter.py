# SPDX-License-Identifier: Apache-2.0
"""Volumes, media in meshes and subsurface scattering of a stage, for rivals: plain values, and how Mitsuba and Cycles draw them.

Mitsuba has no subsurface scattering of a surface's own: its walk is in a medium of the albedo that Standard Surface's
formula gives (Kulla and Conty 2017), behind a boundary that does nothing. That is another picture than the one of a surface which
light enters by a diffuse lobe, with about the same walks. Cycles divides the radius of a random walk by 4 pi to get the mean free
path, which is what Standard Surface's radius is. Cycles samples a volume's way by steps of its own choice, and a body's
exactly."""

import pathlib
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

_SURFACES = ("ND_standard_surface_surfaceshader",)
_CYCLES_RADIUS = 4 * np.pi  # of a random walk, over its mean free path
DEPTH = 1024  # events of a path in media; all renderers go on to the end


@dataclass
class Volume:
    """Voxels of a box, and what its density of 1 does in a unit of the world's length."""

    file: str  # OpenVDB; NAME.npz beside it has `values` [x][y][z] and `voxel`
    matrix: np.ndarray  # row vectors, no scale
    medium: dict


def _Shader(output):
    return UsdShade.Shader(output.GetConnectedSources()[0][0].source.GetPrim())


def ReadLook(material):
    """{"medium": ...} or {"subsurface": ...} of a material; None where it has neither."""
    volume = material.GetVolumeOutput("mtlx") if material else None
    if volume and volume.HasConnectedSource():
        shader = _Shader(_Shader(volume).GetInput("vdf"))
        value = lambda name: np.array(shader.GetInput(name).Get(), float)
        extinction = value("absorption") + value("scattering")
        return {"medium": dict(extinction=float(extinction.max()), albedo=tuple((value("scattering") / extinction).tolist()),
                               anisotropy=float(value("anisotropy")))}
    surface = material.GetSurfaceOutput("mtlx") if material else None
    if surface and surface.HasConnectedSource() and _Shader(surface).GetIdAttr().Get() in _SURFACES:
        shader = _Shader(surface)
        return {"subsurface": dict(color=tuple(shader.GetInput("subsurface_color").Get()),
                                   radius=tuple(shader.GetInput("subsurface_radius").Get()))}
    return None


def ReadVolume(prim) -> Volume:
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    field = next(child for child in prim.GetChildren() if child.GetTypeName() == "OpenVDBAsset")
    matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    return Volume(field.GetAttribute("filePath").Get().resolvedPath, matrix, ReadLook(material)["medium"])


def WalkOf(subsurface: dict) -> dict:
    """The medium of a walk: extinction 1 / radius, albedo by Kulla and Conty's fit."""
    color = np.array(subsurface["color"])
    albedo = 1 - np.exp(-5.09406 * color + 2.61188 * color**2 - 4.31805 * color**3)
    return dict(extinction=1 / subsurface["radius"][0], albedo=tuple(albedo.tolist()), anisotropy=0.0)


def HasMatter(scene) -> bool:
    return bool(scene.volumes) or any("medium" in look or "subsurface" in look for look in scene.materials)


def MitsubaMedium(mi, medium: dict, factor: float, density=None) -> dict:
    """\\param factor the scene is enlarged by. \\param density a volume of Mitsuba's; None: even."""
    color = lambda values: {"type": "rgb", "value": [float(v) for v in values]}
    phase = {"type": "hg", "g": medium["anisotropy"]} if medium["anisotropy"] else {"type": "isotropic"}
    albedo = {"type": "constvolume", "value": color(medium["albedo"])}
    if density is None:
        extinction = {"type": "constvolume", "value": medium["extinction"] / factor}
        return {"type": "homogeneous", "sigma_t": extinction, "albedo": albedo, "phase": phase}
    return {"type": "heterogeneous", "scale": medium["extinction"] / factor, "sigma_t": density, "albedo": albedo, "phase": phase}


def MitsubaVolume(mi, volume: Volume, factor: float) -> dict:
    """A cube without a surface around the voxels."""
    kept = np.load(pathlib.Path(volume.file).with_suffix(".npz"))
    values, voxel = kept["values"], float(kept["voxel"])
    box = np.diag([*(voxel * np.array(values.shape)), 1.0])
    box[3, :3] = -0.5 * voxel
    place = box @ volume.matrix @ np.diag([factor, factor, factor, 1.0])
    grid = mi.VolumeGrid(np.ascontiguousarray(values.transpose(2, 1, 0)[..., None]))
    toWorld = lambda matrix: mi.ScalarTransform4f(matrix.T.copy())
    density = {"type": "gridvolume", "grid": grid, "to_world": toWorld(place), "wrap_mode": "clamp", "filter_type": "trilinear"}
    unit = np.diag([0.5, 0.5, 0.5, 1.0])
    unit[3, :3] = 0.5
    return {"type": "cube", "to_world": toWorld(unit @ place), "bsdf": {"type": "null"},
            "interior": MitsubaMedium(mi, volume.medium, factor, density)}


def CyclesLook(nodes, look: dict):
    """A material of a body. \\param nodes as of rivalsCycles."""
    if "medium" in look:
        nodes.Add("ShaderNodeOutputMaterial", {"Volume": _CyclesMedium(nodes, look["medium"])})
    else:
        inputs = {"Base Color": look["subsurface"]["color"], "Subsurface Weight": 1.0,
                  "Subsurface Radius": look["subsurface"]["radius"], "Subsurface Scale": _CYCLES_RADIUS, "Specular IOR Level": 0.0,
                  "Subsurface Anisotropy": 0.0}
        surface = nodes.Add("ShaderNodeBsdfPrincipled", inputs, subsurface_method="RANDOM_WALK").outputs[0]
        nodes.Add("ShaderNodeOutputMaterial", {"Surface": surface})
    return nodes.material


def _CyclesMedium(nodes, medium: dict):
    """Principled Volume: what its colour leaves is absorbed."""
    inputs = {"Color": medium["albedo"], "Density": medium["extinction"], "Anisotropy": medium["anisotropy"],
              "Absorption Color": (0.0, 0.0, 0.0)}
    return nodes.Add("ShaderNodeVolumePrincipled", inputs).outputs[0]


def AddCyclesVolume(target, nodes, volume: Volume) -> None:
    import bpy
    import mathutils

    nodes.Add("ShaderNodeOutputMaterial", {"Volume": _CyclesMedium(nodes, volume.medium)})
    data = bpy.data.volumes.new("volume")
    data.filepath = volume.file
    data.materials.append(nodes.material)
    item = bpy.data.objects.new("volume", data)
    item.matrix_world = mathutils.Matrix(volume.matrix.T.tolist())
    target.collection.objects.link(item)
