# SPDX-License-Identifier: Apache-2.0
"""hdStream's pictures equal Mitsuba 3's on every verification case.

The references were rendered by Mitsuba from the same stages (makeReferences.py, 4096 samples a pixel)
and are read from references/, so that this suite needs no Mitsuba. Criteria: mean radiance within
0.2 % where all surfaces are Lambert and 1 % elsewhere, relMSE <= 1e-3, and blocks of 10 x 10 pixels
within their noise. A last test renders one reference anew where Mitsuba is installed.
"""

import pathlib

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import ours
from stages.imageFile import ReadExr
from stages.verify import CASES

REFERENCES = pathlib.Path(__file__).resolve().parent / "references"
_ABSOLUTE_NOISE = 1e-4  # of a block's mean, for blocks that are black but for half-float rounding


def _Reference(name: str) -> tuple[np.ndarray, np.ndarray]:
    channels = ReadExr(REFERENCES / f"{name}.exr")
    return np.stack([channels[c] for c in "RGB"], -1).astype(np.float64), channels["V"].astype(np.float64) / 1e6


@pytest.mark.parametrize("name", sorted(CASES))
def test_case_equals_reference(name, tmp_path):
    case = CASES[name]
    reference, referenceVariance = _Reference(name)
    picture = ours.Render(case.Write(f"{tmp_path}/stage.usda"), case.width, case.height, ("color", "variance"), samples=case.samples,
                          maxDepth=case.maxDepth, pixelAspectRatio=case.pixelAspectRatio, seed=1)
    tolerance = 0.002 if case.lambert else 0.01
    assert picture.rgb.mean() == pytest.approx(reference.mean(), rel=tolerance)
    assert compare.RelMse(picture.rgb, reference) <= 1e-3
    # The blocks may differ by the tolerance and by noise. Low-discrepancy samples have less variance
    # than the AOV's estimate, so the limit is on the safe side.
    variance = picture.layers["variance"].astype(np.float64).mean(-1)
    z = compare.BlockZ(picture.rgb.mean(-1), variance + _ABSOLUTE_NOISE**2 * 100, reference.mean(-1), referenceVariance,
                       bias=tolerance)
    assert z.max() < compare.ZLimit(z.size)


def test_no_reference_is_missing_or_left_over():
    assert {p.stem for p in REFERENCES.glob("*.exr")} == set(CASES)


@pytest.mark.parametrize("name", ["rectLight", "surfaceClearcoat"])
def test_reference_can_be_made_again(name, tmp_path):
    """A new, smaller render of the reference agrees with the stored one: the stages have not drifted."""
    pytest.importorskip("mitsuba")
    import mitsubaScene

    try:
        mitsubaScene.UseVariant("llvm_ad_rgb")
    except (ImportError, RuntimeError) as error:
        pytest.skip(f"Mitsuba has no LLVM: {error}")
    case = CASES[name]
    mean, variance = mitsubaScene.RenderReference(case.Write(f"{tmp_path}/stage.usda"), case, samples=256, batches=8, seed=5)
    stored, storedVariance = _Reference(name)
    error = np.sqrt(variance.mean(-1).sum() + storedVariance.sum()) / variance[..., 0].size
    assert abs(mean.mean() - stored.mean()) < 5 * error + 1e-5
