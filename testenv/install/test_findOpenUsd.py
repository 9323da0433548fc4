# SPDX-License-Identifier: Apache-2.0
"""OpenUSD asks CMake for the exact Python that it was built with; another one that comes first on PATH (pyenv,
conda) must not hide it. OpenUSD's package file stands in for it here, as far as it concerns Python."""

import os
import pathlib
import platform
import sysconfig

import pytest
from installCase import ROOT, Run

VERSION = platform.python_version()
SHORT = sysconfig.get_python_version()
# What pxrConfig.cmake of a build without hints of its own does.
PXR_CONFIG = """
if(NOT DEFINED Python3_EXECUTABLE)
    if(NOT [[/usr/bin/python3]] STREQUAL "")
        set(Python3_EXECUTABLE [[/usr/bin/python3]])
    endif()
endif()
find_package(Python3 "{version}" EXACT COMPONENTS Development REQUIRED)
"""
PROJECT = """cmake_minimum_required(VERSION 3.22)
project(probe LANGUAGES C CXX)
{hint}
find_package(pxr CONFIG REQUIRED HINTS "${{PREFIX}}")
message(STATUS "FOUND ${{Python3_VERSION}}")
"""


@pytest.fixture
def prefixes(tmp_path):
    """OpenUSD's prefix, and that of another Python: headers, a library and the program that tells of them."""
    if not os.path.exists(f"/usr/include/python{SHORT}/Python.h") or not pathlib.Path("/usr/bin/python3").exists():
        pytest.skip("no headers of the system's Python")
    openUsd, other = tmp_path / "usd", tmp_path / "other"
    openUsd.mkdir()
    (openUsd / "pxrConfig.cmake").write_text(PXR_CONFIG.format(version=VERSION))
    include, library = other / "include" / f"python{SHORT}", other / "lib"
    for folder in (include, library, other / "bin"):
        folder.mkdir(parents=True)
    (include / "Python.h").touch()
    (include / "patchlevel.h").write_text(f'#define PY_VERSION "{SHORT}.99"\n')
    (library / f"libpython{SHORT}.so").touch()
    config = other / "bin" / f"python{SHORT}-config"
    config.write_text(f"""#!/bin/sh
case "$*" in
    *--includes*) echo "-I{include}" ;;
    *--ldflags*) echo "-L{library} -lpython{SHORT}" ;;
    *--prefix*) echo "{other}" ;;
    *--configdir*) echo "{library}" ;;
    *--abiflags*) echo "" ;;
    *--extension-suffix*) echo ".so" ;;
esac
""")
    config.chmod(0o755)
    return openUsd, other


@pytest.mark.parametrize("isHinted", [False, True])
def test_python_of_openusd_is_found_behind_another(prefixes, isHinted, tmp_path):
    openUsd, other = prefixes
    hint = f"include({ROOT}/cmake/probeOpenUsd/PythonOfOpenUsd.cmake)\nhds_hint_openusd_python(\"${{PREFIX}}\")"
    (tmp_path / "CMakeLists.txt").write_text(PROJECT.format(hint=hint if isHinted else ""))
    result = Run(["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DPREFIX={openUsd}"],
                 env=dict(os.environ, PATH=f"{other}/bin:/usr/bin:/bin"))
    # Without the hint the other Python is taken: the test would notice if there were nothing to mend.
    assert (f"FOUND {VERSION}" in result.stdout) == isHinted, result.stdout + result.stderr
