# SPDX-License-Identifier: Apache-2.0
"""UsdLux lights as light descriptions: authored inputs, UsdLux's fallbacks, nothing folded in."""

from pxr import Gf, UsdGeom

from hdstream import _core

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
_SYNC_MODES = {
    "materialGlowTintsLight": _core.MaterialSyncMode.GlowTintsLight,
    "independent": _core.MaterialSyncMode.Independent,
}
UNSUPPORTED_LIGHT_TYPES = ("GeometryLight", "PluginLight")
_DISTANT_INTENSITY = 50000.0  # UsdLuxDistantLight's fallback; that of all others is 1

_FLOATS = ("intensity", "exposure", "diffuse", "specular", "colorTemperature", "angle", "radius",
           "width", "height", "length")
_BOOLS = ("normalize", "enableColorTemperature")
_SHAPING = {
    "inputs:shaping:focus": ("focus", float),
    "inputs:shaping:focusTint": ("focusTint", list),
    "inputs:shaping:cone:angle": ("coneAngle", float),
    "inputs:shaping:cone:softness": ("coneSoftness", float),
    "inputs:shaping:ies:angleScale": ("iesAngleScale", float),
    "inputs:shaping:ies:normalize": ("iesNormalize", bool),
}
_IES_FILE = "inputs:shaping:ies:file"
_SHADOW = {
    "inputs:shadow:enable": ("enable", bool),
    "inputs:shadow:color": ("color", list),
    "inputs:shadow:distance": ("distance", float),
    "inputs:shadow:falloff": ("falloff", float),
    "inputs:shadow:falloffGamma": ("falloffGamma", float),
}
_Z_FROM_Y = Gf.Matrix4d(1.0).SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))


def IsLight(prim):
    """Whether a mesh is a light: UsdLuxMeshLightAPI, or LightAPI, is applied."""
    return "LightAPI" in prim.GetAppliedSchemas()


def ReadSyncMode(prim):
    """How a mesh light and its material go together."""
    attribute = prim.GetAttribute("light:materialSyncMode")
    return _SYNC_MODES.get(attribute.Get() if attribute else "", _core.MaterialSyncMode.NoMaterialResponse)


def ReadLight(prim, typeName, names, timeCode, assets):
    """The description of a light of one of LIGHT_TYPES, or of a mesh."""
    light = _core.LightDescription()
    light.type = _TYPES.get(typeName, _core.LightType.Mesh)
    if typeName == "DistantLight":
        light.intensity = _DISTANT_INTENSITY
    for name in names:
        base = name[len("inputs:"):] if name.startswith("inputs:") else name
        if base in _FLOATS:
            setattr(light, base, float(prim.GetAttribute(name).Get(timeCode)))
        elif base in _BOOLS or name in ("treatAsPoint", "treatAsLine"):
            setattr(light, base, bool(prim.GetAttribute(name).Get(timeCode)))
        elif base == "color":
            light.color = list(prim.GetAttribute(name).Get(timeCode))
        elif base == "texture:format":
            light.textureFormat = prim.GetAttribute(name).Get(timeCode)
        elif base == "texture:file":
            attribute = prim.GetAttribute(name)
            value = attribute.Get(timeCode)
            if value and value.path:
                light.textureFile = assets.Resolve(attribute, value)
    _ReadShaping(prim, names, timeCode, assets, light)
    if any(name in _SHADOW for name in names):
        light.shadow = _ReadInputs(prim, _SHADOW, _core.LightShadow(), timeCode)
    return light


def _ReadInputs(prim, inputs, target, timeCode):
    """Sets members of `target` to the inputs that have a value, a schema's fallback included."""
    for name, (member, convert) in inputs.items():
        attribute = prim.GetAttribute(name)
        value = attribute.Get(timeCode) if attribute else None
        if value is not None:
            setattr(target, member, convert(value))
    return target


def _ReadShaping(prim, names, timeCode, assets, light):
    # Where the schema is applied its fallbacks count: a cone of 90 degrees.
    isAuthored = any(name.startswith("inputs:shaping:") for name in names)
    if not isAuthored and "ShapingAPI" not in prim.GetAppliedSchemas():
        return
    shaping = _ReadInputs(prim, _SHAPING, _core.LightShaping(), timeCode)
    attribute = prim.GetAttribute(_IES_FILE)
    value = attribute.Get(timeCode) if attribute else None
    if value and value.path:
        shaping.iesFile = assets.Resolve(attribute, value)
    light.shaping = shaping


def PoleTransform(prim, typeName):
    """The rotation that aligns a dome's pole (+Y of its own space) with its pole axis.

    UsdLux: DomeLight's pole is +Y whatever the stage's up axis; DomeLight_1 has `poleAxis`, whose
    fallback "scene" is the stage's up axis. Applied before the dome's transform.
    """
    if typeName != "DomeLight_1":
        return None
    axis = prim.GetAttribute("poleAxis").Get()
    if axis == "scene":
        axis = UsdGeom.GetStageUpAxis(prim.GetStage())
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


def UnsupportedFeatures(prim, names):
    """Names of authored light features that the renderer does not have yet, sorted."""
    features = set()
    for name in names:
        if name == "light:filters":
            features.update(f"light filter {path}" for path in prim.GetRelationship(name).GetForwardedTargets())
        elif name.startswith("inputs:") and prim.GetAttribute(name).HasAuthoredConnections():
            features.add(f"a shader on {name}")
    return sorted(features)
