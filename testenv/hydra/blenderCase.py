# SPDX-License-Identifier: Apache-2.0
"""Blender's extension as the zip has it, with the plug-in of the build under test: for tests and benches."""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "packaging")]

import openUsd  # noqa: E402


def MakeExtension(folder: pathlib.Path, blender: str) -> pathlib.Path:
    """The extension's folder, made in `folder`, which need not exist."""
    import blenderExtension

    tree = folder / "hdstream_extension"
    tree.mkdir(parents=True)
    blenderExtension.AddPython(openUsd.BuildFolder(), blender, tree)
    (tree / "plugin").symlink_to(openUsd.BuildFolder() / "plugin")
    return tree
