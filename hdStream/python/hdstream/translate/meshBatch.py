# SPDX-License-Identifier: Apache-2.0
"""Meshes that wait for their materials: those of all prims of a stage are found by one call."""

from hdstream.translate.materials import FindBoundMaterials


class MeshBatch:
    """Meshes on their way into a session."""

    def __init__(self, session, warn):
        self._session = session
        self._warn = warn
        self._entries = []  # (scene path, prim, MeshPrim, [(MeshSubset, prim)])

    def Add(self, path, prim, meshPrim, subsets):
        self._entries.append((path, prim, meshPrim, subsets))

    def Flush(self):
        """Binds materials and hands the meshes over; returns the bound material prims by path."""
        prims = []
        for _, prim, _, subsets in self._entries:
            prims.append(prim)
            prims.extend(child for _, child in subsets)
        paths, primByPath = FindBoundMaterials(prims, self._warn)
        bound = iter(paths)
        for path, _, meshPrim, subsets in self._entries:
            meshPrim.materialPath = next(bound)
            for subset, _ in subsets:
                subset.materialPath = next(bound)
            if subsets:
                meshPrim.mesh.subsets = [subset for subset, _ in subsets]
            self._session.SetMesh(path, meshPrim)
        self._entries.clear()
        return primByPath
