# SPDX-License-Identifier: Apache-2.0
"""Writes kernels/shared/albedoTable.h: directional albedos of the lobes of layered surfaces (docs/materials.md).

    python testenv/support/makeAlbedoTables.py kernels/shared/albedoTable.h

Axes: sqrt(cosine), roughness = sqrt(alpha), and for dielectrics the ratio (ior - 1) / (ior + 1). Glass has the root of the
ratio, and two tables, seen from outside and from inside. --check prints how far linear interpolation is from the integral between the nodes.
"""

import sys

import numpy as np

NUM_COSINES, NUM_ROUGHNESSES, NUM_RATIOS, NUM_GLASS_RATIOS = 20, 16, 5, 9
LARGEST_RATIO = 0.6  # ior 4
SAMPLES, GLASS_SAMPLES = 160, 96  # squared: points of the unit square


def Fresnel(cosine, ratio):
    """Exact, unpolarised, of a dielectric; seen from the less dense side where the ratio is above 0."""
    eta = (1 + ratio) / (1 - ratio)
    squared = eta * eta - 1 + cosine * cosine
    g = np.sqrt(np.maximum(squared, 1e-12))
    a = (g - cosine) / (g + cosine)
    b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return np.where(squared > 0, np.minimum(0.5 * a * a * (1 + b * b), 1), 1)


class Microfacets:
    """Visible normals of GGX seen at a cosine, stratified (Heitz 2018)."""

    def __init__(self, cosine, roughness, samples=SAMPLES):
        self.alpha = alpha = max(roughness * roughness, 1e-4)
        self.cosine = cosine = max(cosine, 1e-4)
        grid = (np.arange(samples) + 0.5) / samples
        u, v = (axis.ravel() for axis in np.meshgrid(grid, grid))
        wo = np.array([np.sqrt(1 - cosine * cosine), 0.0, cosine])
        i = np.array([alpha * wo[0], 0.0, wo[2]])
        i /= np.linalg.norm(i)
        k = v * (1 + i[2])
        sine = np.sqrt(np.maximum(0, k * (2 - k)))
        h = np.stack([sine * np.cos(2 * np.pi * u) + i[0], sine * np.sin(2 * np.pi * u), 1 - k + i[2]], -1)
        self.normals = np.stack([alpha * h[:, 0], alpha * h[:, 1], np.maximum(h[:, 2], 0)], -1)
        self.normals /= np.linalg.norm(self.normals, axis=-1, keepdims=True)
        self.toNormals = np.clip(self.normals @ wo, 0, 1)

    def _Smith(self, z):
        return np.sqrt(self.alpha * self.alpha * (1 - z * z) + z * z)

    def _Mean(self, z, values):
        """Of values * G2 / G1 over the normals; z: cosine of where each sends the light, not above 0 for nowhere."""
        isThere = z > 0
        z, cosine = np.where(isThere, z, 1.0), self.cosine
        weight = z * (cosine + self._Smith(cosine)) / (cosine * self._Smith(z) + z * self._Smith(cosine))
        return float(np.mean(np.where(isThere, weight * values, 0)))

    def Reflected(self, fresnel):
        """Integral of F D G2 / (4 cos) over the hemisphere."""
        return self._Mean(2 * self.toNormals * self.normals[:, 2] - self.cosine, fresnel(self.toNormals))

    def Refracted(self, ratio):
        """The same of what refracts, which has 1 - F."""
        eta, c = (1 + ratio) / (1 - ratio), self.toNormals
        inner = np.sqrt(np.maximum(1 - (1 - c * c) / (eta * eta), 0))
        return self._Mean(self.cosine / eta - (c / eta - inner) * self.normals[:, 2], 1 - Fresnel(c, ratio))


def MicrofacetAlbedo(cosine, roughness, fresnel):
    return Microfacets(cosine, roughness).Reflected(fresnel)


def GlassAlbedo(cosine, roughness, ratio):
    """Of what glass reflects and refracts; what is missing to 1 bounces more often."""
    microfacets = Microfacets(cosine, roughness, GLASS_SAMPLES)
    return microfacets.Reflected(lambda x: Fresnel(x, ratio)) + microfacets.Refracted(ratio)


def SheenAlbedo(cosine, roughness):
    """Integral of D V cos: Conty and Kulla's distribution, Neubelt and Pettineo's visibility."""
    n = 512
    z = (np.arange(n) + 0.5) / n
    phi = (np.arange(n) + 0.5) / n * np.pi
    z, phi = (axis.ravel() for axis in np.meshgrid(z, phi))
    sine, cosine = np.sqrt(1 - z * z), max(cosine, 1e-4)
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], -1)
    h = wi + np.array([np.sqrt(1 - cosine * cosine), 0, cosine])
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    inverse = 1 / max(roughness, 0.07)
    d = (2 + inverse) * np.maximum(1 - h[:, 2] ** 2, 0) ** (0.5 * inverse) / (2 * np.pi)
    return float(np.mean(d / (4 * (cosine + z - cosine * z)) * z) * 2 * np.pi)


def Nodes(count, largest=1.0):
    return np.arange(count) / (count - 1) * largest


def Tables():
    cosines, roughnesses, ratios = Nodes(NUM_COSINES) ** 2, Nodes(NUM_ROUGHNESSES), Nodes(NUM_RATIOS, LARGEST_RATIO)
    ggx = np.array([[MicrofacetAlbedo(c, r, lambda x: np.ones_like(x)) for c in cosines] for r in roughnesses])
    # As shares of the Fresnel term at the macro normal, which is what varies most.
    dielectric = np.array([[[MicrofacetAlbedo(c, r, lambda x: Fresnel(x, max(s, 1e-3))) / Fresnel(max(c, 1e-4), max(s, 1e-3))
                             for c in cosines] for r in roughnesses] for s in ratios])
    sheen = np.array([[SheenAlbedo(c, r) for c in cosines] for r in roughnesses])
    glass = np.array([[[[GlassAlbedo(c, r, side * max(s, 1e-3)) for c in cosines] for r in roughnesses]
                       for s in LARGEST_RATIO * Nodes(NUM_GLASS_RATIOS) ** 2] for side in (1, -1)])
    return {"ggx": ggx, "dielectric": dielectric, "sheen": sheen, "glass": glass}


def Lookup(table, *at):
    """Multilinear."""
    result = table
    for x, count in zip(at, table.shape):
        f = min(max(x, 0), 1) * (count - 1)
        i = min(int(f), count - 2)
        result = result[i] + (f - i) * (result[i + 1] - result[i])
    return result


def Check(tables):
    rng = np.random.default_rng(1)
    worst = {}
    for _ in range(200):
        c, r, s = rng.uniform(0.02, 1), rng.random(), rng.random() * LARGEST_RATIO
        s = max(s, 1e-2)
        errors = {
            "ggx": Lookup(tables["ggx"], r, np.sqrt(c)) - MicrofacetAlbedo(c, r, lambda x: np.ones_like(x)),
            "dielectric": Lookup(tables["dielectric"], s / LARGEST_RATIO, r, np.sqrt(c)) * Fresnel(c, s)
                          - MicrofacetAlbedo(c, r, lambda x: Fresnel(x, s)),
            "sheen": Lookup(tables["sheen"], r, np.sqrt(c)) - SheenAlbedo(c, r)}
        for name, side in (("glass", 1), ("glass from inside", -1)):
            exact = GlassAlbedo(c, r, side * s)
            errors[name] = exact / Lookup(tables["glass"][0 if side > 0 else 1], np.sqrt(s / LARGEST_RATIO), r, np.sqrt(c)) - 1
        worst = {name: max(worst.get(name, 0.0), abs(error)) for name, error in errors.items()}
    print({name: f"{error:.2g}" for name, error in worst.items()}, "sheen at most", tables["sheen"].max())


def Write(path, tables):
    lines = ["/* SPDX-License-Identifier: Apache-2.0",
             " * Directional albedos, written by testenv/support/makeAlbedoTables.py, which says what the axes",
             " * are. The cosine runs fastest, then the roughness, then the ratio of indices. */",
             "#ifndef HDS_SHARED_ALBEDO_TABLE_H", "#define HDS_SHARED_ALBEDO_TABLE_H", '#include "shared/compat.h"', "",
             f"#define HDS_ALBEDO_COSINES {NUM_COSINES}u", f"#define HDS_ALBEDO_ROUGHNESSES {NUM_ROUGHNESSES}u",
             f"#define HDS_ALBEDO_RATIOS {NUM_RATIOS}u", f"#define HDS_ALBEDO_GLASS_RATIOS {NUM_GLASS_RATIOS}u",
             f"#define HDS_ALBEDO_LARGEST_RATIO {LARGEST_RATIO}f", "",
             "HDS_SHARED_BEGIN", "/* clang-format off */"]
    for name, text in (("ggx", "Of a microfacet reflection that absorbs nothing."),
                       ("dielectric", "Of a dielectric, as a share of its Fresnel term at the macro normal."),
                       ("sheen", "Of the sheen."),
                       ("glass", "Of what glass reflects and refracts: seen from outside, then from inside.")):
        values = tables[name].ravel()
        lines.append(f"/* {text} */")
        lines.append(f"HDS_TABLE f32 albedo_{name}_table[{values.size}] = {{")
        for row in values.reshape(-1, NUM_COSINES):
            lines.append("    " + ", ".join(f"{value:.5f}f" for value in row) + ",")
        lines.append("};")
    lines += ["/* clang-format on */", "HDS_SHARED_END", "", "#endif", ""]
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines))


if __name__ == "__main__":
    made = Tables()
    if "--check" in sys.argv:
        Check(made)
    Write(sys.argv[1], made)
