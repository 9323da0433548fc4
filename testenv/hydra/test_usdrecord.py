# SPDX-License-Identifier: Apache-2.0
"""usdrecord with the plug-in gives the scene and the picture of `hdstream record`, to the bit.

Both run on generated stages, through both ways in which OpenUSD hands a stage to a renderer. The pictures
are read by testenv's own EXR reader.
"""

import pathlib

import numpy as np
import pytest
from pxr import Sdf, UsdShade, UsdUtils

import instancePrimvarStages
from brokenStages import BROKEN
from frontEnds import MODES, CheckDifferences, CompareFrontEnds, ComparePictures, FrontEnds, ReadColor
from openUsd import RunProgram
from stages import author, shapes
from stages.imageFile import WritePng
from stages.verify import CASES
from viewStage import WriteViewStage
from wrapperStage import WriteWrapper

WIDTH = 64  # pixels
SETTINGS = {"samples": 2, "maxDepth": 3, "seed": 7, "noCache": True}
# The project's stages that differ in what a front end must translate; and the one of the usdview test,
# which has all purposes, an implicit prim and native instances.
STAGES = ["instancing", "subsets", "primvarColors", "authoredNormals", "upAxisZ", "cameraOrthographic",
          "cameraDepthOfField", "cameraOffsets", "cameraExposure", "sphereLightScaled", "rectLightNormalized",
          "domeLatlong", "fiveLights", "surfaceReaders", "surfaceCutout", "surfaceNormalInput", "purposes",
          "pointPrimvars", "nativePrimvars"]
TRANSLATE = pathlib.Path(__file__).resolve().parents[1] / "translate"
TRANSLATED = sorted(path.parent.name for path in TRANSLATE.glob("*/scene.usda"))
PURPOSES = {"purposes": ("proxy", "guide")}


def WriteCase(name, path):
    if name == "purposes":
        WriteViewStage(path)
    elif name in instancePrimvarStages.WRITERS:
        instancePrimvarStages.WRITERS[name](path)
    else:
        CASES[name].Write(path)


@pytest.fixture(params=MODES)
def frontEnds(request, openUsd, plugin, renderer):
    return FrontEnds(openUsd, plugin, renderer, request.param)


def Prepare(name, folder, frontEnds, **settings):
    WriteCase(name, folder / f"{name}.usda")
    return WriteWrapper(folder / f"{name}.usda", folder / "wrapper.usda", WIDTH, mode=frontEnds.mode,
                        purposes=PURPOSES.get(name, ("render",)), **{**SETTINGS, **settings})


@pytest.mark.parametrize("name", STAGES)
def test_scene_and_picture_are_those_of_hdstream_record(name, frontEnds, isStream, tmp_path):
    """Equal dumps, so that a picture that is equal by chance does not pass; equal bits of the picture."""
    wrapper = Prepare(name, tmp_path, frontEnds)
    differences, _ = CompareFrontEnds(frontEnds, wrapper, tmp_path, hasDump=isStream)
    assert ReadColor(tmp_path / "hydra.exr")[..., :3].max() > 0.0
    if isStream:
        CheckDifferences(differences, frontEnds.openUsd.version, frontEnds.mode, f"stages/{name}")


@pytest.mark.parametrize("case", TRANSLATED)
def test_translated_scene_is_that_of_hdstream_record(case, frontEnds, isStream, tmp_path):
    """The scenes of testenv/translate, whose goldens `hdstream record` gives, and their pictures: equal but for what is
    known."""
    if not isStream:
        pytest.skip("only Stream writes dumps")
    if case == "materialX" and not frontEnds.openUsd.hasMaterialX:
        pytest.skip("OpenUSD was built without MaterialX: materials have no context mtlx then (docs/materials.md)")
    wrapper = WriteWrapper(TRANSLATE / case / "scene.usda", tmp_path / "wrapper.usda", WIDTH, mode=frontEnds.mode,
                           purposes=("render", "proxy", "guide"), **SETTINGS)
    differences, _ = CompareFrontEnds(frontEnds, wrapper, tmp_path)
    CheckDifferences(differences, frontEnds.openUsd.version, frontEnds.mode, f"translate/{case}")


@pytest.mark.parametrize("isPackage", [True, False], ids=["usdz", "folder"])
def test_textures_are_relative_to_what_authors_them(isPackage, frontEnds, isStream, tmp_path):
    """Tiles of a UDIM set, and an image with a name that is not ASCII, in a usdz or in the folder of a layer further in."""
    shade = {"t.1001.png": 250, "t.1002.png": 120, "Grün.png": 60}
    folder = tmp_path / "further in"
    folder.mkdir()
    for name, value in shade.items():
        WritePng(folder / name, np.full((4, 4, 3), value, np.uint8))
    stage = author.NewStage(folder / "plates.usda")
    for i, (file, width) in enumerate({"./t.<UDIM>.png": 2.0, "./Grün.png": 1.0}.items()):
        plane = shapes.Plane(2.0, 1.0)
        plane = shapes.Shape(plane.points, plane.counts, plane.indices, plane.normals, plane.texcoords * (width, 1.0))
        material = author.AddMaterial(stage, f"/World/M{i}", diffuseColor=(0, 0, 0))
        texture = UsdShade.Shader.Define(stage, f"/World/M{i}/T")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("raw")
        reader = UsdShade.Shader.Define(stage, f"/World/M{i}/R")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
            reader.CreateOutput("result", Sdf.ValueTypeNames.Float2))
        UsdShade.Shader(stage.GetPrimAtPath(f"/World/M{i}/Surface")).CreateInput(
            "emissiveColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))
        author.AddMesh(stage, f"/World/P{i}", plane, material=material, translate=(0, 0, 1.2 * i))
    author.AddCamera(stage, eye=(0, 4, 0.6), target=(0, 0, 0.6), up=(0, 0, -1))
    author.AddLight(stage, "/World/Light", "Distant", intensity=0.0)
    stage.GetRootLayer().Save()
    plates = folder / "plates.usda"
    if isPackage:
        plates = tmp_path / "plates.usdz"
        assert UsdUtils.CreateNewUsdzPackage(str(folder / "plates.usda"), str(plates))
        for name in shade:
            (folder / name).unlink()
    wrapper = WriteWrapper(plates, tmp_path / "wrapper.usda", WIDTH, mode=frontEnds.mode, **SETTINGS)
    differences, output = CompareFrontEnds(frontEnds, wrapper, tmp_path, hasDump=False)
    if isStream:
        levels = set(np.round(ReadColor(tmp_path / "hydra.exr")[..., 0] * 255).ravel().tolist())
        assert not differences and {60, 120, 250} <= levels, output


def test_the_gpu_path_of_usdrecord_gives_the_same_bits(frontEnds, windowed, isStream, tmp_path):
    """With a GPU the picture goes through a texture of OpenGL and comes back as it was."""
    if not isStream:
        pytest.skip("another renderer's buffers have 8 bits")
    wrapper = Prepare("subsets", tmp_path, frontEnds)
    assert frontEnds.RunUsdrecord(wrapper, tmp_path / "cpu.exr").code == 0
    frontEnds.windowed = windowed
    result = frontEnds.RunUsdrecord(wrapper, tmp_path / "gpu.exr")
    assert result.code == 0, result.output
    assert ComparePictures(tmp_path / "cpu.exr", tmp_path / "gpu.exr").isEqual


def test_settings_of_the_render_settings_prim_count(frontEnds, isStream, tmp_path):
    """Each changes the picture, and to what `hdstream record` makes of it."""
    if not isStream:
        pytest.skip("only Stream knows these settings")

    def Hydra(name, **settings):
        (tmp_path / name).mkdir()
        wrapper = Prepare("subsets", tmp_path / name, frontEnds, **settings)
        result = frontEnds.RunUsdrecord(wrapper, tmp_path / f"{name}.exr")
        assert result.code == 0, result.output
        return wrapper, ReadColor(tmp_path / f"{name}.exr")

    _, base = Hydra("base")
    for name, value in dict(samples=5, maxDepth=0, seed=8, pixelFilter="box").items():
        wrapper, changed = Hydra(name, **{name: value})
        assert frontEnds.RecordHere(wrapper, tmp_path / "record.exr").code == 0
        assert ComparePictures(tmp_path / f"{name}.exr", tmp_path / "record.exr").isEqual, name
        assert not np.array_equal(base, changed), name


def test_hdstream_compare_reads_what_usdrecord_wrote(frontEnds, isStream, tmp_path):
    from hdstream import _core
    wrapper = Prepare("subsets", tmp_path, frontEnds)
    assert frontEnds.RunUsdrecord(wrapper, tmp_path / "hydra.exr").code == 0
    assert frontEnds.RecordHere(wrapper, tmp_path / "record.exr").code == 0
    comparison = _core.CompareImages(str(tmp_path / "hydra.exr"), str(tmp_path / "record.exr"))
    assert comparison.error == "" and [layer.name for layer in comparison.layers] == ["color"]
    if isStream:
        assert comparison.layers[0].numDifferingPixels == 0


@pytest.mark.parametrize("name", BROKEN)
def test_broken_scenes_end_well(name, frontEnds, tmp_path):
    """No crash, no hang, no error of the plug-in's own making: a picture, or exit code 1."""
    (tmp_path / "broken.usda").write_text(BROKEN[name])
    wrapper = WriteWrapper(tmp_path / "broken.usda", tmp_path / "wrapper.usda", 32, **SETTINGS)
    result = frontEnds.RunUsdrecord(wrapper, tmp_path / "out.exr", seconds=120)
    assert result.code in (0, 1), result.output
    ours = [line for line in result.output.splitlines() if "Error" in line and "/hdStream/" in line]
    assert "Traceback" not in result.output and not ours, result.output
    if result.code == 0:
        assert ReadColor(tmp_path / "out.exr").shape[1] == 32


def test_wrong_files_are_errors(openUsd, plugin, renderer, tmp_path):
    """usdrecord's own errors, with the plug-in loaded: exit codes, not crashes."""
    (tmp_path / "bad.usda").write_text("this is no USD")
    for words in (["bad.usda", "out.exr"], ["missing.usda", "out.exr"]):
        result = RunProgram([*openUsd.Program("usdrecord"), "--disableGpu", "--renderer", renderer, *words],
                            openUsd.Environment(plugin), 120, cwd=tmp_path)
        assert 0 < result.code < 124, (words, result.output)


def test_the_list_of_renderers_names_ours(openUsd, plugin, renderer, tmp_path):
    result = RunProgram([*openUsd.Program("usdrecord"), "--help"], openUsd.Environment(plugin), 120)
    assert result.code == 0 and renderer in result.output
