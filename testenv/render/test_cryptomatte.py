# SPDX-License-Identifier: Apache-2.0
"""Cryptomattes, read back from files by a decoder of our own that shares nothing with the writer.

Oracles: the alpha of a render in which the object is alone, whose camera rays are the same to the bit; published values of
MurmurHash3. Blender's compositor is another: hydra/test_blender.py.
"""

import struct

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hdstream
from matteCase import ALL, HEIGHT, SAMPLES, WIDTH, Cryptomatte, Murmur, RenderMattes, WriteMatteStage

# MurmurHash3_x86_32 with seed 0, by other programs.
_HASHES = {"": 0, "test": 0xba6bd213, "Hello, world!": 0xc0363e43, "The quick brown fox jumps over the lazy dog": 0x2e4ff723,
           "a": 0x3c2569b2, "ab": 0x9bbfd75f, "abc": 0xb3dd93fa}


@pytest.fixture(scope="module", name="stage")
def MakeStage(tmp_path_factory):
    return WriteMatteStage(tmp_path_factory.mktemp("mattes") / "all.usda")


@pytest.fixture(scope="module", name="image")
def MakeImage(stage):
    return RenderMattes(stage, ("color", "alpha") + ALL)


@pytest.fixture(scope="module", name="file")
def MakeFile(image, tmp_path_factory):
    file = tmp_path_factory.mktemp("file") / "mattes.exr"
    assert not image.Write(file)
    return file


def _Alpha(tmp_path, *names):
    return RenderMattes(WriteMatteStage(tmp_path / "alone.usda", names), ("alpha",)).aovs["alpha"][..., 0]


def test_hash_of_the_tests_is_the_published_one():
    assert {text: Murmur(text) for text in _HASHES} == _HASHES


def test_coverages_add_up_to_alpha(file, image):
    alpha = image.aovs["alpha"][..., 0]
    assert 0.2 < alpha.mean() < 0.8 and ((alpha > 0) & (alpha < 1)).sum() > 100
    for name in ALL:
        assert np.allclose(Cryptomatte(file, name).Total(), alpha, atol=1e-6)


def test_what_lies_in_front_has_its_own_alpha(file, tmp_path):
    """A cut-out, out of focus."""
    matte = Cryptomatte(file, "crypto_object").Matte("/World/Card")
    assert 0.5 < np.median(matte[matte > 0]) < 0.9  # two sides, each half transparent
    assert np.array_equal(matte, _Alpha(tmp_path, "Card"))


def test_what_moves_behind_a_veil_takes_what_that_lets_through(file, tmp_path):
    mattes = Cryptomatte(file, "crypto_object")
    matte = mattes.Matte("/World/Mover")
    assert ((matte > 0) & (matte < 1)).sum() > 50
    both = _Alpha(tmp_path, "Card", "Mover")
    assert np.allclose(matte + mattes.Matte("/World/Card"), both, atol=1e-6)


def test_materials_of_faces_and_of_prims_are_told_apart(file):
    objects, materials = Cryptomatte(file, "crypto_object"), Cryptomatte(file, "crypto_material")
    assert set(materials.manifest) == {"/Looks/Veil", "/Looks/Red", "/Looks/Blue", "none"}
    assert np.allclose(materials.Matte("none"), objects.Matte("/World/Many/Prototypes/Small"), atol=1e-6)
    wall = materials.Matte("/Looks/Red") + materials.Matte("/Looks/Blue") - objects.Matte("/World/Mover")
    assert np.allclose(wall, objects.Matte("/World/Wall"), atol=1e-6)
    assert materials.Matte("/Looks/Blue").max() > 0.9


def test_instances_are_told_apart(file):
    objects, instances = Cryptomatte(file, "crypto_object"), Cryptomatte(file, "crypto_instance")
    small = "/World/Many/Prototypes/Small"
    single = [instances.Matte(f"{small}[{index}]") for index in range(3)]
    assert all(matte.max() > 0.5 for matte in single)
    assert np.allclose(sum(single), objects.Matte(small), atol=1e-6)
    assert np.allclose(instances.Matte("/World/Wall"), objects.Matte("/World/Wall"), atol=1e-6)


def test_ids_are_hashes_of_names_and_ranks_fall(file):
    for name in ALL:
        matte = Cryptomatte(file, name)
        for text, digits in matte.manifest.items():
            number = Murmur(text)
            if number >> 23 & 255 in (0, 255):
                number ^= 1 << 23
            assert int(digits, 16) == number and len(digits) == 8
            assert np.isfinite(struct.unpack("<f", struct.pack("<I", number))[0])
        assert len(matte.ranks) == 6
        for (_, larger), (_, smaller) in zip(matte.ranks, matte.ranks[1:]):
            assert (larger >= smaller).all()


@pytest.mark.parametrize("settings", [{"residency": "stream", "geometryMemory": "30%", "chunkBytes": 16384}, {"waveSize": 4096},
                                      {"residency": "stream", "geometryMemory": "30%", "chunkBytes": 16384, "waveSize": 1024},
                                      {"traversal": "scalar"}], ids=["pool", "waves", "slotsUsedAgain", "scalar"])
def test_bits_depend_on_nothing_else(stage, image, settings):
    other = RenderMattes(stage, ("color", "alpha") + ALL, **settings)
    assert other.headers == image.headers
    for name, pixels in image.aovs.items():
        assert pixels.tobytes() == other.aovs[name].tobytes(), name


def test_colour_has_the_bits_of_a_render_without(stage, image):
    assert image.aovs["color"].tobytes() == RenderMattes(stage, ("color",)).aovs["color"].tobytes()


def test_adaptive_pixels_have_coverages_of_their_own_samples(stage):
    image = RenderMattes(stage, ("alpha", "sampleCount", "crypto_object"), samples=96, noise=0.02)
    assert len(np.unique(image.aovs["sampleCount"])) > 1
    total = sum(image.aovs[f"crypto_object{layer:02}"][..., 1::2].sum(-1) for layer in range(3))
    assert np.allclose(total, image.aovs["alpha"][..., 0], atol=1e-6)


def test_an_opaque_background_is_of_colours_only(stage, image):
    opaque = RenderMattes(stage, ("color", "crypto_object"), opaqueBackground=True)
    assert (opaque.aovs["color"][..., 3] == 1.0).all()
    assert opaque.aovs["crypto_object00"].tobytes() == image.aovs["crypto_object00"].tobytes()


def test_single_layers(stage, image):
    """For hosts, which ask for one buffer after another."""
    alone = RenderMattes(stage, ("crypto_object01",))
    assert list(alone.aovs) == ["crypto_object01"]
    assert alone.aovs["crypto_object01"].tobytes() == image.aovs["crypto_object01"].tobytes()
    assert alone.headers["crypto_object01"] == image.headers["crypto_object00"]


def test_sums_without_counts_are_refused(stage):
    renderer = hdstream.Renderer(stage)
    values = {"imageWidth": WIDTH, "imageHeight": HEIGHT, "noCache": True, "maxDepth": 1, "domeVisible": False, "camera": "/World/Camera"}
    renderer.Prepare(1, samples=16, aovs=["color"], **values)
    sums = renderer.RenderSums()
    renderer.Prepare(1, samples=32, aovs=["crypto_object"], **values)
    with pytest.raises(hdstream.UsageError, match="without a Cryptomatte"):
        renderer.RenderPrepared(None, [sums])


def test_renders_go_on_from_sums(stage, image):
    renderer = hdstream.Renderer(stage)
    values = {"imageWidth": WIDTH, "imageHeight": HEIGHT, "noCache": True, "maxDepth": 1, "domeVisible": False, "camera": "/World/Camera"}
    renderer.Prepare(1, samples=16, aovs=["crypto_object"], **values)
    sums = renderer.RenderSums()
    renderer.Prepare(1, samples=SAMPLES, aovs=list(ALL), **values)
    again = renderer.RenderPrepared(None, [sums])
    for name, pixels in again.aovs.items():
        assert pixels.tobytes() == image.aovs[name].tobytes(), name


def test_of_instances_in_chunks(tmp_path):
    """What is said of prims lies in pages then, the largest ones apart, and both have other numbers."""
    stage = WriteMatteStage(tmp_path / "still.usda", ("Card", "Many", "Wall"))
    aovs = ("color", "primId", "primvars:displayColor") + ALL
    tables, chunks = (RenderMattes(stage, aovs, instanceChunks=least) for least in (0, 1))
    assert chunks.statistics["geometry"]["chunks"] == tables.statistics["geometry"]["chunks"] + 1
    assert chunks.headers == tables.headers and len(chunks.headers) > 2
    for name, pixels in tables.aovs.items():
        assert pixels.tobytes() == chunks.aovs[name].tobytes(), name
    assert len(np.unique(tables.aovs["primId"])) == 4


def test_renders_go_on_in_chunks(tmp_path):
    """Sums of a render whose instances lie in tables, and of one where they lie in pages: both count by the same numbers."""
    renderer = hdstream.Renderer(WriteMatteStage(tmp_path / "still.usda", ("Card", "Many", "Wall")))
    values = {"imageWidth": WIDTH, "imageHeight": HEIGHT, "noCache": True, "maxDepth": 1, "camera": "/World/Camera", "aovs": list(ALL)}
    images = []
    for before, after in ((0, 0), (1, 0), (0, 1)):
        renderer.Prepare(1, samples=16, instanceChunks=before, **values)
        sums = renderer.RenderSums()
        renderer.Prepare(1, samples=32, instanceChunks=after, **values)
        images.append(renderer.RenderPrepared(None, [sums]))
    for image in images[1:]:
        for name, pixels in images[0].aovs.items():
            assert pixels.tobytes() == image.aovs[name].tobytes(), name
