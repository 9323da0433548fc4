# SPDX-License-Identifier: Apache-2.0
"""Closed forms and double-precision quadrature that the tests hold pictures against.

All in world units, float64. Irradiance functions take points [n][3] and one unit normal, and return
irradiance per unit radiance of the light.
"""

import numpy as np


def IrradianceOfSphere(points, normal, centre, radius) -> np.ndarray:
    """pi (R/d)^2 cos: a sphere wholly above the horizon (Siegel and Howell, configuration factors)."""
    d = np.asarray(centre) - points
    distance2 = np.sum(d * d, -1)
    return np.pi * radius**2 / distance2 * (d @ normal) / np.sqrt(distance2)


def _IrradianceOfPatches(points, normal, centres, normals, area) -> np.ndarray:
    """Sum over emitting patches of area `area` each; the back sides emit nothing."""
    total = np.zeros(len(points))
    for centre, lightNormal in zip(centres, normals):
        d = centre - points
        distance2 = np.sum(d * d, -1)
        cosines = np.maximum(d @ normal, 0) * np.maximum(-(d @ lightNormal), 0)
        total += area * cosines / distance2**2
    return total


def IrradianceOfRect(points, normal, matrix, width, height, steps: int = 64) -> np.ndarray:
    """Midpoint rule over a UsdLux rect: emits along -z of `matrix` (row vectors)."""
    x, y = np.meshgrid((np.arange(steps) + 0.5) / steps - 0.5, (np.arange(steps) + 0.5) / steps - 0.5)
    local = np.stack([x.ravel() * width, y.ravel() * height, 0 * x.ravel()], -1)
    edges = [width * matrix[0, :3], height * matrix[1, :3]]
    area = np.linalg.norm(np.cross(*edges)) / steps**2
    return _IrradianceOfPatches(points, normal, local @ matrix[:3, :3] + matrix[3, :3],
                                np.tile(-_Unit(matrix[2, :3]), (steps**2, 1)), area)


def IrradianceOfDisk(points, normal, matrix, radius, rings: int = 48, sectors: int = 96) -> np.ndarray:
    """Midpoint rule in equal areas over a UsdLux disk."""
    r = radius * np.sqrt((np.arange(rings) + 0.5) / rings)
    phi = 2 * np.pi * (np.arange(sectors) + 0.5) / sectors
    local = np.stack([np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.zeros((rings, sectors))], -1).reshape(-1, 3)
    scale = np.linalg.norm(np.cross(matrix[0, :3], matrix[1, :3]))
    return _IrradianceOfPatches(points, normal, local @ matrix[:3, :3] + matrix[3, :3],
                                np.tile(-_Unit(matrix[2, :3]), (len(local), 1)), np.pi * radius**2 * scale / len(local))


def IrradianceOfCylinder(points, normal, matrix, radius, length, steps: int = 96, sectors: int = 96) -> np.ndarray:
    """Midpoint rule over the side of a UsdLux cylinder (axis x, no caps); similar transforms."""
    x = length * ((np.arange(steps) + 0.5) / steps - 0.5)
    phi = 2 * np.pi * (np.arange(sectors) + 0.5) / sectors
    gx, gp = np.meshgrid(x, phi, indexing="ij")
    outward = np.stack([0 * gx, np.cos(gp), np.sin(gp)], -1).reshape(-1, 3)
    local = radius * outward + np.stack([gx, 0 * gx, 0 * gx], -1).reshape(-1, 3)
    scale = np.linalg.norm(matrix[0, :3])
    normals = outward @ matrix[:3, :3] / scale
    area = 2 * np.pi * radius * length * scale**2 / (steps * sectors)
    return _IrradianceOfPatches(points, normal, local @ matrix[:3, :3] + matrix[3, :3], normals, area)


def ShapingFactor(emitted, matrix, shaping: dict) -> np.ndarray:
    """What UsdLuxShapingAPI leaves of the radiance [n][3] in unit directions [n][3] in which it leaves a light of that
    `matrix` (row vectors; similar transforms). `shaping` has the schema's names; `profile`: a function of polar angle
    and azimuth in radians."""
    rotation = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=1, keepdims=True)
    x, y, z = (emitted @ rotation.T).T
    angle = np.arctan2(np.hypot(x, y), -z)
    cutoff = np.radians(shaping.get("coneAngle", 90.0))
    start = cutoff * (1 - shaping.get("coneSoftness", 0.0))
    step = np.clip((angle - start) / max(cutoff - start, 1e-12), 0, 1)
    factor = np.where(angle > cutoff, 0.0, 1 - step * step * (3 - 2 * step))
    if "profile" in shaping:
        scale = shaping.get("iesAngleScale", 0.0)
        polar = angle if scale == 0 else angle / scale if scale > 0 else np.pi - (np.pi - angle) / -scale
        factor = factor * shaping["profile"](np.clip(polar, 0, np.pi), np.arctan2(y, x) % (2 * np.pi))
    focus = np.abs(z)[:, None] ** shaping.get("focus", 0.0)
    return factor[:, None] * (focus + (1 - focus) * np.array(shaping.get("focusTint", (0, 0, 0)), float))


def IrradianceOfShaped(points, normal, patches, matrix, shaping) -> np.ndarray:
    """[n][3] per unit radiance: a sum over `patches` = (centres, normals, area of each)."""
    centres, normals, area = patches
    total = np.zeros((len(points), 3))
    for centre, lightNormal in zip(centres, normals):
        d = centre - points
        distance = np.linalg.norm(d, axis=-1)
        cosines = np.maximum(d @ normal, 0) * np.maximum(-(d @ lightNormal), 0)
        total += (area * cosines / distance**4)[:, None] * ShapingFactor(-d / distance[:, None], matrix, shaping)
    return total


def PatchesOfSphere(matrix, radius, steps: int = 40):
    """Equal areas of a UsdLux sphere under a similar transform."""
    z, phi = np.meshgrid(2 * (np.arange(steps) + 0.5) / steps - 1, 2 * np.pi * (np.arange(2 * steps) + 0.5) / (2 * steps),
                         indexing="ij")
    r = np.sqrt(1 - z * z)
    outward = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1).reshape(-1, 3)
    radius = radius * np.linalg.norm(matrix[0, :3])
    return matrix[3, :3] + radius * outward, outward, 4 * np.pi * radius**2 / len(outward)


def PatchesOfFlat(matrix, width, height=None, steps: int = 40):
    """Equal areas of a UsdLux rect, or of a disk of radius `width`."""
    if height is not None:
        x, y = np.meshgrid((np.arange(steps) + 0.5) / steps - 0.5, (np.arange(steps) + 0.5) / steps - 0.5)
        local, area = np.stack([x * width, y * height, 0 * x], -1).reshape(-1, 3), width * height
    else:
        r = width * np.sqrt((np.arange(steps) + 0.5) / steps)
        phi = 2 * np.pi * (np.arange(2 * steps) + 0.5) / (2 * steps)
        local = np.stack([np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.zeros((steps, 2 * steps))], -1)
        local, area = local.reshape(-1, 3), np.pi * width**2
    area *= np.linalg.norm(np.cross(matrix[0, :3], matrix[1, :3]))
    return local @ matrix[:3, :3] + matrix[3, :3], np.tile(-_Unit(matrix[2, :3]), (len(local), 1)), area / len(local)


def PatchesOfCylinder(matrix, radius, length, steps: int = 40):
    """Equal areas of the side of a UsdLux cylinder under a similar transform."""
    x, phi = np.meshgrid(length * ((np.arange(steps) + 0.5) / steps - 0.5), 2 * np.pi * (np.arange(steps) + 0.5) / steps)
    outward = np.stack([0 * x, np.cos(phi), np.sin(phi)], -1).reshape(-1, 3)
    local = radius * outward + np.outer(x.ravel(), (1, 0, 0))
    scale = np.linalg.norm(matrix[0, :3])
    return (local @ matrix[:3, :3] + matrix[3, :3], outward @ matrix[:3, :3] / scale,
            2 * np.pi * radius * length * scale**2 / len(local))


def IrradianceOfShapedCone(normal, matrix, halfAngle, shaping, steps: int = 200) -> np.ndarray:
    """[3]: a shaped distant light, by midpoints over its cone."""
    cosine, phi = np.meshgrid(1 - (1 - np.cos(halfAngle)) * (np.arange(steps) + 0.5) / steps,
                              2 * np.pi * (np.arange(steps) + 0.5) / steps)
    sine = np.sqrt(1 - cosine**2)
    toLight = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], -1).reshape(-1, 3) @ matrix[:3, :3]
    weights = np.maximum(toLight @ normal, 0)[:, None] * ShapingFactor(-toLight, matrix, shaping)
    return 2 * np.pi * (1 - np.cos(halfAngle)) * weights.mean(0)


def IrradianceOfCone(normal, axis, halfAngle) -> float:
    """pi sin^2 cos: a distant light, its whole cone above the horizon; `axis` points to the light."""
    return float(np.pi * np.sin(halfAngle) ** 2 * np.dot(normal, axis))


def IrradianceOfLatlong(image, normal) -> np.ndarray:
    """A dome image [height][width][3] by its texels, in OpenEXR's orientation (+z in the centre, +x at
    the first quarter, +y up), the dome untransformed."""
    height, width = image.shape[:2]
    theta = np.pi * (np.arange(height) + 0.5) / height
    longitude = np.pi - 2 * np.pi * (np.arange(width) + 0.5) / width
    direction = np.stack([np.outer(np.sin(theta), np.sin(longitude)), np.outer(np.cos(theta), np.ones(width)),
                          np.outer(np.sin(theta), np.cos(longitude))], -1)
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solidAngle = (edges[:-1] - edges[1:]) * 2 * np.pi / width
    return np.einsum("ijc,ij,i->c", image, np.maximum(direction @ normal, 0), solidAngle)


def EnclosureRadiance(emission: float, albedo: float, fraction: float, bounces: int | None = None) -> float:
    """Wall radiance of a sphere of Lambert albedo, of which the black, emitting `fraction` has radiance
    `emission`: the sphere's exchange is uniform, L = rho (f e + (1 - f) L). `bounces` truncates: a ray
    sees wall vertices 0..bounces, as --maxDepth counts."""
    total, wall = 0.0, albedo * fraction * emission
    for _ in range(10000 if bounces is None else bounces + 1):
        total += wall
        wall *= albedo * (1 - fraction)
    return total


def PreviewReflected(normal, view, light, diffuseColor=(0.18,) * 3, specularColor=(0.0,) * 3, useSpecularWorkflow=0,
                     metallic=0.0, roughness=0.5, clearcoat=0.0, clearcoatRoughness=0.01, opacity=1.0, ior=1.5) -> np.ndarray:
    """f cos [3] of UsdPreviewSurface for unit directions to the viewer and to the light, as its text and docs/shading.md
    state it: Schlick's Fresnel, GGX of the squared roughness with height-correlated Smith terms."""
    normal, view, light = (_Unit(v) for v in (normal, view, light))
    half = _Unit(view + light)
    cosV, cosL, cosH, e = normal @ view, normal @ light, normal @ half, view @ half
    color, r2, schlick = np.array(diffuseColor, float) * opacity, ((1 - ior) / (1 + ior)) ** 2, (1 - e) ** 5
    if useSpecularWorkflow:
        f0, f90, diffuse = np.array(specularColor, float), np.ones(3), color
    else:
        tint = 1 - metallic + metallic * color
        f0, f90, diffuse = (1 - metallic) * r2 * tint + metallic * tint, tint, color * (1 - metallic)

    def Lobe(rough):
        a2 = rough**4
        smith = lambda c: (np.sqrt(1 + a2 * (1 / c**2 - 1)) - 1) / 2
        distribution = a2 / (np.pi * (cosH**2 * (a2 - 1) + 1) ** 2)
        return distribution / (1 + smith(cosV) + smith(cosL)) / (4 * cosV)

    fresnel, coat = f0 + (f90 - f0) * schlick, clearcoat * (r2 + (1 - r2) * schlick)
    base = diffuse * (1 - fresnel) * cosL / np.pi + fresnel * Lobe(roughness)
    return base * (1 - coat) + coat * Lobe(clearcoatRoughness)


def PreviewAlbedo(cosine, rgb, roughness=0.5, metallic=0.0, clearcoat=0.0, clearcoatRoughness=0.01, ior=1.5,
                  specularColor=None, steps: int = 600) -> np.ndarray:
    """Directional albedo [3] of UsdPreviewSurface as docs/shading.md states it, seen at `cosine`: midpoint
    rule over the half vector's hemisphere for the lobes of GGX, over directions for the diffuse one.
    `specularColor` selects the specular workflow."""
    z = (np.arange(steps) + 0.5) / steps
    phi = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    view = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    color, r2 = np.array(rgb, float), ((1 - ior) / (1 + ior)) ** 2
    if specularColor is None:
        tint = 1 - metallic + metallic * color
        f0, f90, diffuse = (1 - metallic) * r2 * tint + metallic * tint, tint, color * (1 - metallic)
    else:
        f0, f90, diffuse = np.array(specularColor, float), np.ones(3), color

    def Fresnels(cosVH):
        schlick = np.clip(1 - cosVH, 0, 1)[..., None] ** 5
        return f0 + (f90 - f0) * schlick, clearcoat * (r2 + (1 - r2) * schlick)

    gz, gp = np.meshgrid(z, phi, indexing="ij")
    sine = np.sqrt(1 - gz**2)
    light = np.stack([sine * np.cos(gp), sine * np.sin(gp), gz], -1)
    half = light + view
    fresnel, coat = Fresnels(half @ view / np.linalg.norm(half, axis=-1))
    total = ((1 - fresnel) * (1 - coat) * gz[..., None]).mean((0, 1)) * 2 * diffuse

    def GgxLobe(rough, weigh):
        """Integral of D G2 / (4 cosV) weigh over light directions, over (u, phi) with D cosH = du / pi."""
        a2 = max(rough, 0.01) ** 4
        cosH2 = (1 - gz) / (1 + (a2 - 1) * gz)
        h = np.stack([np.sqrt(1 - cosH2) * np.cos(gp), np.sqrt(1 - cosH2) * np.sin(gp), np.sqrt(cosH2)], -1)
        vh = h @ view
        cosL = 2 * vh * h[..., 2] - view[2]
        good = (vh > 0) & (cosL > 0)
        cosL = np.where(good, cosL, 1.0)
        smith = lambda c: np.sqrt(a2 + (1 - a2) * c * c)
        g2 = 2 * view[2] * cosL / (cosL * smith(view[2]) + view[2] * smith(cosL))  # Heitz 2014, eq. 99
        weight = np.where(good, g2 * vh / (view[2] * h[..., 2]), 0.0)
        return (weight[..., None] * weigh(*Fresnels(vh))).mean((0, 1))

    total = total + GgxLobe(roughness, lambda fresnel, coat: fresnel * (1 - coat))
    return total + (GgxLobe(clearcoatRoughness, lambda fresnel, coat: coat) if clearcoat > 0 else 0.0)


def _Unit(v) -> np.ndarray:
    return np.asarray(v, float) / np.linalg.norm(v)
