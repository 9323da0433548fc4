# SPDX-License-Identifier: Apache-2.0
"""The inputs of MaterialX's surfaces, their types and defaults, against the package MaterialX's definitions."""

import pytest

from hdstream import _core

_COMPONENTS = {"float": 1, "integer": 1, "boolean": 1, "color3": 3}


@pytest.mark.parametrize("identifier", ["ND_standard_surface_surfaceshader", "ND_open_pbr_surface_surfaceshader",
                                        "ND_gltf_pbr_surfaceshader", "ND_surface_unlit"])
def test_inputs_are_those_of_the_definition(identifier):
    materialX = pytest.importorskip("MaterialX")
    library = materialX.createDocument()
    materialX.loadLibraries(materialX.getDefaultDataLibraryFolders(), materialX.getDefaultDataSearchPath(), library)
    definition = library.getNodeDef(identifier)
    inputs = _core.SurfaceInputs(identifier)
    assert len(inputs) >= 4 and len({name for name, *_ in inputs}) == len(inputs)
    for name, components, default in inputs:
        defined = definition.getActiveInput(name)
        assert defined and _COMPONENTS[defined.getType()] == components, name
        values = {"true": "1", "false": "0", "": "0"}.get(defined.getValueString(), defined.getValueString())
        assert [float(value) for value in values.split(",")] == pytest.approx(default), name
