# SPDX-License-Identifier: Apache-2.0
"""A first render has its kernels compiled by other processes (docs/device.md): the picture has the bits of one that
compiles them itself, all binaries are kept, and what goes wrong is one line."""

import os
import pathlib

import pytest

import hdstream._core as core
from cliCase import SCENE, SMALL, Run, WriteStage

_COMPILER = "hdstreamCompileKernels"

pytestmark = pytest.mark.skipif(not core.ListDevices() or "Portable" not in core.ListDevices()[0].platform,
                                reason="only PoCL's kernels are compiled by other processes")


def _Cold(folder, name, environment):
    """The picture, the names of the kernels kept and the result of a render with empty caches."""
    own = folder / name
    (own / "pocl").mkdir(parents=True)
    result = Run("record", WriteStage(folder, SCENE), own / "o.exr", *SMALL, "--camera", "/main_cam", "--cacheDir", own / "cache",
                 environment={"POCL_CACHE_DIR": str(own / "pocl"), **environment})
    assert result.code == 0 and not result.errors, result.text
    return (own / "o.exr").read_bytes(), sorted(path.name for path in (own / "cache").glob("kernel-*")), result


def test_the_program_is_beside_the_module():
    assert os.access(pathlib.Path(core.__file__).parent / _COMPILER, os.X_OK)


def test_pictures_and_binaries_are_those_of_one_process(tmp_path):
    picture, kept, result = _Cold(tmp_path, "apart", {})
    alone, keptAlone, aloneResult = _Cold(tmp_path, "alone", {"HDSTREAM_KERNEL_COMPILER": ""})
    assert picture == alone
    # The kernels of the texture cache are compiled early, and are kept though this stage has no textures.
    assert set(keptAlone) <= set(kept) and len(kept) - len(keptAlone) <= 1
    assert len(keptAlone) >= 4
    assert result.warnings == aloneResult.warnings


def test_a_program_that_fails_is_one_line(tmp_path):
    picture, kept, result = _Cold(tmp_path, "failing", {"HDSTREAM_KERNEL_COMPILER": "/bin/false"})
    lines = [line for line in result.warnings if "/bin/false" in line]
    assert lines == ["/bin/false: it does not answer as it should; kernels are compiled without it, which takes longer"]
    assert kept, "what was compiled here is kept"
    assert picture == _Cold(tmp_path, "apart", {})[0]
