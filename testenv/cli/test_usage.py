# SPDX-License-Identifier: Apache-2.0
"""Wrong usage and bad files: one line that names the option or file, and the right exit code."""

import ctypes.util
import json
import os
import shutil
import subprocess
import sys

import pytest

from cliCase import SCENE, SMALL, AssertFails, Run, RunHere, WriteStage


@pytest.mark.parametrize("arguments, part", [
    ([], "no COMMAND: record renders a stage"),
    (["paint"], "paint"),
    (["record"], "STAGE"),
    (["record", "a.usda", "b.exr", "--imageWidth", "0"], "0 is not in 1..32768"),
    (["record", "a.usda", "b.exr", "-w", "100000", "--imageHeight", "100000"], "100000 is not in 1..32768"),
    (["record", "a.usda", "b.exr", "--imageHeight", "100000"], "--imageHeight"),
    (["record", "a.usda", "b.exr", "-w", "ten"], "'ten' is not a whole number"),
    (["record", "a.usda", "b.exr", "--samples", "0"], "--samples"),
    (["record", "a.usda", "b.exr", "--mask", ","], "--mask: no paths"),
    (["record", "a.usda", "b.exr", "--maxDepth", "-1"], "--maxDepth"),
    (["record", "a.usda", "b.exr", "--seed", "-1"], "--seed"),
    (["record", "a.usda", "b.exr", "--time", "nan"], "--time"),
    (["record", "a.usda", "b.exr", "--noise", "-0.5"], "--noise"),
    (["record", "a.usda", "b.exr", "--complexity", "extreme"], "extreme"),
    (["record", "a.usda", "b.exr", "--complexity", "9"], "'9'"),
    (["record", "a.usda", "b.exr", "--residency", "nowhere"], "nowhere"),
    (["record", "a.usda", "b.exr", "--geometryMemory", "12Q"], "--geometryMemory"),
    (["record", "a.usda", "b.exr", "--textureMemory", "130%"], "130%"),
    (["record", "a.usda", "b.exr", "--volumeMemory", "lots"], "--volumeMemory"),
    (["record", "a.usda", "b.exr", "--hostMemory", "0"], "--hostMemory"),
    (["record", "a.usda", "b.exr", "--chunkSize", "big"], "--chunkSize"),
    (["record", "a.usda", "b.exr", "--waveSize", "-1"], "--waveSize"),
    (["record", "a.usda", "b.exr", "--purposes", "render,none"], "'none'"),
    (["record", "a.usda", "b.exr", "--aovs", "color,colour"], "colour"),
    (["record", "a.usda", "b.exr", "--aovs", ","], "--aovs"),
    (["record", "a.usda", "b.exr", "--aovs", "color,lpe:C<RX>L"], "'C<RX>L', column 4: 'X' is no scattering (D G S s)"),
    (["record", "a.usda", "b.exr", "--aovs", "lpe:CD{2,1}L"], "'CD{2,1}L', column 7: the second count is below the first"),
    (["record", "a.usda", "b.exr", "--aovs", "lightGroup:"], "lightGroup:"),
    (["record", "a.usda", "b.exr", "--frames", "1", "--defaultTime"], "--defaultTime"),
    (["record", "a.usda", "b\udcff.exr"], "'b\\udcff.exr'"),
    (["record", "a.usda", "--samples", "1", "b.gif"], "cannot write 'b.gif'"),
    (["record", "a.usda", "--samples", "1", "b.exr", "c.exr"], "hdstream record: unrecognized arguments: b.exr c.exr"),
    (["record", "a.usda", "b.exr", "--cam", "x"], "hdstream record: unrecognized arguments: --cam x; did you mean --camera?"),
    (["record", "a.usda", "b.exr", "--width", "64", "--sample=8"], "--width 64 --sample=8; did you mean --imageWidth, --samples?"),
    (["info", "a.usda", "--jso", "b"], "hdstream info: unrecognized arguments: --jso b; did you mean --json?"),
    (["record", "a.usda", "b.gif"], "b.gif"),
    (["record", "a.usda", "b.png", "--aovs", "motionForward,depth"], "two channels ('motionForward') can only be stored"),
    (["record", "a.usda", "b.jpg", "--aovs", "primId"], "ids ('primId') can only be stored in an .exr file"),
    (["record", "a.usda", "noExtension"], "noExtension"),
    (["compare", "a.exr"], "B"),
    (["compare", "a.exr", "b.exr", "--threshold", "x"], "--threshold"),
    (["cache", "--empty"], "--empty"),
])
def test_wrong_usage_is_exit_code_2(arguments, part):
    AssertFails(RunHere(*arguments), 2, part)


@pytest.mark.parametrize("word", ["--zzz", "c.exr", "width"])
def test_what_comes_close_to_no_option_is_no_guess(word):
    result = RunHere("record", "a.usda", "b.exr", word)
    AssertFails(result, 2, f"hdstream record: unrecognized arguments: {word}")
    assert result.errors[0].endswith(word), result.text


@pytest.mark.parametrize("arguments, part", [
    (["--frames", "1:x"], "1:x"),
    (["--frames", "1:"], "1:"),
    (["--frames", ""], "--frames"),
    (["--frames", "1:10000000000"], "more than 1000000 frames"),
    (["--frames", "inf"], "--frames inf: not a frame spec"),
    (["--frames", "inf:1"], "--frames inf:1: not a frame spec"),
    (["--frames", "1e300"], "--frames 1e300: not a frame spec"),
    (["--frames", "-2:x"], "--frames -2:x: not a frame spec"),
    (["-f", "-2:0"], "--frames -2:0 needs a frame placeholder"),
    (["--frames", "1:3"], "placeholder"),
    (["--camera", "nobody"], "--camera nobody"),
    (["--camera", "/Triangle"], "--camera /Triangle"),
    (["--mask", "relative"], "--mask relative"),
    (["--renderSettingsPrimPath", "/None"], "/None"),
    (["--renderPassPrimPath", "/Triangle"], "--renderPassPrimPath /Triangle"),
])
def test_wrong_usage_for_a_stage(tmp_path, arguments, part):
    stage = WriteStage(tmp_path)
    AssertFails(RunHere("record", stage, tmp_path / "o.exr", *SMALL, *arguments), 2, part)


def test_placeholder_needs_frames_and_digits(tmp_path):
    stage = WriteStage(tmp_path)
    AssertFails(RunHere("record", stage, tmp_path / "o.##.exr", *SMALL), 2, "--frames")
    AssertFails(RunHere("record", stage, tmp_path / "o.##.exr", *SMALL, "-f", "1:2x0.25"), 2, "####.##")
    AssertFails(RunHere("record", stage, tmp_path / "o.#.#.a#.exr", *SMALL, "-f", "1:2"), 2, "placeholder")


@pytest.mark.parametrize("frames, name, part", [
    ("1.5:3.5", "o.####.exr", "needs a placeholder with 1 digits after the dot, as ####.#"),
    ("1.1,1.25", "o.####.#.exr", "needs a placeholder with 2 digits"), ("2.5", "o.##.exr", "####.#"),
    ("15e-1,25e-1", "o.####.exr", "o.0002.exr would hold both 1.5 and 2.5")])
def test_frames_at_fractional_times_have_files_of_their_own(frames, name, part, tmp_path):
    """They overwrote each other, with exit code 0."""
    AssertFails(RunHere("record", WriteStage(tmp_path), tmp_path / name, *SMALL, "-f", frames), 2, part)
    assert not list(tmp_path.glob("*.exr"))


def test_statistics_of_fractional_times_have_files_of_their_own(tmp_path):
    stats = ["--stats", tmp_path / "s.####.json"]
    AssertFails(RunHere("record", WriteStage(tmp_path), tmp_path / "o.#.#.exr", *SMALL, "-f", "1.5:2.5", *stats), 2,
                "s.0002.json would hold both 1.5 and 2.5")


def test_frames_that_fit_their_names_are_recorded(tmp_path):
    from hdstream.stage import FrameOutputs, ParseFrames
    assert ParseFrames("1.50:3.50,7.0,8:9x0.250") == ([1.5, 2.5, 3.5, 7, 8, 8.25, 8.5, 8.75, 9], 2)
    one = FrameOutputs(None, "1.5", False, "o.exr")
    assert one.timeCodes == [1.5] and one.FileOf(1.5) == "o.exr", "a single frame needs no number"
    result = RunHere("record", WriteStage(tmp_path), tmp_path / "o.##.#.exr", *SMALL, "-f", "1.5:2.5")
    assert result.code == 0 and sorted(path.name for path in tmp_path.glob("*.exr")) == ["o.01.5.exr", "o.02.5.exr"], result.text


@pytest.mark.parametrize("command", ["record", "info"])
def test_missing_and_unreadable_stages(tmp_path, command):
    output = [tmp_path / "o.exr", *SMALL] if command == "record" else []
    AssertFails(RunHere(command, tmp_path / "none.usda", *output), 1, "none.usda", "no such file")
    broken = tmp_path / "broken.usda"
    broken.write_text("#usda 1.0\ndef Mesh {", encoding="utf-8")
    AssertFails(RunHere(command, broken, *output), 1, "broken.usda")
    notUsd = tmp_path / "picture.png"
    notUsd.write_bytes(b"\x89PNG")
    AssertFails(RunHere(command, notUsd, *output), 1, "picture.png", "not a USD stage")
    for name in ("binary.usd", "binary.usdc", "binary.usda", "binary.usdz"):
        (tmp_path / name).write_bytes(bytes(range(256)) * 4)
        AssertFails(RunHere(command, tmp_path / name, *output), 1, name)
    (tmp_path / "empty.usda").write_bytes(b"")
    AssertFails(RunHere(command, tmp_path / "empty.usda", *output), 1, "empty.usda")
    AssertFails(RunHere(command, tmp_path, *output), 1, tmp_path)
    os.mkfifo(tmp_path / "pipe.usda")  # nobody writes into it
    AssertFails(Run(command, tmp_path / "pipe.usda", *output), 1, "pipe.usda", "is not a file")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="pipes are found by what Linux says of threads")
@pytest.mark.parametrize("command", ["record", "info"])
def test_layers_that_are_pipes_are_not_waited_for(tmp_path, command):
    """Nobody writes into them. What else there is, is drawn."""
    for name in ("below.usda", "prop.usd", "late.usdc", "look.mtlx"):
        os.mkfifo(tmp_path / name)
    body = SCENE + """def "Prop" (references = @./prop.usd@) { }
def "Late" (payload = @./late.usdc@</A>) { }
def "Look" (references = @./look.mtlx@</MaterialX>) { }
"""
    stage = WriteStage(tmp_path, body, header="(subLayers = [@./below.usda@])")
    result = Run(command, stage, *([tmp_path / "o.exr", *SMALL] if command == "record" else []))
    assert result.code == 0, result.text
    for name in ("below.usda", "prop.usd", "late.usdc"):
        said = [line for line in result.warnings if f"{name} is a pipe, not a file" in line]
        assert len(said) == 1, result.text
    assert [line for line in result.warnings if "look.mtlx" in line], result.text
    assert command == "info" or (tmp_path / "o.exr").exists()


CLIPS = """def "Prop" ( clips = {{ dictionary default = {{
        asset[] assetPaths = [@./{clip}@]
        string primPath = "/Prop"
        double2[] active = [(0, 0)]
        double2[] times = [(0, 0), (10, 10)]
        {manifest}
    }} }} ) {{
    def Mesh "Leaf" {{
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points
    }}
}}
"""
CLIP = 'over "Prop" { over "Leaf" { point3f[] points.timeSamples = { 0: [(-1, -1, 0), (1, -1, 0), (0, 1, 0)] } } }'


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="pipes are found by what Linux says of threads")
@pytest.mark.parametrize("clip, manifest", [("pipe.usda", ""), ("clip.usda", "pipe.usda"), ("pipe.usda", "names.usda")])
def test_value_clips_that_are_pipes_are_not_waited_for(tmp_path, clip, manifest):
    """Nobody writes into them. OpenUSD opens them with the stage, for want of a manifest, or with the first value."""
    os.mkfifo(tmp_path / "pipe.usda")
    WriteStage(tmp_path, CLIP, name="clip.usda")
    WriteStage(tmp_path, 'over "Prop" { over "Leaf" { point3f[] points } }', name="names.usda")
    body = CLIPS.format(clip=clip, manifest=manifest and f"asset manifestAssetPath = @./{manifest}@")
    result = Run("record", WriteStage(tmp_path, SCENE + body), tmp_path / "o.exr", *SMALL, "--frames", "1")
    assert result.code == 0 and not result.errors, result.text
    assert [line for line in result.warnings if "pipe.usda" in line and "is a pipe, not a file" in line], result.text
    assert (tmp_path / "o.exr").exists()


def test_text_for_a_pipe_waits_for_no_reader(tmp_path):
    """With a reader it arrives whole."""
    stage, pipe = WriteStage(tmp_path), tmp_path / "pipe.json"
    os.mkfifo(pipe)
    AssertFails(Run("info", stage, "--json", pipe), 1, "--json", "pipe.json", "nobody reads")
    AssertFails(Run("record", stage, tmp_path / "o.exr", *SMALL, "--stats", pipe), 1, "--stats", "pipe.json", "nobody reads")
    assert (tmp_path / "o.exr").exists()
    with subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE) as reader:
        assert Run("info", stage, "--json", pipe).code == 0
        assert "primTypes" in json.loads(reader.communicate(timeout=60)[0])


def test_unwritable_output_is_found_before_rendering(tmp_path):
    stage = WriteStage(tmp_path)
    AssertFails(RunHere("record", stage, tmp_path / "none" / "o.exr", *SMALL), 1, "none")
    (tmp_path / "folder.exr").mkdir()
    AssertFails(RunHere("record", stage, tmp_path / "folder.exr", *SMALL), 1, "folder.exr")
    AssertFails(RunHere("record", stage, tmp_path / "o.exr", *SMALL, "--stats", tmp_path / "none" / "s.json"),
                1, "--stats", "s.json")
    assert not (tmp_path / "o.exr").exists()


def test_statistics_overwrite_neither_the_picture_nor_the_stage(tmp_path):
    stage = WriteStage(tmp_path)
    before = stage.read_bytes()
    (tmp_path / "link").symlink_to(tmp_path, target_is_directory=True)
    AssertFails(RunHere("record", stage, tmp_path / "o.exr", *SMALL, "--stats", tmp_path / "link" / "o.exr"), 2, "--stats", "the picture")
    AssertFails(RunHere("record", stage, tmp_path / "o.#.exr", *SMALL, "-f", "1:2", "--stats", tmp_path / "o.2.exr"),
                2, "--stats", "the picture")
    AssertFails(RunHere("record", stage, tmp_path / "o.exr", *SMALL, "--stats", stage), 2, "--stats", "the stage")
    assert not list(tmp_path.glob("*.exr")) and stage.read_bytes() == before


@pytest.fixture(scope="module")
def turkish(tmp_path_factory):
    """The environment of a user whose language has another lower case of I."""
    folder = tmp_path_factory.mktemp("locales")
    if not shutil.which("localedef") or subprocess.run(["localedef", "-i", "tr_TR", "-f", "UTF-8", folder / "tr_TR.UTF-8"],
                                                       capture_output=True).returncode:
        pytest.skip("no localedef, or no sources of locales")
    return {"LOCPATH": str(folder), "LC_ALL": "tr_TR.UTF-8"}


def test_extensions_in_a_turkish_locale(tmp_path, turkish):
    isOther = "import ctypes; print(ctypes.CDLL(None).tolower(ord('I')) != ord('i'))"
    assert subprocess.run([sys.executable, "-c", isOther], env={**os.environ, **turkish}, capture_output=True).stdout == b"True\n"
    result = Run("record", WriteStage(tmp_path), tmp_path / "O.TIF", *SMALL, environment=turkish)
    assert result.code == 0 and (tmp_path / "O.TIF").exists(), result.text


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_folder(tmp_path):
    stage = WriteStage(tmp_path)
    folder = tmp_path / "readOnly"
    folder.mkdir(mode=0o555)
    AssertFails(Run("record", stage, folder / "o.exr", *SMALL), 1, "o.exr")


def test_a_home_that_cannot_be_written(tmp_path):
    """PoCL has a device all the same (hdStream/device/poclCache.h)."""
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    environment = {"HOME": str(blocked), "XDG_CACHE_HOME": str(blocked), "POCL_CACHE_DIR": ""}
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, environment=environment)
    assert result.code == 0 and not result.errors, result.text


def test_no_opencl_device(tmp_path):
    """The loader looks for drivers in a folder that has none."""
    empty = tmp_path / "vendors"
    empty.mkdir()
    environment = {"OCL_ICD_VENDORS": str(empty), "OPENCL_VENDOR_PATH": str(empty), "OCL_ICD_FILENAMES": ""}
    AssertFails(Run("devices", environment=environment), 1, "no OpenCL device")
    AssertFails(Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, environment=environment),
                1, "no OpenCL device")


@pytest.mark.skipif(ctypes.util.find_library("OpenImageDenoise"), reason="the system has Open Image Denoise")
def test_no_denoiser(tmp_path):
    """A package of that name that has no library."""
    (tmp_path / "pyoidn").mkdir()
    (tmp_path / "pyoidn" / "__init__.py").touch()
    environment = {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    AssertFails(Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--denoise", environment=environment),
                1, "Open Image Denoise 2 was not found")
    assert not (tmp_path / "o.exr").exists()


def test_unknown_device(tmp_path):
    AssertFails(Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--device", "Abacus"),
                2, "Abacus")


def test_help_and_version_exit_with_0():
    for arguments in (["--help"], ["record", "--help"], ["info", "--help"], ["--version"]):
        result = RunHere(*arguments)
        assert result.code == 0 and not result.errors and result.out


@pytest.mark.parametrize("arguments, heavy", [
    (["--help"], {"pxr", "numpy", "hdstream._core"}),
    (["info", "--help"], {"pxr", "numpy", "hdstream._core"}),
    (["record", "--help"], {"pxr", "numpy"}),  # its options come from the core's settings table
])
def test_help_needs_no_heavy_module(arguments, heavy):
    """Startup stays fast."""
    import subprocess
    import sys
    code = ("import sys, hdstream.cli as c\n"
            f"try: c.Main({arguments})\nexcept SystemExit: pass\n"
            f"assert not {heavy} & set(sys.modules), 'imported'")
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
