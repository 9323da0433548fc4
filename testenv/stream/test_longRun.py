# SPDX-License-Identifier: Apache-2.0
"""A session that is edited many times and put back has the picture's bits and the device's bytes that it had before."""

import pytest

pytest.importorskip("hdstream._core")

from bench import longRun


@pytest.mark.parametrize("residency", ["stream", "resident"])
def test_edits_leave_nothing_behind(tmp_path, residency):
    samples = longRun.Run(tmp_path, residency, frames=120, every=40, seed=3)
    assert all(sample.picture == samples[0].picture for sample in samples)
    # Until the last sample, which begins anew, tables and pools may have room to spare from larger scenes.
    assert samples[-1].deviceBytes == samples[0].deviceBytes, [sample.deviceBytes for sample in samples]
