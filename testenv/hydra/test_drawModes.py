# SPDX-License-Identifier: Apache-2.0
"""Draw modes of models: usdrecord with the plug-in draws the cards of `hdstream record`, to the bit."""

import pathlib

import pytest

from drawModeStage import WriteDrawModeStage
from frontEnds import MODES, CheckDifferences, CompareFrontEnds, FrontEnds, ReadColor
from wrapperStage import WriteWrapper

TEXTURES = pathlib.Path(__file__).resolve().parents[1] / "translate" / "drawModes"


@pytest.fixture(params=MODES)
def frontEnds(request, openUsd, plugin, renderer):
    return FrontEnds(openUsd, plugin, renderer, request.param)


def Prepare(folder, mode):
    WriteDrawModeStage(folder / "scene.usda", TEXTURES, hasInstances=mode == "legacy")
    return WriteWrapper(folder / "scene.usda", folder / "wrapper.usda", 96, mode=mode, samples=4, maxDepth=3, seed=7,
                        noCache=True)


def test_cards_are_those_of_hdstream_record(frontEnds, isStream, tmp_path):
    """Scene indices call the mesh of a card `cardsMesh`, below the model; so its dump is another one, as is known."""
    if not isStream:
        pytest.skip("only Stream writes dumps")
    wrapper = Prepare(tmp_path, frontEnds.mode)
    differences, output = CompareFrontEnds(frontEnds, wrapper, tmp_path)
    assert ReadColor(tmp_path / "hydra.exr")[..., :3].max() > 0.0
    CheckDifferences(differences, frontEnds.openUsd.version, frontEnds.mode, "cards")
    # Nobody misses the materials of bare cards.
    assert "does not exist" not in output
