# SPDX-License-Identifier: Apache-2.0
"""Mesh lights are linked by the collections of their meshes, as other lights by their own."""

from translateCase import StageOf, Translate

_FACE = "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\nint[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]"


def _LinksOf(text):
    """What the meshes of a scene are not lit by, and cast no shadows of."""
    found, path = {}, ""
    for line in Translate(StageOf(text)).Dump().splitlines():
        path = line.removeprefix("mesh ") if not line.startswith(" ") else path
        name, _, value = line.strip().partition(": ")
        if name in ("unlit by", "no shadows of"):
            found.setdefault(path, {})[name] = value
    return found


def test_collections_of_mesh_lights():
    """Meshes that come before and after the light; a collection that holds everything is none."""
    lamp = f'def Mesh "Lamp" (prepend apiSchemas = ["MeshLightAPI"]) {{ {_FACE}\n%s }}\n'
    others = f'def Mesh "A" {{ {_FACE} }}\ndef Mesh "Z" {{ {_FACE} }}\n'
    assert _LinksOf(others + lamp % "rel collection:lightLink:excludes = </A>\nrel collection:shadowLink:excludes = </Z>") == {
        "/A": {"unlit by": "/Lamp"}, "/Z": {"no shadows of": "/Lamp"}}
    assert _LinksOf(others + lamp % "uniform bool collection:lightLink:includeRoot = 0\nrel collection:lightLink:includes = </A>") == {
        "/Lamp": {"unlit by": "/Lamp"}, "/Z": {"unlit by": "/Lamp"}}
    assert _LinksOf(others + lamp % "uniform bool collection:lightLink:includeRoot = 1") == {}
