# SPDX-License-Identifier: Apache-2.0
"""Draw modes of models: usdrecord with the plug-in draws the cards of `hdstream record`, to the bit."""

import pathlib

import pytest

from drawModeStage import WriteDrawModeStage
from dumpStage import DumpStage
from frontEnds import MODES, CompareDumps, ComparePictures, FrontEnds, ReadColor
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
    """Scene indices call the mesh of a card `cardsMesh`, below the model; so its dump is another one."""
    if not isStream:
        pytest.skip("only Stream writes dumps")
    wrapper = Prepare(tmp_path, frontEnds.mode)
    ours, theirs = tmp_path / "record.exr", tmp_path / "hydra.exr"
    record = frontEnds.RecordHere(wrapper, ours)
    assert record.code == 0, record.output
    hydra = frontEnds.RunUsdrecord(wrapper, theirs, tmp_path / "hydra.txt")
    assert hydra.code == 0, hydra.output
    assert ReadColor(theirs)[..., :3].max() > 0.0
    dump, _ = DumpStage(wrapper.path)
    if frontEnds.mode == "legacy":
        differences = CompareDumps(dump, (tmp_path / "hydra.txt").read_text(), wrapper.purposes)
        assert not differences, "\n".join(differences)
    assert ComparePictures(ours, theirs).isEqual, ComparePictures(ours, theirs)
    # Nobody misses the materials of bare cards.
    assert "does not exist" not in record.output + hydra.output
