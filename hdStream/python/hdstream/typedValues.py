# SPDX-License-Identifier: Apache-2.0
"""Values of schema attributes. OpenUSD hands out whatever a layer holds, also where a schema has another type."""

from pxr import Usd


def TypedValue(attribute, time=Usd.TimeCode.Default()):
    """The authored value of an attribute in its schema's type; None without one. Raises TypeError, with a text, for a value that
    cannot be of that type."""
    value = attribute.Get(time) if attribute and attribute.HasAuthoredValue() else None
    if value is None:
        return None
    like = attribute.GetTypeName().defaultValue
    try:
        return _As(like, value)
    except (TypeError, ValueError, RuntimeError):
        raise TypeError(f"cannot be a {attribute.GetPropertyStack(time)[0].typeName}") from None


def _As(like, value):
    kind = type(like)
    if isinstance(value, kind):
        return value
    if isinstance(like, bool) and isinstance(value, int) or isinstance(like, float) and isinstance(value, (int, float)):
        return kind(value)
    if hasattr(like, "dimension"):
        return kind(*value)
    raise TypeError


def MistypedValues(prim, time):
    """A line for each authored value of a prim that cannot be of its attribute's type."""
    lines = []
    for attribute in prim.GetAuthoredAttributes():
        try:
            TypedValue(attribute, time)
        except TypeError as error:
            lines.append(f"{attribute.GetName()} {error}")
    return lines
