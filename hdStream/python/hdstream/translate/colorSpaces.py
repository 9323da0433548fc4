# SPDX-License-Identifier: Apache-2.0
"""Colour spaces of attributes, by their names, as UsdColorSpaceAPI finds them: that of the attribute, else that of its prim
or of the nearest ancestor which has the schema. Nothing is converted here.

The schema is read by its name, so that a usd-core that does not know it yet reads it too.
"""

_SCHEMA = "ColorSpaceAPI"
_NAME = "colorSpace:name"
_ofAncestors = {}  # prim -> name, "" where there is none


def Forget():
    """Stages may have been edited since: prims are asked again."""
    _ofAncestors.clear()


def ColorSpaceOf(attribute):
    """The name of an attribute's colour space; "" where none is authored."""
    if attribute.HasColorSpace():
        return attribute.GetColorSpace()
    return _OfPrim(attribute.GetPrim())


def ColorSpaceOfColor(attribute):
    """As ColorSpaceOf; what is no colour by its type has only a space of its own."""
    if attribute.HasColorSpace():
        return attribute.GetColorSpace()
    return _OfPrim(attribute.GetPrim()) if attribute.GetRoleName() == "Color" else ""


def _OfPrim(prim):
    """Its own, else that of its ancestors. Those are remembered; prims with attributes may be millions."""
    attribute = prim.GetAttribute(_NAME) if _SCHEMA in prim.GetAppliedSchemas() else None
    return (attribute.Get() if attribute else None) or _OfAncestor(prim.GetParent())


def _OfAncestor(prim):
    if not prim or prim.IsPseudoRoot():
        return ""
    space = _ofAncestors.get(prim)
    if space is None:
        space = _ofAncestors[prim] = _OfPrim(prim)
    return space
