# SPDX-License-Identifier: Apache-2.0
"""What a prim inherits, kept on the traversal's own stack instead of asked for at every prim.

A State is immutable once made and shared by all prims that change nothing.
"""

from pxr import Gf, Usd

from hdstream.translate.pathTexts import PathText

PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
# As UsdImaging: a prototype may be an `over`'s child, so its ancestors need not be defined.
PROTOTYPE_PREDICATE = Usd.TraverseInstanceProxies(
    Usd.PrimIsActive & Usd.PrimIsLoaded & Usd.PrimHasDefiningSpecifier & ~Usd.PrimIsAbstract)
IDENTITY = Gf.Matrix4d(1.0)
BINDING = "material:binding"
_STRONGER = "strongerThanDescendants"
# What instances of one prototype may be animated by, each by its own.
SKEL_BINDINGS = frozenset(("skel:animationSource", "skel:skeleton"))


def HasBindings(names):
    """Whether a prim has bindings of materials of its own; asked of each, so no generator."""
    for name in names:
        if name.startswith(BINDING):
            return True
    return False


class State:
    """Inherited values at a prim, relative to the space of its Context."""

    __slots__ = ("matrix", "matrices", "visible", "purpose", "isPurposeAuthored", "primvars", "bindings",
                 "hasCollections", "drawMode", "skelRoot", "skelBindings", "ofPass", "motion", "way",
                 "hasClips")

    def __init__(self):
        self.matrix = IDENTITY          # context space from prim, row vectors (Gf)
        self.matrices = None            # the same at the times of the Motion; None: at rest
        self.motion = None              # a Motion with another motion:blurScale; None: the stage's
        self.way = ()                   # prims with transforms that `matrix` is composed of, where the shutter is open
        self.visible = True
        self.purpose = "default"
        self.isPurposeAuthored = False  # only an authored purpose is inherited
        self.primvars = {}              # name -> InheritedPrimvar: constant ones only
        self.bindings = {}              # material purpose -> (target path, strength)
        self.hasCollections = False     # a collection-based material binding applies
        self.drawMode = ""              # UsdGeomModelAPI; empty: default
        self.skelRoot = None            # the SkelRoot prim around, below which prims may be skinned
        self.skelBindings = {}          # name of a relationship of UsdSkelBindingAPI -> paths of its targets
        self.ofPass = None              # the prim's own Membership, not inherited; None: there is no pass
        self.hasClips = False           # value clips may hold attributes of the prim that no layer declares

    def WithClips(self):
        copy = self.Copy()
        copy.hasClips = True
        return copy

    def Copy(self):
        copy = State.__new__(State)
        for name in State.__slots__:
            setattr(copy, name, getattr(self, name))
        return copy

    def AddSkelBinding(self, prim, name):
        """Takes a relationship of UsdSkelBindingAPI that is authored on `prim` over (this state is still private)."""
        targets = prim.GetRelationship(name).GetTargets() if prim.GetRelationship(name) else []
        self.skelBindings = {**self.skelBindings, name: tuple(path.pathString for path in targets)}

    def AddBindings(self, prim, names):
        """Takes the material bindings authored on `prim` over (this state is still private)."""
        bindings = dict(self.bindings)
        for name in names:
            if not name.startswith(BINDING):
                continue
            if name.startswith(f"{BINDING}:collection"):
                self.hasCollections = True
                continue
            purpose = name[len(BINDING):]
            inherited = bindings.get(purpose)
            if inherited and inherited[1] == _STRONGER:
                continue
            relationship = prim.GetRelationship(name)
            targets = relationship.GetTargets() if relationship else []
            if targets:
                strength = relationship.GetMetadata("bindMaterialAs") or ""
                bindings[purpose] = (targets[0].pathString, strength)
        self.bindings = bindings


class Context:
    """A space that prims are placed in: the world, or the prototypes of one instancer."""

    def __init__(self, instancerPath="", instances=None, chain=(), passOfInstancer=None, passByInstance=frozenset()):
        self.instancerPath = instancerPath  # scene path of the instancer; empty: the world
        self.instances = instances          # int32: those of its instances that place what is here
        self.isPlacing = False              # some prim is placed here
        self.instanceGroups = {}            # key -> InstanceGroup: native instances found here
        self.standInGroups = {}             # the same of instances that a draw mode replaces
        self.contextsByDrawMode = {}        # draw mode -> Context: collects the instances that inherit it
        self.chain = chain                  # USD paths of the point instancers around
        self.passOfInstancer = passOfInstancer  # OfInstancer of the point instancer around; None: there is none, or no pass
        self.passByInstance = passByInstance    # names of primvars by which the pass tells the native instances around apart
        # Below an `over` nothing is defined; the prototypes of point instancers may be there.
        self.predicate = PROTOTYPE_PREDICATE if chain else PREDICATE

    def OfDrawMode(self, drawMode):
        """Where instances that inherit a draw mode are grouped: below them others may be replaced."""
        if not drawMode:
            return self
        found = self.contextsByDrawMode.get(drawMode)
        if found is None:
            found = Context(self.instancerPath, self.instances, self.chain, self.passOfInstancer, self.passByInstance)
            self.contextsByDrawMode[drawMode] = found
        return found

    def ScenePath(self, prim):
        """The prim's path in the scene: USD's, named after the instancer where it lies outside of it."""
        path = PathText(prim)
        if not self.instancerPath or path.startswith(self.instancerPath + "/"):
            return path
        return f"{self.instancerPath}{{{path}}}"
