# SPDX-License-Identifier: Apache-2.0
"""Geometry that waits for its materials: those of many prims are found by one call.

It is handed over while the stage is walked, so that of each prim there are several objects of Python for a short time alone.
What it is linked to is known when all lights are.
"""

from hdstream.translate.materials import BoundMaterials


_AT_ONCE = 16384  # prims: enough for UsdShade to share its caches between


class GeometryBatch:
    """Geometry on its way into a session."""

    def __init__(self, session, links, warn):
        self._session = session
        self._links = links
        self._warn = warn
        self._entries = []  # (scene path, prim, GeometryPrim, prims of its subsets, bindings)
        self._handedOver = []  # scene paths; with the prim's path where that is another
        self._inherited = {}  # id of bindings -> (bindings, BoundMaterial of what inherits them)
        self._primByPath = {}  # of the bound materials

    def Add(self, path, prim, geometryPrim, subsetPrims, bindings):
        """`bindings`: those of a State that alone tell which material is bound to the prim; None: it has others too."""
        self._entries.append((path, prim, geometryPrim, subsetPrims, bindings))
        if len(self._entries) >= _AT_ONCE:
            self._HandOver()

    def AddStandIn(self, path, prim, geometryPrim):
        """What is drawn in place of `prim`, with materials of its own."""
        self._session.SetGeometry(path, geometryPrim)
        self._handedOver.append((path, prim.GetPath()))

    def AddVolume(self, path, prim):
        """A volume that is in the session already: its links too are found at the end."""
        self._NoteHandedOver(path, prim)

    def Flush(self):
        """Hands over what is left and finds links; returns the bound material prims by path."""
        self._HandOver()
        if self._links.areUsed:
            for entry in self._handedOver:
                path, primPath = entry if isinstance(entry, tuple) else (entry, entry)
                self._session.SetCategories(path, self._links.CategoriesOf(primPath))
        found = self._primByPath
        self._handedOver, self._inherited, self._primByPath = [], {}, {}
        return found

    def _HandOver(self):
        entries, self._entries = self._entries, []
        self._FindInherited(entries)
        own = []
        for _, prim, _, subsetPrims, bindings in entries:
            if bindings is None:
                own.append(prim)
            own.extend(subsetPrims)
        ofOwn = iter(BoundMaterials(own, self._warn))
        for path, prim, geometryPrim, subsetPrims, bindings in entries:
            bound = next(ofOwn) if bindings is None else self._inherited[id(bindings)][1]
            geometryPrim.materialPath = self._PathOf(bound, prim)
            if subsetPrims:
                geometryPrim.subsetMaterialPaths = [self._PathOf(next(ofOwn), subset) for subset in subsetPrims]
            self._session.SetGeometry(path, geometryPrim)
            self._NoteHandedOver(path, prim)

    def _NoteHandedOver(self, path, prim):
        self._handedOver.append((path, prim.GetPath()) if "{" in path else path)

    def _FindInherited(self, entries):
        """What prims inherit with bindings that were not met before: the first prim of each stands for all."""
        firsts = {}
        for _, prim, _, _, bindings in entries:
            if bindings is not None and id(bindings) not in self._inherited:
                firsts.setdefault(id(bindings), (prim, bindings))
        found = BoundMaterials([prim for prim, _ in firsts.values()], self._warn)
        for (key, (_, bindings)), bound in zip(firsts.items(), found):
            self._inherited[key] = (bindings, bound)  # kept, so that no others get its id

    def _PathOf(self, bound, prim):
        if bound.missing:
            self._warn(prim, f"bound material {bound.missing} does not exist")
        if bound.prim:
            self._primByPath[bound.path] = bound.prim
        return bound.path
