# SPDX-License-Identifier: Apache-2.0
"""UsdLux lights as light descriptions: authored inputs, UsdLux's fallbacks, nothing folded in."""

from pxr import Gf, Sdf, UsdGeom

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
UNSUPPORTED_LIGHT_TYPES = ("PortalLight", "GeometryLight", "PluginLight")
_DISTANT_INTENSITY = 50000.0  # UsdLuxDistantLight's fallback; that of all others is 1

_FLOATS = ("intensity", "exposure", "diffuse", "specular", "colorTemperature", "angle", "radius",
           "width", "height", "length")
_BOOLS = ("normalize", "enableColorTemperature")
# Inputs of features that are not there yet, and the values at which they do nothing.
_UNSUPPORTED_INPUTS = {
    "inputs:shaping:focus": ("shaping", (0.0,)),
    "inputs:shaping:ies:file": ("shaping", (None, Sdf.AssetPath())),
    "inputs:shadow:enable": ("shadow", (True,)),
    "inputs:shadow:color": ("shadow", (Gf.Vec3f(0),)),
    "inputs:shadow:distance": ("shadow", (-1.0,)),
}
_Z_FROM_Y = Gf.Matrix4d(1.0).SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))


def ReadLight(prim, typeName, names, timeCode, assets):
    """The description of a light of one of LIGHT_TYPES."""
    light = _core.LightDescription()
    light.type = _TYPES[typeName]
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
    return light


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


def UnsupportedFeatures(prim, names, timeCode):
    """Names of authored light features that the renderer does not have yet, sorted."""
    features = set()
    for name in names:
        if name in _UNSUPPORTED_INPUTS:
            feature, idle = _UNSUPPORTED_INPUTS[name]
            if prim.GetAttribute(name).Get(timeCode) not in idle:
                features.add(feature)
        elif name == "inputs:shaping:cone:angle":
            # A cone of 90 degrees is all of a flat light, and one of 180 of any other.
            idleAngle = 90.0 if prim.GetTypeName() in ("RectLight", "DiskLight") else 180.0
            if prim.GetAttribute(name).Get(timeCode) < idleAngle:
                features.add("shaping")
        elif name in ("light:filters", "portals") and prim.GetRelationship(name).GetTargets():
            features.add("light filters" if name == "light:filters" else "portals")
        elif name.startswith(("collection:lightLink:", "collection:shadowLink:")):
            if _IsLinkRestricting(prim, name, timeCode):
                features.add("light linking")
    return sorted(features)


def _IsLinkRestricting(prim, name, timeCode):
    if name.endswith(":includeRoot"):
        return prim.GetAttribute(name).Get(timeCode) is False
    if name.endswith((":includes", ":excludes")):
        return bool(prim.GetRelationship(name).GetTargets())
    return False
