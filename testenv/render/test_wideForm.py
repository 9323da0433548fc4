# SPDX-License-Identifier: Apache-2.0
"""CPUs sample eight paths at once where they can (kernels/math/lanes.clh); the image has the bits that one path at a time gives.

There is no setting for it: the other picture is rendered with a copy of the kernels that has no form of eight paths.
"""

import pathlib
import shutil

import pytest

pytest.importorskip("hdstream._core")

import formStages
import ours

KERNELS = pathlib.Path(__file__).resolve().parents[2] / "kernels"
_AOVS = ("color", "alpha", "variance")
_SIZE = (61, 47)  # odd: batches of eight are not all full


@pytest.fixture(scope="module")
def Kernels(tmp_path_factory):
    """The folder of the kernels without the form of eight paths."""
    folder = tmp_path_factory.mktemp("form") / "kernels"
    shutil.copytree(KERNELS, folder)
    lanes = folder / "math" / "lanes.clh"
    text = lanes.read_text()
    switch = "#define HDS_WIDE (HDS_ITEMS_PER_WORK_ITEM >= HDS_LANES)"
    assert text.count(switch) == 1
    lanes.write_text(text.replace(switch, "#define HDS_WIDE 0"))
    return folder


@pytest.mark.parametrize("write", [formStages.EveryLight, formStages.Layered, formStages.Stacked, formStages.Media, formStages.Hair,
                                   formStages.Textured, formStages.ManyLights, formStages.FewShaped, formStages.Nested, formStages.Spaces,
                                   formStages.Displaced, formStages.InsideGlass, formStages.Smooth], ids=lambda write: write.__name__)
def test_form_does_not_matter(write, Kernels, tmp_path):
    path = f"{tmp_path}/stage.usda"
    write(path)
    settings = dict(aovs=list(_AOVS), samples=20, maxDepth=7, russianRoulette=True)
    picture = ours.Render(path, *_SIZE, **settings)
    assert picture.warnings == []
    assert picture.rgb.std() > 0.01
    expected = ours.RenderApart(path, *_SIZE, {"HDSTREAM_KERNEL_DIR": str(Kernels)}, **settings)
    for name in _AOVS:
        assert picture.layers[name].tobytes() == expected[name].tobytes(), f"layer {name} differs"
