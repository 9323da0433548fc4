# SPDX-License-Identifier: Apache-2.0
"""UsdLux lights as light descriptions: authored inputs, UsdLux's fallbacks, nothing folded in."""

from pxr import Gf, Sdf, UsdGeom

from hdstream import _core
from hdstream.translate import valueClips
from hdstream.translate.colorSpaces import ColorSpaceOf, ColorSpaceOfColor
from hdstream.translate.materials import ParameterFrom
from hdstream.translate.usdCalls import GetAppliedSchemas

_TYPES = {
    "DistantLight": _core.LightType.Distant,
    "SphereLight": _core.LightType.Sphere,
    "RectLight": _core.LightType.Rect,
    "DiskLight": _core.LightType.Disk,
    "CylinderLight": _core.LightType.Cylinder,
    "DomeLight": _core.LightType.Dome,
    "DomeLight_1": _core.LightType.Dome,
}
LIGHT_TYPES = tuple(_TYPES)
UNSUPPORTED_LIGHT_TYPES = ("GeometryLight", "PluginLight")
_DISTANT_INTENSITY = 50000.0  # UsdLuxDistantLight's fallback; that of all others is 1

FILTERS = "light:filters"
_FILTER_IDS = ("ri:lightFilter:shaderId", "lightFilter:shaderId", "info:id")
_HOST_FILTER = "Pxr"
_NO_FILTER_INPUTS = ("xformOp", "visibility", "purpose", "collection:", "lightFilter:", "ri:lightFilter:", "info:",
                     "colorSpace:")
_SHAPING = "inputs:shaping:"
_SHADOW = "inputs:shadow:"
_NO_INPUTS = ("type", "colorSpace", "shaping", "shadow", "visibleToCamera", "group")
_VARYING = ("intensity", "exposure", "color", "colorTemperature", "angle", "radius", "width", "height", "length")
_Z_FROM_Y = Gf.Matrix4d(1.0).SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))


def IsLight(prim):
    """Whether a gprim is a light: LightAPI is applied, which is also part of UsdLuxMeshLightAPI."""
    return "LightAPI" in GetAppliedSchemas(prim)


def ReadSyncMode(prim, warn):
    """How a mesh light and its material go together."""
    attribute = prim.GetAttribute("light:materialSyncMode")
    text = (attribute.Get() if attribute else None) or "noMaterialResponse"
    mode = _core.MaterialSyncModeByText.get(text)
    if mode is None:
        warn(prim, f"light:materialSyncMode {text} is unknown; noMaterialResponse is used")
        return _core.MaterialSyncMode.NoMaterialResponse
    return mode


def ReadLight(prim, typeName, names, timeCode, assets, warn):
    """The description of a light of one of LIGHT_TYPES, or of a gprim with faces; warn(prim, message) of inputs of other types."""
    light = _core.LightDescription()
    light.type = _TYPES.get(typeName, _core.LightType.Mesh)
    if typeName == "DistantLight":
        light.intensity = _DISTANT_INTENSITY
    for name in names:
        if light.type == _core.LightType.Mesh and not name.startswith("inputs:"):
            continue  # a gprim's own radius is no input of the light
        member = _Member(name.removeprefix("inputs:"))
        if member not in _NO_INPUTS and hasattr(light, member):
            _ReadInput(prim.GetAttribute(name), light, member, timeCode, assets, warn)
    light.group = _ReadGroup(prim, names, timeCode)
    color = prim.GetAttribute("inputs:color")
    light.colorSpace = ColorSpaceOf(color) if color else ""
    # Where the schema is applied its fallbacks count: a cone of 90 degrees.
    if any(name.startswith(_SHAPING) for name in names) or "ShapingAPI" in prim.GetAppliedSchemas():
        light.shaping = _ReadInputs(prim, _SHAPING, _core.LightShaping(), timeCode, assets, warn)
    if any(name.startswith(_SHADOW) for name in names):
        light.shadow = _ReadInputs(prim, _SHADOW, _core.LightShadow(), timeCode, assets, warn)
    return light


def ReadLightSamples(prim, light, names, motion):
    """What of a light changes while the shutter is open; empty when it is the same at all times."""
    if not motion.isOn:
        return []
    inputs = {name: prim.GetAttribute(f"inputs:{name}") for name in _VARYING if f"inputs:{name}" in names}
    varying = {name: attribute for name, attribute in inputs.items() if valueClips.Varies(attribute)}
    if not varying:
        return []
    samples = []
    for time, told in zip(motion.times, motion.ToldTimes()):
        sample = _core.LightSample()
        sample.time = told
        for name in _VARYING:
            setattr(sample, name, getattr(light, name))
        for name, attribute in varying.items():
            value = attribute.Get(motion.At(time))
            try:
                if value is not None:
                    setattr(sample, name, type(getattr(sample, name))(value))
            except (TypeError, ValueError):
                pass  # which ReadLight has told
        samples.append(sample)
    return samples


def _ReadGroup(prim, names, timeCode):
    """The group that light path expressions know a light by."""
    values = (prim.GetAttribute(name).Get(timeCode) for name in _core.LIGHT_GROUP_ATTRIBUTES if name in names)
    return next((str(value) for value in values if value), "")


def _Member(name):
    """The member of a description that an input is: "cone:angle" is coneAngle."""
    first, *rest = name.split(":")
    return first + "".join(part[:1].upper() + part[1:] for part in rest)


def _ReadInput(attribute, target, member, timeCode, assets, warn):
    """Sets a member to an input that has a value, a schema's fallback included."""
    value = attribute.Get(timeCode) if attribute else None
    kind = type(getattr(target, member))
    try:
        if kind is _core.AssetReference:
            if value and value.path:
                setattr(target, member, _InSpace(assets.Resolve(attribute, value), attribute))
        elif value is not None:
            setattr(target, member, kind(value))
    except (AttributeError, TypeError, ValueError):
        warn(attribute.GetPrim(), f"{attribute.GetName()} cannot be a {Sdf.GetValueTypeNameForValue(value)}; not read")


def _InSpace(asset, attribute):
    """The same file, which says its colour space."""
    return _core.AssetReference(asset.authoredPath, asset.file, asset.offset, asset.size, ColorSpaceOf(attribute))


def _ReadInputs(prim, prefix, target, timeCode, assets, warn):
    """Sets members of `target` to the inputs whose names begin so."""
    for name in prim.GetPropertyNames():
        if name.startswith(prefix):
            member = _Member(name[len(prefix):])
            if hasattr(target, member):
                _ReadInput(prim.GetAttribute(name), target, member, timeCode, assets, warn)
    return target


def PoleTransform(prim, typeName, warn):
    """The rotation that aligns a dome's pole (+Y of its own space) with its pole axis.

    UsdLux: DomeLight's pole is +Y whatever the stage's up axis; DomeLight_1 has `poleAxis`, whose
    fallback "scene" is the stage's up axis. Applied before the dome's transform.
    """
    if typeName != "DomeLight_1":
        return None
    axis = prim.GetAttribute("poleAxis").Get()
    if axis == "scene":
        axis = UsdGeom.GetStageUpAxis(prim.GetStage())
    if axis not in ("Y", "Z"):
        warn(prim, f"poleAxis {axis} is unknown; Y is used")
    return _Z_FROM_Y if axis == "Z" else None


def ReadPortals(prim, names, timeCode, warn):
    """(worldFromPortal, width, height) of the PortalLights that a dome names; warn(prim, message) of what is none."""
    if "portals" not in names:
        return []
    portals = []
    for path in prim.GetRelationship("portals").GetForwardedTargets():
        portal = prim.GetStage().GetPrimAtPath(path)
        if not portal or portal.GetTypeName() != "PortalLight":
            warn(prim, f"portal {path} is no PortalLight; left out")
            continue
        matrix = UsdGeom.Xformable(portal).ComputeLocalToWorldTransform(timeCode)
        # Schemas before width and height: "The rectangle is 1 unit in length."
        sizes = [portal.GetAttribute(f"inputs:{name}") for name in ("width", "height")]
        values = [size.Get(timeCode) if size else None for size in sizes]
        portals.append((matrix, *(1.0 if value is None else float(value) for value in values)))
    return portals


def ReadFilters(prim, names, matrix, timeCode, assets, warn):
    """(node, worldFromFilter) of the light filters that a light names, which are placed as the light of that matrix is;
    warn(prim, message) of paths without a prim."""
    if FILTERS not in names:
        return []
    filters = []
    transforms = UsdGeom.XformCache(timeCode)
    for path in prim.GetRelationship(FILTERS).GetForwardedTargets():
        source = prim.GetStage().GetPrimAtPath(path)
        if not source:
            warn(prim, f"light filter {path} does not exist; left out")
            continue
        worldFromFilter = transforms.GetLocalToWorldTransform(source)
        worldFromLight = transforms.GetLocalToWorldTransform(prim)
        if not Gf.IsClose(worldFromLight, matrix, 1e-9):  # it is placed below an instancer
            if worldFromLight.GetDeterminant() == 0.0:
                warn(prim, f"light with a singular transform below an instancer: its filter {path} is left out")
                continue
            worldFromFilter *= worldFromLight.GetInverse() * matrix
        filters.append((_ReadFilterNode(source, timeCode, assets), worldFromFilter))
    return filters


def _ReadFilterNode(prim, timeCode, assets):
    """A filter as a node: its kind and what is authored of its inputs, nothing folded in."""
    kind = prim.GetTypeName()
    isOfHost = kind.startswith(_HOST_FILTER)  # UsdRi's schemas had inputs without "inputs:" before OpenUSD 21.02
    if not isOfHost:
        ids = (prim.GetAttribute(name) for name in _FILTER_IDS)
        kind = next((str(value) for value in (each.Get() if each else None for each in ids) if value), "")
    parameters = {}
    connections = {}
    for attribute in prim.GetAttributes():
        if not (attribute.IsAuthored() or attribute.HasAuthoredValue()):  # the second of value clips
            continue
        name = attribute.GetName()
        isInput = name.startswith("inputs:")
        if not isInput and not (isOfHost and not name.startswith(_NO_FILTER_INPUTS)):
            continue
        name = name[len("inputs:"):] if isInput else name
        if attribute.HasAuthoredConnections():
            source = attribute.GetConnections()[0]
            connections[name] = _core.Connection(source.GetPrimPath().pathString, source.name.split(":", 1)[-1])
            continue
        value = attribute.Get(timeCode)
        if isinstance(value, Sdf.AssetPath):
            parameters[name] = _InSpace(assets.Resolve(attribute, value), attribute)
        elif value is not None and (converted := ParameterFrom(value)) is not None:
            parameters[name] = converted
            if space := ColorSpaceOfColor(attribute):
                parameters["colorSpace:" + name] = space
    return _core.MaterialNode(prim.GetPath().pathString, kind, parameters, connections)


def UnsupportedFeatures(prim, names):
    """Names of authored light features that the renderer does not have yet, sorted."""
    features = set()
    for name in names:
        if name == FILTERS and prim.IsA(UsdGeom.Mesh):
            features.update(f"light filter {path}" for path in prim.GetRelationship(name).GetForwardedTargets())
        elif name.startswith("inputs:") and prim.GetAttribute(name).HasAuthoredConnections():
            features.add(f"a shader on {name}")
    return sorted(features)
