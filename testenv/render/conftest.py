# SPDX-License-Identifier: Apache-2.0
"""Which kernels the render tests use: kernels for most scenes (docs/device.md), but in the files named here, which hold all kinds of
scenes against what is not of ours, or to the bit. HDSTREAM_TEST_KERNELS=own|general|auto decides for all files."""

import os

import pytest

# Kernels for each of two thousand scenes take more time to compile than all tests to run. Bits are equal: test_generalKernels.
OWN_KERNELS = {"test_closed_form", "test_identity", "test_mitsuba", "test_stability", "test_wideForm"}


@pytest.fixture(scope="module", autouse=True)
def _Kernels(request):
    with pytest.MonkeyPatch.context() as patch:
        if "HDSTREAM_TEST_KERNELS" not in os.environ:
            patch.setenv("HDSTREAM_TEST_KERNELS", "own" if request.module.__name__ in OWN_KERNELS else "general")
        yield
