# SPDX-License-Identifier: Apache-2.0
"""Writes the beauty layer of an EXR as a display-referred picture: displayImage.py IN.exr OUT.png"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from hdstream import _core  # noqa: E402
from stages.imageFile import ReadExr  # noqa: E402


def main(source: str, target: str) -> None:
    channels = ReadExr(source)
    names = [name for name in "RGBA" if name in channels]
    pixels = np.ascontiguousarray(np.stack([channels[name] for name in names], -1), np.float32)
    _core.WriteImage(target, [_core.ImageLayer("color", names, pixels)])


if __name__ == "__main__":
    main(*sys.argv[1:])
