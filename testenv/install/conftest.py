# SPDX-License-Identifier: Apache-2.0
"""The source archive, the wheel built from it, once, and a fresh virtual environment that holds the wheel. All need no
network."""

import os
import pathlib
import sys
import sysconfig
import tarfile

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from installCase import ROOT, STAGE, CleanEnvironment, Run  # noqa: E402

# What scripts/setup.sh installs; a clean machine has no make.
os.environ.setdefault("CMAKE_GENERATOR", "Ninja")
# The compiler by the name that CMake finds for the build, not by the one that this Python was built with: ccache counts them as two,
# and the wheel would compile everything again.
os.environ.setdefault("CC", "cc")
os.environ.setdefault("CXX", "c++")


@pytest.fixture
def stage(tmp_path):
    path = tmp_path / "stage.usda"
    path.write_text(STAGE)
    return path


@pytest.fixture(scope="session")
def sdist(tmp_path_factory):
    """The source archive as `python -m build --sdist` and pip make it."""
    folder = tmp_path_factory.mktemp("sdist")
    result = Run([sys.executable, "-c", "import sys; from scikit_build_core.build import build_sdist; build_sdist(sys.argv[1])",
                  folder], cwd=ROOT, env=CleanEnvironment())
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-4000:]
    (path,) = folder.glob("*.tar.gz")
    return path


@pytest.fixture(scope="session")
def source(sdist):
    """The archive's tree in build/sdist. What did not change since the last run is not written again, so that objects
    stay good."""
    folder = ROOT / "build" / "sdist"
    held = set()
    with tarfile.open(sdist) as archive:
        for member in filter(tarfile.TarInfo.isfile, archive.getmembers()):
            path = folder / member.name.partition("/")[2]
            content = archive.extractfile(member).read()
            held.add(path)
            if not path.exists() or path.read_bytes() != content:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
                path.chmod(member.mode)
    for path in folder.rglob("*"):
        if path.is_file() and path not in held and not path.is_relative_to(folder / "build"):
            path.unlink()
    return folder


@pytest.fixture(scope="session")
def wheel(source, tmp_path_factory):
    """Built with the build requirements of this interpreter; objects stay in build/sdist/build/<tag>."""
    folder = tmp_path_factory.mktemp("wheel")
    result = Run([sys.executable, "-m", "pip", "wheel", source, "--no-deps", "--no-build-isolation",
                  "--wheel-dir", folder], env=CleanEnvironment())
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-4000:]
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """bin/ of a fresh environment with the wheel. usd-core and numpy are lent by a path file: the
    .pth files of the lender, which name the build tree, are not read through it."""
    folder = tmp_path_factory.mktemp("venv with spaces")
    assert Run([sys.executable, "-m", "venv", "--without-pip", folder]).returncode == 0
    python = folder / "bin" / "python"
    result = Run([sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel],
                 env=CleanEnvironment())
    assert result.returncode == 0, result.stdout + result.stderr
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"
