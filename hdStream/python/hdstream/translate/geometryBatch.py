# SPDX-License-Identifier: Apache-2.0
"""Geometry that waits for its materials: those of many prims are found by one call."""

from hdstream.translate.materials import FindBoundMaterials


_AT_ONCE = 16384  # prims: enough for UsdShade to share its caches between


class GeometryBatch:
    """Geometry on its way into a session."""

    def __init__(self, session, links, warn):
        self._session = session
        self._links = links
        self._warn = warn
        self._entries = []  # (scene path, prim, GeometryPrim, prims of its subsets)

    def Add(self, path, prim, geometryPrim, subsetPrims):
        self._entries.append((path, prim, geometryPrim, subsetPrims))

    def Flush(self):
        """Binds materials, finds links and hands the prims over; returns the bound material prims by path."""
        primByPath = {}
        entries, self._entries = self._entries, []
        entries.reverse()  # what is handed over leaves memory: of each prim there are several objects of Python
        while entries:
            piece = entries[:-_AT_ONCE - 1:-1]
            del entries[-_AT_ONCE:]
            primByPath.update(self._HandOver(piece))
        return primByPath

    def _HandOver(self, entries):
        prims = []
        for _, prim, _, subsetPrims in entries:
            prims.append(prim)
            prims.extend(subsetPrims)
        paths, primByPath = FindBoundMaterials(prims, self._warn)
        bound = iter(paths)
        for path, prim, geometryPrim, subsetPrims in entries:
            if self._links.areUsed:
                geometryPrim.categories = self._links.CategoriesOf(prim.GetPath())
            geometryPrim.materialPath = next(bound)
            if subsetPrims:
                geometryPrim.subsetMaterialPaths = [next(bound) for _ in subsetPrims]
            self._session.SetGeometry(path, geometryPrim)
        return primByPath
