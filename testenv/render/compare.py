# SPDX-License-Identifier: Apache-2.0
"""Measures between pictures: relMSE (docs/film.md) and a z-test over blocks."""

import math

import numpy as np


def RelMse(picture: np.ndarray, reference: np.ndarray) -> float:
    """Mean over pixels and channels of (a - b)^2 / (b^2 + 0.01)."""
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01)))


def Blocks(plane: np.ndarray, size: int) -> np.ndarray:
    """Means of size x size blocks of [height][width]; the rest at the right and bottom is left out."""
    rows, columns = plane.shape[0] // size, plane.shape[1] // size
    return plane[: rows * size, : columns * size].reshape(rows, size, columns, size).mean((1, 3))


def BlockZ(picture, variance, reference, referenceVariance, size: int = 10, bias: float = 0.0) -> np.ndarray:
    """z of each block's difference, after a relative bias of `bias` is granted. All [height][width];
    variances are of the pixels' means."""
    error = np.sqrt((Blocks(variance, size) + Blocks(referenceVariance, size)) / size**2)
    difference = np.abs(Blocks(picture, size) - Blocks(reference, size)) - bias * Blocks(reference, size)
    return np.maximum(difference, 0) / np.maximum(error, 1e-12)


def ZLimit(numTests: int, alpha: float = 1e-3) -> float:
    """The two-sided z that all of `numTests` normal variables stay below with probability 1 - alpha
    (Sidak's correction), by bisection of erfc."""
    single = 1 - (1 - alpha) ** (1 / numTests)
    low, high = 0.0, 40.0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if math.erfc(middle / math.sqrt(2)) > single else (low, middle)
    return high
