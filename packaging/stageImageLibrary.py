# SPDX-License-Identifier: Apache-2.0
"""stageImageLibrary.py WHEEL SDIST FOLDER: what CMake needs to build against the OpenImageIO of PyPI.

The wheel has the shared libraries without headers, the source archive of the same version the headers; the
formatting library that the headers include is the one that the system's OpenImageIO bundles. FOLDER becomes a
prefix for -DOpenImageIO_DIR (docs/decisions/0014-wheel.md)."""

import pathlib
import re
import shutil
import sys
import tarfile
import zipfile

SYSTEM_HEADERS = pathlib.Path("/usr/include/OpenImageIO")

CONFIG = """# The OpenImageIO of PyPI, version {version}, as packaging/stageImageLibrary.py laid it out.
set(OpenImageIO_VERSION {version})
foreach(name OpenImageIO_Util OpenImageIO)
    add_library(OpenImageIO::${{name}} SHARED IMPORTED)
    set_target_properties(OpenImageIO::${{name}} PROPERTIES
        IMPORTED_LOCATION "${{CMAKE_CURRENT_LIST_DIR}}/lib/lib${{name}}.so.{soname}"
        IMPORTED_SONAME "lib${{name}}.so.{soname}"
        INTERFACE_INCLUDE_DIRECTORIES "${{CMAKE_CURRENT_LIST_DIR}}/include;/usr/include/Imath")
endforeach()
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_LINK_LIBRARIES OpenImageIO::OpenImageIO_Util)
"""


def Libraries(wheel: pathlib.Path, folder: pathlib.Path) -> str:
    """Copies the wheel's shared libraries into `folder`; what follows ".so." in their names."""
    sonames = set()
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            match = re.fullmatch(r"OpenImageIO/lib/(libOpenImageIO(?:_Util)?\.so\.(\S+))", name)
            if match:
                (folder / match.group(1)).write_bytes(archive.read(name))
                sonames.add(match.group(2))
    (soname,) = sonames
    return soname


def Headers(sdist: pathlib.Path, folder: pathlib.Path) -> str:
    """Copies the public headers into `folder`/OpenImageIO and configures the one that is a template, as the
    library's own CMake files do; the version."""
    with tarfile.open(sdist) as archive:
        for member in archive.getmembers():
            match = re.fullmatch(r"[^/]+/src/include/(OpenImageIO/(?:\w+/)*\w+\.h(?:\.in)?)", member.name)
            if match and member.isfile():
                target = folder / match.group(1)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(archive.extractfile(member).read())
    version = re.fullmatch(r"openimageio-([0-9.]+)\.tar\.gz", sdist.name).group(1)
    major, minor, patch, tweak = version.split(".")
    values = {
        "PROJECT_VERSION_MAJOR": major, "PROJECT_VERSION_MINOR": minor, "PROJECT_VERSION_PATCH": patch,
        "PROJECT_VERSION_TWEAK": tweak, "PROJECT_VERSION_RELEASE_TYPE": "", "OIIO_USE_COMPILED_FMT_VALUE": "0",
        "PROJ_NAMESPACE": "OpenImageIO", "PROJ_VERSION_NAMESPACE": f"v{major}_{minor}",
        "Imath_VERSION_MAJOR": "3", "Imath_VERSION_MINOR": "1", "CMAKE_CXX_STANDARD": "17",
    }
    template = folder / "OpenImageIO" / "oiioversion.h.in"
    text = re.sub(r"@(\w+)@", lambda match: values[match.group(1)], template.read_text())
    template.with_suffix("").write_text(re.sub(r"#\s*cmakedefine.*", "", text))
    template.unlink()
    shutil.copytree(SYSTEM_HEADERS / "detail" / "fmt", folder / "OpenImageIO" / "detail" / "fmt")
    return version


def Main(wheel: str, sdist: str, target: str) -> None:
    folder = pathlib.Path(target)
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "lib").mkdir(parents=True)
    soname = Libraries(pathlib.Path(wheel), folder / "lib")
    version = Headers(pathlib.Path(sdist), folder / "include")
    (folder / "OpenImageIOConfig.cmake").write_text(CONFIG.format(version=version, soname=soname))


if __name__ == "__main__":
    Main(*sys.argv[1:])
