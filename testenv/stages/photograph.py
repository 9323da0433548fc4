# SPDX-License-Identifier: Apache-2.0
"""Pictures with the statistics of photographs, in any number, each different.

Amplitudes fall with one over the frequency, as in natural images (Field 1987, "Relations between the statistics of
natural images and the response properties of cortical cells"); regions of different colours meet in sharp edges; fine
grain lies over all. Deterministic: picture `index` of a size is the same wherever it is made.
"""

import numpy as np

_FIELDS = 4


def _Field(rng, size: int) -> np.ndarray:
    """[size][size] of mean 0 and deviation 1, whose amplitudes fall as 1 / frequency; periodic."""
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None])
    frequency[0, 0] = np.inf
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, size))) / frequency, (size, size))
    return (field / field.std()).astype(np.float32)


class Photographs:
    """Makes square pictures of one size. The fields are made once: 16 bytes a pixel."""

    def __init__(self, size: int):
        rng = np.random.default_rng(size)
        self.size = size
        self.fields = [_Field(rng, size) for _ in range(_FIELDS)]
        self.grain = rng.normal(0, 3.0, (size, size)).astype(np.float32)

    def _Take(self, rng, field: int) -> np.ndarray:
        taken = np.roll(self.fields[field], tuple(rng.integers(0, self.size, 2)), (0, 1))
        taken = taken[:, ::-1] if rng.random() < 0.5 else taken
        return taken.T if rng.random() < 0.5 else taken

    def Make(self, index: int) -> np.ndarray:
        """[size][size][3] codes of 8 bits."""
        rng = np.random.default_rng([self.size, index])
        colors = rng.uniform(40, 215, (3, 3)).astype(np.float32)
        shape, other = self._Take(rng, 0), self._Take(rng, 1)
        region = np.where(shape > rng.uniform(0.2, 1.0), 2, np.where(other > rng.uniform(-0.5, 0.5), 1, 0))
        light = 1.0 + 0.22 * self._Take(rng, 2)
        tint = 9.0 * self._Take(rng, 3)
        picture = colors[region] * light[..., None]
        picture += self.grain[..., None]
        picture[..., 0] += tint
        picture[..., 2] -= tint
        return np.clip(picture + 0.5, 0, 255).astype(np.uint8)
