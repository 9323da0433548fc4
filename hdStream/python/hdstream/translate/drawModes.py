# SPDX-License-Identifier: Apache-2.0
"""UsdGeomModelAPI draw modes: what stands in for a model instead of its subtree.

The rules are those of UsdImaging with legacy scene delegates (usdview's default in OpenUSD 24.11). A draw
mode is inherited along namespace and counts for models only: where model:applyDrawMode says so, else on
components. `cards` is a mesh of quads, `bounds` and `origin` are lines: curves of wrap `segmented`.
A card shows its back to nobody, so the two cards of a cross that share a place do not fight.
"""

import collections

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom

from hdstream import _core
from hdstream.translate import valueClips
from hdstream.translate.circles import HasCircularInstancers
from hdstream.translate.exrHeader import ReadMatrices
from hdstream.translate.instanceArrays import BindingsKey, InstanceGroup
from hdstream.translate.primState import IDENTITY, Context, State

ATTRIBUTE = "model:drawMode"
_SCHEMA_COLOR = Gf.Vec3f(0.18)  # model:drawModeColor's fallback
_PURPOSES = ["default", "proxy", "render"]

# A face looks along its axis; u and v of its image grow along the other two, u backwards where mirrored.
_Face = collections.namedtuple("_Face", "name axis isPositive uAxis isMirrored vAxis")
_FACES = (_Face("XPos", 0, True, 1, False, 2), _Face("XNeg", 0, False, 1, True, 2),
          _Face("YPos", 1, True, 0, True, 2), _Face("YNeg", 1, False, 0, False, 2),
          _Face("ZPos", 2, True, 0, False, 1), _Face("ZNeg", 2, False, 0, True, 1))
_OPPOSITE = dict(XPos="XNeg", XNeg="XPos", YPos="YNeg", YNeg="YPos", ZPos="ZNeg", ZNeg="ZPos")
_CORNERS = np.array([(1, 1), (0, 1), (0, 0), (1, 0)], np.float32)  # (u, v) of a quad, as seen from its front
# Cards whose place is in their image: screen positions and (u, v), in OpenUSD's orders.
_SCREEN_FACES = ("XPos", "YPos", "ZPos", "XNeg", "YNeg", "ZNeg")
_SCREEN_CORNERS = ((-1, -1, 0), (-1, 1, 0), (1, 1, 0), (1, -1, 0))
_SCREEN_UVS = np.array([(0, 1), (0, 0), (1, 0), (1, 1)], np.float32)
# Lines as pairs of points, in OpenUSD's orders; corner i of a box is high in x for bit 4, y for 2, z for 1.
_ORIGIN_POINTS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], np.float32)
_ORIGIN_LINES = np.array([0, 1, 0, 2, 0, 3], np.int32)
_BOX_LINES = np.array([0, 4, 4, 6, 6, 2, 2, 0, 1, 5, 5, 7, 7, 3, 3, 1, 0, 1, 4, 5, 6, 7, 2, 3], np.int32)
_SCREEN_MATRICES = ("worldtoscreen", "worldToNDC")  # names in an image's header, the first found counts


class _Cards:
    """Quads with the texture that each shows."""

    def __init__(self):
        self.points = []    # [4][3] a quad
        self.uvs = []       # [4][2] a quad
        self.faces = []     # name of each quad: XPos ...
        self.textures = []  # name of the face whose texture it shows; None: the model's colour

    def Add(self, face, points, uvs, texture):
        self.faces.append(face)
        self.points.append(points)
        self.uvs.append(uvs)
        self.textures.append(texture)


class DrawModes:
    """Finds the draw modes of prims and adds to a session what they ask for."""

    def __init__(self, translator, session, batch, links, timeCode, assets, reports):
        self._translator = translator
        self._session = session
        self._batch = batch
        self._links = links
        self._timeCode = timeCode
        self._assets = assets
        self._reports = reports
        self._modeByPath = {}  # Sdf.Path -> mode that its children inherit
        self._bounds = {}      # is at the frame's time -> UsdGeom.BBoxCache
        self._hasCircles = None  # known once bounds are asked for

    # --- Which mode ------------------------------------------------------------------------------

    @staticmethod
    def ModeOf(prim, inherited):
        """The draw mode at a prim with model:drawMode; "" is `default`."""
        if not prim.HasAPI(UsdGeom.ModelAPI):
            return inherited
        mode = prim.GetAttribute(ATTRIBUTE).Get()
        if mode in (None, "inherited"):
            return inherited
        return "" if mode == "default" else mode

    def InheritedBy(self, prim):
        """The draw mode that a prim inherits, for a traversal that starts at it."""
        passed = []
        mode = ""
        parent = prim.GetParent()
        while parent and not parent.IsPseudoRoot():
            path = parent.GetPath()
            known = self._modeByPath.get(path)
            if known is None:
                passed.append(path)
                known = self.ModeOf(parent, None)
            if known is not None:
                mode = known
                break
            parent = parent.GetParent()
        self._modeByPath.update((path, mode) for path in passed)
        return mode

    @staticmethod
    def IsApplied(prim):
        """True when a draw mode other than `default` at this prim replaces its subtree."""
        if not prim.IsModel():
            return False
        if prim.HasAPI(UsdGeom.ModelAPI):
            attribute = prim.GetAttribute("model:applyDrawMode")
            if attribute.HasAuthoredValue():
                return bool(attribute.Get())
        return Usd.ModelAPI(prim).IsKind(Kind.Tokens.component)

    # --- What stands in --------------------------------------------------------------------------

    def Add(self, prim, names, state, context):
        """Replaces a prim to which its draw mode applies; instances wait for others that look like it."""
        if not prim.IsInstance():
            self._Place(prim, state, context)
            return
        # UsdImaging tells instances by bindings too, though cards have materials of their own.
        look = tuple((name, repr(prim.GetAttribute(name).Get(self._timeCode))) for name in sorted(names)
                     if name.startswith("model:") or name == "extentsHint")
        key = (prim.GetPrototype().GetPath(), state.drawMode, look, state.purpose,
               BindingsKey(state, prim.GetPath().pathString), state.ofPass, state.motion)
        group = context.standInGroups.get(key)
        if group is None:
            group = context.standInGroups[key] = InstanceGroup(prim, state)
        group.Add(prim, state)

    def AddGroup(self, group, context):
        """Makes the instancers of native instances that show the same cards: one for each way in which they are linked."""
        for part in group.Split(self._LinksOf) if self._links.areUsed else [group]:
            self._AddPart(part, context)

    def _LinksOf(self, instance):
        return frozenset(self._links.CategoriesOf(instance.GetPath()))

    def _AddPart(self, group, context):
        path = self._translator.ReservePath(group.firstPrim, context)
        inner = Context(path, group.VisibleIndices(), context.chain, context.passOfInstancer)
        state = State()
        state.purpose = group.state.purpose
        state.ofPass = group.state.ofPass
        state.drawMode = group.state.drawMode
        state.motion = group.state.motion
        self._Place(group.firstPrim, state, inner)
        if inner.isPlacing:
            instancer = _core.InstancerPrim(_core.Placement(IDENTITY, context.instancerPath, context.instances))
            instancer.instanceTransforms = group.Transforms()
            instancer.samples = group.Samples(self._translator.MotionOf(group.state))
            context.isPlacing = True
            self._session.SetInstancer(path, instancer)

    def _Place(self, prim, state, context):
        if state.drawMode in ("bounds", "origin"):
            return self._PlaceLines(prim, state, context)
        if state.drawMode != "cards":
            return self._reports.Warn(prim, f"draw mode {state.drawMode} is unknown; left out")
        cards, color = self._ReadCards(prim)
        if not cards.faces:
            return None
        path = self._translator.ReservePath(prim, context)
        mesh = _MakeMesh(cards, color, path)
        placement = self._translator.PlacementOf(state, context)
        geometryPrim = _core.GeometryPrim(mesh, placement, state.purpose)
        geometryPrim.cullStyle = _core.CullStyle.Back
        geometryPrim.subsetMaterialPaths = [_MaterialPath(prim, texture) for texture in cards.textures]
        for texture in sorted(set(cards.textures) - {None}):
            self._SetMaterial(prim, texture, color)
        context.isPlacing = context.isPlacing or bool(context.instancerPath)
        if state.ofPass:
            state.ofPass.Apply(geometryPrim)
        return self._batch.AddStandIn(path, prim, geometryPrim)

    def _PlaceLines(self, prim, state, context):
        lines, points = _ORIGIN_LINES, _ORIGIN_POINTS
        if state.drawMode == "bounds":
            bounds = self._BoundsOf(prim)
            if bounds.IsEmpty():
                return self._reports.Warn(prim, "bounds of a model without extent; left out")
            ends = np.array([bounds.GetMin(), bounds.GetMax()], np.float32)
            corners = np.arange(8)
            points = np.stack([ends[corners >> 2 & 1, 0], ends[corners >> 1 & 1, 1], ends[corners & 1, 2]], 1)
            lines = _BOX_LINES
        description = _core.GeometryDescription()
        description.primitives = _core.PrimitiveKind.Curves
        description.curves = _LineForm()
        description.points = np.ascontiguousarray(points)
        description.faceVertexCounts = np.array([lines.size], np.int32)
        description.faceVertexIndices = lines
        description.primvars = _ConstantPrimvars(self._ColorOf(prim), ("displayOpacity", "widths"))
        path = self._translator.ReservePath(prim, context)
        placement = self._translator.PlacementOf(state, context)
        context.isPlacing = context.isPlacing or bool(context.instancerPath)
        geometryPrim = _core.GeometryPrim(description, placement, state.purpose)
        if state.ofPass:
            state.ofPass.Apply(geometryPrim)
        return self._batch.AddStandIn(path, prim, geometryPrim)

    def _ColorOf(self, prim):
        if not prim.HasAPI(UsdGeom.ModelAPI):
            return _SCHEMA_COLOR
        color = UsdGeom.ModelAPI(prim).GetModelDrawModeColorAttr().Get()
        return color if isinstance(color, Gf.Vec3f) else _SCHEMA_COLOR

    def _ReadCards(self, prim):
        """(cards, colour). Without the applied schema only its fallbacks count."""
        if not prim.HasAPI(UsdGeom.ModelAPI):
            return self._CardsInBounds(prim, "cross", set()), _SCHEMA_COLOR
        textures = {face.name for face in _FACES if self._TextureOf(prim, face.name)}
        model = UsdGeom.ModelAPI(prim)
        geometry = model.GetModelCardGeometryAttr().Get()
        if geometry == "fromTexture":
            cards = self._CardsOfImages(prim, textures)
        elif geometry in ("cross", "box"):
            cards = self._CardsInBounds(prim, geometry, textures)
        else:
            self._reports.Warn(prim, f"card geometry {geometry} is unknown; left out")
            cards = _Cards()
        return cards, self._ColorOf(prim)

    def _TextureOf(self, prim, face):
        """The texture of a face (Sdf.AssetPath); None without one."""
        value = prim.GetAttribute("model:cardTexture" + face).Get(self._timeCode)
        return value if isinstance(value, Sdf.AssetPath) and value.path else None

    def _CardsInBounds(self, prim, geometry, textures):
        """Both cards of each axis that has a texture, of all axes when none has; see _FACES."""
        cards = _Cards()
        bounds = self._BoundsOf(prim)
        if bounds.IsEmpty():
            self._reports.Warn(prim, "cards of a model without extent; left out")
            return cards
        low, high = np.array(bounds.GetMin(), np.float32), np.array(bounds.GetMax(), np.float32)
        for face in _FACES:
            texture = next((name for name in (face.name, _OPPOSITE[face.name]) if name in textures), None)
            if textures and texture is None:
                continue
            u, v = _CORNERS[:, 0], _CORNERS[:, 1]
            points = np.empty((4, 3), np.float32)
            points[:, face.axis] = ((low + high) / np.float32(2) if geometry == "cross"
                                    else high if face.isPositive else low)[face.axis]
            points[:, face.uAxis] = np.where(u != face.isMirrored, high[face.uAxis], low[face.uAxis])
            points[:, face.vAxis] = np.where(v > 0, high[face.vAxis], low[face.vAxis])
            cards.Add(face.name, points, _CardUvs(face.name, texture in (face.name, None)), texture)
        return cards

    def _BoundsOf(self, prim):
        """The untransformed bounds, hints included; of the earliest time unless the prim's own vary."""
        isVarying = any(attribute and valueClips.Varies(attribute)
                        for attribute in map(prim.GetAttribute, ("extent", "extentsHint")))
        if self._hasCircles is None:
            self._hasCircles = HasCircularInstancers(prim.GetStage())
        if self._hasCircles:
            return Gf.Range3d()
        cache = self._bounds.get(isVarying)
        if cache is None:
            timeCode = self._timeCode if isVarying else Usd.TimeCode.EarliestTime()
            cache = self._bounds[isVarying] = UsdGeom.BBoxCache(timeCode, _PURPOSES, useExtentsHint=True)
        return cache.ComputeUntransformedBound(prim).ComputeAlignedBox()

    def _CardsOfImages(self, prim, textures):
        """A card for each image that says where it is."""
        cards = _Cards()
        for face in _SCREEN_FACES:
            if face not in textures:
                continue
            attribute = prim.GetAttribute("model:cardTexture" + face)
            asset = self._assets.Resolve(attribute, self._TextureOf(prim, face))
            matrices = ReadMatrices(asset)
            screenFromModel = next((matrices[name] for name in _SCREEN_MATRICES if name in matrices), None)
            if screenFromModel is None:
                self._reports.Warn(prim, f"texture {asset.authoredPath} has no worldtoscreen matrix; "
                                         "its card is left out")
                continue
            modelFromScreen = screenFromModel.GetInverse()
            points = [modelFromScreen.Transform(Gf.Vec3d(*corner)) for corner in _SCREEN_CORNERS]
            cards.Add(face, np.array(points, np.float32), _SCREEN_UVS, face)
        return cards

    def _SetMaterial(self, prim, face, color):
        """The material of a face's texture, with the node names of OpenUSD."""
        path = _MaterialPath(prim, face)
        surface, texture, reader = (f"{path}/{name}" for name in ("cardSurface", "cardTexture", "cardUvCoords"))
        asset = self._assets.Resolve(prim.GetAttribute("model:cardTexture" + face), self._TextureOf(prim, face))
        nodes = [
            _core.MaterialNode(surface, "UsdPreviewSurface", {"opacityThreshold": float(np.float32(0.1))},
                               {"diffuseColor": _core.Connection(texture, "rgb"),
                                "opacity": _core.Connection(texture, "a")}),
            _core.MaterialNode(texture, "UsdUVTexture",
                               {"file": asset, "fallback": [*map(float, color), 1.0],
                                "wrapS": "clamp", "wrapT": "clamp"},
                               {"st": _core.Connection(reader, "result")}),
            _core.MaterialNode(reader, "UsdPrimvarReader_float2", {"varname": "cardsUv"}, {}),
        ]
        self._session.SetMaterial(path, _core.MaterialNetwork(nodes, {"surface": _core.Connection(surface, "surface")}))


def _MaterialPath(prim, face):
    """As UsdImaging names it, so that both front ends give one scene. It binds such a path without a texture too, where
    there is no material; nothing is bound then here."""
    return f"{prim.GetPath()}/subsetMaterial{face}" if face else ""


def _CardUvs(face, isOwn):
    """(u, v) of a card's corners. One that borrows the opposite card's texture shows it mirrored; ZNeg
    shows its own upside down, as OpenUSD has it."""
    flipsU, flipsV = (face == "ZNeg", face == "ZNeg") if isOwn else (face != "ZPos", face == "ZPos")
    return np.abs(_CORNERS - np.array([flipsU, flipsV], np.float32))


def _ConstantPrimvars(color, namesOfOnes):
    constant = _core.Interpolation.Constant
    one = np.ones(1, np.float32)
    return [_core.Primvar("displayColor", constant, np.array([color], np.float32)),
            *(_core.Primvar(name, constant, one) for name in namesOfOnes)]


def _LineForm():
    form = _core.CurveForm()
    form.type = "linear"
    form.wrap = "segmented"
    return form


def _MakeMesh(cards, color, path):
    mesh = _core.GeometryDescription()
    mesh.points = np.concatenate(cards.points)
    mesh.faceVertexCounts = np.full(len(cards.faces), 4, np.int32)
    mesh.faceVertexIndices = np.arange(4 * len(cards.faces), dtype=np.int32)
    mesh.subdivisionScheme = "none"
    mesh.primvars = [_core.Primvar("cardsUv", _core.Interpolation.Vertex, np.concatenate(cards.uvs)),
                     *_ConstantPrimvars(color, ("displayOpacity", "displayRoughness", "widths"))]
    subsets = []
    for index, face in enumerate(cards.faces):
        subset = _core.MeshSubset()
        subset.name = f"{path}/subset{face}"
        subset.faces = np.array([index], np.int32)
        subsets.append(subset)
    mesh.subsets = subsets
    return mesh
