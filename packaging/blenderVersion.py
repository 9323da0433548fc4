# SPDX-License-Identifier: Apache-2.0
"""blenderVersion.py PREFIX [X.Y]: checks that PREFIX is an OpenUSD of Blender, and prints the version of that Blender.

It is X.Y, else what the folder beside the library is called: Blender keeps its scripts in one of that name. What is wrong is
one line on the error stream, and exit code 1."""

import pathlib
import re
import sys

MINIMUM = 2411  # of OpenUSD, as PXR_VERSION counts
NAMESPACE = "pxrBlender"  # of the OpenUSD that Blender's own builds have
# The lowest version of Blender that takes extensions.
FIRST = (4, 2)


def CheckPrefix(prefix: pathlib.Path) -> pathlib.Path:
    """The package file of an OpenUSD with imaging whose binaries fit Blender's."""
    if not prefix.is_dir():
        sys.exit(f"hdStream: {prefix}: there is no such folder")
    places = [prefix / "pxrConfig.cmake", prefix / "lib" / "cmake" / "pxr" / "pxrConfig.cmake"]
    config = next((place for place in places if place.is_file()), None)
    if config is None:
        sys.exit(f"hdStream: {prefix}: no pxrConfig.cmake: this is no prefix of OpenUSD (docs/hydra.md says how to write one)")
    header = next((folder / "include" / "pxr" / "pxr.h" for folder in (prefix, *prefix.parents)
                   if (folder / "include" / "pxr" / "pxr.h").is_file()), None)
    if header is None or not (header.parent / "imaging").is_dir():
        sys.exit(f"hdStream: {prefix}: no headers of OpenUSD with imaging (include/pxr)")
    text = header.read_text(errors="replace")
    numbers = {name: int(value) for name, value in re.findall(r"#define PXR_(MINOR|PATCH)_VERSION (\d+)", text)}
    version = numbers.get("MINOR", 0) * 100 + numbers.get("PATCH", 0)
    if version < MINIMUM:
        sys.exit(f"hdStream: {prefix}: OpenUSD {version // 100}.{version % 100:02d} is older than "
                 f"{MINIMUM // 100}.{MINIMUM % 100:02d}, with which the plug-in was first built")
    namespace = re.search(r"#define PXR_INTERNAL_NS (\w+)", text)
    if not namespace or not namespace.group(1).startswith(NAMESPACE):
        found = namespace.group(1) if namespace else "none"
        sys.exit(f"hdStream: {prefix}: its namespace is {found}, and Blender's OpenUSD has {NAMESPACE}_...: Blender could "
                 "not load the plug-in")
    return config


def FoundBeside(config: pathlib.Path) -> str:
    """The version of the Blender whose library the package file names; empty: it names none."""
    for text in re.findall(r"(/[^\s\"\];]*libusd_ms\.so)", config.read_text(errors="replace")):
        folder = pathlib.Path(text).parent.parent
        names = [path.name for path in folder.glob("[0-9]*.[0-9]*") if (path / "scripts").is_dir()]
        if len(names) == 1:
            return names[0]
    return ""


def Main(prefix: str, asked: str = "") -> None:
    config = CheckPrefix(pathlib.Path(prefix))
    if asked and not re.fullmatch(r"\d+\.\d+", asked):
        sys.exit(f"hdStream: --blender {asked}: a version is like 4.5")
    found = FoundBeside(config)
    if asked and found and asked != found:
        sys.exit(f"hdStream: {prefix}: its library is that of Blender {found}, not {asked}")
    version = asked or found
    if not version:
        sys.exit(f"hdStream: {prefix}: which Blender has this OpenUSD? Say it with --blender X.Y")
    if tuple(map(int, version.split("."))) < FIRST:
        sys.exit(f"hdStream: Blender {version} takes no extensions; {'.'.join(map(str, FIRST))} is the first that does")
    print(version)


if __name__ == "__main__":
    Main(*sys.argv[1:])
