# SPDX-License-Identifier: Apache-2.0
"""A plain scene in Mitsuba 3, and its renders.

Surfaces are `principled`, two-sided, under `normalmap` where there is one; `diffuse` without a material. What stays unlike
UsdPreviewSurface: principled's diffuse lobe depends on roughness, its Fresnel is the dielectric's own. Where opacity is
below 1 the surface is a blend of `thindielectric` (of such an ior that both its sides together reflect what one does) and
`principled`. Light shapes have a `null` surface, so that they do not occlude; `path` then finds what lies behind one by
BSDF sampling, without bias. `mitsuba preview` is the llvm variant with UsdPreviewSurface's own formula, the plug-in of
testenv/render/previewBsdf.py: what differs there is no matter of materials. One pass has at most _PASS_PATHS paths, as all of
them are in memory at once.
"""

import math

import numpy as np

import mitsubaScene
import rivalsMatter

SCALAR, PREVIEW = "mitsuba scalar", "mitsuba preview"
_PASS_PATHS = 1 << 23
_SAMPLER = "multijitter"
_SIZE = 1000.0  # of a small scene's diagonal
_PASSES = 8  # surfaces that a path passes straight through: bounces to Mitsuba, none to hdStream


def Build(scene, job: dict):
    """render(samples, seed) -> [height][width][3]; and warmUp(samples) -> the counts to render once before a render of so many is
    timed, since this sampler's kernels are compiled for one count. Takes the arrays out of `scene`."""
    mitsubaScene.UseVariant("scalar_rgb" if job["renderer"] == SCALAR else "llvm_ad_rgb")
    mi = mitsubaScene.mi
    mi.set_log_level(mi.LogLevel.Error)
    import drjit

    drjit.set_thread_count(job["threads"])
    factor = _Enlarge(scene)
    sensor = mitsubaScene.Sensor(scene.camera, job["width"], job["height"])
    sensor["sampler"] = {"type": _SAMPLER}
    passes = _PASSES if any(material.get("opacity", 1.0) != 1.0 for material in scene.materials) else 0
    integrator = {"type": "path", "max_depth": job["maxDepth"] + 2 + passes,
                  "rr_depth": job.get("rouletteDepth", 100000)}
    if rivalsMatter.HasMatter(scene):
        integrator = {"type": "volpath", "max_depth": rivalsMatter.DEPTH, "rr_depth": 100000}
    content = {"type": "scene", "sensor": sensor, "integrator": integrator}
    looks = _Looks(mi, scene.materials, _PreviewLook if job["renderer"] == PREVIEW else _PrincipledLook)
    while scene.meshes:
        mesh = scene.meshes.pop()
        material = scene.materials[mesh.material]
        within = {"interior": _Interior(mi, material, factor), "emitter": _Emitter(mi, material, mesh)}
        _AddMesh(mi, content, mesh, looks[mesh.material], len(scene.meshes), within)
    for i, volume in enumerate(scene.volumes):
        content[f"volume{i}"] = rivalsMatter.MitsubaVolume(mi, volume, factor)
    for i, light in enumerate(scene.lights):
        shape = mitsubaScene.LightShape(light, "")
        if "bsdf" in shape:
            shape["bsdf"] = {"type": "null"}
        content[f"light{i}"] = shape
    built = mi.load_dict(content)
    perPass = 1 << int(math.log2(max(1, _PASS_PATHS / (job["width"] * job["height"]))))

    def Render(samples: int, seed: int) -> np.ndarray:
        total, done = 0.0, 0
        while done < samples:
            count = min(perPass, samples - done)
            total = total + count * np.array(mi.render(built, spp=count, seed=1000 * seed + done), np.float64)
            done += count
        return total / samples

    isCompiled = job["renderer"] != SCALAR
    return Render, lambda samples: [min(perPass, samples)] if isCompiled else []


def _Interior(mi, material: dict, factor: float):
    medium = rivalsMatter.WalkOf(material["subsurface"]) if "subsurface" in material else material.get("medium")
    return mi.load_dict(rivalsMatter.MitsubaMedium(mi, medium, factor)) if medium else None


def _Emitter(mi, material: dict, mesh):
    """What a surface emits, to its front alone."""
    radiance = material.get("emissiveColor", (0.0,) * 3)
    if not any(radiance):
        return None
    if len(mesh.places) > 1:
        raise ValueError(f"{mesh.path}: emissive meshes at several places are not handled")
    return mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": list(radiance)}})


def _Enlarge(scene) -> float:
    """Scales a small scene up, lights and camera with it: Mitsuba moves rays by at least 1.8e-4 of a unit, and so skips
    surfaces that lie closer together. Radiance stays. Returns the factor."""
    boxes = [bounds @ place[:3, :3] + place[3, :3] for mesh in scene.meshes for place in mesh.places
             for bounds in [np.stack([mesh.points.min(0), mesh.points.max(0)])]]
    corners = np.concatenate(boxes)
    factor = max(1.0, _SIZE / np.linalg.norm(corners.max(0) - corners.min(0)))
    scaling = np.diag([factor, factor, factor, 1.0])
    for mesh in scene.meshes:
        mesh.places = mesh.places @ scaling
    for light in scene.lights:
        if light.kind in ("Rect", "Sphere"):  # those at infinity stay as they are
            light.matrix = light.matrix @ scaling
    camera = scene.camera  # its own axes stay unit vectors
    camera["matrix"] = np.linalg.inv(scaling) @ camera["matrix"] @ scaling
    camera["focus"] *= factor
    if camera["fStop"] > 0:
        camera["fStop"] /= factor
    return factor


def _Looks(mi, materials: list, Look) -> list:
    """BSDF objects; an image is loaded once however many use it."""
    textures = {}

    def Value(value, isColor: bool):
        if hasattr(value, "file"):
            if value not in textures:
                textures[value] = mi.load_dict({"type": "bitmap", "filename": value.file, "raw": not value.isSrgb, "format": "auto"})
            return textures[value]
        return {"type": "rgb", "value": [float(v) for v in value]} if isColor else float(value)

    return [mi.load_dict(_Look(material, Value, Look)) for material in materials]


def _Look(material: dict, Value, Look) -> dict:
    if "medium" in material or "subsurface" in material:
        return {"type": "null"}
    if "lambert" in material:
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": Value(material["lambert"], True)}}
    return Look(material, Value)


def _WithNormal(material: dict, look: dict, Value) -> dict:
    if material["normal"] is None:
        return look
    # Its softening of the shadow terminator takes light away, up to a seventh of a bumped wall's below a grazing lamp.
    return {"type": "normalmap", "normalmap": Value(material["normal"], False), "bsdf": look, "use_shadowing_function": False}


def _PreviewLook(material: dict, Value) -> dict:
    look = {"type": "usdpreview", "useSpecularWorkflow": 0, "lambert": 0, "opacityThreshold": 0.0, "normalX": 0.0, "normalY": 0.0,
            "normalZ": 1.0, "diffuseColor": Value(material["diffuseColor"], True), "specularColor": Value((0, 0, 0), True)}
    for name in ("metallic", "roughness", "clearcoat", "clearcoatRoughness", "opacity", "ior"):
        look[name] = Value(material[name], False)
    return _WithNormal(material, look, Value)


def _PrincipledLook(material: dict, Value) -> dict:
    f0 = _Reflectance(material["ior"])
    look = {"type": "principled", "base_color": Value(material["diffuseColor"], True), "roughness": Value(material["roughness"], False),
            "specular": f0 / 0.08}
    for name in ("metallic", "clearcoat"):
        if material[name] != 0.0:
            look[name] = Value(material[name], False)
    if material["clearcoat"] != 0.0:
        look["clearcoat_gloss"] = 1.0 - Value(material["clearcoatRoughness"], False)
    look = {"type": "twosided", "bsdf": _WithNormal(material, look, Value)}
    if material["opacity"] == 1.0:
        return look
    root = math.sqrt(f0 / (2.0 - f0))  # both sides of a pane reflect 2 r / (1 + r)
    pane = {"type": "thindielectric", "int_ior": (1 + root) / (1 - root), "ext_ior": 1.0}
    return {"type": "blendbsdf", "weight": Value(material["opacity"], False), "first": pane, "second": look}


def _Reflectance(ior: float) -> float:
    return ((1 - ior) / (1 + ior)) ** 2


def _AddMesh(mi, content: dict, mesh, look, index: int, within: dict) -> None:
    """A mesh at one place in world space, at several as a group and its instances."""
    matrices = mesh.places
    if len(matrices) == 1:
        content[f"mesh{index}"] = _Mesh(mi, mesh, look, matrices[0], within)
        return
    content[f"group{index}"] = {"type": "shapegroup", "mesh": _Mesh(mi, mesh, look, np.eye(4), {})}
    group = mi.load_dict(content.pop(f"group{index}"))
    content[f"group{index}"] = group
    for i, matrix in enumerate(matrices):
        content[f"instance{index}_{i}"] = {"type": "instance", "group": group, "to_world": mi.ScalarTransform4f(matrix.T.copy())}


def _Mesh(mi, mesh, look, matrix: np.ndarray, within: dict):
    properties = mi.Properties()
    properties["mesh_bsdf"] = look
    for name, value in within.items():
        if value is not None:
            properties[name] = value
    out = mi.Mesh("mesh", len(mesh.points), len(mesh.triangles), props=properties, has_vertex_normals=mesh.normals is not None,
                  has_vertex_texcoords=mesh.texcoords is not None)
    params = mi.traverse(out)
    linear, isMirrored = matrix[:3, :3], np.linalg.det(matrix[:3, :3]) < 0
    params["vertex_positions"] = (mesh.points @ linear + matrix[3, :3]).astype(np.float32).ravel()
    params["faces"] = (mesh.triangles[:, ::-1] if isMirrored else mesh.triangles).astype(np.uint32).ravel()
    if mesh.normals is not None:
        normals = mesh.normals @ np.linalg.inv(linear).T
        params["vertex_normals"] = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32).ravel()
    if mesh.texcoords is not None:  # Mitsuba's images hang from the top
        params["vertex_texcoords"] = (mesh.texcoords * [1, -1] + [0, 1]).astype(np.float32).ravel()
    params.update()
    return out
