# SPDX-License-Identifier: Apache-2.0
"""What becomes of a prim, by its schema: meshes, curves, points, splats, volumes, lights and cameras.

The traversal (`stageTranslator.py`) visits prims and keeps what they inherit; the handlers here read them and hand them to the
session.
"""

import numpy as np
from pxr import UsdGeom, UsdSkel

from hdstream import _core
from hdstream.translate import cameras, curves, lights, meshes, splats, volumes
from hdstream.translate.materials import FindBoundMaterials
from hdstream.translate.primState import HasBindings
from hdstream.translate.skinning import ReasonAtRest
from hdstream.translate.usdCalls import GetAttribute, GetFilteredChildren, GetTypeName, GetValue

# Schemas that are drawn by other renderers and skipped here, with a count.
_SKIPPED_SCHEMAS = ("ParticleField",)


class TypeInfo:
    """What the traversal needs to know of a schema."""

    __slots__ = ("schema", "handler", "isImageable", "isXformable", "isLeaf", "isSkelRoot")

    def __init__(self, prim, schema, handler, isLeaf):
        self.schema = schema
        self.handler = handler
        self.isImageable = prim.IsA(UsdGeom.Imageable) or schema == splats.TYPE
        self.isXformable = prim.IsA(UsdGeom.Xformable) or schema == splats.TYPE
        self.isSkelRoot = prim.IsA(UsdSkel.Root)
        self.isLeaf = isLeaf  # a gprim, whose primvars its handler reads; see _BelowLeaf


class PrimHandlers:
    """The handlers of one translation. `translator`: the StageTranslator, which is a cycle until it drops the handlers."""

    def __init__(self, translator, instancers, session, timeCode, motion, assets, links, batch, skins, reports):
        self._translator = translator
        self._instancers = instancers
        self._session = session
        self._timeCode = timeCode
        self._motion = motion
        self._assets = assets
        self._links = links
        self._batch = batch
        self._skins = skins
        self._reports = reports
        self._handlers = self._MakeHandlers()
        self._types = {}
        self.volumeMaterials = {}  # path -> prim, of what volumes are bound to

    def End(self):
        """Breaks the cycle of references through the handlers' own methods."""
        self._handlers = self._types = None

    def InfoOf(self, prim):
        """What the traversal needs to know of a prim's type."""
        return self._types.get(GetTypeName(prim)) or self._AddType(prim)

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
        info = TypeInfo(prim, *found, isLeaf=found[1] in leaves)
        self._types[prim.GetTypeName()] = info
        return info

    def _Place(self, prim, state, context):
        """The scene path of a prim and its placement."""
        path = self._translator.ReservePath(prim, context)
        if context.instancerPath:
            context.isPlacing = True
        return path, self._translator.PlacementOf(state, context)

    def _OnMesh(self, prim, schema, names, state, context):
        mesh = self._KeptGeometry(prim, context) or meshes.ReadMesh(
            prim, names, state.primvars, self._timeCode, self._translator.MotionOf(state), self._reports.Warn, self._SkinOf(prim, names, state))
        if mesh is None:
            if lights.IsLight(prim):
                self._reports.Warn(prim, "mesh light has no faces; it lights nothing")
            return state
        return self._AddMesh(prim, names, mesh, state, context)

    def _OnTetMesh(self, prim, schema, names, state, context):
        return self._AddConverted(meshes.ReadTetMesh, prim, names, state, context)

    def _OnNurbsPatch(self, prim, schema, names, state, context):
        return self._AddConverted(meshes.ReadNurbsPatch, prim, names, state, context)

    def _AddConverted(self, read, prim, names, state, context):
        """A prim that `read` makes a mesh of."""
        mesh = self._KeptGeometry(prim, context) or read(
            prim, names, state.primvars, self._timeCode, self._translator.MotionOf(state), self._reports.Warn,
            self._SkinOf(prim, names, state))
        return state if mesh is None else self._AddMesh(prim, names, mesh, state, context)

    def _OnImplicit(self, prim, schema, names, state, context):
        mesh = self._KeptGeometry(prim, context) or meshes.ReadImplicit(
            prim, schema, names, state.primvars, self._timeCode, self._translator.MotionOf(state), self._reports.Warn)
        return self._AddMesh(prim, names, mesh, state, context, isPlane=schema == "Plane")

    def _OnCurves(self, prim, schema, names, state, context):
        description = curves.ReadCurves(prim, schema, names, state.primvars, self._timeCode, self._translator.MotionOf(state),
                                        self._reports.Warn, self._SkinOf(prim, names, state))
        if description is not None and schema != "BasisCurves" and description.curves.type == "linear":
            self._reports.Count(prim, f"{schema} are drawn as lines between their points: {{count}}")
        self._AddSolid(prim, names, description, state, context)
        return state

    def _OnPoints(self, prim, schema, names, state, context):
        self._AddSolid(prim, names, curves.ReadPointCloud(prim, names, state.primvars, self._timeCode, self._translator.MotionOf(state),
                                                          self._reports.Warn, self._SkinOf(prim, names, state)), state, context)
        return state

    def _OnSplats(self, prim, schema, names, state, context):
        description = splats.ReadSplats(prim, names, state.primvars, self._timeCode)
        if description is not None:
            splats.AddSamples(prim, description, self._translator.MotionOf(state), self._timeCode, self._reports.Warn)
        self._AddSolid(prim, names, description, state, context)
        return state

    def _OnVolume(self, prim, schema, names, state, context):
        (materialPath,), materials = FindBoundMaterials([prim], self._reports.Warn)
        self.volumeMaterials.update(materials)
        self._WarnOfNoLight(prim)
        path, placement = self._Place(prim, state, context)
        if state.ofPass and placement.visible and (state.ofPass.isMatte or not state.ofPass.isSeenByCamera):
            self._reports.Count(prim, "volumes have no matte and are always seen by the camera, whatever the pass says: {count}")
        self._session.SetVolume(path, volumes.ReadVolume(
            prim, placement, state.purpose, materialPath, self._timeCode, self._assets, self._reports.Warn))
        self._batch.AddVolume(path, prim)
        return state

    def _SkinOf(self, prim, names, state):
        skin = self._skins.Of(prim, state.skelRoot, self._translator.MotionOf(state))
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
        if not self._translator.isKeeping:
            return None
        kept = self._translator.KeptPrim(context.ScenePath(prim))
        return kept.geometry if kept else None

    def _AddMesh(self, prim, names, mesh, state, context, isPlane=False):
        """Adds a mesh; returns the state of what is below it, None where nothing is."""
        subsets = []
        subsetPrims = []
        children = GetFilteredChildren(prim, context.predicate)
        for child in children:
            if child.IsA(UsdGeom.Subset):
                subset = meshes.ReadSubset(child, self._timeCode, self._reports.Warn)
                if subset is not None:
                    subset.name = context.ScenePath(child)
                    subsets.append(subset)
                    subsetPrims.append(child)
        path, placement = self._Place(prim, state, context)
        geometryPrim = self._translator.KeptPrim(path)
        if geometryPrim:  # the core knows geometry by its identity
            geometryPrim.placement, geometryPrim.purpose = placement, state.purpose
        else:
            if subsets:
                mesh.subsets = subsets
            geometryPrim = _core.GeometryPrim(mesh, placement, state.purpose)
        if "doubleSided" in names or isPlane:  # whose fallback is true
            geometryPrim.doubleSided = bool(GetValue(GetAttribute(prim, "doubleSided"), self._timeCode))
        self._ReadMeshLight(prim, names, geometryPrim)
        if state.ofPass:
            state.ofPass.Apply(geometryPrim)
        self._AddToBatch(path, prim, names, geometryPrim, subsetPrims, state)
        return state if children else None

    def _AddToBatch(self, path, prim, names, geometryPrim, subsetPrims, state):
        hasOwn = state.hasCollections or HasBindings(names)
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
                placement.samples = self._translator.MotionOf(state).SamplesOf([pole * matrix for matrix in state.matrices])
        lightPrim = _core.LightPrim(light, placement)
        lightPrim.samples = lights.ReadLightSamples(prim, light, names, self._translator.MotionOf(state))
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
