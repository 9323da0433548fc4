# SPDX-License-Identifier: Apache-2.0
"""UsdRenderSettings prims: what the command line does not say comes from them.

The first raster product's own opinions have precedence over the settings prim's, as in
UsdRenderComputeSpec. Attributes "hdstream:NAME" set the core's setting of that name.
"""

import math

import numpy as np
from pxr import Sdf, UsdRender, Vt

from hdstream import _core
from hdstream.diagnostics import MessagesOf, TfError
from hdstream.errors import OneLine, UsageError
from hdstream.options import PURPOSES
from hdstream.translate.materials import BINDING_PURPOSE
from hdstream.typedValues import TypedValue

NAMESPACE = "hdstream:"
# Settings that judge what an attribute of UsdRenderSettingsBase says; of `resolution` the options may say something else.
_SETTING_BY_ATTRIBUTE = {"pixelAspectRatio": "pixelAspectRatio", "aspectRatioConformPolicy": "conformPolicy"}


class RenderSettings:
    """Values of a render settings prim; None or empty where it says nothing."""

    def __init__(self):
        self.path = ""
        self.camera = None
        self.resolution = None
        self.resolutionProblem = ""  # of the prim that it would be of
        self.pixelAspectRatio = None
        self.conformPolicy = None
        self.dataWindowNDC = None  # (left, bottom, right, top) of the resolution, y up
        self.dataWindowPath = ""   # of the prim that says it
        self.purposes = None
        self.disableDepthOfField = False
        self.disableMotionBlur = False
        self.aovs = []
        self.values = {}  # core setting -> value, of the "hdstream:" namespace


def FindRenderSettings(stage, path, session):
    """The prim at `path`, or at the stage's renderSettingsPrimPath; None: there is none."""
    wanted = path or stage.GetMetadata("renderSettingsPrimPath")
    if not wanted:
        return None
    prim = stage.GetPrimAtPath(wanted) if Sdf.Path.IsValidPathString(wanted) else None
    if prim and prim.IsA(UsdRender.Settings):
        return prim
    if path:
        raise UsageError(f"--renderSettingsPrimPath {path}: the stage has no such render settings")
    session.Warn(wanted, "renderSettingsPrimPath of the stage names no render settings; ignored")
    return None


def ReadRenderSettings(stage, path, session, productPath=None):
    """The settings at `path`, or at the stage's renderSettingsPrimPath, or none; with the values of one of its products, by
    default of the first."""
    settings = RenderSettings()
    prim = FindRenderSettings(stage, path, session)
    if prim is None:
        return settings
    settings.path = prim.GetPath().pathString
    products = [stage.GetPrimAtPath(target) for target in TargetsOf(prim, "products", session)]
    products = [product for product in products if product and product.IsA(UsdRender.Product)]
    _ReadCommon(prim, settings, session)
    if productPath:
        _ReadCommon(stage.GetPrimAtPath(productPath), settings, session)
    elif products:
        _ReadCommon(products[0], settings, session)
        _ReadVars(stage, products[0], settings, session)
        for product in products[1:]:
            session.Warn(product.GetPath().pathString, "not rendered: without OUT all products of the render settings are")
    _ReadPurposes(prim, settings, session)
    _WarnOfBindingPurposes(prim, session)
    _ReadColorSpace(prim, settings, session)
    _ReadNamespace(prim, settings, session)
    return settings


def FindRenderPass(stage, path, session):
    """The render pass at `path`; None without a path. Raises UsageError where the stage has none there."""
    if not path:
        return None
    prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
    if not prim or not prim.IsA(UsdRender.Pass):
        raise UsageError(f"--renderPassPrimPath {path}: the stage has no such render pass")
    if prim.GetAttribute("fileName").HasAuthoredValue():
        session.Warn(path, "fileName is not read: what the pass names is looked for in the stage itself")
    return prim


def SettingsPathOf(stage, settingsPath, passPath, session):
    """The path of the render settings that hold: those that are asked for, else the pass's renderSource; None: the stage's."""
    passPrim = FindRenderPass(stage, passPath, session)
    sources = TargetsOf(passPrim, "renderSource", session) if passPrim and not settingsPath else []
    if not sources:
        return settingsPath
    source = stage.GetPrimAtPath(sources[0])
    if source and source.IsA(UsdRender.Settings):
        return sources[0].pathString
    session.Warn(passPath, f"renderSource {sources[0]} is no render settings; ignored")
    return settingsPath


def TargetsOf(prim, name, session):
    """What a relationship names; nothing, and one warning, where it is none."""
    try:
        return prim.GetRelationship(name).GetForwardedTargets()
    except TfError as error:
        session.Warn(prim.GetPath().pathString, f"{name} cannot be read: {'; '.join(MessagesOf(error))}")
        return []


def _ReadCommon(prim, settings, session):
    """UsdRenderSettingsBase: only authored values, so that a product overrides its settings."""
    def Authored(name):
        try:
            value = TypedValue(prim.GetAttribute(name))
        except TypeError as error:
            raise UsageError(f"{prim.GetPath()}: {name}: {error}") from None
        if value is not None:
            _Check(prim, name, value)
        return value

    targets = TargetsOf(prim, "camera", session)
    if targets:
        settings.camera = targets[0]
    try:
        resolution = TypedValue(prim.GetAttribute("resolution"))
        if resolution:
            settings.resolution, settings.resolutionProblem = resolution, ""
    except TypeError as error:  # counts where no option says the size
        settings.resolutionProblem = f"{prim.GetPath()}: resolution: {error}"
    settings.pixelAspectRatio = Authored("pixelAspectRatio") or settings.pixelAspectRatio
    settings.conformPolicy = Authored("aspectRatioConformPolicy") or settings.conformPolicy
    dataWindow = Authored("dataWindowNDC")
    if dataWindow:
        settings.dataWindowNDC, settings.dataWindowPath = dataWindow, prim.GetPath().pathString
    isDisabled = Authored("disableDepthOfField")
    if isDisabled is not None:
        settings.disableDepthOfField = isDisabled
    for name in ("instantaneousShutter", "disableMotionBlur"):  # the older name first
        isDisabled = Authored(name)
        if isDisabled is not None:
            settings.disableMotionBlur = isDisabled


def _Check(prim, name, value):
    """Raises UsageError for a value of an attribute of UsdRenderSettingsBase that no picture can be made with."""
    problem = ""
    if name == "dataWindowNDC" and not all(map(math.isfinite, value)):
        problem = "must be finite numbers"
    elif setting := _SETTING_BY_ATTRIBUTE.get(name):
        try:
            _core.SetSetting(_core.Settings(), setting, value)
        except _core.UsageError as error:
            problem = OneLine(error)
    if problem:
        raise UsageError(f"{prim.GetPath()}: {name}: {problem}")


def _ReadVars(stage, product, settings, session):
    for target in TargetsOf(product, "orderedVars", session):
        name = AovOfVar(stage.GetPrimAtPath(target), target, session)
        if name is not None and name not in settings.aovs:
            settings.aovs.append(name)


def AovOfVar(var, path, session):
    """The AOV that a render var (an invalid prim: none) shows; None, and a warning, for what is none of ours."""
    isVar = var and var.IsA(UsdRender.Var)
    try:
        source = TypedValue(var.GetAttribute("sourceName")) if isVar else None
    except TypeError as error:
        session.Warn(str(path), f"sourceName {error}; left out")
        return None
    if not source:
        session.Warn(str(path), f"{'render var has no sourceName' if isVar else 'is no render var'}; left out")
        return None
    kind = var.GetAttribute("sourceType").Get()
    if kind == "primvar":
        source = "primvars:" + (source[len("primvars:"):] if source.startswith("primvars:") else source)
    if kind == "lpe":
        return _LightPathOf(source, path)
    name = _core.AovOfSource(source) or None
    if kind not in ("raw", "intrinsic", "primvar"):
        session.Warn(str(path), f"render var of the type {kind!r}, which is not supported; left out")
        return None
    if name is None:
        session.Warn(str(path), f"render var {source!r} is not one of the AOVs; left out")
    return name


def _LightPathOf(source, path):
    """The AOV of a light path expression. Raises UsageError for one that cannot be read."""
    name = source if source.startswith("lpe:") else "lpe:" + source
    try:
        _core.CheckAovs([name])
    except _core.UsageError as error:
        raise UsageError(f"{path}: {OneLine(error)}") from None
    return name


def _ReadPurposes(prim, settings, session):
    attribute = prim.GetAttribute("includedPurposes")
    if not attribute.HasAuthoredValue():
        return
    purposes = attribute.Get()
    if not isinstance(purposes, (Vt.TokenArray, Vt.StringArray)):
        session.Warn(settings.path, f"includedPurposes {purposes!r} is no list of names; ignored")
        return
    settings.purposes = [purpose for purpose in purposes if purpose in PURPOSES]
    for purpose in purposes:
        if purpose not in PURPOSES:
            session.Warn(settings.path, f"includedPurposes: {purpose!r} is none of {', '.join(PURPOSES)}; ignored")


def _WarnOfBindingPurposes(prim, session):
    """materialBindingPurposes: bindings are always those of its fallback."""
    attribute = prim.GetAttribute("materialBindingPurposes")
    if not attribute.HasAuthoredValue():
        return
    purposes = attribute.Get()
    isList = isinstance(purposes, (Vt.TokenArray, Vt.StringArray))
    if not isList or list(purposes) != [BINDING_PURPOSE, ""]:
        said = list(purposes) if isList else purposes
        session.Warn(prim.GetPath().pathString, f"materialBindingPurposes {said!r} is not read: bindings of the purpose "
                     f"{BINDING_PURPOSE} count, and those of all purposes")


def _ReadColorSpace(prim, settings, session):
    """renderingColorSpace: the working space of all shading; hdstream:workingSpace precedes it."""
    try:
        space = TypedValue(prim.GetAttribute("renderingColorSpace"))
    except TypeError as error:
        session.Warn(prim.GetPath().pathString, f"renderingColorSpace {error}; ignored")
        return
    if not space:
        return
    if _core.IsWorkingSpace(space):
        settings.values["workingSpace"] = space
    else:
        session.Warn(prim.GetPath().pathString, f"renderingColorSpace {space!r} is no colour space that is known; ignored")


def _ReadNamespace(prim, settings, session):
    userSettings = {info.name for info in _core.SettingTable() if info.isUserSetting}
    for name in prim.GetAuthoredPropertyNames():
        if not name.startswith(NAMESPACE):
            continue
        setting = name[len(NAMESPACE):]
        attribute = prim.GetAttribute(name)
        value = attribute.Get() if attribute else None
        if setting not in userSettings or value is None:
            session.Warn(prim.GetPath().pathString, f"{name} is no setting of the renderer; ignored")
            continue
        if attribute.GetTypeName() == Sdf.ValueTypeNames.Float:
            value = float(str(np.float32(value)))  # as it was written: 0.1, not 0.100000001490116
        try:
            _core.SetSetting(_core.Settings(), setting, value)
            settings.values[setting] = value
        except (TypeError, _core.UsageError) as error:
            session.Warn(prim.GetPath().pathString, f"{name}: {value!r} is of no use ({OneLine(error)}); ignored")


def DataWindow(windowNDC, width, height):
    """The pixels (left, top, right, bottom) of a UsdRender dataWindowNDC, y down.

    UsdRenderSettingsBase: a pixel is in the data window when its centre is in the NDC rectangle.
    """
    def First(coordinate, size):
        return math.ceil(coordinate * size - 0.5)

    left, bottom, right, top = windowNDC
    return First(left, width), First(1.0 - top, height), First(right, width), First(1.0 - bottom, height)
