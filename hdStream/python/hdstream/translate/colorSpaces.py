# SPDX-License-Identifier: Apache-2.0
"""Colour spaces of attributes, by their names, as UsdColorSpaceAPI finds them: that of the attribute, else that of its prim
or of the nearest ancestor which has the schema. Nothing is converted here.

Spaces that a stage defines (UsdColorSpaceDefinitionAPI) are named by what they are made of, as the core reads them
(texture/colorConfig.h). Schemas are read by their names, so that a usd-core that does not know them yet reads them too.
"""

from pxr import Gf

from hdstream.translate.usdCalls import (
    GetAppliedSchemas, GetColorSpace, GetParent, GetPrimOf, GetRoleName, HasColorSpace)

_SCHEMA = "ColorSpaceAPI"
_NAME = "colorSpace:name"
_DEFINITION = "ColorSpaceDefinitionAPI:"
_FALLBACKS = (("redChroma", (1.0, 0.0)), ("greenChroma", (0.0, 1.0)), ("blueChroma", (0.0, 0.0)), ("whitePoint", (1 / 3, 1 / 3)),
              ("gamma", 1.0), ("linearBias", 0.0))
_ofAncestors = {}  # prim -> name, "" where there is none
_definitions = {}  # prim -> {name: what it is made of}, of the prim and its ancestors


def Forget():
    """Stages may have been edited since: prims are asked again."""
    _ofAncestors.clear()
    _definitions.clear()


def ColorSpaceOf(attribute):
    """The name of an attribute's colour space; "" where none is authored."""
    prim = attribute.GetPrim()
    return _Defined(prim, attribute.GetColorSpace() if attribute.HasColorSpace() else _OfPrim(prim))


def ColorSpaceOfColor(attribute, prim=None):
    """As ColorSpaceOf, of an attribute of `prim`; what is no colour by its type has only a space of its own."""
    if HasColorSpace(attribute):
        return _Defined(GetPrimOf(attribute), GetColorSpace(attribute))
    if GetRoleName(attribute) != "Color":
        return ""
    prim = GetPrimOf(attribute) if prim is None else prim
    name = _OfPrim(prim)
    return _Defined(prim, name) if name else ""


def _Defined(prim, name):
    """A name, or what the nearest definition of it makes of it. Names of OpenUSD's own cannot be defined anew."""
    if not name or (hasattr(Gf, "ColorSpace") and Gf.ColorSpace.IsValid(name)):
        return name
    return _DefinitionsAt(prim).get(name, name)


def _DefinitionsAt(prim):
    if not prim or prim.IsPseudoRoot():
        return {}
    found = _definitions.get(prim)
    if found is None:
        found = _DefinitionsAt(prim.GetParent())
        own = [schema[len(_DEFINITION):] for schema in prim.GetAppliedSchemas() if schema.startswith(_DEFINITION)]
        if own:
            found = dict(found, **{_Value(prim, instance, "name", "custom"): _Numbers(prim, instance) for instance in own})
        _definitions[prim] = found
    return found


def _Value(prim, instance, name, fallback):
    attribute = prim.GetAttribute(f"colorSpaceDefinition:{instance}:{name}")
    value = attribute.Get() if attribute else None
    return fallback if value is None else value


def _Numbers(prim, instance):
    values = [_Value(prim, instance, name, fallback) for name, fallback in _FALLBACKS]
    numbers = [float(number) for pair in values[:4] for number in pair] + [float(value) for value in values[4:]]
    return "primaries:" + " ".join(f"{number:.9g}" for number in numbers)


def _OfPrim(prim):
    """Its own, else that of its ancestors. Those are remembered; prims with attributes may be millions."""
    attribute = prim.GetAttribute(_NAME) if _SCHEMA in GetAppliedSchemas(prim) else None
    return (attribute.Get() if attribute else None) or _OfAncestor(GetParent(prim))


def _OfAncestor(prim):
    space = _ofAncestors.get(prim)
    if space is None:
        space = _ofAncestors[prim] = "" if not prim or prim.IsPseudoRoot() else _OfPrim(prim)
    return space
