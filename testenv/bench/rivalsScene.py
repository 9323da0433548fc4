# SPDX-License-Identifier: Apache-2.0
"""A stage as plain arrays that every rival is handed: meshes of triangles with the places they stand at, materials of
UsdPreviewSurface's inputs, lights, one camera.

Read over usd-core, apart from hdStream's own translation. What it cannot say the same to all renderers it refuses with a
line that names the prim. A mesh that stands at several places stays one mesh, so that rivals can instance it. Subdivision
surfaces are their cages with smooth normals, which is what hdStream draws with `subdivision` at `cage`.
"""

import pickle
from dataclasses import dataclass, field

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdVol

import rivalsMatter
from stageReader import ReadCamera, ReadLight, Spread, Triangulate

_PURPOSES = {"default", "render"}
_EIGHT_BITS = (".png", ".jpg", ".jpeg", ".tga", ".bmp")
_LAMBERT = "displayColor"
_DEFAULTS = dict(diffuseColor=(0.18,) * 3, metallic=0.0, roughness=0.5, clearcoat=0.0, clearcoatRoughness=0.01, opacity=1.0, ior=1.5,
                 normal=None, emissiveColor=(0.0,) * 3)
_REFUSED = dict(useSpecularWorkflow=0, opacityThreshold=0.0)


@dataclass
class Mesh:
    """Triangles with one material. A vertex has one normal and one coordinate; where they differ it is there twice."""

    path: str
    points: np.ndarray  # [vertices][3]
    normals: np.ndarray | None  # [vertices][3], unit; None: flat
    texcoords: np.ndarray | None  # [vertices][2], (0, 0) is the image's lower left corner
    triangles: np.ndarray  # [triangles][3], counter-clockwise from the front
    material: int
    places: np.ndarray | None = None  # [places][4][4] to world, for row vectors


@dataclass(frozen=True)
class Texture:
    """An image that feeds an input by one channel or by rgb, and repeats in both directions. Scale 2 and bias -1 for the
    normal, else 1 and 0."""

    file: str
    isSrgb: bool
    output: str  # r, g, b, a or rgb
    scale: tuple
    bias: tuple


@dataclass
class PlainScene:
    """All that is drawn. A material has the inputs of _DEFAULTS, or is {"lambert": color}, or what rivalsMatter reads."""

    meshes: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    lights: list = field(default_factory=list)  # of stageReader
    volumes: list = field(default_factory=list)  # of rivalsMatter
    camera: dict = field(default_factory=dict)

    def NumTriangles(self) -> tuple[int, int]:
        """(unique, with all places)."""
        counts = [(len(mesh.triangles), len(mesh.places)) for mesh in self.meshes]
        return sum(n for n, _ in counts), sum(n * places for n, places in counts)


def Save(scene: PlainScene, path) -> None:
    with open(path, "wb") as file:
        pickle.dump(scene, file, protocol=5)


def Load(path) -> PlainScene:
    with open(path, "rb") as file:
        return pickle.load(file)


def Read(path, cameraPath: str) -> PlainScene:
    """The whole stage at the default time."""
    stage = Usd.Stage.Open(str(path))
    camera = UsdGeom.Camera(stage.GetPrimAtPath(cameraPath))
    if not camera:
        raise ValueError(f"{path}: no camera {cameraPath}")
    scene = _Reader(stage).Scene(camera)
    if scene.camera["orthographic"] or (scene.camera["fStop"] > 0 and any(scene.camera["offset"])):
        raise ValueError(f"{cameraPath}: an orthographic camera, or a lens with an aperture offset, is not handled")
    return scene


def ReadView(path, cameraPath: str) -> tuple[dict, list]:
    """(camera, lights) alone, for a rival that reads the rest itself."""
    stage = Usd.Stage.Open(str(path))
    lights = [_Reader.ReadLight(prim) for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI)
              and UsdGeom.Imageable(prim).ComputeVisibility() != "invisible"]
    return ReadCamera(UsdGeom.Camera(stage.GetPrimAtPath(cameraPath))), lights


class _Reader:
    def __init__(self, stage):
        self._stage = stage
        self._scene = PlainScene()
        self._meshes, self._materials, self._contents = {}, {}, {}

    def Scene(self, camera) -> PlainScene:
        places = {}
        for prim in self._stage.GetPseudoRoot().GetChildren():
            for mesh, matrices in self._Content(prim, False):
                places.setdefault(mesh, []).append(matrices)
        for i, mesh in enumerate(self._scene.meshes):
            if i in places:
                mesh.places = np.concatenate(places[i])
        self._scene.meshes = [mesh for mesh in self._scene.meshes if mesh.places is not None]
        self._scene.camera = ReadCamera(camera)
        return self._scene

    def _Content(self, prim, isShared: bool) -> list:
        """(mesh, matrices [k][4][4] to the parent's space) of all that is drawn at and below a prim."""
        if not prim.IsDefined() or prim.IsAbstract():
            return []
        imageable = UsdGeom.Imageable(prim)
        if imageable and (imageable.GetVisibilityAttr().Get() == "invisible" or imageable.ComputePurpose() not in _PURPOSES):
            return []
        content = []
        if prim.IsA(UsdGeom.Mesh):
            content += [(i, np.eye(4)[None]) for i in self._Mesh(UsdGeom.Mesh(prim))]
        elif prim.IsA(UsdGeom.PointInstancer):
            return self._Moved(prim, self._Instances(UsdGeom.PointInstancer(prim)))
        elif prim.IsA(UsdVol.Volume):
            self._scene.volumes.append(rivalsMatter.ReadVolume(prim))
            return []
        elif prim.IsA(UsdGeom.Gprim):
            raise ValueError(f"{prim.GetPath()}: {prim.GetTypeName()} is not handled")
        elif prim.HasAPI(UsdLux.LightAPI):
            if isShared:
                raise ValueError(f"{prim.GetPath()}: lights of instances are not handled")
            self._scene.lights.append(self.ReadLight(prim))
        if prim.IsInstance():
            prototype = prim.GetPrototype().GetPath()
            if prototype not in self._contents:
                self._contents[prototype] = [item for child in prim.GetPrototype().GetChildren() for item in self._Content(child, True)]
            content += self._contents[prototype]
        else:
            content += [item for child in prim.GetChildren() for item in self._Content(child, isShared)]
        return self._Moved(prim, content)

    @staticmethod
    def _Moved(prim, content: list) -> list:
        xformable = UsdGeom.Xformable(prim)
        if not xformable or not content:
            return content
        if xformable.GetResetXformStack():
            raise ValueError(f"{prim.GetPath()}: !resetXformStack! is not handled")
        local = np.array(xformable.GetLocalTransformation())
        return [(mesh, matrices @ local) for mesh, matrices in content]

    def _Instances(self, instancer) -> list:
        """(mesh, matrices to the instancer's space)."""
        time = Usd.TimeCode.Default()
        matrices = np.array(instancer.ComputeInstanceTransformsAtTime(time, time, UsdGeom.PointInstancer.ExcludeProtoXform,
                                                                      UsdGeom.PointInstancer.IgnoreMask))
        kinds = np.array(instancer.GetProtoIndicesAttr().Get())
        mask = instancer.ComputeMaskAtTime(time)
        isDrawn = np.array(mask, bool) if len(mask) else np.ones(len(kinds), bool)
        content = []
        for kind, target in enumerate(instancer.GetPrototypesRel().GetTargets()):
            own = matrices[isDrawn & (kinds == kind)]
            for mesh, inner in self._Content(self._stage.GetPrimAtPath(target), True):
                content.append((mesh, (inner[None] @ own[:, None]).reshape(-1, 4, 4)))
        return content

    @staticmethod
    def ReadLight(prim):
        matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        light = ReadLight(prim, matrix)
        if light.kind not in ("Dome", "Rect", "Sphere", "Distant") or (light.kind == "Rect" and light.inputs.get("texture:file")):
            raise ValueError(f"{prim.GetPath()}: this {light.kind} light is not handled")
        return light

    def _Mesh(self, mesh) -> list:
        """Indices of the meshes that a prim is made of, one a material."""
        path = mesh.GetPath()
        if path not in self._meshes:
            parts = self._ReadMesh(mesh)
            self._meshes[path] = list(range(len(self._scene.meshes), len(self._scene.meshes) + len(parts)))
            self._scene.meshes += parts
        return self._meshes[path]

    def _ReadMesh(self, mesh) -> list:
        points = np.array(mesh.GetPointsAttr().Get() or np.zeros((0, 3)), np.float64)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], int)
        if len(points) == 0 or len(counts) == 0:
            return []
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        corners, faces = Triangulate(points, counts, indices, list(mesh.GetHoleIndicesAttr().Get() or []))
        isLeft = mesh.GetOrientationAttr().Get() == "leftHanded"
        if isLeft:
            corners = corners[:, ::-1]
        normals = self._Normals(mesh, points, counts, indices, corners, faces, isLeft)
        parts = []
        for material, isIn in self._Subsets(mesh, counts):
            pick = isIn[faces]
            if not pick.any():
                continue
            look, coordinates = self._Material(material, mesh)
            texcoords = self._Texcoords(mesh, coordinates, indices, corners, faces) if coordinates else None
            values = [None if v is None else v[pick].reshape(-1, v.shape[-1]) for v in (normals, texcoords)]
            parts.append(Mesh(str(mesh.GetPath()), *_Welded(points, indices[corners[pick]], *values), look))
        return parts

    @staticmethod
    def _Subsets(mesh, counts) -> list:
        """(material prim or None, faces [bool])."""
        api = UsdShade.MaterialBindingAPI(mesh.GetPrim())
        rest, out = np.ones(len(counts), bool), []
        for subset in api.GetMaterialBindSubsets():
            faces = np.zeros(len(counts), bool)
            faces[np.array(subset.GetIndicesAttr().Get(), int)] = True
            rest &= ~faces
            out.append((UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0], faces))
        return [(api.ComputeBoundMaterial()[0], rest)] + out

    @staticmethod
    def _Normals(mesh, points, counts, indices, corners, faces, isLeft: bool) -> np.ndarray | None:
        """By triangle corner, or None for flat faces."""
        if mesh.GetSubdivisionSchemeAttr().Get() != "none":
            smooth = _SmoothNormals(points, counts, indices) * (-1 if isLeft else 1)
            return smooth[indices[corners]]
        raw = mesh.GetNormalsAttr().Get()
        if not raw:
            return None
        raw = np.array(raw, np.float64)
        raw /= np.maximum(np.linalg.norm(raw, axis=-1, keepdims=True), 1e-30)
        return Spread(raw, mesh.GetNormalsInterpolation(), indices, corners, faces)

    @staticmethod
    def _Texcoords(mesh, name: str, indices, corners, faces) -> np.ndarray | None:
        primvar = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance(name)
        if not primvar or not primvar.HasValue():
            return None
        return Spread(np.array(primvar.ComputeFlattened(), np.float64), primvar.GetInterpolation(), indices, corners, faces)

    def _Material(self, material, mesh) -> tuple[int, str]:
        """(index, name of the coordinates that its images use or "")."""
        surface = material.ComputeSurfaceSource()[0] if material else None
        matter = rivalsMatter.ReadLook(material)
        if matter:
            inputs, coordinates = matter, ""
        elif surface:
            inputs, coordinates = _ReadSurface(surface)
        else:
            inputs, coordinates = {"lambert": _DisplayColor(mesh)}, ""
        key = repr(sorted(inputs.items()))
        if key not in self._materials:
            self._materials[key] = len(self._scene.materials)
            self._scene.materials.append(inputs)
        return self._materials[key], coordinates


def _SmoothNormals(points, counts, indices) -> np.ndarray:
    """[points][3]: a corner weighs by the sine of its angle over the lengths of its sides (Max 1999)."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    face = np.repeat(np.arange(len(counts)), counts)
    at = np.arange(len(indices)) - starts[face]
    after = points[indices[starts[face] + (at + 1) % counts[face]]] - points[indices]
    before = points[indices[starts[face] + (at - 1) % counts[face]]] - points[indices]
    scale = np.sum(after**2, 1) * np.sum(before**2, 1)
    weighed = np.cross(after, before) / np.maximum(scale, 1e-300)[:, None]
    normals = np.stack([np.bincount(indices, weighed[:, k], len(points)) for k in range(3)], 1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _Welded(points, vertices, normals, texcoords) -> tuple:
    """(points, normals, texcoords, triangles) in which corners with equal values share a vertex. `vertices`
    [triangles][3]; values by corner."""
    flat = vertices.reshape(-1)
    columns = [flat[:, None].astype(np.int32)]
    columns += [np.ascontiguousarray(v, np.float32).view(np.int32) for v in (normals, texcoords) if v is not None]
    rows = np.ascontiguousarray(np.concatenate(columns, 1))
    _, first, inverse = np.unique(rows.view([("", np.int32)] * rows.shape[1]).ravel(), return_index=True, return_inverse=True)
    pick = lambda v: None if v is None else np.ascontiguousarray(v[first], np.float32)
    return points[flat[first]].astype(np.float32), pick(normals), pick(texcoords), inverse.reshape(-1, 3).astype(np.int32)


def _DisplayColor(mesh) -> tuple:
    primvar = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance(_LAMBERT)
    values = np.array(primvar.ComputeFlattened(), float).reshape(-1, 3) if primvar and primvar.HasValue() else np.full((1, 3), 0.5)
    if np.ptp(values, axis=0).max() > 0:
        raise ValueError(f"{mesh.GetPath()}: displayColor that varies is not handled")
    return tuple(float(v) for v in values[0])


def _ReadSurface(surface) -> tuple[dict, str]:
    path = surface.GetPrim().GetPath()
    if surface.GetIdAttr().Get() != "UsdPreviewSurface":
        raise ValueError(f"{path}: is no UsdPreviewSurface")
    inputs, names = {}, set()
    for name, default in {**_DEFAULTS, **_REFUSED}.items():
        value = _InputValue(surface.GetInput(name), names)
        inputs[name] = default if value is None else value
    for name, default in _REFUSED.items():
        if inputs.pop(name) != default:
            raise ValueError(f"{path}: {name} is not handled")
    for name, value in inputs.items():
        usual = ((2.0,), (-1.0,)) if name == "normal" else ((1.0,), (0.0,))
        if isinstance(value, Texture) and (tuple(set(value.scale)), tuple(set(value.bias))) != usual:
            raise ValueError(f"{path}: scale and bias of {name}'s texture are not handled")
    if isinstance(inputs["emissiveColor"], Texture):
        raise ValueError(f"{path}: a texture of emissiveColor is not handled")
    if inputs["normal"] is not None and not isinstance(inputs["normal"], Texture):
        raise ValueError(f"{path}: a normal that is no texture is not handled")
    if len(names) > 1:
        raise ValueError(f"{path}: several sets of texture coordinates are not handled")
    return inputs, "".join(names)


def _InputValue(port, names: set):
    """A number, a tuple, a Texture, or None where nothing is authored. Adds to `names` the coordinates it reads."""
    if not port:
        return None
    sources = UsdShade.Utils.GetValueProducingAttributes(port)
    if not sources:
        return None
    source = sources[0]
    shader = UsdShade.Shader(source.GetPrim())
    if not shader or not source.GetName().startswith("outputs:"):
        return _Plain(source.Get())
    if shader.GetIdAttr().Get() != "UsdUVTexture":
        raise ValueError(f"{shader.GetPath()}: {shader.GetIdAttr().Get()} is not handled")
    return _ReadTexture(shader, source.GetName().split(":")[1], names)


def _ReadTexture(shader, output: str, names: set):
    own = lambda name, default: default if (value := _InputValue(shader.GetInput(name), names)) is None else value
    reader = UsdShade.Utils.GetValueProducingAttributes(shader.GetInput("st"))[0].GetPrim()
    if UsdShade.Shader(reader).GetIdAttr().Get() != "UsdPrimvarReader_float2":
        raise ValueError(f"{reader.GetPath()}: is no UsdPrimvarReader_float2")
    file, scale, bias = own("file", ""), own("scale", (1.0,) * 4), own("bias", (0.0,) * 4)
    channels = {"rgb": slice(0, 3), "r": slice(0, 1), "g": slice(1, 2), "b": slice(2, 3), "a": slice(3, 4)}[output]
    try:
        open(file, "rb").close()
    except OSError:
        value = tuple(own("fallback", (0.0, 0.0, 0.0, 1.0))[channels])
        return value if output == "rgb" else value[0]
    if {own("wrapS", "useMetadata"), own("wrapT", "useMetadata")} != {"repeat"}:
        raise ValueError(f"{shader.GetPath()}: wrap modes other than repeat are not handled")
    names.add(str(_InputValue(UsdShade.Shader(reader).GetInput("varname"), names)))
    space = own("sourceColorSpace", "auto")
    isSrgb = space == "sRGB" or (space == "auto" and file.lower().endswith(_EIGHT_BITS))
    return Texture(file, isSrgb, output, tuple(scale[channels]), tuple(bias[channels]))


def _Plain(value):
    if isinstance(value, Sdf.AssetPath):
        return value.resolvedPath
    if isinstance(value, (Gf.Vec2f, Gf.Vec3f, Gf.Vec4f)):
        return tuple(float(v) for v in value)
    return value
