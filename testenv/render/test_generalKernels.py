# SPDX-License-Identifier: Apache-2.0
"""General kernels (docs/device.md) give the bits of those that are compiled for a scene."""

import pytest

pytest.importorskip("hdstream._core")

import formStages
import ours
from pxr import Usd
from stages import author, materialX, motion, shapes
from stages.verify import CASES

_AOVS = ("color", "depth", "albedo", "variance")
_SIZE = (61, 47)


@pytest.fixture(scope="module")
def Cache(tmp_path_factory) -> str:
    """A cache of their own: renders of other tests would find general kernels in the suite's."""
    return str(tmp_path_factory.mktemp("cache"))


def _Render(stage, kernels: str, cache: str, **settings):
    picture = ours.Render(stage, *_SIZE, _AOVS, kernels=kernels, cacheDirectory=cache, noCache=False, **({"samples": 8} | settings))
    return picture, picture.statistics["wave"]["kernels"]


def _AssertSameBits(stage, cache: str, **settings) -> None:
    general, generalKernels = _Render(stage, "general", cache, **settings)
    own, ownKernels = _Render(stage, "own", cache, **settings)
    assert (generalKernels, ownKernels) == ("general", "own")
    assert own.rgb.std() > 0.01
    for name in own.layers:
        assert general.layers[name].tobytes() == own.layers[name].tobytes(), name


@pytest.mark.parametrize("write", [formStages.Layered, formStages.Textured, formStages.ManyLights, formStages.FewShaped, formStages.Nested],
                         ids=lambda write: write.__name__)
def test_form_stages(write, Cache, tmp_path):
    """Each shows surfaces and lights of unlike kinds side by side."""
    path = f"{tmp_path}/stage.usda"
    write(path)
    _AssertSameBits(path, Cache, maxDepth=7)


@pytest.mark.parametrize("name", ["surfaceCutout", "emissiveMesh", "lambertRoom"])
@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_cases(name, residency, Cache, tmp_path):
    """Without textures kernels that know them get none; geometry has each form."""
    _AssertSameBits(CASES[name].Write(f"{tmp_path}/stage.usda"), Cache, residency=residency, geometryMemory="50%")


def test_what_few_scenes_have_is_not_covered(Cache, tmp_path):
    """Kernels of its own are compiled, whatever is asked for."""
    stage = f"{tmp_path}/moving.usda"
    motion.Write(stage, next(iter(motion.SCENES)))
    assert _Render(stage, "general", Cache, samples=1)[1] == "own"


def _WriteFilmInABox(path, thickness: float) -> str:
    """A sheet of materials, and a ball that nothing can see: a closed box is around it."""
    formStages.Layered(path)
    stage = Usd.Stage.Open(str(path))
    look = materialX.AddSurface(stage, "/World/Looks/Hidden", thin_film_thickness=thickness)
    author.AddMesh(stage, "/World/Hidden", shapes.Sphere(0.1, 8, 16), material=look, translate=(0, -3, 0))
    author.AddMesh(stage, "/World/Around", shapes.Box(1, 1, 1), color=(0, 0, 0), translate=(0, -3.5, 0))
    stage.GetRootLayer().Save()
    return str(path)


def test_films_elsewhere(tmp_path):
    """A feature that a surface does not use leaves its bits alone; films also switch the form of eight paths off."""
    pictures = [ours.Render(_WriteFilmInABox(f"{tmp_path}/{nanometres}.usda", nanometres), *_SIZE, _AOVS, samples=8)
                for nanometres in (0.0, 400.0)]
    for name in pictures[0].layers:
        assert pictures[0].layers[name].tobytes() == pictures[1].layers[name].tobytes(), name
