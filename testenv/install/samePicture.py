# SPDX-License-Identifier: Apache-2.0
"""samePicture.py EXR PNG: whether both show the same, the first in linear light, the second in sRGB; exit code 1 if not.
Reads them by the image library that a wheel brings, and knows nothing of hdStream."""

import sys

import numpy as np
import OpenImageIO as oiio


def _Read(path: str) -> np.ndarray:
    image = oiio.ImageInput.open(path)
    assert image, oiio.geterror()
    return image.read_image(oiio.FLOAT)[..., :3]


linear, shown = (_Read(path) for path in sys.argv[1:3])
linear = np.clip(linear, 0, 1)
expected = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
difference = float(np.abs(expected - shown).max())
print(f"{shown.shape[1]} x {shown.shape[0]} pixels, largest difference {difference:.4f}, deviation {shown.std():.3f}")
sys.exit(0 if difference < 0.004 and shown.std() > 0.05 else 1)
