# SPDX-License-Identifier: Apache-2.0
"""The licences of what a wheel bundles, as Debian's packages state them: shared libraries, and headers whose code is
compiled into the module."""

import importlib.metadata
import pathlib
import re
import subprocess
import sys

HEADER_PACKAGES = ("libglm-dev", "nlohmann-json3-dev", "libopenimageio-dev")
DOCUMENTS = pathlib.Path("/usr/share/doc")
LIBRARY_FOLDERS = ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/lib/x86_64-linux-gnu",
                   "/lib/aarch64-linux-gnu", "/usr/lib")


def SystemName(bundled: str) -> str:
    """libtbb-1a2b3c4d.so.12.8 -> libtbb.so.12.8: auditwheel puts a hash into the name, before its first dot."""
    return re.sub(r"^([^.]+)-[0-9a-f]{8}(?=\.)", r"\1", bundled)


def VersionOf(package: str) -> str:
    return subprocess.run(["dpkg-query", "-W", "-f=${Version}\n", package],
                          capture_output=True, text=True, check=True).stdout.split()[0]


def PackageOf(library: str) -> str:
    """The package that owns a library of the system."""
    for folder in LIBRARY_FOLDERS:
        for path in (f"{folder}/{library}", str(pathlib.Path(f"{folder}/{library}").resolve())):
            found = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True)
            if found.returncode == 0:
                return found.stdout.split(":")[0]
    sys.exit(f"{library}: no package of this system owns it, so that its licence is not known")


def NanobindLicence() -> str:
    files = importlib.metadata.files("nanobind") or []
    return next(path.read_text() for path in files if path.name == "LICENSE" and ".dist-info" in str(path))


def WriteLicences(libraries: list[str], folder: pathlib.Path, hasNanobind: bool = True) -> None:
    """`folder`/THIRD_PARTY.md lists the bundled libraries and what is compiled in; beside it lie the licences."""
    parts = {package: ["headers"] for package in HEADER_PACKAGES}
    for library in sorted(libraries):
        parts.setdefault(PackageOf(SystemName(library)), []).append(library)
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# Bundled parts", "", "Of Debian, unchanged but for the names of files. Sources: `apt-get source PACKAGE=VERSION`.",
             "", "| package | version | files | licence |", "|---|---|---|---|"]
    for package, files in sorted(parts.items()):
        text = (DOCUMENTS / package / "copyright").read_text(errors="replace")
        (folder / f"{package}.txt").write_text(text)
        lines.append(f"| {package} | {VersionOf(package)} | {', '.join(files)} | {package}.txt |")
    if hasNanobind:
        (folder / "nanobind.txt").write_text(NanobindLicence())
        lines += ["", f"Of PyPI: nanobind {importlib.metadata.version('nanobind')}, headers, nanobind.txt."]
    (folder / "THIRD_PARTY.md").write_text("\n".join(lines) + "\n")
