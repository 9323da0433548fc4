# SPDX-License-Identifier: Apache-2.0
"""Short ways to author USD: meshes, materials, lights and cameras on a usd-core stage.

Single-threaded, as usd-core's authoring is. Nothing here interprets a scene; it only writes one.
"""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from .shapes import Shape

_INPUT_TYPES = {
    "diffuseColor": Sdf.ValueTypeNames.Color3f, "emissiveColor": Sdf.ValueTypeNames.Color3f,
    "specularColor": Sdf.ValueTypeNames.Color3f, "useSpecularWorkflow": Sdf.ValueTypeNames.Int,
    "normal": Sdf.ValueTypeNames.Normal3f, "opacityMode": Sdf.ValueTypeNames.Token,
}


def NewStage(path: str, upAxis: str = "Y") -> Usd.Stage:
    """An empty stage at `path` (replacing a file there) with metersPerUnit 1 and a default prim."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, upAxis)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    return stage


def Place(prim, translate=None, rotate=None, scale=None, matrix=None) -> None:
    """Authors the transform: translate * rotateXYZ (degrees) * scale, or one matrix."""
    xformable = UsdGeom.Xformable(prim)
    if matrix is not None:
        xformable.AddTransformOp().Set(Gf.Matrix4d(matrix))
    if translate is not None:
        xformable.AddTranslateOp().Set(Gf.Vec3d(*map(float, translate)))
    if rotate is not None:
        xformable.AddRotateXYZOp().Set(Gf.Vec3f(*map(float, rotate)))
    if scale is not None:
        scale = (scale,) * 3 if np.isscalar(scale) else scale
        xformable.AddScaleOp().Set(Gf.Vec3f(*map(float, scale)))


def AddMesh(stage, path: str, shape: Shape, color=None, material=None, doubleSided=False, **placement) -> UsdGeom.Mesh:
    """A mesh prim, subdivisionScheme none, with the shape's normals (vertex) and `st` if it has them."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    points = np.ascontiguousarray(shape.points, np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(shape.counts, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(shape.indices, np.int32)))
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateExtentAttr([Gf.Vec3f(*map(float, points.min(0))), Gf.Vec3f(*map(float, points.max(0)))])
    if shape.normals is not None:
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(shape.normals, np.float32)))
        mesh.SetNormalsInterpolation("vertex")
    if shape.texcoords is not None:
        AddPrimvar(mesh, "st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex",
                   Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(shape.texcoords, np.float32)))
    if doubleSided:
        mesh.CreateDoubleSidedAttr(True)
    if color is not None:
        mesh.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    if material is not None:
        Bind(mesh, material)
    Place(mesh, **placement)
    return mesh


def AddPrimvar(prim, name: str, valueType, interpolation: str, values, indices=None) -> None:
    """A primvar with an interpolation and optional indices."""
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, valueType, interpolation)
    primvar.Set(values)
    if indices is not None:
        primvar.SetIndices(Vt.IntArray([int(i) for i in indices]))


def Bind(prim, material: UsdShade.Material) -> None:
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def AddMaterial(stage, path: str, readers: dict | None = None, **inputs) -> UsdShade.Material:
    """A UsdPreviewSurface with constant inputs. `readers` maps an input to (primvar, reader type,
    fallback), for example {"opacity": ("cover", "float", 1.0)}."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path + "/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for name, value in inputs.items():
        valueType = _INPUT_TYPES.get(name, Sdf.ValueTypeNames.Float)
        value = Gf.Vec3f(*map(float, value)) if isinstance(value, (tuple, list)) else value
        shader.CreateInput(name, valueType).Set(value)
    for name, (primvar, kind, fallback) in (readers or {}).items():
        reader = UsdShade.Shader.Define(stage, f"{path}/Reader_{name}")
        reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
        valueType = _INPUT_TYPES.get(name, Sdf.ValueTypeNames.Float)
        reader.CreateInput("fallback", valueType).Set(Gf.Vec3f(*fallback) if isinstance(fallback, tuple) else fallback)
        output = reader.CreateOutput("result", valueType)
        shader.CreateInput(name, valueType).ConnectToSource(output)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def AddCamera(stage, path="/World/Camera", eye=(0, 0, 5), target=(0, 0, 0), up=(0, 1, 0), width=36.0,
              focalLength=35.0, aspect=4 / 3, orthographic=False, offset=(0.0, 0.0)) -> UsdGeom.Camera:
    """A camera looking from eye to target; `width` is the horizontal aperture in tenths of a unit."""
    camera = UsdGeom.Camera.Define(stage, path)
    camera.CreateProjectionAttr("orthographic" if orthographic else "perspective")
    camera.CreateHorizontalApertureAttr(float(width))
    camera.CreateVerticalApertureAttr(float(width / aspect))
    camera.CreateHorizontalApertureOffsetAttr(float(offset[0]))
    camera.CreateVerticalApertureOffsetAttr(float(offset[1]))
    camera.CreateFocalLengthAttr(float(focalLength))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1000.0))
    view = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*map(float, eye)), Gf.Vec3d(*map(float, target)), Gf.Vec3d(*map(float, up)))
    Place(camera, matrix=view.GetInverse())
    return camera


def AddLight(stage, path: str, kind: str, placement: dict | None = None, **inputs):
    """A UsdLux light ("Sphere", "Rect", "Disk", "Cylinder", "Distant", "Dome") with inputs by name."""
    light = getattr(UsdLux, kind + "Light").Define(stage, path)
    for name, value in inputs.items():
        if name == "color":
            value = Gf.Vec3f(*map(float, value))
        getattr(light, f"Create{name[0].upper()}{name[1:]}Attr")(value)
    Place(light, **(placement or {}))
    return light


def ShapeLight(light, **inputs):
    """Applies UsdLuxShapingAPI with inputs by name: focus, focusTint, coneAngle, coneSoftness, iesFile, ..."""
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    for name, value in inputs.items():
        value = Gf.Vec3f(*map(float, value)) if name == "focusTint" else value
        getattr(shaping, f"CreateShaping{name[0].upper()}{name[1:]}Attr")(value)
    return light


def ShadowLight(light, **inputs):
    """Applies UsdLuxShadowAPI with inputs by name: enable, color, distance, falloff, falloffGamma."""
    shadow = UsdLux.ShadowAPI.Apply(light.GetPrim())
    for name, value in inputs.items():
        value = Gf.Vec3f(*map(float, value)) if name == "color" else value
        getattr(shadow, f"CreateShadow{name[0].upper()}{name[1:]}Attr")(value)
    return light


def LinkLight(light, collection, includes=None, excludes=()):
    """Sets a light's "lightLink" or "shadowLink": only `includes` (None: all) but for `excludes`."""
    api = Usd.CollectionAPI.Apply(light.GetPrim(), collection)
    if includes is not None:
        api.CreateIncludeRootAttr(False)
        for path in includes:
            api.CreateIncludesRel().AddTarget(path)
    for path in excludes:
        api.CreateExcludesRel().AddTarget(path)
    return light
