# SPDX-License-Identifier: Apache-2.0
"""Writes kernels/shared/filmTable.h: what interference leaves of red, green and blue (docs/materials.md).

    python testenv/support/makeFilmTable.py kernels/shared/filmTable.h

Node i: the integrals of r(wavelength) cos(2 pi i STEP / wavelength) for the three responses r of linear Rec. 709, each of
which integrates to 1. Beyond the last node nothing is left. The responses are those of the CIE's standard observer, by the
fit of Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2).
"""

import sys

import numpy as np

STEP, NUM_NODES = 10.0, 601  # nanometres of path difference
_RGB_FROM_XYZ = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]])


def Responses(wavelengths):
    """Of red, green and blue [3, wavelength] in nanometres; each integrates to 1."""
    def Lobe(peak, below, above):
        sigma = np.where(wavelengths < peak, below, above)
        return np.exp(-0.5 * ((wavelengths - peak) / sigma) ** 2)

    x = 1.056 * Lobe(599.8, 37.9, 31.0) + 0.362 * Lobe(442.0, 16.0, 26.7) - 0.065 * Lobe(501.1, 20.4, 26.2)
    y = 0.821 * Lobe(568.8, 46.9, 40.5) + 0.286 * Lobe(530.9, 16.3, 31.1)
    z = 1.217 * Lobe(437.0, 11.8, 36.0) + 0.681 * Lobe(459.0, 26.0, 13.8)
    rgb = _RGB_FROM_XYZ @ np.array([x, y, z])
    return rgb / (rgb.sum(1, keepdims=True) * (wavelengths[1] - wavelengths[0]))


def Table():
    wavelengths = np.arange(340.0, 860.0, 0.1)
    differences = STEP * np.arange(NUM_NODES)
    waves = np.cos(2 * np.pi * differences[:, None] / wavelengths)
    return waves @ Responses(wavelengths).T * 0.1


def Write(path, table):
    lines = ["/* SPDX-License-Identifier: Apache-2.0",
             " * What interference leaves of red, green and blue, by path difference; written by",
             " * testenv/support/makeFilmTable.py, which says how. */",
             "#ifndef HDS_SHARED_FILM_TABLE_H", "#define HDS_SHARED_FILM_TABLE_H", '#include "shared/compat.h"', "",
             f"#define HDS_FILM_NODES {NUM_NODES}u", f"#define HDS_FILM_STEP {STEP}f /* nanometres */", "",
             "HDS_SHARED_BEGIN", "/* clang-format off */", f"HDS_TABLE f32 film_table[{3 * NUM_NODES}] = {{"]
    values = table.ravel()
    for first in range(0, len(values), 12):
        lines.append("    " + ", ".join(f"{value:.5f}f" for value in values[first:first + 12]) + ",")
    lines += ["};", "/* clang-format on */", "HDS_SHARED_END", "", "#endif", ""]
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines))


if __name__ == "__main__":
    Write(sys.argv[1], Table())
