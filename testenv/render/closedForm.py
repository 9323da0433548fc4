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


def _Unit(v) -> np.ndarray:
    return np.asarray(v, float) / np.linalg.norm(v)
