# SPDX-License-Identifier: Apache-2.0
"""The collections of a UsdRenderPass: which prims a pass removes, hides, hides from the camera and cuts out.

Members are asked by path, as UsdCollectionAPI says, path expressions included. `renderVisibility` and `cameraVisibility` hold
what is seen, `prune` and `matte` what is taken away. What a point instancer draws has the instancer's own membership, and that
of its prototypes' prims where these lie below the instancer; prims that are pruned are nowhere. Native instances are told
apart by what is a member below them. hdStream/hydra/passSceneIndex.cpp does the same in Hydra.
"""

import bisect
import dataclasses

import numpy as np
from pxr import Sdf, Usd

from hdstream import _core
from hdstream.translate.primState import PREDICATE
from hdstream.translate.primvars import InheritedPrimvar

# Names of the core's own: what a pass takes away, whatever other primvars say.
_SEEN_BY_CAMERA = "hdstream:pass:camera"
_MATTE = "hdstream:pass:matte"


@dataclasses.dataclass(frozen=True)
class Membership:
    """What a pass does to a prim that it does not prune."""

    isRendered: bool = True
    isSeenByCamera: bool = True
    isMatte: bool = False

    def Within(self, other):
        """Of a prim that `other` places."""
        return Membership(self.isRendered and other.isRendered, self.isSeenByCamera and other.isSeenByCamera,
                          self.isMatte or other.isMatte)

    def Apply(self, geometryPrim):
        """Says it to the core, as primvars of the prim."""
        values = {}
        if not self.isSeenByCamera:
            values[_SEEN_BY_CAMERA] = 0.0
        if self.isMatte:
            values[_MATTE] = 1.0
        if values:
            geometry = geometryPrim.geometry
            # Geometry that is kept from before has them already.
            geometry.primvars = [primvar for primvar in geometry.primvars if primvar.name not in values] + [
                _Primvar(name, value) for name, value in sorted(values.items())]


_NOTHING_DONE = Membership()


def _Primvar(name, value):
    return _core.Primvar(name, _core.Interpolation.Constant, np.array([value], np.float32))


@dataclasses.dataclass(frozen=True)
class OfInstancer:
    """What a pass does to all that a point instancer draws, and whether the paths of its prototype say more."""

    membership: Membership
    asksPaths: bool


class _Members:
    """A collection that is neither empty nor everything."""

    def __init__(self, query):
        self._query = query
        # Sorted texts; None: an expression, which may say something of every prim by itself.
        self._rules = (sorted(f"{path}/" for path in query.GetAsPathExpansionRuleMap())
                       if query.UsesPathExpansionRuleMap() else None)

    def Hold(self, path):
        return bool(self._query.IsPathIncluded(path))

    def Below(self, prim):
        """Whether all below a prim is held, none of it, or each thing for itself: True, False, or a tuple."""
        path = prim.GetPath()
        prefix = f"{path}/"
        if self._rules is not None:
            rule = bisect.bisect_right(self._rules, prefix)
            if rule == len(self._rules) or not self._rules[rule].startswith(prefix):
                return self.Hold(path.AppendChild("any"))
        return tuple(self.Hold(child.GetPath()) for child in Usd.PrimRange(prim, PREDICATE) if child != prim)


def _MembersOf(prim, name, isAllUsual):
    """The members of a pass's collection; None where it does nothing."""
    api = Usd.CollectionAPI(prim, name)
    if not prim.HasAPI(Usd.CollectionAPI, name) and not any(
            text.startswith(f"collection:{name}:") for text in prim.GetAuthoredPropertyNames()):
        return None
    query = api.ComputeMembershipQuery()
    if query.UsesPathExpansionRuleMap():
        rules = query.GetAsPathExpansionRuleMap()
        usual = {Sdf.Path.absoluteRootPath: Usd.Tokens.expandPrims} if isAllUsual else {}
        if dict(rules) == usual:
            return None
    return _Members(query)


class PassCollections:
    """Membership in the collections of one render pass, on a stage as it is. Used by one traversal."""

    def __init__(self, prim):
        self._rendered = _MembersOf(prim, "renderVisibility", True)
        self._seen = _MembersOf(prim, "cameraVisibility", True)
        self._matte = _MembersOf(prim, "matte", False)
        self._pruned = _MembersOf(prim, "prune", False)

    def IsPruned(self, prim):
        return self._pruned is not None and self._pruned.Hold(prim.GetPath())

    def IsPrunedWithin(self, prim):
        """Whether a prim is pruned itself, or with one above it."""
        while self._pruned is not None and prim and not prim.IsPseudoRoot():
            if self.IsPruned(prim):
                return True
            prim = prim.GetParent()
        return False

    def Of(self, prim, context):
        """What happens to a prim, in a Context of a traversal."""
        if context.passByInstance:
            own = self._Own(prim.GetPath())
            return Membership(own.isRendered, own.isSeenByCamera or _SEEN_BY_CAMERA in context.passByInstance,
                              own.isMatte and _MATTE not in context.passByInstance)
        outer = context.passOfInstancer
        if outer is None:
            return self._Own(prim.GetPath())
        return self._Own(prim.GetPath()).Within(outer.membership) if outer.asksPaths else outer.membership

    def InPrototype(self, instancer, root, state, context):
        """What holds in a prototype of a point instancer with a State, in its Context."""
        isBelow = root.GetPath().HasPrefix(instancer.GetPath())
        return OfInstancer(state.ofPass, isBelow and (context.passOfInstancer is None or context.passOfInstancer.asksPaths))

    def _Own(self, path):
        found = Membership(self._rendered is None or self._rendered.Hold(path), self._seen is None or self._seen.Hold(path),
                           self._matte is not None and self._matte.Hold(path))
        return _NOTHING_DONE if found == _NOTHING_DONE else found

    def KeyBelow(self, instance, context):
        """Equal for native instances of a prototype in which the pass does the same; None: it draws nothing below."""
        if context.passOfInstancer and not context.passOfInstancer.asksPaths:
            return (self._pruned.Below(instance),) if self._pruned else ()
        key = tuple(members.Below(instance) if members else () for members in (
            self._rendered, self._seen, self._matte, self._pruned))
        isHidden = self._rendered is not None and not (any(key[0]) if isinstance(key[0], tuple) else key[0])
        return None if isHidden else key

    def ByInstance(self, state, key, context):
        """What a key says of an instance as a whole becomes primvars that it inherits, so that instances which differ in it
        share an instancer and their geometry. Returns (state, key, names of these primvars)."""
        if len(key) != 4 or context.passOfInstancer is not None:
            return state, key, frozenset()
        key, values = list(key), {}
        for place, name in ((1, _SEEN_BY_CAMERA), (2, _MATTE)):
            if isinstance(key[place], bool):
                values[name] = float(key[place])
                key[place] = ()
        if values:
            state = state.Copy()
            state.primvars = {**state.primvars, **{
                name: InheritedPrimvar(_Primvar(name, value), (name, value)) for name, value in values.items()}}
        return state, tuple(key), frozenset(values)

    @staticmethod
    def DropUsual(primvars, names):
        """Without those of `names` that all instances have and that take nothing away."""
        usual = {_SEEN_BY_CAMERA: 1.0, _MATTE: 0.0}
        return {name: entry for name, entry in primvars.items() if name not in names or entry.key[1] != usual[name]}
