# SPDX-License-Identifier: Apache-2.0
"""--resume: by content, never by dates; partial frames go on; equal bits."""

import os
import pathlib
import shutil

import pytest

from hdstream import _core

from cliCase import ANIMATED, SECONDS, AssertFails, Run, RunHere, WriteStage
from farmCase import OPTIONS, SameImages
from hdstream.resume import AssetHashes

RESUME = [*OPTIONS, "--resume"]
KERNELS = pathlib.Path(__file__).resolve().parents[2] / "kernels"


@pytest.fixture(name="stage")
def MakeStage(tmp_path):
    return WriteStage(tmp_path, ANIMATED)


def Record(stage, output, samples, *options):
    # Processes of a cluster are started by one of our own.
    run = Run if "--workers" in options else RunHere
    result = run("record", stage, output, *RESUME, "--samples", samples, *options)
    assert result.code == 0 and not result.errors, result.text
    return result


def IsThere(result):
    return "is there already" in result.out


def test_finished_frames_are_not_rendered_again(stage, tmp_path):
    output = tmp_path / "f####.exr"
    assert not IsThere(Record(stage, output, 4, "--frames", "1:2"))
    os.utime(stage)  # a newer date means nothing
    result = Record(stage, output, 4, "--frames", "1:3")
    assert result.out.count("is there already") == 2 and "f0003.exr: 24x" in result.out
    result = Record(stage, output, 2, "--frames", 1)
    assert IsThere(result), "samples are never taken away"


@pytest.mark.parametrize("pattern", ["{}/t.<UDIM>.png", "{}/p.usdz[t.<UDIM>.png]", "{}/p.usdz[q.usdz[a/t.<UDIM>.png]]"])
def test_tiles_of_udim_sets_count(tmp_path, pattern):
    """In a folder each tile; in a package the whole of it."""
    file = tmp_path / ("p.usdz" if "usdz" in pattern else "t.1002.png")
    file.write_bytes(b"first")
    first = AssetHashes().Of(pattern.format(tmp_path))
    assert first and "missing" not in first
    assert AssetHashes().Of(pattern.format(tmp_path)) == first
    file.write_bytes(b"other")
    assert AssetHashes().Of(pattern.format(tmp_path)) != first


@pytest.mark.parametrize("Make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")], ids=["pipe", "device"])
def test_assets_without_an_end_are_missing(tmp_path, Make):
    Make(tmp_path / "t.png")
    assert "missing" in AssetHashes().Of(f"{tmp_path}/t.png")


def test_changes_are_seen_by_content(stage, tmp_path):
    output = tmp_path / "o.exr"
    dates = os.stat(stage)
    Record(stage, output, 4)
    text = stage.read_text()
    stage.write_text(text.replace("intensity = 1", "intensity = 2"))
    os.utime(stage, ns=(dates.st_atime_ns, dates.st_mtime_ns))  # an unchanged date means nothing either
    assert not IsThere(Record(stage, output, 4))
    assert not IsThere(Record(stage, output, 4, "--seed", 3)), "settings count"
    assert IsThere(Record(stage, output, 4, "--seed", 3, "--waveSize", 4096, "--residency", "stream")), "the machine does not"
    shutil.copy(stage, tmp_path / "copy.usda")
    assert IsThere(Record(tmp_path / "copy.usda", output, 4, "--seed", 3)), "nor does the file's name"
    whole = output.read_bytes()
    for size in (100, len(whole) // 2, len(whole) - 1):
        output.write_bytes(whole[:size])
        assert not IsThere(Record(stage, output, 4, "--seed", 3)), "a cut file is none"


def test_other_kernels_make_other_frames(stage, tmp_path):
    output, kernels = tmp_path / "o.exr", tmp_path / "kernels"
    shutil.copytree(KERNELS, kernels)
    own = {"HDSTREAM_KERNEL_DIR": str(kernels)}

    def IsThereWith(environment):
        result = Run("record", stage, output, *RESUME, "--samples", 4, environment=environment)
        assert result.code == 0 and not result.errors, result.text
        return IsThere(result)

    assert not IsThereWith(own)
    assert IsThereWith({}), "the same kernels, wherever they come from"
    file = kernels / "film" / "film.cl"
    file.write_text(file.read_text() + "/* another */\n")
    assert not IsThereWith(own)


_CONFIG = """ocio_profile_version: 2
roles: {{default: linear, scene_linear: linear}}
displays: {{d: [!<View> {{name: v, colorspace: linear}}]}}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace> {{name: linear}}
  - !<ColorSpace> {{name: camera, to_scene_reference: !<ExponentTransform> {{value: {}}}}}
"""


def test_another_color_configuration_makes_other_frames(tmp_path):
    """At one path, where it now says that a space is another one."""
    stage = WriteStage(tmp_path, ANIMATED.replace("intensity = 1", 'intensity = 1\n    color3f inputs:color = (0.5, 0.5, 0.5) '
                                                  '(colorSpace = "camera")\n'))
    config, output = tmp_path / "config.ocio", tmp_path / "o.exr"

    def IsThereWith(exponents):
        config.write_text(_CONFIG.format(exponents))
        result = Run("record", stage, output, *RESUME, "--samples", 2, environment={"OCIO": str(config)})
        assert result.code == 0 and not result.errors, result.text
        return IsThere(result)

    assert not IsThereWith("[2, 2, 2, 1]")
    first = output.read_bytes()
    assert IsThereWith("[2, 2, 2, 1]"), "written again, and the same"
    assert not IsThereWith("[3, 3, 3, 1]")
    assert output.read_bytes() != first


_TABLE = "Version 1\nFrom 0 1\nLength 2\nComponents 1\n{{\n 0.0\n {}\n}}\n"


@pytest.fixture(name="colors")
def MakeColors(tmp_path, monkeypatch):
    """A configuration whose space is made of a table of the folder `luts`, and of a variable."""
    config = tmp_path / "config.ocio"
    transform = "!<GroupTransform> {children: [!<FileTransform> {src: a.spi1d}, !<ColorSpaceTransform> {src: $CAM, dst: linear}]}"
    text = _CONFIG.replace("!<ExponentTransform> {{value: {}}}", transform.replace("{", "{{").replace("}", "}}")).format()
    config.write_text("\n".join([text.split("\n")[0], "search_path: luts", "environment: {CAM: linear}", *text.split("\n")[1:]]) +
                      "  - !<ColorSpace> {name: other, to_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}}\n")
    (tmp_path / "luts").mkdir()
    (tmp_path / "luts" / "a.spi1d").write_text(_TABLE.format("1.0"))
    monkeypatch.setenv("OCIO", str(config))
    return config


def test_a_table_of_the_color_configuration_counts_by_its_bytes(colors, tmp_path):
    """In one process, as a worker of a farm sees it."""
    stage = WriteStage(tmp_path, ANIMATED.replace("intensity = 1", 'intensity = 1\n    color3f inputs:color = (0.5, 0.5, 0.5) '
                                                  '(colorSpace = "camera")\n'))
    table, output, fresh = tmp_path / "luts" / "a.spi1d", tmp_path / "o.exr", tmp_path / "fresh.exr"
    assert not IsThere(Record(stage, output, 2))
    first = output.read_bytes()
    shutil.copy(table, tmp_path / "copy")
    os.replace(tmp_path / "copy", table)
    assert IsThere(Record(stage, output, 2)), "the same bytes in another file"
    table.write_text(_TABLE.format("0.2"))
    assert not IsThere(Record(stage, output, 2))
    assert output.read_bytes() != first
    other = Run("record", stage, fresh, *RESUME, "--samples", 2)
    assert other.code == 0 and SameImages(fresh, output), "what another process makes"
    result = Run("record", stage, output, *RESUME, "--samples", 2, environment={"CAM": "other"})
    assert result.code == 0 and not IsThere(result), "a variable that a transform names"


def test_textures_are_prepared_again_for_another_table(colors, tmp_path):
    """In one cache, in one process and the next: an image's lines have colours that the configuration made."""
    from stages.imageFile import WriteExr
    import numpy as np
    WriteExr(tmp_path / "sky.exr", dict.fromkeys("RGB", np.full((8, 16), 0.5, np.float32)))
    stage = WriteStage(tmp_path, ANIMATED + """
def DomeLight "Sky" { asset inputs:texture:file = @sky.exr@ (colorSpace = "camera") }""")
    cached = ["--cacheDir", tmp_path / "cache", "-w", "24", "--samples", "2", "--maxDepth", "1"]
    table = tmp_path / "luts" / "a.spi1d"
    pictures = {}
    for scale in ("1.0", "0.2", "1.0"):
        table.write_text(_TABLE.format(scale))
        for runs, name in ((RunHere, "here"), (Run, "next")):
            result = runs("record", stage, tmp_path / "o.exr", *cached)
            assert result.code == 0 and not result.errors, result.text
            picture = (tmp_path / "o.exr").read_bytes()
            assert pictures.setdefault(scale, picture) == picture, (scale, name)
    assert pictures["1.0"] != pictures["0.2"]


def test_a_color_configuration_that_is_rewritten_is_loaded_again(colors):
    before = _core.FindColorConfigSources()
    assert before == ([str(colors), str(colors.parent / "luts" / "a.spi1d")], ["", "linear", "linear"])
    colors.write_text(colors.read_text().replace("src: a.spi1d", "src: a.spi1d, cccid: another"))
    assert _core.FindColorConfigSources() == (before[0], ["another", *before[1][1:]])


def test_a_color_configuration_that_cannot_be_read_costs_no_frame(stage, tmp_path):
    environment = {"OCIO": str(tmp_path / "none.ocio")}
    for isThere in (False, True):
        result = Run("record", stage, tmp_path / "o.exr", *RESUME, "--samples", 2, environment=environment)
        assert result.code == 0 and not result.errors and IsThere(result) == isThere, result.text


def test_frames_that_the_edit_does_not_reach_stay(stage, tmp_path):
    output = tmp_path / "f####.exr"
    Record(stage, output, 2, "--frames", "1:2")
    stage.write_text(stage.read_text().replace("24: (1, 0.5, 1)", "24: (1, 0.7, 1)"))
    result = Record(stage, output, 2, "--frames", "1:2")
    assert "f0001.exr: is there already" in result.out and "f0002.exr: 24x" in result.out


def test_images_count(tmp_path):
    from stages.imageFile import WriteExr
    import numpy as np
    stage = WriteStage(tmp_path, ANIMATED + 'def DomeLight "Sky" { asset inputs:texture:file = @sky.exr@ }')
    WriteExr(tmp_path / "sky.exr", dict.fromkeys("RGB", np.full((4, 8), 0.25, np.float32)))
    output = tmp_path / "o.exr"
    Record(stage, output, 2)
    assert IsThere(Record(stage, output, 2))
    WriteExr(tmp_path / "sky.exr", dict.fromkeys("RGB", np.full((4, 8), 0.75, np.float32)))
    assert not IsThere(Record(stage, output, 2))


def test_whatever_file_a_scene_reads_counts(tmp_path):
    """Volumes, images of light filters, profiles of lights and of mesh lights, images of lights and materials."""
    from hdstream import Renderer
    from hdstream.resume import KeyOf
    names = ("volume.vdb", "filter.png", "light.ies", "meshLight.ies", "rect.png", "look.png")
    for name in names:
        (tmp_path / name).write_bytes(b"first")
    body = """
def Volume "Cloud" { rel field:density = </Cloud/Field>
    def OpenVDBAsset "Field" { asset filePath = @volume.vdb@
        token fieldName = "density" } }
def RectLight "Rect" { rel light:filters = </Filter>
    asset inputs:texture:file = @rect.png@ }
def LightFilter "Filter" { token lightFilter:shaderId = "PxrCookieLightFilter"
    asset inputs:map = @filter.png@ }
def SphereLight "Lamp" (prepend apiSchemas = ["ShapingAPI"]) { asset inputs:shaping:ies:file = @light.ies@ }
def Sphere "Tube" {}
def Mesh "Glow" (prepend apiSchemas = ["MeshLightAPI", "ShapingAPI", "MaterialBindingAPI"]) {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    asset inputs:shaping:ies:file = @meshLight.ies@
    rel material:binding = </Look> }
def Material "Look" { token outputs:surface.connect = </Look/Surface.outputs:surface>
    def Shader "Surface" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </Look/Image.outputs:rgb>
        token outputs:surface }
    def Shader "Image" { uniform token info:id = "UsdUVTexture"
        asset inputs:file = @look.png@
        float3 outputs:rgb } }
"""
    stage = WriteStage(tmp_path, ANIMATED + body)

    def Key():
        renderer = Renderer(str(stage), onWarning=lambda line: None)
        renderer.Prepare(imageWidth=8)
        assert renderer.AssetFiles() == sorted(str(tmp_path / name) for name in names)
        return KeyOf(renderer, AssetHashes())

    keys = [Key(), Key()]
    assert keys[0] == keys[1]
    for name in names:
        (tmp_path / name).write_bytes(b"second")
        keys.append(Key())
    assert len(set(keys)) == 1 + len(names)


@pytest.mark.parametrize("first", [5, 16, 40])
def test_partial_frames_go_on_to_the_bits_of_one_render(first, stage, tmp_path):
    whole, output = tmp_path / "whole.exr", tmp_path / "o.exr"
    assert RunHere("record", stage, whole, *OPTIONS, "--samples", 72).code == 0
    Record(stage, output, first, "--stats", tmp_path / "s.json")
    result = Record(stage, output, 72, "--stats", tmp_path / "s.json")
    assert not IsThere(result) and SameImages(output, whole)
    import json
    rays = json.loads((tmp_path / "s.json").read_text())["rays"]["camera"]
    assert rays == 24 * 17 * (72 - first), "only what was missing is rendered"


def test_a_frame_goes_on_where_it_was_interrupted(stage, tmp_path):
    import signal
    import subprocess
    from cliCase import Command
    output = tmp_path / "o.exr"
    command = Command("record", stage, output, *RESUME, "--samples", 1 << 20)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=dict(os.environ, HDSTREAM_PROGRESS="1"),
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as client:
        seen = ""
        while "samples" not in seen:
            text = os.read(client.stderr.fileno(), 4096).decode()
            assert text, seen
            seen += text
        client.send_signal(signal.SIGINT)
        client.communicate(timeout=SECONDS)
    assert client.returncode == 130
    from hdstream import filmSums
    import numpy as np
    with np.load(filmSums.FileOf(output)) as data:
        done = filmSums.Unpack(data)
    assert done.endSample > 0
    more = done.MostSamples() + 40  # a pass that was stopped has given some pixels more than others
    Record(stage, output, more)
    whole = tmp_path / "whole.exr"
    assert RunHere("record", stage, whole, *OPTIONS, "--samples", more).code == 0
    assert SameImages(output, whole)


def test_other_formats_keep_their_key_beside_them(stage, tmp_path):
    output = tmp_path / "o.png"
    options = ["-w", "24", "--maxDepth", "2", "--resume", "--samples", "4"]
    assert RunHere("record", stage, output, *options).code == 0
    assert "is there already" in RunHere("record", stage, output, *options).out
    assert "is there already" not in RunHere("record", stage, output, *options, "-color", "disabled").out
    output.write_bytes(output.read_bytes()[:-40])
    assert "is there already" not in RunHere("record", stage, output, *options, "-color", "disabled").out


def test_a_picture_that_could_not_be_written_is_not_there(stage, tmp_path, monkeypatch):
    """Whatever ends the write, and though an old picture is there; the samples of the new one are kept."""
    import json
    from hdstream import _core, image
    output, whole, stats = tmp_path / "o.png", tmp_path / "whole.png", tmp_path / "s.json"
    text = stage.read_text()
    stage.write_text(text.replace("intensity = 1", "intensity = 10000"))  # what 8 bits show
    Record(stage, output, 4)
    stage.write_text(text.replace("intensity = 1", "intensity = 20000"))
    assert RunHere("record", stage, whole, *OPTIONS, "--samples", 4).code == 0
    assert output.read_bytes() != whole.read_bytes(), "the test would show little"

    def Fail(*_):
        raise _core.Error("cannot write: No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(image.Image, "Write", Fail)
        assert RunHere("record", stage, output, *RESUME, "--samples", 4).code == 1
    result = Record(stage, output, 4, "--stats", stats)
    assert not IsThere(result) and output.read_bytes() == whole.read_bytes()
    assert json.loads(stats.read_text())["rays"]["camera"] == 0, "the samples were there"
    assert IsThere(Record(stage, output, 4))
    output.write_bytes((tmp_path / "o.png").read_bytes() + b"\0")
    assert not IsThere(Record(stage, output, 4)), "somebody else's file is none"
    assert output.read_bytes() == whole.read_bytes()


def test_sums_that_cannot_be_written_cost_no_picture(stage, tmp_path):
    output = tmp_path / "o.exr"
    (tmp_path / "o.exr.sums").mkdir()
    AssertFails(RunHere("record", stage, output, *RESUME, "--samples", 4), 1, "o.exr.sums")
    assert IsThere(Record(stage, output, 4))


def test_damaged_sums_are_none(tmp_path):
    """Of a valid sidecar: cut anywhere, any byte of its index changed, or another kind of file; never an exception, never
    other words."""
    import io
    import numpy as np
    from hdstream import _core, filmSums
    words = np.random.default_rng(1).integers(0, 1 << 32, (6, 8, 12), dtype=np.uint32)
    file, damaged = str(tmp_path / "a.sums"), tmp_path / "b.sums"
    filmSums.Save(file, _core.FilmSums(8, 6, 0, 16, words), "key", "device")
    assert np.array_equal(filmSums.Load(file, "key")[0].words, words) and filmSums.Load(file, "other")[0] is None
    whole = (tmp_path / "a.sums").read_bytes()
    array = io.BytesIO()
    np.save(array, words)
    contents = [array.getvalue(), b"", *(whole[:size] for size in range(0, len(whole), 400))]
    index = whole.index(b"PK\x01\x02")
    contents += [whole[:at] + bytes([255 - whole[at]]) + whole[at + 1:] for at in range(index, len(whole), 3)]
    contents += [whole[:index + 8] + b"\1" + whole[index + 9:]]  # as if encrypted
    for content in contents:
        damaged.write_bytes(content)
        kept, _ = filmSums.Load(str(damaged), "key")
        assert kept is None or np.array_equal(kept.words, words)


def test_without_sums_all_samples_are_rendered(stage, tmp_path):
    output = tmp_path / "o.exr"
    Record(stage, output, 16)
    (tmp_path / "o.exr.sums").write_bytes(b"damaged")
    Record(stage, output, 32)
    whole = tmp_path / "whole.exr"
    assert RunHere("record", stage, whole, *OPTIONS, "--samples", 32).code == 0
    assert SameImages(output, whole)


def test_a_split_frame_goes_on_too(stage, tmp_path):
    output, whole = tmp_path / "o.exr", tmp_path / "whole.exr"
    assert RunHere("record", stage, whole, *OPTIONS, "--samples", 72).code == 0
    Record(stage, output, 32)
    Record(stage, output, 72, "--workers", 2)
    assert SameImages(output, whole)
    assert IsThere(Record(stage, output, 72, "--workers", 1))
