# SPDX-License-Identifier: Apache-2.0
"""The registry of pattern nodes against the pages that list them and against the package MaterialX's definitions."""

import pathlib
import re

import pytest

from hdstream import _core

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def test_the_page_lists_the_nodes_that_there_are():
    page = (ROOT / "docs/materials.md").read_text(encoding="utf-8")
    rows = re.search(r"^\| group \| nodes \|\n\|[-|]*\n((?:\|.*\n)+)", page, re.MULTILINE)[1]
    listed = [name.strip().removesuffix("_*") for row in rows.splitlines() for name in row.split("|")[2].split(",")]
    assert sorted(listed) == _core.PatternNames()


def test_their_number_is_right():
    number = len(_core.PatternNames())
    assert f"There are {number} pattern nodes." in (ROOT / "docs/materials.md").read_text(encoding="utf-8")
    assert f"more than {(number - 1) // 10 * 10} pattern nodes" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_ids_are_known_by_the_names_of_their_nodes():
    materialX = pytest.importorskip("MaterialX")
    library = materialX.createDocument()
    materialX.loadLibraries(materialX.getDefaultDataLibraryFolders(), materialX.getDefaultDataSearchPath(), library)
    names = set(_core.PatternNames())
    closures = set(_core.ClosureIds())
    definitions = [d for d in library.getNodeDefs() if "shader" not in d.getType() and d.getType() != "material"]
    wrong = [d.getName() for d in definitions if _core.IsKnownShader(d.getName()) != (d.getNodeString() in names or d.getName() in closures)]
    assert len(definitions) > 500 and not wrong
    # Of other versions of MaterialX than the package's; files have them.
    assert names - {d.getNodeString() for d in library.getNodeDefs()} <= {"swizzle", "mincomponent", "maxcomponent"}


def test_closures_are_those_of_the_library():
    materialX = pytest.importorskip("MaterialX")
    library = materialX.createDocument()
    materialX.loadLibraries(materialX.getDefaultDataLibraryFolders(), materialX.getDefaultDataSearchPath(), library)
    page = (ROOT / "docs/materials.md").read_text(encoding="utf-8")
    for identifier in _core.ClosureIds():
        definition = library.getNodeDef(identifier)
        assert definition and definition.getType() in ("BSDF", "EDF", "VDF"), identifier
        assert f"`{definition.getNodeString()}`" in page, identifier


def test_ids_without_a_prefix_are_of_usd_alone():
    assert all(map(_core.IsKnownShader, ("UsdUVTexture", "UsdPrimvarReader_float2", "UsdTransform2d", "UsdPreviewSurface")))
    assert not any(map(_core.IsKnownShader, ("mix", "mix_color3", "", "ND_", "ND_mixed_color3", "UsdUVTextures")))
