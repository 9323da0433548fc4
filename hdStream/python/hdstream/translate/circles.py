# SPDX-License-Identifier: Apache-2.0
"""Point instancers that are among what they place. OpenUSD asks for the bounds of such prims until the stack is full."""

from pxr import Usd, UsdGeom

from hdstream.diagnostics import TfError

_PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)


def HasCircularInstancers(stage):
    """Whether some point instancer is its own prototype, or below one, directly or through others."""
    instancers = [prim for prim in Usd.PrimRange.Stage(stage, _PREDICATE) if prim.IsA(UsdGeom.PointInstancer)]
    below = {}  # path -> instancers at or below it
    for prim in instancers:
        for path in prim.GetPath().GetPrefixes():
            below.setdefault(path, []).append(prim.GetPath())
    placed = {prim.GetPath(): [found for target in _Prototypes(prim) for found in below.get(target, ())] for prim in instancers}
    # What places nothing that is left cannot be part of a circle.
    isChanged = True
    while isChanged:
        ended = [path for path, others in placed.items() if not any(other in placed for other in others)]
        for path in ended:
            del placed[path]
        isChanged = bool(ended)
    return bool(placed)


def _Prototypes(prim):
    try:
        return prim.GetRelationship("prototypes").GetTargets()
    except TfError:  # an attribute; the translator says so
        return []
