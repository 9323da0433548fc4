# SPDX-License-Identifier: Apache-2.0
"""`hdstream record STAGE`: all products of the render settings, each with its camera, size and layers."""

import deepFile
import exrFile
import numpy as np
import pytest

from hdstream import _core

from cliCase import ANIMATED, SCENE, SMALL, AssertFails, Run, RunHere, WriteStage

_PRODUCTS = """
def Camera "side_cam" {
    double3 xformOp:translate = (1, 0, 9)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Scope "Render" {
    def RenderSettings "Settings" {
        rel products = [</Render/Main>, </Render/Mattes>, </Render/Side>, </Render/Deep>, </Render/Other>]
        uniform int2 resolution = (24, 16)
        rel camera = </main_cam>
        custom int hdstream:samples = 4
        custom int hdstream:maxDepth = 2
    }
    def RenderProduct "Main" {
        token productName = "main.####.exr"
        rel orderedVars = [</Render/Vars/beauty>, </Render/Vars/depth>, </Render/Vars/uv>]
    }
    def RenderProduct "Mattes" {
        token productName.timeSamples = { 1: "mattes1.exr", 2: "mattes2.exr" }
        rel orderedVars = [</Render/Vars/id>, </Render/Vars/crypto>]
    }
    def RenderProduct "Side" {
        token productName = "side.####.exr"
        uniform int2 resolution = (32, 20)
        uniform float4 dataWindowNDC = (0.25, 0.25, 0.75, 0.75)
        rel camera = </side_cam>
        rel orderedVars = [</Render/Vars/beauty>, </Render/Vars/lit>, </Render/Vars/key>]
    }
    def RenderProduct "Deep" {
        token productName = "deep.####.exr"
        token productType = "deepRaster"
        rel orderedVars = [</Render/Vars/depth>, </Render/Vars/whole>, </Render/Vars/id>]
    }
    def RenderProduct "Other" {
        token productName = "other.exr"
        token productType = "path"
    }
    def Scope "Vars" {
        def RenderVar "beauty" { string sourceName = "Ci"
            token dataType = "color4h" }
        def RenderVar "whole" { string sourceName = "Ci" }
        def RenderVar "depth" { string sourceName = "cameraDepth"
            token dataType = "float"
            custom string driver:parameters:aov:name = "Z" }
        def RenderVar "uv" { string sourceName = "st"
            token sourceType = "primvar"
            custom token driver:parameters:aov:format = "half3" }
        def RenderVar "id" { string sourceName = "primId" }
        def RenderVar "lit" { string sourceName = "C.[LO]"
            token sourceType = "lpe" }
        def RenderVar "key" { string sourceName = "lpe:C.*<L.'key'>"
            token sourceType = "lpe"
            custom string driver:parameters:aov:name = "keyLight" }
        def RenderVar "crypto" { string sourceName = "crypto_object" }
    }
}
"""
_BRIGHT = ANIMATED.replace("inputs:intensity = 1", "inputs:intensity = 50000")
_SELECT = ["-rs", "/Render/Settings"]


@pytest.fixture(name="stage")
def MakeStage(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return WriteStage(tmp_path, _BRIGHT + _PRODUCTS)


def _SameBits(a, b):
    return a.dtype == b.dtype and a.tobytes() == b.tobytes()


def test_all_products_are_written(stage, tmp_path):
    result = RunHere("record", stage, *_SELECT, "--frames", "1:2")
    assert result.code == 0, result.text
    assert len(result.out.splitlines()) == 4  # two frames of two pictures: two products share one
    assert "main.0001.exr, mattes1.exr, deep.0001.exr: 24x16, 4 samples" in result.out
    assert "/Render/Other: products of type 'path' are not supported; left out" in result.text
    assert "/Render/Deep: a deep product holds colour and depth alone; left out: primId" in result.text
    names = {path.name for path in tmp_path.glob("*.exr")}
    assert names == {"main.0001.exr", "main.0002.exr", "mattes1.exr", "mattes2.exr", "side.0001.exr", "side.0002.exr",
                     "deep.0001.exr", "deep.0002.exr"}
    _, main = exrFile.Read(tmp_path / "main.0001.exr")
    assert {name: kind.dtype.str for name, kind in main.items()} == {
        **{channel: "<f2" for channel in "RGBA"}, "Z.Z": "<f4", **{f"primvars:st.{axis}": "<f2" for axis in "XYZ"}}
    _, mattes = exrFile.Read(tmp_path / "mattes1.exr")
    assert set(mattes) == {"primId.id", *(f"crypto_object{layer:02}.{channel}" for layer in range(3) for channel in "RGBA")}
    _, side = exrFile.Read(tmp_path / "side.0001.exr")
    assert set(side) == {*"RGBA", *(f"{name}.{channel}" for name in ("lit", "keyLight") for channel in "RGB")}
    assert side["lit.R"].max() > 0.1 and not side["keyLight.R"].any()
    assert not _SameBits(main["Z.Z"], exrFile.Read(tmp_path / "main.0002.exr")[1]["Z.Z"])


def test_a_deep_product_is_the_flat_one_in_samples(stage, tmp_path):
    """The layers of the same frame, and those of a single render to the bit; the compression is one that deep files have."""
    assert RunHere("record", stage, *_SELECT, "--frames", "1").code == 0
    single = ["--frames", "1", "--samples", "4", "--maxDepth", "2"]
    assert RunHere("record", stage, "whole.exr", *_SELECT, *single).code == 0
    assert RunHere("record", stage, "single.exr", *_SELECT, *single, "--deep", "--aovs", "color").code == 0
    deep, again = deepFile.Read("deep.0001.exr"), deepFile.Read("single.exr")
    assert np.array_equal(deep.counts, again.counts)
    assert all(_SameBits(deep.channels[name], again.channels[name]) for name in ("R", "G", "B", "A", "Z", "ZBack"))
    _, flat = exrFile.Read("whole.exr")
    colors = np.stack([deep.channels[name] for name in "RGBA"], -1).astype(float)
    for index, name in enumerate("RGBA"):
        assert np.allclose(deepFile.Flatten(deep.counts, colors)[..., index], flat[name], rtol=1e-6, atol=1e-8)
    assert flat["A"].max() == 1.0 and deep.texts["hdStream:camera"] == "/main_cam"
    AssertFails(RunHere("compare", "deep.0001.exr", "single.exr"), 1, "deep.0001.exr: deep images are not read: flatten it first")


@pytest.mark.parametrize("arguments, words", [
    (["a.png", "--deep"], ("--deep", "a.png is no .exr")),
    (["--deep"], ("--deep", "say OUT")),
    (["a.exr", "--deep", "--aovs", "color,normal"], ("--deep", "no other --aovs")),
    (["a.exr", "--deep", "--workers", "1", "--split", "tiles"], ("--split tiles", "deep picture")),
])
def test_what_cannot_be_deep_is_said(arguments, words, tmp_path):
    AssertFails(Run("record", WriteStage(tmp_path, ANIMATED), *arguments, cwd=tmp_path), 2, *words)


_PACKED = """    def RenderProduct "%s" {
        token productName = "%s.exr"
        rel orderedVars = [</Render/Vars/beauty>, </Render/Vars/depth>, </Render/Vars/uv>]
        custom token driver:parameters:OpenEXR:compression = "%s"
        custom float driver:parameters:OpenEXR:dwaCompressionLevel = 20
        custom string driver:parameters:OpenEXR:shot = "seq10"
        custom int driver:parameters:OpenEXR:take = 7
        custom string driver:parameters:artist = "somebody"
        custom string driver:parameters:comment = "a test"
    }
"""


def test_products_say_how_they_are_packed_and_what_is_in_the_header(tmp_path, monkeypatch):
    """Lossless compressions hold the same pixels; DWAA, which is not, holds nearly the same."""
    monkeypatch.chdir(tmp_path)
    numbers = {"none": 0, "rle": 1, "zips": 2, "piz": 4, "dwaa": 8, "lzw": 3}
    body = "".join(_PACKED % (name.upper(), name, name) for name in numbers)
    rel = ", ".join(f"</Render/{name.upper()}>" for name in numbers)
    products = _PRODUCTS.replace("</Render/Deep>, </Render/Other>]", f"{rel}]").replace('    def RenderProduct "Mattes" {',
                                                                      body + '    def RenderProduct "Mattes" {')
    result = RunHere("record", WriteStage(tmp_path, _BRIGHT + products), *_SELECT, "--frames", "1")
    assert result.code == 0, result.text
    assert "/Render/LZW: driver:parameters:OpenEXR:compression 'lzw' is none of none, rle, " in result.text
    for name, number in numbers.items():
        found, texts = exrFile.Compression(f"{name}.exr")
        assert found == number, name
        assert (texts["shot"], texts["take"], texts["Artist"], texts["comments"]) == ("seq10", "7", "somebody", "a test")
        same = _core.CompareImages(f"{name}.exr", "main.0001.exr")
        assert not same.error
        assert all(layer.maxAbs == 0 for layer in same.layers) or name == "dwaa"
    assert max(layer.maxAbs for layer in _core.CompareImages("dwaa.exr", "main.0001.exr").layers) < 0.1
    assert exrFile.Compression("main.0001.exr")[0] == 3


def test_pixels_are_those_of_single_renders(stage, tmp_path):
    """Halves are the nearest to the floats; the crop has the pixels of the whole and says where it lies."""
    assert RunHere("record", stage, *_SELECT, "--frames", "1").code == 0
    common = ["--frames", "1", "--samples", "4", "--maxDepth", "2"]
    assert RunHere("record", stage, "whole.exr", *_SELECT, *common, "--aovs", "color,cameraDepth").code == 0
    _, whole = exrFile.Read("whole.exr")
    _, main = exrFile.Read("main.0001.exr")
    assert all(_SameBits(main[channel], whole[channel].astype("<f2")) for channel in "RGBA")
    assert _SameBits(main["Z.Z"], whole["cameraDepth.Z"])
    assert whole["R"].max() > 0.1
    bare = WriteStage(tmp_path, _BRIGHT + _PRODUCTS.split("def Scope")[0], "bare.usda")
    assert RunHere("record", bare, "side.exr", *common, "--camera", "/side_cam", "-w", "32", "--imageHeight", "20").code == 0
    _, side = exrFile.Read("side.exr")
    _, crop = exrFile.Read("side.0001.exr")
    assert exrFile.Windows("side.0001.exr") == ((8, 5, 23, 14), (0, 0, 31, 19))
    assert all(_SameBits(crop[channel], side[channel][5:15, 8:24].astype("<f2")) for channel in "RGBA")


def test_a_farm_writes_the_same(stage, tmp_path):
    assert RunHere("record", stage, *_SELECT, "--frames", "1").code == 0
    deep = deepFile.Read(tmp_path / "deep.0001.exr")
    (tmp_path / "deep.0001.exr").unlink()
    single = {path.name: exrFile.Read(path)[1] for path in tmp_path.glob("*.exr")}
    for path in tmp_path.glob("*.exr"):
        path.unlink()
    result = Run("record", stage, *_SELECT, "--frames", "1", "--workers", "1", cwd=tmp_path)
    assert result.code == 0, result.text
    for name, channels in single.items():
        _, again = exrFile.Read(tmp_path / name)
        assert again.keys() == channels.keys() and all(_SameBits(again[key], channels[key]) for key in channels)
    again = deepFile.Read(tmp_path / "deep.0001.exr")
    assert all(_SameBits(again.channels[name], channel) for name, channel in deep.channels.items())


def test_resume_knows_every_file(stage, tmp_path):
    arguments = ["record", stage, *_SELECT, "--frames", "1", "--resume"]
    assert RunHere(*arguments).code == 0
    assert RunHere(*arguments).out.count("is there already") == 2
    (tmp_path / "mattes1.exr").unlink()
    assert RunHere(*arguments).out.count("is there already") == 1
    assert (tmp_path / "mattes1.exr").exists()
    (tmp_path / "deep.0001.exr").unlink()
    assert RunHere(*arguments).out.count("is there already") == 1
    assert (tmp_path / "deep.0001.exr").exists()


def test_resume_knows_the_colours_of_every_file(tmp_path, monkeypatch):
    """A .png that is the second file of its picture."""
    monkeypatch.chdir(tmp_path)
    stage = WriteStage(tmp_path, _BRIGHT + 'def RenderSettings "S" { rel products = [</A>, </B>] }\n'
                       'def RenderProduct "A" { token productName = "a.exr" }\ndef RenderProduct "B" { token productName = "b.png" }\n')
    arguments = ["record", stage, "-rs", "/S", "-w", "24", "--maxDepth", "2", "--samples", "4", "-color"]
    assert RunHere(*arguments, "disabled").code == 0
    linear = (tmp_path / "b.png").read_bytes()
    assert RunHere(*arguments, "sRGB", "--resume").code == 0
    assert (tmp_path / "b.png").read_bytes() != linear
    assert "is there already" in RunHere(*arguments, "sRGB", "--resume").out
    result = RunHere(*arguments, "disabled", "--resume")
    assert result.code == 0 and "is there already" not in result.out and (tmp_path / "b.png").read_bytes() == linear


@pytest.mark.parametrize("was, edited", [
    ('OpenEXR:compression = "zip"', 'OpenEXR:compression = "rle"'), ('dataType = "color4h"', 'dataType = "color4f"'),
    ('aov:name = "Z"', 'aov:name = "depth"'), ('OpenEXR:shot = "a"', 'OpenEXR:shot = "b"'), ('tileSize = 8', 'tileSize = 16')])
def test_resume_knows_what_products_say_of_their_files(was, edited, tmp_path, monkeypatch):
    """The picture stays and its file does not."""
    monkeypatch.chdir(tmp_path)
    text = _BRIGHT + _PRODUCTS.replace('productName = "main.####.exr"', """productName = "main.####.exr"
        custom string driver:parameters:OpenEXR:compression = "zip"
        custom string driver:parameters:OpenEXR:shot = "a"
        custom int driver:parameters:OpenEXR:tileSize = 8""").replace(
            ", </Render/Mattes>, </Render/Side>, </Render/Deep>, </Render/Other>]", "]")
    assert text.count(was) == 1
    arguments = [*_SELECT, "--frames", "1", "--resume"]
    assert RunHere("record", WriteStage(tmp_path, text), *arguments).code == 0
    stage = WriteStage(tmp_path, text.replace(was, edited))
    result = RunHere("record", stage, *arguments)
    assert result.code == 0 and "is there already" not in result.out, result.text
    assert RunHere("record", stage, *arguments).out.count("is there already") == 1


@pytest.mark.parametrize("body, words", [
    ("", ("OUT is missing", "no render settings")),
    ('def RenderSettings "S" {}\n', ("OUT is missing", "/S has no products")),
    ('def RenderSettings "S" { rel products = </P> }\ndef RenderProduct "P" {}\n', ("/P", "no productName")),
    ('def RenderSettings "S" { rel products = </P> }\ndef RenderProduct "P" { token productName = "a.gif" }\n', ("a.gif",)),
    ('def RenderSettings "S" { rel products = </P> }\ndef RenderProduct "P" { token productName = "a.exr"\n'
     'rel orderedVars = </V> }\ndef RenderVar "V" { string sourceName = "CXL"\ntoken sourceType = "lpe" }\n',
     ("/V", "'CXL', column 2: 'X' is no event")),
    ('def RenderSettings "S" { rel products = </P> }\ndef RenderProduct "P" { token productName = "a.png"\n'
     'rel orderedVars = </V> }\ndef RenderVar "V" { string sourceName = "motionForward" }\n',
     ("a.png", "two channels ('motionForward') can only be stored in an .exr or .tif file")),
])
def test_what_cannot_be_written_is_said(body, words, tmp_path):
    stage = WriteStage(tmp_path, ANIMATED + body)
    AssertFails(Run("record", stage, *(["-rs", "/S"] if body else [])), 2, *words)


def test_frames_need_names_of_their_own(tmp_path):
    stage = WriteStage(tmp_path, ANIMATED + 'def RenderSettings "S" { rel products = </P> }\n'
                                            'def RenderProduct "P" { token productName = "a.exr" }\n')
    AssertFails(Run("record", stage, "-rs", "/S", "--frames", "1:2"), 2, "/P", "a.exr", "####")


def test_a_placeholder_has_no_number_at_the_default_time(tmp_path):
    stage = WriteStage(tmp_path, ANIMATED + 'def RenderSettings "S" { rel products = </P> }\n'
                                            'def RenderProduct "P" { token productName = "a.####.exr" }\n')
    AssertFails(Run("record", stage, "-rs", "/S", "--defaultTime"), 2, "/P: productName a.####.exr: ", "--defaultTime")


@pytest.mark.parametrize("compression", ["dwaa", "pxr24", "b44"])
def test_cryptomattes_keep_their_bits(compression, tmp_path, monkeypatch):
    """Whatever the type of their var and the compression of their product, which then holds for what it can."""
    monkeypatch.chdir(tmp_path)
    body = """def RenderSettings "S" { rel products = [</A>, </B>] }
def RenderProduct "A" { token productName = "a.exr"
    rel orderedVars = [</Crypto>] }
def RenderProduct "B" { token productName = "b.exr"
    custom string driver:parameters:OpenEXR:compression = "%s"
    rel orderedVars = [</Half>] }
def RenderVar "Crypto" { string sourceName = "crypto_object" }
def RenderVar "Half" { string sourceName = "crypto_object"
    token dataType = "color4h" }
""" % compression
    result = RunHere("record", WriteStage(tmp_path, ANIMATED + body), "-rs", "/S", *SMALL)
    assert result.code == 0, result.text
    difference = _core.CompareImages("b.exr", "a.exr")
    assert not difference.error and len(difference.layers) == 3 and all(layer.numDifferingPixels == 0 for layer in difference.layers)
    _, floats = exrFile.Read("a.exr")
    assert any(channel.any() for channel in floats.values())
    if compression != "b44":  # our reader knows zip alone
        _, found = exrFile.Read("b.exr")
        assert floats.keys() == found.keys() and all(_SameBits(floats[name], found[name]) for name in floats)
    assert "/Half: ids of a Cryptomatte are 32 bits" in result.text
    assert ("would change the ids of its Cryptomattes; zip is used" in result.text) == (compression != "b44")


def test_names_that_no_exr_file_holds_are_left_out(tmp_path, monkeypatch):
    """Names of channels have 255 bytes: cut there, the three of a normal would be one."""
    monkeypatch.chdir(tmp_path)
    names = {"n" * 240: "n" * 240, "é" * 128: "normal"}
    for given, written in names.items():
        result = RunHere("record", WriteStage(tmp_path, SCENE + """
def Scope "Render" { def RenderSettings "S" { rel products = </Render/A>
    int2 resolution = (8, 8)
    custom int hdstream:samples = 1 }
def RenderProduct "A" { token productName = "a.exr"
    rel orderedVars = [</Render/N>] }
def RenderVar "N" { string sourceName = "normal"
    custom string driver:parameters:aov:name = "%s" }
}
""" % given), "-rs", "/Render/S")
        assert result.code == 0, result.text
        assert ("/Render/N: the name of its layer has more than 240 bytes" in result.text) == (given != written)
        assert sorted(exrFile.Read("a.exr")[1]) == [f"{written}.{axis}" for axis in "XYZ"]


def test_vars_are_not_chosen_twice(tmp_path):
    AssertFails(Run("record", WriteStage(tmp_path, ANIMATED), "--aovs", "depth"), 2, "--aovs", "OUT")


def test_intrinsic_sources_are_known_by_their_usual_names(tmp_path, monkeypatch):
    """As raw ones are: P is the position, cameraDepth an AOV of ours; what is neither is left out, and what is no var."""
    monkeypatch.chdir(tmp_path)
    variables = "".join(f'        def RenderVar "{name}" {{ string sourceName = "{source}"\n            token sourceType = "{kind}" }}\n'
                        for name, source, kind in (("where", "P", "intrinsic"), ("far", "cameraDepth", "intrinsic"),
                                                   ("none", "curvature", "intrinsic")))
    variables += '        def RenderVar "silent" { token sourceType = "lpe" }\n'
    products = _PRODUCTS.replace('    def Scope "Vars" {\n', '    def Scope "Vars" {\n' + variables).replace(
        "[</Render/Vars/beauty>, </Render/Vars/depth>, </Render/Vars/uv>]",
        "[</Render/Vars/where>, </Render/Vars/far>, </Render/Vars/none>, </Render/Vars/silent>, </Render/Vars/absent>]")
    result = RunHere("record", WriteStage(tmp_path, _BRIGHT + products), *_SELECT, "--frames", "1")
    assert result.code == 0, result.text
    assert "/Render/Vars/none: render var 'curvature' is not one of the AOVs; left out" in result.text
    assert "/Render/Vars/silent: render var has no sourceName; left out" in result.text
    assert "/Render/Vars/absent: is no render var; left out" in result.text
    _, found = exrFile.Read("main.0001.exr")
    assert set(found) == {"position.X", "position.Y", "position.Z", "cameraDepth.Z"}
    raw = WriteStage(tmp_path, _BRIGHT + products.replace('"intrinsic"', '"raw"'), "raw.usda")
    assert RunHere("record", raw, *_SELECT, "--frames", "1").code == 0
    _, again = exrFile.Read("main.0001.exr")
    assert all(_SameBits(again[name], found[name]) for name in found)


_LENS = "float fStop = 4\nfloat focusDistance = 8\nint hdstream:camera:apertureBlades = 5\nfloat exposure:iso = 200\n"


@pytest.mark.parametrize("lens", ["", _LENS], ids=["pinholes", "oneLens"])
def test_two_eyes_are_two_products_of_one_run(lens, tmp_path, monkeypatch):
    """The disparity of a card that faces both is that of its depth. Each eye has the bits of a run of its own, though only
    one may have a lens, which kernels of the other know nothing of."""
    monkeypatch.chdir(tmp_path)
    distance, apart, width = 8.0, 0.5, 48
    eyes = {"left": "", "right": lens}
    cameras = "".join(
        f'def Camera "{name}" {{ {more}double3 xformOp:translate = ({side * apart / 2}, 0, {distance})\n'
        'uniform token[] xformOpOrder = ["xformOp:translate"] }\n' for side, (name, more) in zip((-1, 1), eyes.items()))
    products = "".join(
        f'def RenderProduct "{name}" {{ token productName = "{name}.exr"\nrel camera = </{name}>\n'
        'rel orderedVars = [</Render/Vars/beauty>] }\n' for name in eyes)
    stage = WriteStage(tmp_path, f"""{SCENE}{cameras}def Scope "Render" {{ def RenderSettings "Settings" {{
        rel products = [</Render/left>, </Render/right>]
        uniform int2 resolution = ({width}, 36)
        custom int hdstream:samples = 64 }}
        {products}def Scope "Vars" {{ def RenderVar "beauty" {{ string sourceName = "Ci"
            token dataType = "color4f" }} }} }}""")
    result = RunHere("record", stage, *_SELECT)
    assert result.code == 0, result.text
    pictures = {name: exrFile.Read(f"{name}.exr")[1] for name in eyes}
    middles = {}
    for name, channels in pictures.items():
        assert RunHere("record", stage, "alone.exr", "--camera", f"/{name}", "-w", width, "--imageHeight", 36,
                       "--samples", 64).code == 0
        _, alone = exrFile.Read("alone.exr")
        assert all(_SameBits(channels[channel], alone[channel]) for channel in "RGBA")
        alpha = channels["A"].astype(float)
        middles[name] = (alpha * (np.arange(width) + 0.5)).sum() / alpha.sum()
    disparity = apart / distance * 50.0 / 20.955 * width  # pixels; UsdGeomCamera's focal length and aperture
    assert middles["left"] - middles["right"] == pytest.approx(disparity, abs=0.02)
    brightness = [pictures[name]["R"].max() / pictures["left"]["R"].max() for name in eyes]
    assert brightness == pytest.approx([1.0, 2.0 if lens else 1.0], rel=1e-3)


def test_colours_are_colours_by_any_name(tmp_path, monkeypatch):
    """To a PNG: a colour that the product has another name for, behind what is none, and the light of an expression."""
    monkeypatch.chdir(tmp_path)
    products = {"plain": ["color"], "renamed": ["beauty"], "behind": ["depth", "beauty"], "diffuse": ["diffuse"], "expression": ["lit"]}
    body = "".join(f"""def RenderProduct "{name}" {{ token productName = "{name}.png"
        rel orderedVars = [{", ".join(f"</Render/Vars/{var}>" for var in variables)}] }}
""" for name, variables in products.items())
    stage = WriteStage(tmp_path, _BRIGHT + f"""def Scope "Render" {{
    def RenderSettings "Settings" {{ rel products = [{", ".join(f"</Render/{name}>" for name in products)}]
        uniform int2 resolution = (24, 16)
        rel camera = </main_cam> }}
    {body}
    def Scope "Vars" {{
        def RenderVar "color" {{ string sourceName = "color" }}
        def RenderVar "beauty" {{ string sourceName = "color"
            custom string driver:parameters:aov:name = "beauty" }}
        def RenderVar "depth" {{ string sourceName = "depth" }}
        def RenderVar "diffuse" {{ string sourceName = "diffuse" }}
        def RenderVar "lit" {{ string sourceName = "C<RD>.*[LO]"
            token sourceType = "lpe" }}
    }}
}}
""")
    result = RunHere("record", stage, *_SELECT, "--frames", "1", "--samples", "4")
    assert result.code == 0, result.text
    written = {name: (tmp_path / f"{name}.png").read_bytes() for name in products}
    assert written["renamed"] == written["plain"] and written["behind"] == written["plain"]
    assert written["expression"] == written["diffuse"] and written["diffuse"] != written["plain"]


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
def test_ids_of_cryptomattes_are_for_exr(name, tmp_path):
    AssertFails(Run("record", WriteStage(tmp_path, ANIMATED), name, "--aovs", "crypto_object", cwd=tmp_path), 2, "crypto_object", ".exr")


def test_a_file_that_cannot_be_written_costs_no_other(stage, tmp_path, monkeypatch):
    """Nor those of the same picture that come after it."""
    from hdstream import image
    write = image.Image.Write

    def Write(self, file, *further):
        if "main" in file or "mattes1" in file:
            raise _core.Error(f"cannot write '{file}': No space left on device")
        return write(self, file, *further)

    monkeypatch.setattr(image.Image, "Write", Write)
    AssertFails(RunHere("record", stage, *_SELECT, "--frames", "1"), 1, "main.0001.exr", "device; cannot write", "mattes1.exr")
    assert {path.name for path in tmp_path.glob("*.exr")} == {"deep.0001.exr"}


def test_statistics_are_written_where_the_picture_cannot_be(tmp_path, monkeypatch):
    from hdstream import image

    def Write(self, file, *further):
        raise _core.Error(f"cannot write '{file}': No space left on device")

    monkeypatch.setattr(image.Image, "Write", Write)
    stats = tmp_path / "stats.json"
    AssertFails(RunHere("record", WriteStage(tmp_path, ANIMATED), tmp_path / "o.exr", *SMALL, "--stats", stats), 1, "No space left")
    assert '"device"' in stats.read_text()
