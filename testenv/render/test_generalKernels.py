# SPDX-License-Identifier: Apache-2.0
"""General kernels (docs/device.md) give the bits of those that are compiled for a scene."""

import pytest

pytest.importorskip("hdstream._core")

import formStages
import ours
from pxr import Sdf, Usd, UsdShade
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


@pytest.mark.parametrize("write", [formStages.Layered, formStages.Textured, formStages.ManyLights, formStages.FewShaped, formStages.Nested,
                                   formStages.Smooth, formStages.InsideGlass], ids=lambda write: write.__name__)
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


def _WriteClosures(path, *layers) -> None:
    """A ball of closures, each on those after it."""
    stage = author.NewStage(path)
    UsdShade.Material.Define(stage, "/World/Look")
    below = None
    for i, (kind, inputs) in reversed(list(enumerate(layers))):
        node = materialX.AddNode(stage, f"/World/Look/Layer{i}", f"ND_{kind}_bsdf", Sdf.ValueTypeNames.Token, **inputs)
        below = node if below is None else materialX.AddNode(stage, f"/World/Look/On{i}", "ND_layer_bsdf", Sdf.ValueTypeNames.Token, top=node,
                                                             base=below)
    look = materialX.AddSurface(stage, "/World/Look", "ND_surface", bsdf=below)
    author.AddMesh(stage, "/World/Ball", materialX.Ball(1.0), material=look)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, eye=(0, 0, 5))
    stage.GetRootLayer().Save()


_TINTED = [("dielectric", dict(tint=(0.9, 0.5, 0.2), ior=1.4 + 0.1 * i)) for i in range(3)]
# Name: what writes the stage at a path.
_RARE = {
    "motion": lambda path: motion.Write(path, next(iter(motion.SCENES))),
    "layersOnLayers": lambda path: _WriteClosures(path, *_TINTED, ("oren_nayar_diffuse", {})),
    "sentBack": lambda path: _WriteClosures(path, ("conductor", dict(retroreflective=True, roughness=(0.2, 0.2)))),
}


@pytest.mark.parametrize("name", _RARE)
def test_what_few_scenes_have_is_not_covered(name, Cache, tmp_path):
    """Kernels of its own are compiled, whatever is asked for, and draw it from the first sample on."""
    stage = f"{tmp_path}/rare.usda"
    _RARE[name](stage)
    (general, kernels), (own, _) = (_Render(stage, asked, Cache, samples=1) for asked in ("general", "own"))
    assert kernels == "own" and own.rgb.std() > 0.001
    assert general.layers["color"].tobytes() == own.layers["color"].tobytes()


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
