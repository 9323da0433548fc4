# SPDX-License-Identifier: Apache-2.0
"""Meshes that wait for their materials: those of all prims of a stage are found by one call."""

from hdstream.translate.materials import FindBoundMaterials


class MeshBatch:
    """Meshes on their way into a session."""

    def __init__(self, session, links, warn):
        self._session = session
        self._links = links
        self._warn = warn
        self._entries = []  # (scene path, prim, GeometryPrim, prims of its subsets)

    def Add(self, path, prim, meshPrim, subsetPrims):
        self._entries.append((path, prim, meshPrim, subsetPrims))

    def Flush(self):
        """Binds materials, finds links and hands the meshes over; returns the bound material prims by path."""
        prims = []
        for _, prim, _, subsetPrims in self._entries:
            prims.append(prim)
            prims.extend(subsetPrims)
        paths, primByPath = FindBoundMaterials(prims, self._warn)
        bound = iter(paths)
        for path, prim, meshPrim, subsetPrims in self._entries:
            if self._links.areUsed:
                meshPrim.categories = self._links.CategoriesOf(prim.GetPath())
            meshPrim.materialPath = next(bound)
            if subsetPrims:
                meshPrim.subsetMaterialPaths = [next(bound) for _ in subsetPrims]
            self._session.SetMesh(path, meshPrim)
        self._entries.clear()
        return primByPath
