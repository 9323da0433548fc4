# SPDX-License-Identifier: Apache-2.0
"""What `record` writes: files, sizes, layers, frames, statistics, and settings in their order."""

import json

import pytest

from cliCase import SCENE, SMALL, TRIANGLE, AssertFails, Run, RunHere, WriteStage

SETTINGS = SCENE + """def RenderSettings "Settings"
{
    int2 resolution = (12, 6)
    rel camera = </Wide>
    rel products = </Product>
    int hdstream:samples = 3
    int hdstream:nonsense = 1
    uniform token[] includedPurposes = ["default", "proxy"]
}
def RenderProduct "Product"
{
    rel orderedVars = [</Ci>, </Depth>, </Odd>]
}
def RenderVar "Ci"
{
    uniform string sourceName = "Ci"
}
def RenderVar "Depth"
{
    uniform string sourceName = "depth"
}
def RenderVar "Odd"
{
    uniform string sourceName = "odd"
}
"""


def Image(path):
    """(width, height, layer names) of an image, read by comparing it with itself."""
    from hdstream import _core
    result = _core.CompareImages(str(path), str(path))
    assert not result.error, result.error
    return result.width, result.height, [layer.name for layer in result.layers]


def test_image_size_follows_usdrecord(tmp_path):
    stage = WriteStage(tmp_path)
    # 20.955 x 15.2908 is the fallback film back; the height is rounded down.
    for options, size in (
            (["-w", "16"], (16, 11)),
            (["-w", "16", "--camera", "Wide"], (16, 4)),
            (["-w", "16", "--imageHeight", "5"], (16, 5)),
            (["-w", "1", "--camera", "/Wide"], (1, 1))):
        result = Run("record", stage, tmp_path / "o.exr", "--samples", "1", *options)
        assert result.code == 0 and not result.errors, result.text
        assert Image(tmp_path / "o.exr")[:2] == size


def test_a_framed_stage_names_its_cameras(tmp_path):
    """Once for all frames, and only where nobody has chosen one and none is called main_cam."""
    cameras = [f"Camera{i}" for i in range(5)]
    stage = WriteStage(tmp_path, TRIANGLE + "".join(f'def Camera "{name}"\n{{\n}}\n' for name in cameras))
    note = "the stage is framed from the front; --camera takes /Camera0, /Camera1, /Camera2 and 2 more"
    result = Run("record", stage, tmp_path / "o.#.exr", *SMALL, "--frames", "1:2")
    assert result.code == 0 and not result.errors and result.out.splitlines()[0] == note and result.out.count(note) == 1
    for words in (["--camera", "Camera1"], ["--quiet"]):
        result = Run("record", stage, tmp_path / "o.exr", *SMALL, *words)
        assert result.code == 0 and "is framed" not in result.text, result.text
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and "is framed" not in result.text, result.text


@pytest.mark.parametrize("name", ["o.exr", "o.png", "o.jpg"])
def test_formats(tmp_path, name):
    assert Run("record", WriteStage(tmp_path), tmp_path / name, *SMALL).code == 0
    assert Image(tmp_path / name)[0] == 8


def test_aovs_become_layers(tmp_path):
    from hdstream import _core
    names = [info.name for info in _core.AovTable()]
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--aovs", ",".join(names))
    assert result.code == 0, result.text
    assert set(Image(tmp_path / "o.exr")[2]) == {layer for name in names for layer in _core.LayersOf(name)}
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.png", *SMALL, "--aovs", "color,depth")
    assert result.code == 0 and any("depth" in line and "o.png" in line for line in result.warnings), result.text


def test_frames_are_numbered(tmp_path):
    stage = WriteStage(tmp_path)
    result = Run("record", stage, tmp_path / "o.###.exr", *SMALL, "-f", "1:5x2,9")
    assert result.code == 0, result.text
    assert sorted(path.name for path in tmp_path.glob("*.exr")) == [
        "o.001.exr", "o.003.exr", "o.005.exr", "o.009.exr"]
    result = Run("record", stage, tmp_path / "h.##.#.png", *SMALL, "-f", "1:2x0.5",
                 "--stats", tmp_path / "s.##.#.json")
    assert result.code == 0, result.text
    assert sorted(path.name for path in tmp_path.glob("h.*")) == ["h.01.0.png", "h.01.5.png", "h.02.0.png"]
    assert sorted(path.name for path in tmp_path.glob("s.*.json")) == ["s.01.0.json", "s.01.5.json", "s.02.0.json"]


def test_frames_differ_where_the_stage_moves(tmp_path):
    """The triangle is in view at 1 and out of view at 2; depth tells without noise."""
    moving = SCENE.replace('def Mesh "Triangle"\n{', 'def Mesh "Triangle"\n{\n'
                           'double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (0, 1000, 0)}\n'
                           'uniform token[] xformOpOrder = ["xformOp:translate"]')
    stage = tmp_path / "moving.usda"
    stage.write_text("#usda 1.0\n" + moving, encoding="utf-8")
    result = Run("record", stage, tmp_path / "o.#.exr", *SMALL, "-f", "1:2", "--aovs", "primId")
    assert result.code == 0, result.text
    from hdstream import _core
    layer, = _core.CompareImages(str(tmp_path / "o.1.exr"), str(tmp_path / "o.2.exr")).layers
    assert layer.numDifferingPixels > 0


def test_statistics_have_all_sections(tmp_path):
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--stats", tmp_path / "s.json")
    assert result.code == 0, result.text
    stats = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))
    assert {"version", "device", "image", "time", "memory", "geometry", "texture", "rays", "accuracy",
            "warnings"} <= set(stats)
    assert stats["image"] == {"width": 8, "height": 5, "samples": 1}
    assert 0 < stats["time"]["translate"] < stats["time"]["firstPixel"] <= stats["time"]["total"]


def test_render_settings_fill_what_options_leave_open(tmp_path):
    stage = WriteStage(tmp_path, SETTINGS)
    stats = tmp_path / "s.json"
    result = Run("record", stage, tmp_path / "o.exr", "-rs", "/Settings", "--stats", stats)
    assert result.code == 0, result.text
    assert Image(tmp_path / "o.exr") == (12, 6, ["color", "depth"])
    assert json.loads(stats.read_text(encoding="utf-8"))["image"]["samples"] == 3
    assert any("hdstream:nonsense" in line for line in result.warnings)
    assert any(line.startswith("/Odd: ") for line in result.warnings)
    result = Run("record", stage, tmp_path / "o.exr", "-rs", "/Settings", "-w", "20", "--imageHeight", "4",
                 "--samples", "2", "--aovs", "color", "--stats", stats)
    assert Image(tmp_path / "o.exr") == (20, 4, ["color"])
    assert json.loads(stats.read_text(encoding="utf-8"))["image"]["samples"] == 2


def test_render_settings_that_cannot_be_read_are_one_line_each(tmp_path):
    """Found by fuzzing: attributes where relationships belong, pixels beyond floats."""
    body = SCENE + """def RenderSettings "Settings" {
token camera = "x"
rel products = </Product> }
def RenderProduct "Product" {
token orderedVars = "y" }
def PointInstancer "Many" {
token prototypes = "z" }
"""
    result = Run("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL, "-rs", "/Settings")
    assert result.code == 0 and not result.errors, result.text
    for start in ("/Settings: camera cannot be read: ", "/Product: orderedVars cannot be read: ", "/Many: "):
        assert len([line for line in result.warnings if line.startswith(start)]) == 1, result.text
    from hdstream.translate.circles import HasCircularInstancers
    from pxr import Usd
    assert not HasCircularInstancers(Usd.Stage.Open(str(tmp_path / "scene.usda")))
    for value in ("-3.4e38", "nan"):
        body = SCENE + f'def RenderSettings "Settings" {{ float pixelAspectRatio = {value} }}\n'
        AssertFails(RunHere("record", WriteStage(tmp_path, body), tmp_path / "o.exr", "-w", "8", "-rs", "/Settings"), 2, "pixelAspectRatio")


@pytest.mark.parametrize("attribute", [
    "int2 resolution = (2000000000, 4)", "int2 resolution = (-4, 4)", "int2 resolution = (4, 0)", "float pixelAspectRatio = nan",
    'token aspectRatioConformPolicy = "fit"', "float4 dataWindowNDC = (nan, 0, 1, 1)", "float4 dataWindowNDC = (0, 0, inf, 1)",
    "float4 dataWindowNDC = (0, 0, 1e9, 1)", "float4 dataWindowNDC = (0, 0, 1000, 1000)", "float4 dataWindowNDC = (1e8, 0, 100000008, 1)",
    "float4 dataWindowNDC = (0, -1e30, 1, 1)",
    "float resolution = 4", 'string resolution = "4 4"', "double3 resolution = (4, 4, 4)", "float[] pixelAspectRatio = [1]",
    "asset aspectRatioConformPolicy = @x@", "float dataWindowNDC = 1", "int2 dataWindowNDC = (0, 1)",
    'token disableDepthOfField = "no"', "float disableMotionBlur = 0.5",
])
def test_render_settings_of_no_use_are_told_with_their_prim(tmp_path, attribute):
    name = attribute.split()[1]
    stage = WriteStage(tmp_path, SCENE + f'def RenderSettings "Settings" {{ {attribute}\n}}\n')
    AssertFails(RunHere("record", stage, tmp_path / "o.exr", "-rs", "/Settings"), 2, f"/Settings: {name}: ")
    if name == "resolution":  # options win, whatever the prim says
        assert Run("record", stage, tmp_path / "o.exr", *SMALL, "-rs", "/Settings").code == 0


def test_a_data_window_without_a_pixel_is_told_with_the_prim_that_says_it(tmp_path):
    body = SCENE + """def RenderSettings "Settings" { rel products = </Product>
}
def RenderProduct "Product" { float4 dataWindowNDC = (0.5, 0.5, 0.5, 1)
}
"""
    result = RunHere("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL, "-rs", "/Settings")
    assert result.code == 0 and result.warnings == ["/Product: dataWindowNDC holds no pixel; ignored"], result.text


@pytest.mark.parametrize("purposes, isTold", [('["full", ""]', False), ('["preview", ""]', True), ('["full"]', True), ("[]", True)])
def test_purposes_of_bindings_that_are_not_read_are_told(purposes, isTold, tmp_path):
    body = SCENE + f'def RenderSettings "Settings" {{ token[] materialBindingPurposes = {purposes}\n}}\n'
    result = RunHere("record", WriteStage(tmp_path, body), tmp_path / "o.exr", *SMALL, "-rs", "/Settings")
    assert result.code == 0, result.text
    told = [line for line in result.warnings if line.startswith("/Settings: materialBindingPurposes ")]
    assert len(told) == isTold and len(result.warnings) == isTold, result.text


def test_attributes_of_other_types_are_told_and_convertible_ones_count(tmp_path):
    """OpenUSD hands out what a layer holds: such values were internal errors."""
    body = SCENE.replace('def Camera "main_cam"\n{', 'def Camera "main_cam"\n{\nstring exposure = "bright"\n') + """
def RenderSettings "Settings" {
int2 resolution = (12, 6)
float[] renderingColorSpace = [1]
rel products = </Product>
}
def RenderProduct "Product" {
double4 dataWindowNDC = (0, 0, 0.5, 1)
rel orderedVars = [</Number>, </Color>]
}
def RenderVar "Number" {
float sourceName = 1.5
}
def RenderVar "Color" {
token sourceName = "color"
}
"""
    assert "exposure" in body
    result = Run("record", WriteStage(tmp_path, body), tmp_path / "o.exr", "--samples", "1", "-rs", "/Settings")
    assert result.code == 0 and not result.errors, result.text
    assert Image(tmp_path / "o.exr")[:2] == (6, 6)
    for line in ("/main_cam: exposure cannot be a string; ignored", "/Settings: renderingColorSpace cannot be a float[]; ignored",
                 "/Number: sourceName cannot be a float; left out"):
        assert result.warnings.count(line) == 1, result.text


def test_render_settings_of_the_stage_are_used(tmp_path):
    stage = WriteStage(tmp_path, SETTINGS, header='(\n    renderSettingsPrimPath = "/Settings"\n)')
    assert Run("record", stage, tmp_path / "o.exr").code == 0
    assert Image(tmp_path / "o.exr")[:2] == (12, 6)


def test_purposes_and_masks_limit_what_is_drawn(tmp_path):
    body = SCENE + TRIANGLE.replace('"Triangle"\n{', '"Proxy"\n{\nuniform token purpose = "proxy"')
    stage = WriteStage(tmp_path, body)
    counts = []
    for options in ([], ["--purposes", "proxy"], ["--mask", "/Proxy,/main_cam", "--purposes", "proxy"],
                    ["--mask", "/main_cam"]):
        result = Run("record", stage, tmp_path / "o.exr", *SMALL, *options, "--stats", tmp_path / "s.json")
        assert result.code == 0, result.text
        counts.append(json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))["geometry"]["meshes"])
    assert counts == [1, 2, 1, 0]


def test_options_of_memory_change_nothing(tmp_path):
    stage = WriteStage(tmp_path)
    assert Run("record", stage, tmp_path / "a.exr", *SMALL).warnings == []
    result = Run("record", stage, tmp_path / "b.exr", *SMALL, "--textureMemory", "512M",
                 "--shadeIterations", "1", "--disableCameraLight", "--chunkSize", "64K")
    assert result.code == 0, result.text
    assert result.warnings == []
    same = RunHere("compare", tmp_path / "a.exr", tmp_path / "b.exr", "--threshold", "0")
    assert same.code == 0, same.text


def test_streamed_geometry_gives_the_same_image(tmp_path):
    stage = WriteStage(tmp_path)
    assert Run("record", stage, tmp_path / "a.exr", *SMALL, "--residency", "resident").code == 0
    modes = []
    for number, options in enumerate((["--geometryMemory", "100%"], ["--geometryMemory", "64K", "--geometryEviction", "flush"],
                                      ["--request", "first", "--chunkSize", "mesh"])):
        path = tmp_path / f"b{number}.exr"
        result = Run("record", stage, path, *SMALL, "--residency", "stream", *options, "--stats", tmp_path / "s.json")
        assert result.code == 0 and result.warnings == [], result.text
        statistics = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))["geometry"]
        assert statistics["streamedPaths"] > 0 and 0 < statistics["uploadedBytes"]
        modes.append(statistics["mode"])
        assert RunHere("compare", tmp_path / "a.exr", path, "--threshold", "0").code == 0
    assert modes[1:] == ["stream", "stream"]  # the first may have become resident, once its pool holds everything


def test_a_pool_that_is_too_small_is_one_line(tmp_path):
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--residency", "stream", "--geometryMemory", "16")
    AssertFails(result, 1, "--geometryMemory", "16 bytes cannot hold the largest chunk")
    assert not (tmp_path / "o.exr").exists()


def test_default_time(tmp_path):
    """-d renders the default value, no option the one at startTimeCode."""
    body = SCENE.replace("double3 xformOp:translate = (0, 0, 8)",
                         "double3 xformOp:translate = (0, 0, 8)\n"
                         "double3 xformOp:translate.timeSamples = { 4: (99, 0, 8)}")
    stage = tmp_path / "times.usda"
    stage.write_text("#usda 1.0\n(\n    startTimeCode = 4\n)\n" + body, encoding="utf-8")
    assert Run("record", stage, tmp_path / "start.exr", *SMALL, "--aovs", "primId").code == 0
    assert Run("record", stage, tmp_path / "default.exr", *SMALL, "--aovs", "primId", "-d").code == 0
    assert RunHere("compare", tmp_path / "start.exr", tmp_path / "default.exr", "--threshold", "0").code == 1


def test_quiet_and_progress(tmp_path):
    stage = WriteStage(tmp_path)
    loud = {"HDSTREAM_PROGRESS": "1"}
    shown = "".join(Run("record", stage, tmp_path / "o.exr", *SMALL, environment=loud).errors)
    assert -1 < shown.find("reading the stage") < shown.find("translating the stage") < shown.find("samples")
    result = Run("record", stage, tmp_path / "o.exr", *SMALL, "--quiet", environment=loud)
    assert result.code == 0 and not result.out and not result.errors
    result = Run("record", tmp_path / "none.usda", tmp_path / "o.exr", *SMALL, environment=loud)
    *bar, cleared, line = result.errors  # each time that the bar is drawn is a line of its own here
    assert result.code == 1 and "reading the stage" in bar[-1] and not cleared.strip() and line.startswith("hdstream record: ")


def test_what_is_begun_is_shown_however_soon_it_follows(monkeypatch, capsys):
    from hdstream.progress import ProgressBar
    monkeypatch.setenv("HDSTREAM_PROGRESS", "1")
    with ProgressBar(False) as bar:
        bar.Begin("first")
        bar.Begin("second")
        bar.Clear()
        bar.Begin("second")
    shown = capsys.readouterr().err
    assert [shown.count(what) for what in ("first", "second")] == [1, 2]


def test_the_bar_says_how_much_is_left_before_samples(monkeypatch, capsys):
    from types import SimpleNamespace

    from hdstream import progress as module
    monkeypatch.setenv("HDSTREAM_PROGRESS", "1")
    now = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])

    def Count(done, total):
        return SimpleNamespace(done=done, total=total)

    with module.ProgressBar(False) as bar:
        for prims, chunks in (((0, 400), (0, 0)), ((100, 400), (0, 0)), ((400, 400), (0, 0)), ((400, 400), (20, 200))):
            bar.Prepare(SimpleNamespace(prims=Count(*prims), chunks=Count(*chunks), textures=Count(0, 0)))
            now[0] += 10.0
    shown = capsys.readouterr().err.split("\r")[1:]
    assert "planning prims: 0 of 400" in shown[0] and "left" not in shown[0]
    assert " 25% " in shown[1] and "planning prims: 100 of 400, 30" in shown[1] and "left" in shown[1]
    assert "preparing the scene" in shown[2]
    assert " 10% " in shown[3] and "making pages of chunks: 20 of 200" in shown[3]


def test_framed_and_default_lit_stage(tmp_path):
    """Without camera and light: framed, lit by the default dome, and one warning says so."""
    result = Run("record", WriteStage(tmp_path, TRIANGLE), tmp_path / "o.exr", *SMALL)
    assert result.code == 0, result.text
    assert len(result.warnings) == 1 and "light" in result.warnings[0]


def test_compare_and_threshold(tmp_path):
    stage = WriteStage(tmp_path)
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        assert Run("record", stage, tmp_path / f"{name}.exr", "-w", "16", "--samples", "2", "--seed", seed).code == 0
    same = RunHere("compare", tmp_path / "a.exr", tmp_path / "b.exr", "--threshold", "0")
    assert same.code == 0 and "color" in same.out and not same.errors, same.text
    unlike = RunHere("compare", tmp_path / "a.exr", tmp_path / "c.exr", "--threshold", "0")
    assert unlike.code == 1 and not unlike.errors, unlike.text
    assert RunHere("compare", tmp_path / "a.exr", tmp_path / "c.exr").code == 0
    AssertFails(RunHere("compare", tmp_path / "a.exr", tmp_path / "none.exr"), 1, "none.exr")
