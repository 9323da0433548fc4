# SPDX-License-Identifier: Apache-2.0
"""A stage, read by stageReader, as a Mitsuba 3 scene; and its reference render with variances.

Call `UseVariant` first. Lambert parts use Mitsuba's own `diffuse`; UsdPreviewSurface uses the plug-in
of previewBsdf.py (vectorised variants only). Light shapes occlude in Mitsuba and not in hdStream: the
stages keep them out of the way. Distant lights with an angle are disks 10^6 units away.
"""

import os
import pathlib
import tempfile
from dataclasses import replace

import numpy as np

from stageReader import Light, Part, Scene, ReadStage

_DISTANT = 1.0e6
mi = None


def UseVariant(variant: str = "llvm_ad_rgb") -> None:
    """Imports Mitsuba with a variant and registers the plug-in. LLVM is found where Debian puts it."""
    global mi
    library = pathlib.Path("/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
    if library.exists():
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(library))
    import mitsuba

    mitsuba.set_variant(variant)
    mi = mitsuba
    if variant != "scalar_rgb":
        import previewBsdf

        previewBsdf.Register()


def _Rgb(value) -> dict:
    return {"type": "rgb", "value": [float(v) for v in value]}


def _Transform(matrix: np.ndarray):
    """Mitsuba's column-vector transform from a row-vector matrix."""
    return mi.ScalarTransform4f(np.ascontiguousarray(matrix.T))


def _Mesh(part: Part, bsdf: dict, emitter: dict | None, folder: str, index: int) -> dict:
    """The part as a PLY file with one vertex a corner, and the dictionary that loads it."""
    count = len(part.positions)
    mesh = mi.Mesh(f"part{index}", 3 * count, count, has_vertex_normals=part.normals is not None,
                   has_vertex_texcoords=part.texcoords is not None)
    for name, values in part.primvars.items():
        mesh.add_attribute(f"vertex_{name}", values.shape[-1], np.ascontiguousarray(values, np.float32).ravel())
    params = mi.traverse(mesh)
    params["vertex_positions"] = np.ascontiguousarray(part.positions, np.float32).ravel()
    params["faces"] = np.arange(3 * count, dtype=np.uint32)
    if part.normals is not None:
        params["vertex_normals"] = np.ascontiguousarray(part.normals, np.float32).ravel()
    if part.texcoords is not None:
        params["vertex_texcoords"] = np.ascontiguousarray(part.texcoords, np.float32).ravel()
    params.update()
    path = f"{folder}/part{index}.ply"
    mesh.write_ply(path)
    out = {"type": "ply", "filename": path, "bsdf": bsdf, "face_normals": part.normals is None}
    if emitter:
        out["emitter"] = emitter
    return out


def _Input(value, part: Part, isColor: bool):
    """A constant or a primvar as a Mitsuba texture (scalars stay floats)."""
    if isinstance(value, tuple) and value and value[0] == "primvar":
        if value[1] in part.primvars:
            return {"type": "mesh_attribute", "name": f"vertex_{value[1]}"}
        value = value[2] if value[2] is not None else 0.0
    return _Rgb(value) if isColor else float(value)


def _Bsdf(part: Part) -> dict:
    if part.material is None:
        color = part.primvars.get("displayColor")
        if color is None:
            reflectance = _Rgb((0.18,) * 3)
        elif np.ptp(color.reshape(-1, 3), axis=0).max() == 0:
            reflectance = _Rgb(color[0, 0])
        else:
            reflectance = {"type": "mesh_attribute", "name": "vertex_displayColor"}
        diffuse = {"type": "diffuse", "reflectance": reflectance}
        return {"type": "twosided", "bsdf": diffuse} if part.doubleSided else diffuse
    inputs = part.material
    out = {"type": "usdpreview", "useSpecularWorkflow": int(inputs["useSpecularWorkflow"]), "lambert": 0}
    for name in ("diffuseColor", "specularColor"):
        out[name] = _Input(inputs[name], part, True)
    for name in ("metallic", "roughness", "clearcoat", "clearcoatRoughness", "opacity", "opacityThreshold", "ior"):
        out[name] = _Input(inputs[name], part, False)
    out.update({f"normal{axis}": float(v) for axis, v in zip("XYZ", inputs["normal"])})
    return out


def LightShape(light: Light, folder: str) -> dict:
    matrix, inputs, radiance = light.matrix, light.inputs, _Rgb(light.radiance)
    scaled = lambda x, y, z: np.diag([x, y, z, 1.0]) @ matrix
    turned = np.diag([1.0, -1.0, -1.0, 1.0])  # half a turn about x: +z to -z
    if light.kind == "Dome":
        if not inputs.get("texture:file"):
            return {"type": "constant", "radiance": radiance}
        bitmap = mi.Bitmap(inputs["texture:file"]).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
        scaledImage = np.array(bitmap) * light.radiance.astype(np.float32)
        return {"type": "envmap", "bitmap": mi.Bitmap(scaledImage), "to_world": _Transform(matrix)}
    if light.kind == "Distant":
        axis = matrix[2, :3] / np.linalg.norm(matrix[2, :3])
        if inputs["angle"] == 0:
            return {"type": "directional", "direction": [float(-a) for a in axis], "irradiance": radiance}
        radius = _DISTANT * np.tan(np.radians(inputs["angle"] / 2))
        rotation = matrix.copy()
        rotation[3, :3] = axis * _DISTANT
        shape = {"type": "disk", "to_world": _Transform(np.diag([radius, radius, 1, 1]) @ turned @ rotation)}
    elif light.kind == "Rect":
        shape = {"type": "rectangle", "to_world": _Transform(turned @ scaled(inputs["width"] / 2, inputs["height"] / 2, 1))}
    elif light.kind == "Disk":
        shape = {"type": "disk", "to_world": _Transform(turned @ scaled(inputs["radius"], inputs["radius"], 1))}
    elif light.kind == "Sphere":
        scale = np.cbrt(np.linalg.det(matrix[:3, :3]))
        shape = {"type": "sphere", "center": [float(x) for x in matrix[3, :3]], "radius": float(inputs["radius"] * scale)}
    else:  # Cylinder, along x
        ends = [np.array([s * inputs["length"] / 2, 0, 0, 1.0]) @ matrix for s in (-1, 1)]
        radius = inputs["radius"] * np.linalg.norm(matrix[1, :3])
        shape = {"type": "cylinder", "p0": [float(x) for x in ends[0][:3]], "p1": [float(x) for x in ends[1][:3]],
                 "radius": float(radius)}
    black = {"type": "diffuse", "reflectance": _Rgb((0, 0, 0))}
    return {**shape, "bsdf": black, "emitter": {"type": "area", "radiance": radiance}}


def Sensor(camera: dict, width: int, height: int) -> dict:
    """USD looks along -z with +x right; Mitsuba along +z with +x left: half a turn about y."""
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32",
            "rfilter": {"type": "box"}, "sample_border": False}
    turned = np.diag([-1.0, 1.0, -1.0, 1.0]) @ camera["matrix"]
    out = {"film": film, "sampler": {"type": "independent"}, "near_clip": 0.001, "far_clip": 1e7}
    if camera["orthographic"]:
        # Mitsuba's film spans [-1, 1] in x; the offset moves the window inside the image plane.
        shift = np.eye(4)
        shift[3, :2] = [-camera["offset"][0], camera["offset"][1]]
        scale = np.diag([camera["width"] / 2, camera["width"] / 2, 1, 1])
        return {**out, "type": "orthographic", "to_world": _Transform(scale @ shift @ turned)}
    out.update({"fov_axis": "x", "fov": float(np.degrees(2 * np.arctan(camera["width"] / 2 / camera["focal"]))),
                "to_world": _Transform(turned)})
    if camera["fStop"] > 0:  # Mitsuba's lens has no film offset
        return {**out, "type": "thinlens", "aperture_radius": float(camera["focal"] / camera["fStop"] / 2),
                "focus_distance": float(camera["focus"])}
    return {**out, "type": "perspective", "principal_point_offset_x": float(camera["offset"][0] / camera["width"]),
            "principal_point_offset_y": float(-camera["offset"][1] / camera["height"])}


def Load(scene: Scene, width: int, height: int, maxDepth: int, folder: str):
    """The Mitsuba scene. `maxDepth` is Mitsuba's own: 1 shows emitters only, 2 adds direct light."""
    dictionary = {"type": "scene", "integrator": {"type": "path", "max_depth": maxDepth, "rr_depth": 100000},
                  "sensor": Sensor(scene.camera, width, height)}
    for i, part in enumerate(scene.parts):
        emission = part.material["emissiveColor"] if part.material else (0, 0, 0)
        emitter = {"type": "area", "radiance": _Rgb(emission)} if any(emission) else None
        dictionary[f"part{i}"] = _Mesh(part, _Bsdf(part), emitter, folder, i)
    for i, light in enumerate(scene.lights):
        dictionary[f"light{i}"] = LightShape(light, folder)
    return mi.load_dict(dictionary)


def _LightGroups(scene: Scene) -> list[Scene]:
    """The scene under one light at a time (all emissive meshes together): transport is linear, so the
    sum of their images is that of lights that do not occlude each other."""
    groups = [Scene([replace(part, material=_Unlit(part.material)) for part in scene.parts], [light], scene.camera)
              for light in scene.lights]
    if any(part.material and any(part.material["emissiveColor"]) for part in scene.parts):
        groups.append(Scene(scene.parts, [], scene.camera))
    return groups


def _Unlit(material: dict | None) -> dict | None:
    return material and {**material, "emissiveColor": (0.0, 0.0, 0.0)}


def _RenderBatches(scene: Scene, case, samples: int, batches: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(mean, variance of the mean) of one light group."""
    depth = 64 if case.passThrough else case.maxDepth + 2
    columns = round(case.pixelAspectRatio)  # square sub-pixels, averaged to one wide pixel
    images = []
    with tempfile.TemporaryDirectory() as folder:
        loaded = Load(scene, case.width * columns, case.height, depth, folder)
        for batch in range(batches):
            image = np.array(mi.render(loaded, spp=samples // batches, seed=seed + batch), np.float64)
            images.append(image.reshape(case.height, case.width, columns, 3).mean(2) * scene.camera["exposure"])
    return np.mean(images, 0), np.var(images, 0, ddof=1) / batches


def RenderReference(path: str, case, samples: int | None = None, batches: int = 16, seed: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """(mean, variance of the mean), both [height][width][3], of a case written at `path`."""
    results = [_RenderBatches(group, case, samples or case.referenceSamples, batches, seed + 100 * i)
               for i, group in enumerate(_LightGroups(ReadStage(path)))]
    return sum(r[0] for r in results), sum(r[1] for r in results)
