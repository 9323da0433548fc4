# SPDX-License-Identifier: Apache-2.0
"""Light and shadow links: the collections of lights that leave something out, as categories.

A category is named by its collection's path. What the collections hold is asked when all lights are
known, and only on stages that have such lights.
"""

from pxr import Usd, UsdGeom

from hdstream import _core
from hdstream.translate.primState import PREDICATE

_COLLECTIONS = ("lightLink", "shadowLink")


class Links:
    """The links of a stage's lights."""

    def __init__(self):
        self._queries = {}  # category -> membership query

    def CategoryOf(self, light, names, collection):
        """The category of a light's collection; empty when it holds everything."""
        prefix = f"collection:{collection}"
        if not any(name.startswith(prefix) for name in names):
            return ""
        api = Usd.CollectionAPI(light, collection)
        query = api.ComputeMembershipQuery()
        isAll = query.IsPathIncluded(light.GetStage().GetPseudoRoot().GetPath()) and not query.HasExcludes()
        if isAll and query.UsesPathExpansionRuleMap():
            return ""
        category = api.GetCollectionPath().pathString
        self._queries[category] = query
        return category

    def Read(self, light, names):
        """What a light is linked to."""
        return _core.LinkCategories(*(self.CategoryOf(light, names, collection) for collection in _COLLECTIONS))

    def CategoriesOf(self, path):
        """The categories that hold the prim of a path."""
        return {category for category, query in self._queries.items() if query.IsPathIncluded(path)}

    def KeyOf(self, instance):
        """What tells native instances apart: the categories of the gprims below."""
        if not self._queries:
            return ()
        return tuple(tuple(sorted(self.CategoriesOf(child.GetPath())))
                     for child in Usd.PrimRange(instance, PREDICATE) if child.IsA(UsdGeom.Gprim))

    @property
    def areUsed(self):
        return bool(self._queries)
