# SPDX-License-Identifier: Apache-2.0
"""The traversal of a stage: every prim is visited once, inherited values live on its stack.

Native instances are collected while a context (the world, or the prototypes of an instancer) is
walked and turned into instancers after it. Materials are found for all geometry at once at the end.
"""

import gc

import numpy as np
from pxr import Tf, Usd, UsdGeom

from hdstream import _core
from hdstream.diagnostics import MessagesOf
from hdstream.translate import colorSpaces, drawModes, pathTexts, primvars, rereading, valueClips
from hdstream.translate.assets import AssetResolver
from hdstream.translate.instancers import Instancers
from hdstream.translate.links import Links
from hdstream.translate.materials import MaterialReader
from hdstream.translate.geometryBatch import GeometryBatch
from hdstream.translate.motion import Motion, ReadBlurScale
from hdstream.translate.passCollections import PassCollections
from hdstream.translate.primHandlers import PrimHandlers
from hdstream.translate.primState import BINDING, PREDICATE, SKEL_BINDINGS, Context, HasBindings, State
from hdstream.translate.reports import Reports
from hdstream.translate.skinning import Skins
from hdstream.translate.usdCalls import GetAttribute, GetFilteredChildren, GetValue
from hdstream.typedValues import MistypedValues

_BLUR_SCALE = "motion:blurScale"
_PURPOSES = frozenset(UsdGeom.Imageable.GetOrderedPurposeTokens())


class StageTranslator:
    """Translates one stage at one time code, and while a shutter is open around it, into a session. Used once."""

    def __init__(self, stage, session, timeCode, shutter=(0.0, 0.0), passPrim=None):
        self._stage = stage
        self._pass = PassCollections(passPrim) if passPrim else None
        self._session = session
        self._timeCode = Usd.TimeCode(timeCode)
        colorSpaces.Forget()
        pathTexts.Forget()
        self._motion = Motion(timeCode, shutter)
        self._reports = Reports(session)
        self._assets = AssetResolver()
        self._xforms = UsdGeom.XformCache(self._timeCode)
        self._skins = Skins(self._timeCode, self._xforms, self._motion, self._reports.Warn)
        self._numPaths = 0
        self._placedPaths = set()  # of what instancers place: all other prims have the paths that USD gives them
        self._links = Links()
        self._batch = GeometryBatch(session, self._links, self._reports.Warn)
        self._drawModes = drawModes.DrawModes(self, session, self._batch, self._links, self._timeCode, self._assets,
                                             self._reports)
        self._instancers = Instancers(self, stage, session, self._timeCode, self._motion, self._links, self._pass,
                                      self._reports)
        self._kept = {}  # scene path -> GeometryPrim of before, whose geometry is as it was
        self.materialPaths = set()  # of the materials that were translated
        self.borrowed = {}  # as of MaterialReader
        self.mappedLayers = rereading.MappedLayers()
        self.numPrims = 0  # prims visited, instance proxies of first instances included
        self._handlers = PrimHandlers(self, self._instancers, session, self._timeCode, self._motion, self._assets, self._links,
                                      self._batch, self._skins, self._reports)

    def Translate(self):
        """Fills the session."""
        # Nothing here makes cycles; without this, scanning 10^5 new objects again and again shows.
        isCollecting = gc.isenabled()
        gc.disable()
        try:
            self._Translate(self._stage.GetPseudoRoot().GetFilteredChildren(PREDICATE), State())
        finally:
            if isCollecting:
                gc.enable()

    def TranslateBelow(self, prim, ancestors, keptPrims):
        """Translates a prim and all below it. `keptPrims`: scene path -> GeometryPrim whose arrays still hold."""
        if self._pass and self._pass.IsPrunedWithin(prim):
            return
        self._kept = keptPrims
        state = State()
        for ancestor in ancestors:
            info = self._handlers.InfoOf(ancestor)
            state = state.WithClips() if valueClips.AreOn(ancestor) else state
            names = valueClips.NamesOf(ancestor, state.hasClips)
            state = self._StateOf(ancestor, info, names, state)
            if info.isLeaf:
                state = self._BelowLeaf(ancestor, names, state, PREDICATE)
        self._Translate([prim], state)

    def TranslateMaterial(self, prim):
        """Reads a material of the scene again."""
        self._SetMaterials({prim.GetPath().pathString: prim})
        self._End()

    def LinksAreUsed(self):
        """Some light leaves something out."""
        return self._links.areUsed

    def _Translate(self, prims, state):
        with np.errstate(over="ignore", invalid="ignore"):  # of values of types that schemas do not have; the core names what is wrong
            self.Walk(prims, state, Context())
            self._SetMaterials({**self._handlers.volumeMaterials, **self._batch.Flush()})
        self._End()

    def _End(self):
        """Breaks the cycles of references, so that a stage and its layers go with their last user."""
        self._reports.Flush()
        pathTexts.Forget()
        self._handlers.End()
        self._handlers = self._instancers = self._drawModes = None

    def _SetMaterials(self, primByPath):
        reader = MaterialReader(self._timeCode, self._assets, self._reports.Warn)
        for path, prim in primByPath.items():
            self._session.SetMaterial(path, reader.Read(prim))
        self.materialPaths.update(primByPath)
        self.borrowed.update(reader.borrowed)

    # --- Traversal -------------------------------------------------------------------------------

    def Walk(self, prims, state, context):
        """Visits prims and all below, then makes instancers of the native instances found."""
        drawMode = self._drawModes.InheritedBy(prims[0]) if prims else ""
        if drawMode:
            state = state.Copy()
            state.drawMode = drawMode
        stack = [(prim, state) for prim in reversed(prims)]
        while stack:
            prim, inherited = stack.pop()
            try:
                state = self._Visit(prim, inherited, context)
            except (Tf.ErrorException, TypeError, ValueError, IndexError, OverflowError) as error:
                self._reports.Warn(prim, f"cannot be read: {'; '.join(self._CausesOf(error, prim))}")
                state = inherited
            if state is not None:
                children = GetFilteredChildren(prim, context.predicate)
                for child in reversed(children):
                    stack.append((child, state))
        for found in (context, *context.contextsByDrawMode.values()):
            for group in found.instanceGroups.values():
                self._instancers.AddGroup(group, context)
        for group in context.standInGroups.values():
            self._drawModes.AddGroup(group, context)

    def _CausesOf(self, error, prim):
        """Why a prim cannot be read. What bindings and numpy say comes from values of types that schemas do not have."""
        isIndex = isinstance(error, IndexError)
        if isIndex or isinstance(error, OverflowError) or "incompatible function arguments" in str(error):
            mistyped = MistypedValues(prim, self._timeCode)
            if mistyped:
                return mistyped
            if isIndex:
                raise error  # a mistake of ours
        return MessagesOf(error)

    def _Visit(self, prim, inherited, context):
        """Translates a prim; returns the state of its children, None when they are not visited."""
        if self._pass and self._pass.IsPruned(prim):
            return None
        self.numPrims += 1
        info = self._handlers.InfoOf(prim)
        if valueClips.AreOn(prim):
            self._WarnOfClips(prim)
            inherited = inherited.WithClips()
        names = valueClips.NamesOf(prim, inherited.hasClips)
        state = self._StateOf(prim, info, names, inherited) if names else inherited
        if info.isSkelRoot:
            state = state.Copy()
            state.skelRoot = prim
        if state.drawMode and self._drawModes.IsApplied(prim):
            self._drawModes.Add(prim, names, self._InPass(prim, state, context), context)
            return None
        if info.handler is None:
            if prim.IsInstance() and not self._skins.AreBelow(prim, inherited.skelRoot):
                self._instancers.AddInstance(prim, state, context.OfDrawMode(state.drawMode))
                return None
            return state
        own = self._InPass(prim, state, context)
        below = info.handler(prim, info.schema, names, own, context)
        below = state if below is own else below
        if info.isLeaf and below is not None:
            below = self._BelowLeaf(prim, names, below, context.predicate)
        return below

    def _BelowLeaf(self, prim, names, state, predicate):
        """What prims below a gprim inherit: of primvars, where there are prims that have some."""
        if HasBindings(names):
            state = state.Copy()
            state.AddBindings(prim, names)
        if any(not child.IsA(UsdGeom.Subset) for child in prim.GetFilteredChildren(predicate)):
            result = primvars.InheritFrom(prim, names, state.primvars, self._timeCode)
            if result is not state.primvars:
                state = state.Copy()
                state.primvars = result
        return state

    def _InPass(self, prim, state, context):
        """A prim's state with what the pass does to it, which those below do not inherit."""
        if self._pass is None:
            return state
        own = state.Copy()
        own.ofPass = self._pass.Of(prim, context)
        own.visible = state.visible and own.ofPass.isRendered
        return own

    def _WarnOfClips(self, prim):
        """Names the files of a prim's own value clips that are not there."""
        for text in valueClips.MissingClips(prim):
            self._reports.Warn(prim, text)

    @property
    def isKeeping(self):
        """Whether there is a geometry prim of before at all."""
        return bool(self._kept)

    def KeptPrim(self, path):
        """The geometry prim of before at a scene path, where it still holds, else None."""
        return self._kept.get(path)

    def _StateOf(self, prim, info, names, inherited):
        """The prim's own state: `inherited` itself when it changes nothing."""
        if self._motion.isOn and _BLUR_SCALE in names:
            inherited = inherited.Copy()
            inherited.motion = self._motion.Scaled(ReadBlurScale(prim, self._timeCode, self._reports.Warn))
            inherited.matrices = inherited.motion.MatricesAlong(inherited.way)
        state = inherited
        if info.isXformable and "xformOpOrder" in names:
            local, resets = self._xforms.GetLocalTransformation(prim)
            state = inherited.Copy()
            state.matrix = local if resets else local * inherited.matrix
            if self._motion.isOn:
                state.matrices = self.MotionOf(inherited).MatricesOf(prim, local, resets, inherited.matrix, inherited.matrices)
                state.way = inherited.way + (prim,)
        if info.isImageable:
            visibility = GetValue(GetAttribute(prim, "visibility"), self._timeCode) if "visibility" in names else None
            if visibility == "invisible":
                state = inherited.Copy() if state is inherited else state
                state.visible = False
            elif visibility not in (None, "inherited"):
                self._reports.Warn(prim, f"visibility {visibility} is unknown; inherited is used")
            if "purpose" in names and prim.GetAttribute("purpose").HasAuthoredValue():
                state = inherited.Copy() if state is inherited else state
                state.purpose = prim.GetAttribute("purpose").Get()
                if state.purpose not in _PURPOSES:
                    self._reports.Warn(prim, f"purpose {state.purpose} is unknown; not drawn")
                state.isPurposeAuthored = True
        if drawModes.ATTRIBUTE in names:
            drawMode = self._drawModes.ModeOf(prim, inherited.drawMode)
            if drawMode != inherited.drawMode:
                state = inherited.Copy() if state is inherited else state
                state.drawMode = drawMode
        if info.isLeaf:
            return state
        hasPrimvars = hasBindings = False
        for name in names:
            if name.startswith("primvars:"):
                hasPrimvars = True
            elif name.startswith(BINDING):
                hasBindings = True
        if hasPrimvars:
            result = primvars.InheritFrom(prim, names, inherited.primvars, self._timeCode)
            if result is not inherited.primvars:
                state = inherited.Copy() if state is inherited else state
                state.primvars = result
        if hasBindings:
            state = inherited.Copy() if state is inherited else state
            state.AddBindings(prim, names)
        for name in SKEL_BINDINGS.intersection(names):
            state = inherited.Copy() if state is inherited else state
            state.AddSkelBinding(prim, name)
        return state

    def MotionOf(self, state):
        """What a prim of that state moves by."""
        return state.motion or self._motion

    def ReservePath(self, prim, context):
        """The scene path of a prim, which no other prim will get."""
        path = context.ScenePath(prim)
        if context.instancerPath:
            if path in self._placedPaths:  # a prototype inside another prototype of the same instancer
                path = f"{path}{{{self._numPaths}}}"
            self._placedPaths.add(path)
        self._numPaths += 1
        return path

    def PlacementOf(self, state, context):
        """Where a prim of that state is; the context's instancer, if any, places it."""
        placement = _core.Placement(state.matrix, context.instancerPath, context.instances, state.visible)
        if state.matrices is not None:
            placement.samples = self.MotionOf(state).SamplesOf(state.matrices)
        return placement

def TranslateStage(stage, session, timeCode, shutter=(0.0, 0.0), passPrim=None):
    """Fills `session` with the stage at a time code (a float, or Usd.TimeCode), and while the shutter is open
    around it: (open, close) in frames. `passPrim`: a UsdRenderPass whose collections count."""
    translator = StageTranslator(stage, session, timeCode, shutter, passPrim)
    translator.Translate()
    return translator
