# SPDX-License-Identifier: Apache-2.0
"""Edits of a stage on their way into a session: only what changed is translated again where that is safe.

Safe are values of prims of the types below in stages without instancers, and of cameras and lights in
all stages: what else depends on such a prim lies below it. Everything else (new or removed prims,
bindings, collections, other types) translates the stage anew; the core keeps what has equal content
in its persistent cache. tests: an edited session dumps the text of a fresh one.
"""

import weakref

from pxr import Sdf, Tf, Usd, UsdGeom, UsdShade

from hdstream.translate import rereading
from hdstream.translate.drawModes import DrawModes
from hdstream.translate.lights import LIGHT_TYPES
from hdstream.translate.meshes import IMPLICIT_TYPES
from hdstream.translate.primState import PREDICATE
from hdstream.translate.stageTranslator import StageTranslator

_ALONE = {"Camera", *LIGHT_TYPES}
_GROUPS = {"Xform", "Scope"}
_BELOW = {"", "GeomSubset", "Material", "Shader", "NodeGraph"}  # met below a prim that changed
_GEOMETRY = {"Mesh", *IMPLICIT_TYPES}
_WHOLE = ("material:binding", "collection:", "model:", "skel:", "light:", "colorSpace:")  # others depend on these
_RENDER = ("RenderSettings", "RenderProduct", "RenderVar")  # read at every render


class StageTranslation:
    """Keeps a session equal to a stage at a time code. One thread at a time, the stage's."""

    def __init__(self, stage, session, onBegin):
        """onBegin() is called when the session was cleared."""
        self._session = session  # it goes before the layers whose arrays it has, as in PreparedStage
        self._onBegin = onBegin  # has the session, too
        self._stage = stage
        self._timeCode = None
        self._shutter = (0.0, 0.0)
        self._pass = ""  # path of the render pass; empty: none
        self._isStale = True
        self._changes = {}  # prim path -> names of its properties that changed
        self._materialPaths = set()
        self._borrowed = {}  # path of a material -> paths of prims outside of it that it was read from
        self._mappedLayers = rereading.MappedLayers()
        self._hasInstancers = False
        self._hasPlacedLights = False  # a light may be a prototype, too, which has copies
        self._hasLinks = False  # what a prim's links are, lights elsewhere say
        # Tf keeps what it calls, which would keep the stage and its layers for ever.
        onChanged = weakref.WeakMethod(self._OnChanged)
        self._listener = Tf.Notice.Register(
            Usd.Notice.ObjectsChanged, lambda notice, _: onChanged() and onChanged()(notice), stage)
        onDirtiness = weakref.WeakMethod(self._OnDirtiness)
        self._saveListener = Tf.Notice.RegisterGlobally(
            Sdf.Notice.LayerDirtinessChanged, lambda _, layer: onDirtiness() and onDirtiness()(layer))

    def Update(self, timeCode, shutter=(0.0, 0.0), passPath=""):
        """Brings the session up to date; returns how many prims were visited. `passPath`: of a UsdRenderPass."""
        timeCode = Usd.TimeCode(timeCode)
        changes, self._changes = self._changes, {}
        isWhole = self._isStale or (timeCode, shutter, passPath) != (self._timeCode, self._shutter, self._pass)
        self._timeCode, self._shutter, self._pass = timeCode, shutter, passPath
        if isWhole or not self._AreSafe(changes):
            return self._TranslateAll()
        return sum(self._TranslateBelow(path, names) for path, names in changes.items())

    def Release(self):
        """Keeps nothing of the stage. Nothing can be brought up to date after it. Returns layers to be kept: OpenUSD makes copies of
        mapped arrays when it closes their file, and of these the core keeps arrays as they are mapped."""
        self._listener.Revoke()
        self._saveListener.Revoke()
        self._stage = self._listener = self._saveListener = None
        return self._mappedLayers.Held()

    def _OnChanged(self, notice):
        for path in notice.GetResyncedPaths():
            if path.IsPropertyPath():
                self._Add(path)
            else:
                self._isStale = True
        for path in notice.GetChangedInfoOnlyPaths():
            self._Add(path)

    def _OnDirtiness(self, layer):
        """A layer that was saved: OpenUSD writes into crate files, of which arrays are read again, so all are read anew."""
        if layer and not layer.dirty and self._stage and layer in self._stage.GetUsedLayers():
            self._isStale = True

    def _Add(self, path):
        # Metadata of a prim may be anything; that of the stage's root is its units and times.
        if path.IsPrimPropertyPath():
            self._changes.setdefault(path.GetPrimPath(), set()).add(path.name)
        else:
            self._isStale = True

    def _NewTranslator(self):
        passPrim = self._stage.GetPrimAtPath(self._pass) if self._pass else None
        return StageTranslator(self._stage, self._session, self._timeCode, self._shutter, passPrim)

    def _TranslateAll(self):
        self._session.Clear()
        self._onBegin()
        translator = self._NewTranslator()
        translator.Translate()
        self._materialPaths = translator.materialPaths
        self._borrowed = translator.borrowed
        self._mappedLayers = translator.mappedLayers
        scene = self._session.Scene()
        self._hasInstancers, self._hasPlacedLights = scene.hasInstancers, scene.hasPlacedLights
        self._hasLinks = translator.LinksAreUsed()
        self._isStale = False
        return translator.numPrims

    # --- Parts -----------------------------------------------------------------------------------

    def _AreSafe(self, changes):
        return all(self._IsSafe(self._stage.GetPrimAtPath(path), names) for path, names in changes.items())

    def _IsSafe(self, prim, names):
        if not prim or prim.IsInPrototype() or prim.IsInstanceProxy():
            return False
        if any(name.startswith(_WHOLE) for name in names):
            return False
        kind = prim.GetTypeName()
        if kind in _RENDER or _MaterialOf(prim):
            return True
        # What is not drawn, or replaced by its bounds, others may depend on.
        if not PREDICATE(prim) or _HasDrawMode(prim):
            return False
        # Below a point instancer are prototypes, which have a space of their own; skins follow their skeletons.
        if any(ancestor.IsA(UsdGeom.PointInstancer) or ancestor.GetTypeName() == "SkelRoot"
               for ancestor in _Ancestors(prim)):
            return False
        if (self._hasLinks and kind != "Camera") or (self._hasPlacedLights and kind in LIGHT_TYPES):
            return False
        if kind not in _ALONE | _GROUPS | _GEOMETRY or (self._hasInstancers and kind not in _ALONE):
            return False
        known = _ALONE | _GROUPS | _GEOMETRY | _BELOW
        return all(below.GetTypeName() in known and not below.HasAuthoredReferences()
                   for below in Usd.PrimRange(prim, PREDICATE) if below != prim)

    def _TranslateBelow(self, path, names):
        prim = self._stage.GetPrimAtPath(path)
        if prim.GetTypeName() in _RENDER:
            return 0
        material = _MaterialOf(prim)
        if material:
            return self._TranslateMaterials(material.GetPath().pathString)
        translator = self._NewTranslator()
        kept = {}
        scene = self._session.Scene()
        isBelow = scene.PathsBelow(path.pathString)
        if all(_IsPlacing(name) for name in names):
            prims = {found: scene.FindGeometry(found) for found in isBelow}
            kept = {found: geometryPrim for found, geometryPrim in prims.items() if geometryPrim}
        for found in isBelow:
            self._session.Remove(found)
        translator.TranslateBelow(prim, _Ancestors(prim), kept)
        self._materialPaths.update(translator.materialPaths)
        self._borrowed.update(translator.borrowed)
        return translator.numPrims

    def _TranslateMaterials(self, edited):
        """A material, and those that have nodes of it, as far as they are bound to what is drawn."""
        paths = [path for path in self._materialPaths if f"{edited}/".startswith(f"{path}/") or any(
            f"{origin}/".startswith(f"{edited}/") for origin in self._borrowed.get(path, ()))]
        for path in paths:
            self._borrowed.pop(path, None)
            translator = self._NewTranslator()
            translator.TranslateMaterial(self._stage.GetPrimAtPath(path))
            self._borrowed.update(translator.borrowed)
        return len(paths)


def _IsPlacing(name):
    """Properties that leave the arrays of meshes at and below a prim as they are."""
    return name.startswith("xformOp") or name in ("visibility", "purpose")


def _Ancestors(prim):
    """From the one below the root to the prim's parent."""
    found = []
    parent = prim.GetParent()
    while parent and not parent.IsPseudoRoot():
        found.append(parent)
        parent = parent.GetParent()
    return found[::-1]


def _HasDrawMode(prim):
    """Whether a draw mode is said at a prim or above it."""
    mode = ""
    for one in (*_Ancestors(prim), prim):
        mode = mode or DrawModes.ModeOf(one, "")
    return bool(mode)


def _MaterialOf(prim):
    """The material a prim is (a part of), if any."""
    return next((part for part in (prim, *reversed(_Ancestors(prim))) if part.IsA(UsdShade.Material)), None)
