# SPDX-License-Identifier: Apache-2.0
"""Paths of prims as texts, without SdfPath's own: it keeps the text of each path that it was asked for, which takes several times
as long as the rest and memory as long as the stage is open.
"""

from hdstream.translate.usdCalls import GetName, GetParent, GetPath

_ofParents = {}  # prim -> the text of its path, which those of its children begin with


def Forget():
    """Drops the prims that are known."""
    _ofParents.clear()


def PathText(prim):
    """`prim.GetPath().pathString` of a prim that is not the pseudo-root."""
    parent = GetParent(prim)
    text = _ofParents.get(parent)
    if text is None:
        text = _ofParents[parent] = GetPath(parent).pathString.rstrip("/")  # that of the pseudo-root is one
    return f"{text}/{GetName(prim)}"
