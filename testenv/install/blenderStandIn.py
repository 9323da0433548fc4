# SPDX-License-Identifier: Apache-2.0
"""As much of Blender's module bpy as loading and drawing the extension's panels needs: every property records its words."""

import sys
import types


class Property:
    """What a function of bpy.props was called with."""

    def __init__(self, kind, words):
        self.kind, self.words = kind, words


class _Struct:
    """Base of panels, property groups and engines."""


class Layout:
    """Records which properties are drawn: `drawn` is shared by all its parts."""

    def __init__(self, drawn):
        self.drawn = drawn

    def prop(self, data, name, **_):
        self.drawn.append((data, name))

    def row(self, **_):
        return self

    column = row


def _Props():
    module = types.ModuleType("bpy.props")
    for name in ("Bool", "Int", "Float", "String", "Enum", "Pointer", "Collection"):
        kind = f"{name}Property"
        setattr(module, kind, lambda kind=kind, **words: Property(kind, words))
    return module


def Install(monkeypatch):
    """`import bpy` gives the stand-in until the test ends; returns it."""
    bpy = types.ModuleType("bpy")
    bpy.props = _Props()
    bpy.types = types.SimpleNamespace(Panel=type("Panel", (_Struct,), {}), PropertyGroup=type("PropertyGroup", (_Struct,), {}),
                                      HydraRenderEngine=type("HydraRenderEngine", (_Struct,), {}), Scene=_Struct,
                                      ViewLayer=_Struct)
    bpy.utils = types.SimpleNamespace(register_classes_factory=lambda classes: (lambda: None, lambda: None))
    bpy.app = types.SimpleNamespace(version=(4, 5, 0))
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    return bpy
