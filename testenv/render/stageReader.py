# SPDX-License-Identifier: Apache-2.0
"""Reads a verification stage into plain data: world-space triangles, materials, lights, one camera.

Written for the tests, over usd-core only, and independent of hdStream's own translation: it flattens
instances, triangulates and resolves bindings in its own way, so that a mistake in either is seen.
It reads what our verification stages use and raises on the rest. Matrices act on row vectors.
"""

from dataclasses import dataclass, field

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade


@dataclass
class Part:
    """Triangles of one mesh prim (or subset) with one material. Everything is given by corner."""

    path: str
    positions: np.ndarray  # [triangles][3][3] world
    normals: np.ndarray | None  # [triangles][3][3] world, unit
    texcoords: np.ndarray | None  # [triangles][3][2]
    primvars: dict  # name -> [triangles][3][components]
    material: dict | None  # inputs of UsdPreviewSurface; readers as ("primvar", name, fallback)
    doubleSided: bool
    faces: np.ndarray  # [triangles] authored face
    instance: int = 0


@dataclass
class Light:
    """A light with its radiance (distant with angle 0: its irradiance) by channel."""

    kind: str
    matrix: np.ndarray
    radiance: np.ndarray
    inputs: dict


@dataclass
class Scene:
    parts: list[Part] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: dict = field(default_factory=dict)


def ReadStage(path: str, cameraPath: str = "/World/Camera") -> Scene:
    """The whole stage at the default time."""
    stage = Usd.Stage.Open(str(path))
    scene = Scene()
    counter = [0]
    for prim in stage.GetPseudoRoot().GetChildren():
        _Visit(prim, np.eye(4), scene, counter)
    scene.camera = ReadCamera(UsdGeom.Camera(stage.GetPrimAtPath(cameraPath)))
    return scene


def _Visit(prim, parent: np.ndarray, scene: Scene, counter: list) -> None:
    if prim.IsAbstract() or not prim.IsDefined():
        return
    matrix = parent
    imageable = UsdGeom.Imageable(prim)
    if imageable and imageable.GetVisibilityAttr().Get() == "invisible":
        return
    xformable = UsdGeom.Xformable(prim)
    if xformable:
        local = np.array(xformable.GetLocalTransformation())
        matrix = local if xformable.GetResetXformStack() else local @ parent
    if prim.IsA(UsdGeom.Mesh):
        scene.parts += _ReadMesh(UsdGeom.Mesh(prim), matrix, counter[0])
        counter[0] += 1
    elif prim.IsA(UsdGeom.PointInstancer):
        _VisitInstancer(UsdGeom.PointInstancer(prim), matrix, scene, counter)
        return
    elif prim.HasAPI(UsdLux.LightAPI):
        scene.lights.append(ReadLight(prim, matrix))
    for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies()):
        _Visit(child, matrix, scene, counter)


def _VisitInstancer(instancer, matrix: np.ndarray, scene: Scene, counter: list) -> None:
    stage = instancer.GetPrim().GetStage()
    targets = instancer.GetPrototypesRel().GetTargets()
    kinds = np.array(instancer.GetProtoIndicesAttr().Get())
    positions = np.array(instancer.GetPositionsAttr().Get(), float)
    orientations, scales = instancer.GetOrientationsAttr().Get(), instancer.GetScalesAttr().Get()
    hidden = set(instancer.GetInvisibleIdsAttr().Get() or [])
    for i, kind in enumerate(kinds):
        if i in hidden:
            continue
        local = np.eye(4)
        if scales:
            local[:3, :3] = np.diag(np.array(scales[i], float))
        if orientations:
            rotation = np.array(Gf.Matrix3d(Gf.Quatd(orientations[i])))
            local[:3, :3] = local[:3, :3] @ rotation
        local[3, :3] = positions[i]
        _Visit(stage.GetPrimAtPath(targets[kind]), local @ matrix, scene, counter)


def _EarClip(points: np.ndarray) -> list:
    """Triangles of a simple planar polygon, by corner."""
    normal = np.sum(np.cross(points, np.roll(points, -1, 0)), 0)
    axis = np.argmax(np.abs(normal))
    flat = np.delete(points, axis, 1)
    cross = lambda a, b, c: (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    area = sum(cross(flat[0], flat[i], flat[i + 1]) for i in range(1, len(flat) - 1))
    ring, out = list(range(len(flat))), []
    while len(ring) > 3:
        for k in range(len(ring)):
            a, b, c = ring[k - 1], ring[k], ring[(k + 1) % len(ring)]
            if cross(flat[a], flat[b], flat[c]) * area <= 0:
                continue
            inside = lambda p: all(cross(flat[u], flat[v], flat[p]) * area >= 0 for u, v in ((a, b), (b, c), (c, a)))
            if any(inside(p) for p in ring if p not in (a, b, c)):
                continue
            out.append((a, b, c))
            ring.pop(k)
            break
        else:
            raise ValueError("polygon is not simple")
    return out + [tuple(ring)]


def Triangulate(points, counts, indices, holes) -> tuple[np.ndarray, np.ndarray]:
    """(corners [triangles][3] as face-vertex indices, faces [triangles])."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    corners, faces = [], []
    for count in np.unique(counts):
        which = np.setdiff1d(np.nonzero(counts == count)[0], holes)
        if count <= 4:
            for k in range(1, count - 1):
                corners.append(starts[which, None] + np.array([0, k, k + 1]))
                faces.append(which)
        else:
            for face in which:
                clip = np.array(_EarClip(points[indices[starts[face] : starts[face] + count]]))
                corners.append(starts[face] + clip)
                faces.append(np.full(len(clip), face))
    return np.concatenate(corners), np.concatenate(faces)


def Spread(values, interpolation: str, indices, corners, faces) -> np.ndarray:
    """A primvar's flattened values by triangle corner."""
    if interpolation == "constant":
        return np.broadcast_to(values[0], corners.shape + values.shape[1:]).copy()
    if interpolation == "uniform":
        return np.repeat(values[faces][:, None], 3, 1)
    if interpolation == "faceVarying":
        return values[corners]
    return values[indices[corners]]  # vertex, varying


def _ReadMesh(mesh, matrix: np.ndarray, instance: int) -> list[Part]:
    points = np.array(mesh.GetPointsAttr().Get(), float)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
    if mesh.GetSubdivisionSchemeAttr().Get() != "none":
        raise ValueError(f"{mesh.GetPath()}: subdivision is not handled")
    corners, faces = Triangulate(points, counts, indices, list(mesh.GetHoleIndicesAttr().Get() or []))
    flipped = (mesh.GetOrientationAttr().Get() == "leftHanded") != (np.linalg.det(matrix[:3, :3]) < 0)
    if flipped:
        corners = corners[:, ::-1]
    world = points @ matrix[:3, :3] + matrix[3, :3]
    normals = None
    if mesh.GetNormalsAttr().Get():
        raw = np.array(mesh.GetNormalsAttr().Get(), float) @ np.linalg.inv(matrix[:3, :3]).T
        raw /= np.linalg.norm(raw, axis=-1, keepdims=True)
        normals = Spread(raw, mesh.GetNormalsInterpolation(), indices, corners, faces)
    primvars = {}
    for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithValues():
        values = np.array(primvar.ComputeFlattened(), float)
        values = values.reshape(len(values), -1) if values.ndim else values.reshape(1, 1)
        primvars[primvar.GetPrimvarName()] = Spread(values, primvar.GetInterpolation(), indices, corners, faces)
    owners = np.full(len(counts), -1)
    materials = [UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]]
    for subset in UsdShade.MaterialBindingAPI(mesh.GetPrim()).GetMaterialBindSubsets():
        owners[np.array(subset.GetIndicesAttr().Get(), int)] = len(materials) - 1
        materials.append(UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0])
    parts = []
    for owner in np.unique(owners[faces]):
        pick = owners[faces] == owner
        select = lambda a: None if a is None else a[pick]
        parts.append(Part(str(mesh.GetPath()), world[indices[corners]][pick], select(normals), select(primvars.get("st")),
                          {name: v[pick] for name, v in primvars.items() if name != "st"},
                          _ReadMaterial(materials[owner + 1]), bool(mesh.GetDoubleSidedAttr().Get()), faces[pick], instance))
    return parts


_DEFAULTS = dict(diffuseColor=(0.18,) * 3, emissiveColor=(0.0,) * 3, specularColor=(0.0,) * 3, useSpecularWorkflow=0, metallic=0.0,
                 roughness=0.5, clearcoat=0.0, clearcoatRoughness=0.01, opacity=1.0, opacityThreshold=0.0, ior=1.5,
                 normal=(0.0, 0.0, 1.0))


def _ReadMaterial(material) -> dict | None:
    if not material:
        return None
    shader = material.ComputeSurfaceSource()[0]
    inputs = dict(_DEFAULTS)
    for name in inputs:
        port = shader.GetInput(name)
        if not port:
            continue
        if port.HasConnectedSource():
            reader = UsdShade.Shader(port.GetConnectedSources()[0][0].source.GetPrim())
            inputs[name] = ("primvar", reader.GetInput("varname").Get(), reader.GetInput("fallback").Get())
        elif port.Get() is not None:
            value = port.Get()
            inputs[name] = tuple(value) if isinstance(value, Gf.Vec3f) else value
    return inputs


def _WorldArea(kind: str, i: dict, m: np.ndarray) -> float:
    """World area by the lengths of the transform's rows; spheres and cylinders: similar transforms only."""
    x, y, z = np.linalg.norm(m[:3, :3], axis=1)
    if kind == "Rect":
        return i["width"] * x * i["height"] * y
    if kind == "Disk":
        return np.pi * i["radius"] ** 2 * x * y
    if kind == "Cylinder":
        return 2 * np.pi * i["radius"] * y * i["length"] * x
    return 4 * np.pi * (i["radius"] * x) ** 2


def ReadLight(prim, matrix: np.ndarray) -> Light:
    """Radiance by UsdLux's text: intensity * 2^exposure * colour * temperature, over the size factor if
    normalised (distant: pi sin^2 of the half angle, 1 for angle 0)."""
    kind = prim.GetTypeName().replace("Light", "")
    inputs = {a.GetName().split(":", 1)[1]: a.Get() for a in prim.GetAttributes() if a.GetName().startswith("inputs:")}
    if inputs.get("texture:file"):
        inputs["texture:file"] = inputs["texture:file"].resolvedPath
    radiance = np.array(inputs["color"], float) * inputs["intensity"] * 2.0 ** inputs["exposure"]
    if inputs["enableColorTemperature"]:
        radiance *= np.array(UsdLux.BlackbodyTemperatureAsRgb(inputs["colorTemperature"]))
    if inputs["normalize"] and kind != "Dome":
        if kind == "Distant":
            sine = np.sin(np.radians(inputs["angle"] / 2))
            radiance /= np.pi * sine**2 if inputs["angle"] > 0 else 1.0
        else:
            radiance /= _WorldArea(kind, inputs, matrix)
    return Light(kind, matrix, radiance, inputs)


def ReadCamera(camera) -> dict:
    get = lambda name: getattr(camera, f"Get{name}Attr")().Get()
    world = np.array(camera.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    exposure = camera.ComputeLinearExposureScale() if hasattr(camera, "ComputeLinearExposureScale") else 2.0 ** get("Exposure")
    return dict(matrix=world, orthographic=get("Projection") == "orthographic", width=get("HorizontalAperture") / 10,
                height=get("VerticalAperture") / 10, offset=(get("HorizontalApertureOffset") / 10, get("VerticalApertureOffset") / 10),
                focal=get("FocalLength") / 10, near=get("ClippingRange")[0], fStop=get("FStop"), focus=get("FocusDistance"),
                exposure=exposure)
