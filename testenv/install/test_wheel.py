# SPDX-License-Identifier: Apache-2.0
"""What `pip install .` gives: complete, needing nothing of the source tree, and the same renderer."""

import email
import pathlib
import sys
import tarfile
import zipfile

import numpy as np
import pytest
from installCase import ROOT, CleanEnvironment, Run
from stages.imageFile import ReadExr

PACKAGE = ROOT / "hdStream" / "python" / "hdstream"


def test_sdist_holds_what_git_tracks(sdist):
    tracked = Run(["git", "-C", ROOT, "ls-files"])
    if tracked.returncode != 0:
        pytest.skip("not a git checkout")
    with tarfile.open(sdist) as archive:
        held = {member.name.partition("/")[2] for member in archive.getmembers()}
    assert not [name for name in tracked.stdout.splitlines() if (ROOT / name).exists() and name not in held]


def test_wheel_holds_every_module_and_names_its_requirements(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (metadataName,) = [name for name in names if name.endswith(".dist-info/METADATA")]
        metadata = email.message_from_bytes(archive.read(metadataName))
    modules = {f"hdstream/{path.relative_to(PACKAGE).as_posix()}" for path in PACKAGE.rglob("*.py")}
    assert modules <= names
    assert any(name.startswith("hdstream/_core.") for name in names)
    assert "hdstream/hdstreamCompileKernels" in names
    assert not [name for name in names if not name.startswith("hdstream")]
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in names)
    requirements = " ".join(metadata.get_all("Requires-Dist"))
    assert "usd-core" in requirements and "numpy" in requirements


@pytest.mark.skipif(sys.prefix == sys.base_prefix, reason="this Python has no folder of its own")
def test_the_wheel_is_made_of_objects_of_the_build(wheel, source):
    """Where there is ccache, which compares commands: in these, paths of the tree count from the build folder, and the environment
    of Python would lie elsewhere from each."""
    (build,) = (source / "build").glob("*/build.ninja")
    lines = [line for line in build.read_text().splitlines() if line.startswith(("  INCLUDES = ", "  FLAGS = ", "  DEFINES = "))]
    assert any("nanobind" in line for line in lines)
    assert not [line for line in lines if sys.prefix in line]


def test_installed_package_is_not_the_build_tree(installed, tmp_path):
    result = Run([installed / "python", "-c", "import hdstream._core as core; print(core.__file__)"],
                 cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == 0, result.stderr
    assert pathlib.Path(result.stdout.strip()).is_relative_to(installed.parent)


def test_installed_program_compiles_kernels(installed, stage, tmp_path):
    """Beside the installed module; a first render that uses it keeps its kernels and says nothing."""
    result = Run([installed / "python", "-c", "import hdstream._core as core; print(core.__file__)"], cwd=tmp_path,
                 env=CleanEnvironment())
    program = pathlib.Path(result.stdout.strip()).parent / "hdstreamCompileKernels"
    assert Run([program]).returncode == 2, "started by hand"
    result = Run([installed / "hdstream", "record", stage, tmp_path / "cold.exr", "--camera", "/Camera", "--imageWidth", 16,
                  "--samples", 1, "--cacheDir", tmp_path / "cache", "--quiet"], cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == 0 and not result.stderr, result.stderr
    assert len(list((tmp_path / "cache").glob("kernel-*"))) >= 4


def test_installed_command_lists_devices(installed, tmp_path):
    result = Run([installed / "hdstream", "devices"], cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip()


def test_installed_command_renders_as_the_build_does(installed, stage, tmp_path):
    options = ["--camera", "/Camera", "--imageWidth", 33, "--samples", 16, "--noCache", "--quiet"]
    result = Run([installed / "hdstream", "record", stage, tmp_path / "wheel.exr", *options],
                 cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == 0, result.stderr
    assert Run([sys.executable, "-m", "hdstream", "record", stage, tmp_path / "build.exr", *options]).returncode == 0
    ours, built = ReadExr(tmp_path / "wheel.exr"), ReadExr(tmp_path / "build.exr")
    # Same compiler, kernels and device: same bits.
    assert ours.keys() == built.keys()
    assert all(np.array_equal(ours[name], built[name]) for name in ours)
    # The dome is seen directly in the corner; the quad's centre reflects half of the half-space it sees.
    # 0.05: the Monte-Carlo noise of 16 samples x 9 pixels of a nearly constant integrand.
    assert np.allclose(ours["R"][0, 0], 1.0, atol=1e-5)
    assert abs(ours["R"][15:18, 15:18].mean() - 0.5) < 0.05
