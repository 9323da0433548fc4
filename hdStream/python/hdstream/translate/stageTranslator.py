# SPDX-License-Identifier: Apache-2.0
"""The traversal of a stage: every prim is visited once, inherited values live on its stack.

Native instances are collected while a context (the world, or the prototypes of an instancer) is
walked and turned into instancers after it. Materials are found for all geometry at once at the end.
"""

import gc

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdSkel

from hdstream import _core
from hdstream.diagnostics import MessagesOf
from hdstream.translate import (cameras, colorSpaces, curves, drawModes, lights, meshes, primvars, rereading, splats,
                                valueClips, volumes)
from hdstream.translate.assets import AssetResolver
from hdstream.translate.instancers import Instancers
from hdstream.translate.links import Links
from hdstream.translate.materials import FindBoundMaterials, MaterialReader
from hdstream.translate.geometryBatch import GeometryBatch
from hdstream.translate.motion import Motion, ReadBlurScale
from hdstream.translate.passCollections import PassCollections
from hdstream.translate.primState import PREDICATE, SKEL_BINDINGS, Context, State
from hdstream.translate.reports import Reports
from hdstream.translate.skinning import ReasonAtRest, Skins
from hdstream.typedValues import MistypedValues

# Schemas that are drawn by other renderers and skipped here, with a count.
_SKIPPED_SCHEMAS = ("ParticleField",)


_BINDING = "material:binding"
_BLUR_SCALE = "motion:blurScale"
_PURPOSES = frozenset(UsdGeom.Imageable.GetOrderedPurposeTokens())


class _TypeInfo:
    """What the traversal needs to know of a schema."""

    __slots__ = ("schema", "handler", "isImageable", "isXformable", "isLeaf", "isSkelRoot")

    def __init__(self, prim, schema, handler, isLeaf):
        self.schema = schema
        self.handler = handler
        self.isImageable = prim.IsA(UsdGeom.Imageable) or schema == splats.TYPE
        self.isXformable = prim.IsA(UsdGeom.Xformable) or schema == splats.TYPE
        self.isSkelRoot = prim.IsA(UsdSkel.Root)
        self.isLeaf = isLeaf  # a gprim, whose primvars its handler reads; see _BelowLeaf


def _HasBindings(names):
    """Whether a prim has bindings of materials of its own; asked of each, so no generator."""
    for name in names:
        if name.startswith(_BINDING):
            return True
    return False


class StageTranslator:
    """Translates one stage at one time code, and while a shutter is open around it, into a session. Used once."""

    def __init__(self, stage, session, timeCode, shutter=(0.0, 0.0), passPrim=None):
        self._stage = stage
        self._pass = PassCollections(passPrim) if passPrim else None
        self._session = session
        self._timeCode = Usd.TimeCode(timeCode)
        colorSpaces.Forget()
        self._motion = Motion(timeCode, shutter)
        self._reports = Reports(session)
        self._assets = AssetResolver()
        self._xforms = UsdGeom.XformCache(self._timeCode)
        self._skins = Skins(self._timeCode, self._xforms, self._motion, self._reports.Warn)
        self._types = {}
        self._numPaths = 0
        self._placedPaths = set()  # of what instancers place: all other prims have the paths that USD gives them
        self._links = Links()
        self._batch = GeometryBatch(session, self._links, self._reports.Warn)
        self._drawModes = drawModes.DrawModes(self, session, self._batch, self._links, self._timeCode, self._assets,
                                             self._reports)
        self._instancers = Instancers(self, stage, session, self._timeCode, self._motion, self._links, self._pass,
                                      self._reports)
        self._volumeMaterials = {}  # path -> prim
        self._kept = {}  # scene path -> GeometryPrim of before, whose geometry is as it was
        self.materialPaths = set()  # of the materials that were translated
        self.mappedLayers = rereading.MappedLayers()
        self.numPrims = 0  # prims visited, instance proxies of first instances included
        self._handlers = self._MakeHandlers()

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
            info = self._types.get(ancestor.GetTypeName()) or self._AddType(ancestor)
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
        self.Walk(prims, state, Context())
        self._SetMaterials({**self._volumeMaterials, **self._batch.Flush()})
        self._End()

    def _End(self):
        """Breaks the cycles of references, so that a stage and its layers go with their last user."""
        self._reports.Flush()
        self._handlers = self._types = self._instancers = self._drawModes = None

    def _SetMaterials(self, primByPath):
        reader = MaterialReader(self._timeCode, self._assets, self._reports.Warn)
        for path, prim in primByPath.items():
            self._session.SetMaterial(path, reader.Read(prim))
        self.materialPaths.update(primByPath)

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
            except (Tf.ErrorException, TypeError, ValueError, IndexError) as error:
                self._reports.Warn(prim, f"cannot be read: {'; '.join(self._CausesOf(error, prim))}")
                state = inherited
            if state is not None:
                children = prim.GetFilteredChildren(context.predicate)
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
        if isIndex or "incompatible function arguments" in str(error):
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
        info = self._types.get(prim.GetTypeName()) or self._AddType(prim)
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
        if _HasBindings(names):
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
            visibility = prim.GetAttribute("visibility").Get(self._timeCode) if "visibility" in names else None
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
            elif name.startswith(_BINDING):
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

    def _MakeHandlers(self):
        """(schema class, handler) from special to general; prims of no schema here are groups."""
        handlers = [("Mesh", self._OnMesh), ("Points", self._OnPoints), ("PointInstancer", self._instancers.AddPointInstancer),
                    ("Camera", self._OnCamera), ("Subset", self._OnSkipped)]
        handlers += [("TetMesh", self._OnTetMesh), ("NurbsPatch", self._OnNurbsPatch)]
        handlers += [(name, self._OnCurves) for name in ("BasisCurves", "NurbsCurves", "HermiteCurves")]
        handlers += [(name, self._OnImplicit) for name in meshes.IMPLICIT_TYPES]
        handlers += [("Volume", self._OnVolume), ("FieldBase", self._OnSkipped)]
        handlers += [(splats.TYPE, self._OnSplats)]
        handlers += [(name, self._OnUnsupported) for name in _SKIPPED_SCHEMAS]
        handlers += [(name, self._OnLight) for name in lights.LIGHT_TYPES]
        handlers += [(name, self._OnUnsupported) for name in lights.UNSUPPORTED_LIGHT_TYPES]
        handlers += [("Material", self._OnSkipped), ("NodeGraph", self._OnSkipped),
                     ("Shader", self._OnSkipped)]
        return handlers

    def _AddType(self, prim):
        """Finds the handler of a type not seen before, through its base schemas."""
        found = (None, None)
        for name, handler in self._handlers:
            schema = _SchemaClass(name)
            if schema is not None and prim.IsA(schema):
                found = (name, handler)
                break
        if prim.GetTypeName() == splats.TYPE:  # whatever this usd-core knows of it
            found = (splats.TYPE, self._OnSplats)
        leaves = (self._OnMesh, self._OnTetMesh, self._OnImplicit, self._OnCurves, self._OnPoints, self._OnSplats)
        info = _TypeInfo(prim, *found, isLeaf=found[1] in leaves)
        self._types[prim.GetTypeName()] = info
        return info

    # --- Prims -----------------------------------------------------------------------------------

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

    def _Place(self, prim, state, context):
        """The scene path of a prim and its placement."""
        path = self.ReservePath(prim, context)
        if context.instancerPath:
            context.isPlacing = True
        return path, self.PlacementOf(state, context)

    def _OnMesh(self, prim, schema, names, state, context):
        mesh = self._KeptGeometry(prim, context) or meshes.ReadMesh(
            prim, names, state.primvars, self._timeCode, self.MotionOf(state), self._reports.Warn, self._SkinOf(prim, names, state))
        if mesh is None:
            if lights.IsLight(prim):
                self._reports.Warn(prim, "mesh light has no faces; it lights nothing")
            return state
        return self._AddMesh(prim, names, mesh, state, context)

    def _WarnOfClips(self, prim):
        """Names the files of a prim's own value clips that are not there."""
        for text in valueClips.MissingClips(prim):
            self._reports.Warn(prim, text)

    def _OnTetMesh(self, prim, schema, names, state, context):
        return self._AddConverted(meshes.ReadTetMesh, prim, names, state, context)

    def _OnNurbsPatch(self, prim, schema, names, state, context):
        return self._AddConverted(meshes.ReadNurbsPatch, prim, names, state, context)

    def _AddConverted(self, read, prim, names, state, context):
        """A prim that `read` makes a mesh of."""
        mesh = self._KeptGeometry(prim, context) or read(
            prim, names, state.primvars, self._timeCode, self.MotionOf(state), self._reports.Warn, self._SkinOf(prim, names, state))
        return state if mesh is None else self._AddMesh(prim, names, mesh, state, context)

    def _OnImplicit(self, prim, schema, names, state, context):
        mesh = self._KeptGeometry(prim, context) or meshes.ReadImplicit(
            prim, schema, names, state.primvars, self._timeCode, self._reports.Warn)
        return self._AddMesh(prim, names, mesh, state, context, isPlane=schema == "Plane")

    def _OnCurves(self, prim, schema, names, state, context):
        description = curves.ReadCurves(prim, schema, names, state.primvars, self._timeCode, self.MotionOf(state),
                                        self._reports.Warn, self._SkinOf(prim, names, state))
        if description is not None and schema != "BasisCurves" and description.curves.type == "linear":
            self._reports.Count(prim, f"{schema} are drawn as lines between their points: {{count}}")
        self._AddSolid(prim, names, description, state, context)
        return state

    def _OnPoints(self, prim, schema, names, state, context):
        self._AddSolid(prim, names, curves.ReadPointCloud(prim, names, state.primvars, self._timeCode, self.MotionOf(state),
                                                          self._reports.Warn, self._SkinOf(prim, names, state)), state, context)
        return state

    def _OnSplats(self, prim, schema, names, state, context):
        description = splats.ReadSplats(prim, names, state.primvars, self._timeCode)
        if description is not None:
            splats.AddSamples(prim, description, self.MotionOf(state), self._timeCode, self._reports.Warn)
        self._AddSolid(prim, names, description, state, context)
        return state

    def _OnVolume(self, prim, schema, names, state, context):
        (materialPath,), materials = FindBoundMaterials([prim], self._reports.Warn)
        self._volumeMaterials.update(materials)
        self._WarnOfNoLight(prim)
        path, placement = self._Place(prim, state, context)
        if state.ofPass and placement.visible and (state.ofPass.isMatte or not state.ofPass.isSeenByCamera):
            self._reports.Count(prim, "volumes have no matte and are always seen by the camera, whatever the pass says: {count}")
        self._session.SetVolume(path, volumes.ReadVolume(
            prim, placement, state.purpose, materialPath, self._timeCode, self._assets, self._reports.Warn))
        self._batch.AddVolume(path, prim)
        return state

    def _SkinOf(self, prim, names, state):
        skin = self._skins.Of(prim, state.skelRoot, self.MotionOf(state))
        if skin is None and (reason := ReasonAtRest(prim, names)):
            self._reports.Count(prim, reason)
        return skin

    def _AddSolid(self, prim, names, description, state, context):
        if description is None:
            return
        self._WarnOfNoLight(prim)
        path, placement = self._Place(prim, state, context)
        geometryPrim = _core.GeometryPrim(description, placement, state.purpose)
        if state.ofPass:
            state.ofPass.Apply(geometryPrim)
        self._AddToBatch(path, prim, names, geometryPrim, [], state)

    def _KeptGeometry(self, prim, context):
        """The geometry of before when it still holds, else None."""
        kept = self._kept.get(context.ScenePath(prim)) if self._kept else None
        return kept.geometry if kept else None

    def _AddMesh(self, prim, names, mesh, state, context, isPlane=False):
        """Adds a mesh; returns the state of what is below it, None where nothing is."""
        subsets = []
        subsetPrims = []
        children = prim.GetFilteredChildren(context.predicate)
        for child in children:
            if child.IsA(UsdGeom.Subset):
                subset = meshes.ReadSubset(child, self._timeCode, self._reports.Warn)
                if subset is not None:
                    subset.name = context.ScenePath(child)
                    subsets.append(subset)
                    subsetPrims.append(child)
        path, placement = self._Place(prim, state, context)
        geometryPrim = self._kept.get(path)
        if geometryPrim:  # the core knows geometry by its identity
            geometryPrim.placement, geometryPrim.purpose = placement, state.purpose
        else:
            if subsets:
                mesh.subsets = subsets
            geometryPrim = _core.GeometryPrim(mesh, placement, state.purpose)
        if "doubleSided" in names or isPlane:  # whose fallback is true
            geometryPrim.doubleSided = bool(prim.GetAttribute("doubleSided").Get(self._timeCode))
        self._ReadMeshLight(prim, names, geometryPrim)
        if state.ofPass:
            state.ofPass.Apply(geometryPrim)
        self._AddToBatch(path, prim, names, geometryPrim, subsetPrims, state)
        return state if children else None

    def _AddToBatch(self, path, prim, names, geometryPrim, subsetPrims, state):
        hasOwn = state.hasCollections or _HasBindings(names)
        for splitPath, splitPrim in self._instancers.Split(path, prim, geometryPrim):
            self._batch.Add(splitPath, prim, splitPrim, subsetPrims, None if hasOwn else state.bindings)

    def _ReadMeshLight(self, prim, names, geometryPrim):
        if not lights.IsLight(prim):
            geometryPrim.RemoveLight()
            return
        self._WarnOfLight(prim, names)
        geometryPrim.SetLight(lights.ReadLight(prim, "Mesh", names, self._timeCode, self._assets, self._reports.Warn),
                              lights.ReadSyncMode(prim, self._reports.Warn), self._links.Read(prim, names))

    def _WarnOfNoLight(self, prim):
        """Says that LightAPI makes no light of a prim that has no faces."""
        if lights.IsLight(prim):
            self._reports.Count(prim, f"LightAPI makes lights of what has faces, and none of {prim.GetTypeName()}: {{count}}")

    def _WarnOfLight(self, prim, names):
        for feature in lights.UnsupportedFeatures(prim, names):
            self._reports.Warn(prim, f"{feature} is not supported yet")

    def _OnLight(self, prim, schema, names, state, context):
        self._WarnOfLight(prim, names)
        light = lights.ReadLight(prim, schema, names, self._timeCode, self._assets, self._reports.Warn)
        if state.ofPass and not state.ofPass.isSeenByCamera:
            light.visibleToCamera = False
        path, placement = self._Place(prim, state, context)
        pole = lights.PoleTransform(prim, schema, self._reports.Warn)
        if pole is not None:
            placement.worldFromObject = np.array(pole * state.matrix)
            if state.matrices is not None:
                placement.samples = self.MotionOf(state).SamplesOf([pole * matrix for matrix in state.matrices])
        lightPrim = _core.LightPrim(light, placement)
        lightPrim.links = self._links.Read(prim, names)
        for matrix, width, height in lights.ReadPortals(prim, names, self._timeCode, self._reports.Warn):
            lightPrim.AddPortal(np.array(matrix), width, height)
        for node, matrix in lights.ReadFilters(prim, names, state.matrix, self._timeCode, self._assets,
                                               self._reports.Warn):
            lightPrim.AddFilter(node, np.array(matrix))
        self._session.SetLight(path, lightPrim)
        return state

    def _OnCamera(self, prim, schema, names, state, context):
        if not context.instancerPath:
            self._session.SetCamera(context.ScenePath(prim), cameras.ReadCamera(prim, self._timeCode, self._motion))
        return state

    def _OnUnsupported(self, prim, schema, names, state, context):
        if state.visible:
            self._reports.Count(prim, f"{prim.GetTypeName()} is not supported yet: {{count}} skipped")
        return state

    def _OnSkipped(self, prim, schema, names, state, context):
        return None


def _SchemaClass(name):
    """The schema class of a name in UsdGeom, UsdLux, UsdShade or UsdVol; None when this usd-core lacks it."""
    from pxr import UsdLux, UsdShade, UsdVol
    for module in (UsdGeom, UsdLux, UsdShade, UsdVol):
        schema = getattr(module, name, None)
        if schema is not None:
            return schema
    return None


def TranslateStage(stage, session, timeCode, shutter=(0.0, 0.0), passPrim=None):
    """Fills `session` with the stage at a time code (a float, or Usd.TimeCode), and while the shutter is open
    around it: (open, close) in frames. `passPrim`: a UsdRenderPass whose collections count."""
    translator = StageTranslator(stage, session, timeCode, shutter, passPrim)
    translator.Translate()
    return translator
