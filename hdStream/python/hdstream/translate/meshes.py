# SPDX-License-Identifier: Apache-2.0
"""UsdGeomMesh and the implicit gprims as mesh descriptions. Only authored attributes are read."""

import numpy as np
from pxr import Usd, UsdGeom, Vt

from hdstream import _core
from hdstream.translate import nurbs
from hdstream.translate.motion import WhereFinite
from hdstream.translate.primvars import PrimvarsOf
from hdstream.translate.rereading import Again, IsKept
from hdstream.translate.usdCalls import GetAttribute, GetValue

_TAG_ARRAYS = {
    "creaseIndices": np.int32, "creaseLengths": np.int32, "creaseSharpnesses": np.float32,
    "cornerIndices": np.int32, "cornerSharpnesses": np.float32,
}
_TAG_TOKENS = ("interpolateBoundary", "faceVaryingLinearInterpolation", "triangleSubdivisionRule")
_TAG_NAMES = frozenset(_TAG_ARRAYS) | frozenset(_TAG_TOKENS)

# Size attributes of the implicit gprims and their fallbacks where the core's differ from the type's.
IMPLICIT_TYPES = ("Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane", "Cylinder_1", "Capsule_1")
_SHAPE_NUMBERS = ("size", "radius", "height", "width", "length")
_SHAPE_ATTRIBUTES = (*_SHAPE_NUMBERS, "radiusBottom", "radiusTop")
_FALLBACKS = {"Capsule": {"radius": 0.5, "height": 1.0}}


def ReadArray(prim, name, timeCode, itemType):
    """The value as a contiguous array of the item type, without a copy where it is one already."""
    value = GetValue(GetAttribute(prim, name), timeCode)
    if value is None:
        return None
    return np.ascontiguousarray(value, itemType)


def OrAgain(prim, name, timeCode, values):
    """What ReadArray gave, in a form that the core may read again where it is large."""
    if IsKept(values.nbytes):  # of a million small arrays no attribute is looked up twice
        return values
    itemType = values.dtype  # the function below must not keep the values
    return Again(prim.GetAttribute(name), timeCode, values, lambda own: ReadArray(own.GetPrim(), name, timeCode, itemType))


def _ReadSubdivTags(prim, names, timeCode):
    tags = _core.SubdivTags()
    for name in names:
        if name in _TAG_TOKENS:
            value = GetValue(GetAttribute(prim, name), timeCode)
            if value:
                setattr(tags, name, value)
        elif name in _TAG_ARRAYS:
            value = ReadArray(prim, name, timeCode, _TAG_ARRAYS[name])
            if value is not None:
                setattr(tags, name, value)
    return tags


def _ReadInts(prim, name, timeCode):
    """The value as an array of int32 that numpy and the core take: OpenUSD's own, around which numpy's would take time and memory."""
    value = GetValue(GetAttribute(prim, name), timeCode)
    return value if value is None or type(value) is Vt.IntArray else np.ascontiguousarray(value, np.int32)


def _IntsAgain(prim, name, timeCode, values):
    """What _ReadInts gave, in a form that the core may read again where it is large."""
    return values if IsKept(4 * len(values)) else OrAgain(prim, name, timeCode, np.asarray(values))


def ReadPoints(prim, names, timeCode):
    """[count][3]; between samples, where velocities take the points of the sample before."""
    points = _ReadPointArray(prim, names, timeCode)
    return None if points is None else np.asarray(points)


def _ReadPointArray(prim, names, timeCode):
    """The same as an array of OpenUSD."""
    points = GetValue(GetAttribute(prim, "points"), timeCode)
    if points is not None and not isinstance(points, Vt.Vec3fArray):
        # UsdImaging draws none of these either.
        raise ValueError(f"points are of type {type(points).__name__}, not point3f[]")
    if "velocities" in names and points and Usd.TimeCode(timeCode).IsNumeric():
        moved = UsdGeom.PointBased(prim).ComputePointsAtTime(timeCode, timeCode)
        points = WhereFinite(moved, points) if moved and len(moved) == len(points) else points
    return points


def PointsAgain(prim, names, timeCode, points):
    """What ReadPoints gave, in a form that the core may read again where it is large."""
    if IsKept(12 * len(points)):
        return points
    return Again(prim.GetAttribute("points"), timeCode, np.asarray(points), lambda own: ReadPoints(own.GetPrim(), names, timeCode))


def PosePoints(prim, names, timeCode, points, skin):
    """What ReadPoints gave, in the pose of a Skin where there is one."""
    return PointsAgain(prim, names, timeCode, points) if skin is None else skin.PointsOf(points)


def PoseSamples(prim, names, points, motion, warn, topology, skin):
    """(time, points) of what ReadPoints gave, in the poses of a Skin where there is one."""
    if skin is not None:
        return skin.SamplesOf(points)
    return motion.PointSamplesOf(prim, names, len(points), warn, topology)


def ReadMesh(prim, names, inherited, timeCode, motion, warn, skin=None):
    """The description of a UsdGeomMesh; None when it has no points or no faces.

    `skin`: the Skin of a skinned mesh. Normals are carried from the points at rest to the skinned ones.
    """
    points = _ReadPointArray(prim, names, timeCode)
    counts = _ReadInts(prim, "faceVertexCounts", timeCode)
    indices = _ReadInts(prim, "faceVertexIndices", timeCode)
    if points is None or counts is None or indices is None or not len(points) or not len(counts):
        return None
    if skin is not None:
        points = np.asarray(points)
    mesh = _core.GeometryDescription()
    mesh.points = PosePoints(prim, names, timeCode, points, skin)
    if skin is not None or motion.isOn:
        mesh.samples = PoseSamples(prim, names, points, motion, warn, ("faceVertexCounts", "faceVertexIndices"), skin)
    mesh.faceVertexCounts = _IntsAgain(prim, "faceVertexCounts", timeCode, counts)
    mesh.faceVertexIndices = _IntsAgain(prim, "faceVertexIndices", timeCode, indices)
    mesh.subdivisionScheme = "catmullClark"  # UsdGeomMesh's fallback
    if "subdivisionScheme" in names:
        mesh.subdivisionScheme = GetValue(GetAttribute(prim, "subdivisionScheme"), timeCode) or "none"
    if "holeIndices" in names:
        holes = ReadArray(prim, "holeIndices", timeCode, np.int32)
        if holes is not None:
            mesh.holeIndices = OrAgain(prim, "holeIndices", timeCode, holes)
    if not _TAG_NAMES.isdisjoint(names):
        mesh.subdivTags = _ReadSubdivTags(prim, names, timeCode)
    if "orientation" in names:
        orientation = GetValue(GetAttribute(prim, "orientation"), timeCode)
        mesh.leftHanded = orientation == "leftHanded"
        if orientation not in ("leftHanded", "rightHanded"):
            warn(prim, f"orientation {orientation} is unknown; rightHanded is used")
    mesh.primvars = PrimvarsOf(prim, names, inherited, timeCode)
    if skin is not None:
        _CarryNormals(mesh, points)
    elif motion.isOn:
        mesh.normalSamples = motion.PrimvarSamplesOf(prim, "normals", names, mesh.primvars)
    return mesh


def _CarryNormals(mesh, atRest):
    """Normals of a skinned polygon mesh go with its points; other schemes have none of their own."""
    normals = next((primvar for primvar in mesh.primvars if primvar.name == "normals"), None)
    if normals is None:
        return
    carried = samples = None
    if mesh.subdivisionScheme == "none":
        atRest = np.ascontiguousarray(atRest, np.float32)
        carried = _core.CarryNormals(normals, mesh, atRest, mesh.points)
        samples = [(time, _core.CarryNormals(normals, mesh, atRest, points)) for time, points in mesh.samples]
    mesh.primvars = [primvar for primvar in mesh.primvars if primvar.name != "normals"] + ([carried] if carried else [])
    if carried:
        mesh.normalSamples = [(time, primvar.values) for time, primvar in samples]


def ReadTetMesh(prim, names, inherited, timeCode, motion, warn, skin=None):
    """The surface of a UsdGeomTetMesh as a mesh: `surfaceFaceVertexIndices`, or else the faces that belong to one
    tetrahedron alone, as UsdImaging has them; None without points or faces. Primvars of tetrahedra are left out."""
    points = ReadPoints(prim, names, timeCode)
    if points is None or not points.size:
        return None
    faces = ReadArray(prim, "surfaceFaceVertexIndices", timeCode, np.int32)
    if faces is None or not faces.size:
        faces = np.ascontiguousarray(UsdGeom.TetMesh.ComputeSurfaceFaces(UsdGeom.TetMesh(prim), timeCode), np.int32)
    if not faces.size:
        return None
    mesh = _core.GeometryDescription()
    mesh.points = points if skin is None else skin.PointsOf(points)
    mesh.faceVertexCounts = np.full(faces.size // 3, 3, np.int32)
    mesh.faceVertexIndices = faces.ravel()
    mesh.subdivisionScheme = "catmullClark"  # as UsdImaging hands it over
    mesh.samples = PoseSamples(prim, names, points, motion, warn, ("tetVertexIndices", "surfaceFaceVertexIndices"), skin)
    if "orientation" in names:
        mesh.leftHanded = prim.GetAttribute("orientation").Get(timeCode) == "leftHanded"
    mesh.primvars = PrimvarsOf(prim, names, inherited, timeCode)
    return mesh


def ReadNurbsPatch(prim, names, inherited, timeCode, motion, warn, skin=None):
    """A UsdGeomNurbsPatch as a grid of quads with the surface's normals; None where it is none."""
    points = ReadPoints(prim, names, timeCode)
    if points is None or not points.size:
        return None
    patch = nurbs.Patch(prim, len(points), timeCode, warn)
    if patch.gridSizes is None:
        warn(prim, "its orders, knots and vertex counts make no NURBS patch; it is left out")
        return None
    trims = prim.GetAttribute("trimCurve:counts").Get(timeCode)
    if trims:
        warn(prim, "trim curves of NURBS patches are not supported; it is drawn whole")
    mesh = _core.GeometryDescription()
    posed = points if skin is None else skin.PointsOf(points)
    mesh.points = patch.Of(posed)
    mesh.faceVertexCounts, mesh.faceVertexIndices = patch.Faces()
    mesh.subdivisionScheme = "none"
    mesh.leftHanded = prim.GetAttribute("orientation").Get(timeCode) == "leftHanded"
    samples = PoseSamples(prim, names, points, motion, warn, ("uVertexCount", "vVertexCount"), skin)
    mesh.samples = [(time, patch.Of(array)) for time, array in samples]
    mesh.primvars = patch.Primvars(PrimvarsOf(prim, names, inherited, timeCode), prim, warn)
    side = np.float32(-1.0 if mesh.leftHanded else 1.0)
    normals = [patch.Normals(array) for array in (posed, *(array for _, array in samples))]
    if all(rows is not None for rows in normals):
        mesh.primvars = mesh.primvars + [_core.Primvar("normals", _core.Interpolation.Vertex, side * normals[0])]
        mesh.normalSamples = [(time, side * rows) for (time, _), rows in zip(samples, normals[1:])]
    return mesh


def ReadImplicit(prim, typeName, names, inherited, timeCode, motion, warn):
    """The description of an implicit gprim: OpenUSD's mesh of it, fitted so that its limit surface is the gprim."""
    mesh = _ImplicitCage(prim, typeName, names, timeCode, warn)
    mesh.samples = motion.ShapeSamplesOf(
        prim, [name for name in _SHAPE_ATTRIBUTES if name in names], len(mesh.points),
        lambda time: np.asarray(_ImplicitCage(prim, typeName, names, time, lambda *_: None).points))
    mesh.primvars = mesh.primvars + PrimvarsOf(prim, names, inherited, timeCode)
    return mesh


def _ImplicitCage(prim, typeName, names, timeCode, warn):
    baseType = typeName[:-2] if typeName.endswith("_1") else typeName
    shape = _core.ImplicitShape()
    shape.type = baseType
    values = dict(_FALLBACKS.get(baseType, {}))
    for name in _SHAPE_NUMBERS:
        if name in names:
            values[name] = prim.GetAttribute(name).Get(timeCode)
    if typeName != baseType:
        values["radius"] = prim.GetAttribute("radiusBottom").Get(timeCode)
        values["radiusTop"] = prim.GetAttribute("radiusTop").Get(timeCode)
    for name, value in values.items():
        if value is not None:
            setattr(shape, name, value)
    if "axis" in names:
        shape.axis = prim.GetAttribute("axis").Get(timeCode) or "Z"
        if shape.axis not in ("X", "Y", "Z"):
            warn(prim, f"axis {shape.axis} is unknown; Z is used")
    mesh = _core.MakeImplicitMesh(shape)
    _core.FitLimitSurface(mesh)
    return mesh


def ReadSubset(prim, timeCode, warn):
    """A face subset of the family materialBind; None for any other subset."""
    elementType = prim.GetAttribute("elementType").Get()
    if prim.GetAttribute("familyName").Get() != "materialBind":
        return None
    if elementType != "face":
        warn(prim, f"a subset of elements of type {elementType} binds no material: those of faces alone do")
        return None
    faces = ReadArray(prim, "indices", timeCode, np.int32)
    if faces is None or not faces.size:
        return None
    subset = _core.MeshSubset()
    subset.faces = OrAgain(prim, "indices", timeCode, faces)
    return subset
