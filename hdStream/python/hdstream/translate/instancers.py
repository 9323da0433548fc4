# SPDX-License-Identifier: Apache-2.0
"""Native instances and point instancers as the core's instancers; never flattened.

Native instances of one prototype share an instancer, which takes the path of the first of them, where
they inherit the same but for primvars of one value each: these the core has by instance. What it places
is translated once, from the instance proxies of that first instance. Instances in another context
(below another instancer) get an instancer there.
Prims below a point instancer are drawn as its prototypes only; prototypes elsewhere are drawn
where they are as well, as UsdGeomPointInstancer says ("Processing and Not Processing Prototypes").
"""

from pxr import Usd, UsdGeom, UsdSkel

from hdstream import _core
from hdstream.translate import primvars, valueClips
from hdstream.translate.instanceArrays import InheritedKey, InstanceGroup, PointInstances, RelativeTo
from hdstream.translate.instancePrimvars import InstanceLevel, InstanceLevels, ReadInstancePrimvars
from hdstream.translate.materials import FindBoundMaterials
from hdstream.translate.motion import ReadBlurScale
from hdstream.translate.primState import PREDICATE, PROTOTYPE_PREDICATE, Context, State


class Instancers:
    """Adds instancers to a session; walks their prototypes with the stage's translator."""

    def __init__(self, translator, stage, session, timeCode, motion, links, passCollections, reports):
        self._translator = translator
        self._stage = stage
        self._session = session
        self._timeCode = timeCode
        self._motion = motion         # of what has no motion:blurScale
        self._links = links
        self._pass = passCollections  # None: there is no pass
        self._reports = reports
        self._levels = InstanceLevels(translator, session)
        self._isFlat = {}  # path of a prototype -> bool
        self._differentBelow = {}  # path of a first instance -> names of primvars that its group has by instance

    def Split(self, path, prim, geometryPrim):
        """(path, GeometryPrim) for each group of a gprim's instances that have equal primvars."""
        return self._levels.Split(path, prim, geometryPrim)

    def AddInstance(self, prim, state, context):
        """Adds a native instance to the group that shares its prototype's look."""
        boundPaths = self._BoundPathsBelow(prim) if state.hasCollections else None
        passKey = self._pass.KeyBelow(prim, context) if self._pass else ()
        if passKey is None:
            return
        isFlat = self._IsFlat(prim.GetPrototype()) and not state.drawMode
        passByInstance = frozenset()
        if self._pass and isFlat:
            state, passKey, passByInstance = self._pass.ByInstance(state, passKey, context)
        key = (prim.GetPrototype().GetPath(), InheritedKey(state, prim.GetPath().pathString, boundPaths, isFlat), passKey, state.motion)
        group = context.instanceGroups.get(key)
        if group is None:
            group = context.instanceGroups[key] = InstanceGroup(prim, state)
            group.passByInstance = passByInstance
        group.Add(prim, state)

    def _IsFlat(self, prototype):
        """Whether a prototype has neither instances nor draw modes inside: what differs between its instances, the core has
        for the innermost of them alone."""
        path = prototype.GetPath()
        if path not in self._isFlat:
            self._isFlat[path] = not any(
                child.IsInstance() or child.IsA(UsdGeom.PointInstancer) or child.HasAPI(UsdGeom.ModelAPI)
                for child in Usd.PrimRange(prototype))
        return self._isFlat[path]

    @staticmethod
    def _BoundPathsBelow(prim):
        """Materials of all gprims below an instance: collections may tell instances apart."""
        gprims = [child for child in Usd.PrimRange(prim, PREDICATE)
                  if child.IsA(UsdGeom.Gprim) or child.IsA(UsdGeom.Subset)]
        root = prim.GetPath().pathString
        paths, _ = FindBoundMaterials(gprims, lambda *_: None)
        return tuple(RelativeTo(root, path) for path in paths)

    def AddGroup(self, group, context):
        """Makes the instancers of a group of native instances: one for each way in which they are linked."""
        for part in group.Split(self._links.KeyOf) if self._links.areUsed else [group]:
            self._AddPart(part, context)

    def _AddPart(self, group, context):
        """Makes the instancer of native instances and translates what it places."""
        path = self._translator.ReservePath(group.firstPrim, context)
        inner = Context(path, group.VisibleIndices(), context.chain, context.passOfInstancer, group.passByInstance)
        rowsByName = group.DifferentPrimvars()
        self._levels.Add(path, InstanceLevel(context.instancerPath, context.instances, rowsByName))
        if rowsByName:
            self._differentBelow[group.firstPrim.GetPath()] = rowsByName.keys()
        state = State()
        state.purpose = group.state.purpose
        state.isPurposeAuthored = group.state.isPurposeAuthored
        state.primvars = {name: entry for name, entry in group.FirstPrimvars().items() if name not in rowsByName}
        if group.passByInstance:
            state.primvars = self._pass.DropUsual(state.primvars, group.passByInstance)
        state.bindings = group.state.bindings
        state.hasCollections = group.state.hasCollections
        state.skelRoot = group.firstPrim if group.firstPrim.IsA(UsdSkel.Root) else None
        state.motion = group.state.motion
        state.hasClips = group.state.hasClips
        self._translator.Walk(group.firstPrim.GetFilteredChildren(inner.predicate), state, inner)
        placement = _core.Placement(State().matrix, context.instancerPath, context.instances)
        if inner.isPlacing:
            self._AddInstancer(path, placement, group.Transforms(), group.Samples(self._translator.MotionOf(group.state)), context)

    def _AddInstancer(self, path, placement, transforms, samples, context):
        instancer = _core.InstancerPrim(placement)
        instancer.instanceTransforms = transforms
        instancer.samples = samples
        instancer.primvars = self._levels.PrimvarsOf(path)
        context.isPlacing = True
        self._session.SetInstancer(path, instancer)

    def AddPointInstancer(self, prim, schema, names, state, context):
        """Makes the instancer of a UsdGeomPointInstancer; a handler of the traversal."""
        usdPath = prim.GetPath().pathString
        if usdPath in context.chain:
            self._reports.Warn(prim, "point instancer is its own prototype; the inner one is skipped")
            return None
        arrays = PointInstances(prim, self._timeCode)
        if arrays.problem:
            self._reports.Warn(prim, f"point instancer not drawn: {arrays.problem}")
        if arrays.problem or not arrays.numInstances:
            return None
        if arrays.numOutside:
            self._reports.Warn(prim, f"{arrays.numOutside} instances have no prototype and are skipped")
        if arrays.numMasked not in (0, arrays.numInstances):
            self._reports.Warn(prim, f"{arrays.numMasked} ids but {arrays.numInstances} instances; what has no id is not hidden by it")
        path = self._translator.ReservePath(prim, context)
        rowsByName = ReadInstancePrimvars(prim, names, arrays.numInstances, self._timeCode, self._reports.Warn)
        self._levels.Add(path, InstanceLevel(context.instancerPath, context.instances, rowsByName))
        isPlacing = False
        for index, prototypePath in enumerate(arrays.prototypePaths):
            instances = arrays.InstancesOf(index)
            if len(instances) and self._WalkPrototype(prim, path, prototypePath, instances, state, context):
                isPlacing = True
        if isPlacing:
            self._translator.mappedLayers.AddOf(prim)
            placement = self._translator.PlacementOf(state, context)
            samples = [] if arrays.isAtRest else self._translator.MotionOf(state).PointInstanceSamplesOf(
                UsdGeom.PointInstancer(prim), arrays.numInstances, self._reports.Warn)
            self._AddInstancer(path, placement, arrays.transforms, samples, context)
        return None

    def _WalkPrototype(self, instancer, path, prototypePath, instances, instancerState, context):
        """Translates a prototype's subtree; true when it contains something to place."""
        root = self._stage.GetPrimAtPath(prototypePath)
        if not root or not PROTOTYPE_PREDICATE(root):
            self._reports.Warn(instancer, f"prototype {prototypePath} {_WhyNotDrawn(root)}")
            return False
        if self._pass and self._pass.IsPrunedWithin(root):
            return False
        ofInstancer = self._pass.InPrototype(instancer, root, instancerState, context) if self._pass else None
        inner = Context(path, instances, context.chain + (instancer.GetPath().pathString,), ofInstancer)
        self._translator.Walk([root], self._PrototypeState(root, instancerState), inner)
        return inner.isPlacing

    def _PrototypeState(self, root, instancerState):
        """What a prototype inherits: from its own ancestors; a purpose also from the instancer."""
        state = State()
        parent = UsdGeom.Imageable(root.GetParent())
        info = parent.ComputePurposeInfo() if parent else None
        if info and info.isInheritable:
            state.purpose, state.isPurposeAuthored = info.purpose, True
        else:
            state.purpose = instancerState.purpose
            state.isPurposeAuthored = instancerState.isPurposeAuthored
        state.primvars = primvars.InheritableAbove(root, self._timeCode, self._differentBelow)
        if self._motion.isOn and parent:
            state.motion = self._motion.Scaled(ReadBlurScale(root.GetParent(), self._timeCode, self._reports.Warn))
        ancestor = root.GetParent()
        chain = []
        while ancestor and not ancestor.IsPseudoRoot():
            chain.append(ancestor)
            ancestor = ancestor.GetParent()
        state.hasClips = any(valueClips.AreOn(ancestor) for ancestor in chain)
        for ancestor in reversed(chain):
            state.AddBindings(ancestor, ancestor.GetAuthoredPropertyNames())
        return state


def _WhyNotDrawn(root):
    """What keeps a prototype from being drawn, as UsdImaging has it."""
    if not root or not root.HasDefiningSpecifier():
        return "does not exist or is not defined"
    if not root.IsActive():
        return "is not active"
    return "is abstract, or below a class" if root.IsAbstract() else "is not loaded"
