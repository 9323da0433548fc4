# SPDX-License-Identifier: Apache-2.0
"""UsdRenderSettings prims: what the command line does not say comes from them.

The first raster product's own opinions have precedence over the settings prim's, as in
UsdRenderComputeSpec. Attributes "hdstream:NAME" set the core's setting of that name.
"""

from pxr import Sdf, UsdRender

from hdstream import _core
from hdstream.errors import UsageError

NAMESPACE = "hdstream:"
# Names of usual sources of render vars for our AOVs; an AOV's own name always works.
_AOV_ALIASES = {
    "Ci": "color", "rgba": "color", "RGBA": "color", "beauty": "color", "a": "alpha", "z": "depth",
    "N": "normal", "Nn": "normal", "P": "position", "id": "primId",
}


class RenderSettings:
    """Values of a render settings prim; None or empty where it says nothing."""

    def __init__(self):
        self.path = ""
        self.camera = None
        self.resolution = None
        self.pixelAspectRatio = None
        self.conformPolicy = "expandAperture"
        self.purposes = None
        self.disableDepthOfField = False
        self.aovs = []
        self.values = {}  # core setting -> value, of the "hdstream:" namespace


def ReadRenderSettings(stage, path, session):
    """The settings at `path`, or at the stage's renderSettingsPrimPath, or none."""
    settings = RenderSettings()
    wanted = path or stage.GetMetadata("renderSettingsPrimPath")
    if not wanted:
        return settings
    prim = stage.GetPrimAtPath(wanted) if Sdf.Path.IsValidPathString(wanted) else None
    if not prim or not prim.IsA(UsdRender.Settings):
        if path:
            raise UsageError(f"--renderSettingsPrimPath {path}: the stage has no such render settings")
        session.Warn(wanted, "renderSettingsPrimPath of the stage names no render settings; ignored")
        return settings
    settings.path = wanted
    products = [stage.GetPrimAtPath(target) for target in
                UsdRender.Settings(prim).GetProductsRel().GetForwardedTargets()]
    products = [product for product in products if product and product.IsA(UsdRender.Product)]
    _ReadCommon(prim, settings)
    if products:
        _ReadCommon(products[0], settings)
        _ReadVars(stage, products[0], settings, session)
        for product in products[1:]:
            session.Warn(product.GetPath().pathString, "only the first product of render settings is rendered")
    if prim.GetAttribute("includedPurposes").HasAuthoredValue():
        settings.purposes = list(prim.GetAttribute("includedPurposes").Get())
    _ReadNamespace(prim, settings, session)
    return settings


def _ReadCommon(prim, settings):
    """UsdRenderSettingsBase: only authored values, so that a product overrides its settings."""
    def Authored(name):
        attribute = prim.GetAttribute(name)
        return attribute.Get() if attribute and attribute.HasAuthoredValue() else None

    targets = prim.GetRelationship("camera").GetForwardedTargets()
    if targets:
        settings.camera = targets[0]
    settings.resolution = Authored("resolution") or settings.resolution
    settings.pixelAspectRatio = Authored("pixelAspectRatio") or settings.pixelAspectRatio
    settings.conformPolicy = Authored("aspectRatioConformPolicy") or settings.conformPolicy
    isDisabled = Authored("disableDepthOfField")
    if isDisabled is not None:
        settings.disableDepthOfField = isDisabled


def _ReadVars(stage, product, settings, session):
    known = {info.name for info in _core.AovTable()}
    for target in UsdRender.Product(product).GetOrderedVarsRel().GetForwardedTargets():
        var = stage.GetPrimAtPath(target)
        source = var.GetAttribute("sourceName").Get() if var and var.IsA(UsdRender.Var) else None
        name = source if source in known else _AOV_ALIASES.get(source)
        if name is None:
            session.Warn(target.pathString, f"render var {source!r} is not one of the AOVs; left out")
        elif name not in settings.aovs:
            settings.aovs.append(name)


def _ReadNamespace(prim, settings, session):
    defaults = _core.Settings()
    for name in prim.GetAuthoredPropertyNames():
        if not name.startswith(NAMESPACE):
            continue
        setting = name[len(NAMESPACE):]
        value = prim.GetAttribute(name).Get()
        default = getattr(defaults, setting, None)
        if default is None or value is None:
            session.Warn(prim.GetPath().pathString, f"{name} is no setting of the renderer; ignored")
            continue
        try:
            settings.values[setting] = list(value) if isinstance(default, list) else type(default)(value)
        except (TypeError, ValueError):
            session.Warn(prim.GetPath().pathString, f"{name}: {value!r} is not a {type(default).__name__}; ignored")


def ConformCamera(camera, policy, width, height, pixelAspectRatio):
    """Applies UsdRender's aspectRatioConformPolicy; returns the pixel aspect ratio to render with.

    The core expands the aperture that is too small, which is the fallback policy; the others
    change the aperture or the pixels so that nothing is left for it to do.
    """
    aspect = camera.horizontalAperture / camera.verticalAperture
    if policy == "adjustPixelAspectRatio":
        return aspect * height / width
    imageAspect = pixelAspectRatio * width / height
    if policy == "cropAperture":
        policy = "adjustApertureWidth" if imageAspect < aspect else "adjustApertureHeight"
    if policy == "adjustApertureWidth":
        camera.horizontalAperture = camera.verticalAperture * imageAspect
    elif policy == "adjustApertureHeight":
        camera.verticalAperture = camera.horizontalAperture / imageAspect
    return pixelAspectRatio
