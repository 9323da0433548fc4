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


_STANDARD, _PREVIEW = "ND_standard_surface_surfaceshader", "UsdPreviewSurface"
# {context: (surface shader, what it emits)}, and which context is drawn.
SURFACES = {
    "unknownMaterialX": ({"mtlx": ("ND_ours_surfaceshader", 0.9), "": (_PREVIEW, 0.1)}, ""),
    "unknownKarma": ({"kma": ("kma_ours", 0.9), "glslfx": (_PREVIEW, 0.2)}, "glslfx"),
    "otherRenderers": ({"": ("PxrSurface", 0.9), "glslfx": (_PREVIEW, 0.3)}, "glslfx"),
    "unknownAndKarma": ({"mtlx": ("ND_ours_surfaceshader", 0.9), "kma": (_STANDARD, 0.4), "": (_PREVIEW, 0.9)}, "kma"),
    "withoutId": ({"mtlx": ("", 0.9), "": (_PREVIEW, 0.5)}, ""),
    "drawn": ({"mtlx": (_STANDARD, 0.6), "": (_PREVIEW, 0.9)}, "mtlx"),
    "onlyMoved": ({"": (_PREVIEW, 0.7)}, ""),  # by mtlx, which has no surface
    "movedBetween": ({"mtlx": ("ND_ours_surfaceshader", 0.9), "": (_PREVIEW, 0.8)}, ""),  # by kma
    "noneIsDrawn": ({"mtlx": ("ND_ours_surfaceshader", 0.9), "": ("PxrSurface", 0.9)}, None),
}


def _AddSurfaces(stage, path, surfaces, mover="mtlx"):
    """A material with a surface for each render context, displaced by that of `mover`."""
    material = UsdShade.Material.Define(stage, path)
    for context, (identifier, emitted) in surfaces.items():
        shader = UsdShade.Shader.Define(stage, f"{path}/S{context}")
        if identifier:
            shader.CreateIdAttr(identifier)
        color = "emissiveColor" if identifier == _PREVIEW else "emission_color"
        for name, value in {color: emitted, "emission": 1.0, "base": 0.0, "specular": 0.0, "diffuseColor": 0.0}.items():
            isColor = "olor" in name
            shader.CreateInput(name, Sdf.ValueTypeNames.Color3f if isColor else Sdf.ValueTypeNames.Float).Set(
                (value, value, value) if isColor else value)
        material.CreateSurfaceOutput(context or UsdShade.Tokens.universalRenderContext).ConnectToSource(
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    move = UsdShade.Shader.Define(stage, f"{path}/Move")
    move.CreateIdAttr("ND_displacement_float")
    move.CreateInput("displacement", Sdf.ValueTypeNames.Float).Set(0.25)
    material.CreateDisplacementOutput(mover).ConnectToSource(move.CreateOutput("out", Sdf.ValueTypeNames.Token))
    return material


def test_a_surface_that_is_drawn_is_preferred_to_one_that_is_not(frontEnds, isStream, tmp_path):
    """Hydra hands over one network a material, the first whose context the material has: the others are asked for."""
    if not isStream or not frontEnds.openUsd.hasMaterialX:
        pytest.skip("needs Stream, and an OpenUSD with MaterialX: materials have no context mtlx without (docs/materials.md)")
    stage = author.NewStage(tmp_path / "surfaces.usda")
    for i, (name, (surfaces, _)) in enumerate(SURFACES.items()):
        author.AddMesh(stage, f"/World/{name}", shapes.Plane(2.0, 1.0),
                       material=_AddSurfaces(stage, f"/World/M{name}", surfaces, "kma" if name == "movedBetween" else "mtlx"),
                       translate=(0, 0, 1.2 * i), color=(0, 0, 0))
    author.AddCamera(stage, eye=(0, 15, 4.8), target=(0, 0, 4.8), up=(0, 0, -1))
    author.AddLight(stage, "/World/Light", "Distant", intensity=0.0)
    stage.GetRootLayer().Save()
    wrapper = WriteWrapper(tmp_path / "surfaces.usda", tmp_path / "wrapper.usda", WIDTH, mode=frontEnds.mode, **SETTINGS)
    differences, output = CompareFrontEnds(frontEnds, wrapper, tmp_path)
    levels = set(np.round(ReadColor(tmp_path / "hydra.exr")[..., 0] * 1000).astype(int).ravel().tolist())
    expected = {round(1000 * surfaces[context][1]) for surfaces, context in SURFACES.values() if context is not None}
    assert expected <= levels and 900 not in levels, output
    CheckDifferences(differences, frontEnds.openUsd.version, frontEnds.mode, "surfaces")
    # Without scene indices UsdImaging drops such surfaces, and tells their ids itself.
    line = "Invalid info:id" if frontEnds.mode == "legacy" else "is not supported; UsdPreviewSurface is used"
    assert line in output, output
    assert "MonlyMoved: surface shader" not in output, output


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
