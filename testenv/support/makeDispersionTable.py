# SPDX-License-Identifier: Apache-2.0
"""Writes kernels/shared/dispersionTable.h: the wavelengths that red, green and blue are made of (docs/materials.md).

    python testenv/support/makeDispersionTable.py kernels/shared/dispersionTable.h

A wavelength is given by how much further from that of the line d its index is than those of the lines F and C are from each
other: (1/l^2 - 1/d^2) / (1/F^2 - 1/C^2), which is linear in the index of a glass that follows Cauchy's formula n = A + B/l^2.
Node i of a channel is the quantile i / (NUM_NODES - 1) of its response to light of all wavelengths alike, in linear Rec. 709;
what of a response is below 0 is left out, and so are the outer SKIPPED of it, which reach far and are dim.
"""

import sys

import numpy as np

from makeFilmTable import Responses

NUM_NODES, SKIPPED = 65, 0.004
LINE_C, LINE_D, LINE_F = 656.27, 587.56, 486.13  # nanometres


def Places(wavelengths):
    return (wavelengths ** -2.0 - LINE_D ** -2.0) / (LINE_F ** -2.0 - LINE_C ** -2.0)


def Table():
    """[3][NUM_NODES], from long wavelengths to short ones."""
    wavelengths = np.arange(360.0, 830.0, 0.1)[::-1]
    rows = []
    for response in np.maximum(Responses(wavelengths[::-1])[:, ::-1], 0.0):
        share = np.cumsum(response) / response.sum()
        at = SKIPPED + (1 - 2 * SKIPPED) * np.linspace(0.0, 1.0, NUM_NODES)
        rows.append(np.interp(at, share, Places(wavelengths)))
    return np.array(rows)


def Write(path, table):
    lines = ["/* SPDX-License-Identifier: Apache-2.0",
             " * The wavelengths of red, green and blue, by how far their indices are from that of the line d;",
             " * written by testenv/support/makeDispersionTable.py, which says how. */",
             "#ifndef HDS_SHARED_DISPERSION_TABLE_H", "#define HDS_SHARED_DISPERSION_TABLE_H", '#include "shared/compat.h"', "",
             f"#define HDS_DISPERSION_NODES {NUM_NODES}u /* of a channel */", "",
             "HDS_SHARED_BEGIN", "/* clang-format off */", f"HDS_TABLE f32 dispersion_table[{3 * NUM_NODES}] = {{"]
    values = table.ravel()
    for first in range(0, len(values), 11):
        lines.append("    " + ", ".join(f"{value:.5f}f" for value in values[first:first + 11]) + ",")
    lines += ["};", "/* clang-format on */", "HDS_SHARED_END", "", "#endif", ""]
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines))


if __name__ == "__main__":
    Write(sys.argv[1], Table())
