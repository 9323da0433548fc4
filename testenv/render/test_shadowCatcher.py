# SPDX-License-Identifier: Apache-2.0
"""Shadow catchers: surfaces that show nothing but what others do to their light.

Oracles: the share of the sun that a half-plane hides, integrated; the same stage rendered as it is and without what casts
shadows, neither with a catcher; Cycles' shadow catcher, where bpy can be imported.
"""

import importlib.util
import math
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

import ours
from stages import author, imageFile, shapes

SIZE = (48, 36)
_NAMES = {"hdstream:shadowCatcher": 1, "cycles:object:is_shadow_catcher": 1, "karma:object:holdoutmode": 2}


def _Say(prim, name, value=1):
    kind = Sdf.ValueTypeNames.Int if name.endswith("mode") else Sdf.ValueTypeNames.Bool
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, UsdGeom.Tokens.constant).Set(value)


def _Save(stage):
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Room(path, catcher=("hdstream:shadowCatcher", 1), isWhole=True, extras=()):
    """A floor under a dome and a lamp; on it a red box, which glows a little on one side, and a ball that the camera does not
    see. `isWhole`: they are there."""
    stage = author.NewStage(str(path))
    floor = author.AddMesh(stage, "/World/Floor", shapes.Box(8.0, 0.2, 8.0), color=(0.6, 0.5, 0.4), translate=(0, -0.1, 0))
    if catcher:
        _Say(floor, *catcher)
    if isWhole:
        author.AddMesh(stage, "/World/Box", shapes.Box(1.0, 1.0, 1.0), color=(0.9, 0.3, 0.1), translate=(0.8, 0.5, 0))
        ball = author.AddMesh(stage, "/World/Hidden", shapes.Sphere(0.4, 16, 32), color=(0.2, 0.6, 0.9), translate=(-1.2, 0.4, 0.5))
        UsdGeom.PrimvarsAPI(ball).CreatePrimvar("hdstream:visibility:camera", Sdf.ValueTypeNames.Bool, "constant").Set(False)
    author.AddLight(stage, "/World/Lamp", "Rect", placement=dict(translate=(1, 4, 1), rotate=(-90, 0, 0)), intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(2.0, 3.0, 6.0), target=(0, 0.4, 0), focalLength=30.0)
    for add in extras:
        add(stage)
    return _Save(stage)


def _Render(path, aovs=("color", "alpha", "primId"), samples=8, maxDepth=2, **settings):
    layers = ours.Render(path, *SIZE, aovs, samples=samples, maxDepth=maxDepth, domeVisible=False, lightsVisible=False, **settings).layers
    return {name: np.squeeze(layer) for name, layer in layers.items()}


def _HiddenShare(x, height, halfAngle, steps=1501):
    """The share of the irradiance of a disc of equal radiance at the zenith that a half-plane above, up to x = 0, hides."""
    radius = math.sin(halfAngle)
    u, v = np.meshgrid(*2 * [radius * (2 * (np.arange(steps) + 0.5) / steps - 1)])
    inside = u * u + v * v < radius * radius
    isHidden = u < -x / height * np.sqrt(np.maximum(1 - u * u - v * v, 0))
    return (inside & isHidden).sum() / inside.sum()


def test_alpha_is_the_share_of_the_sun_that_is_hidden(tmp_path):
    height, angle = 2.0, 30.0
    stage = author.NewStage(str(tmp_path / "a.usda"))
    floor = author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(0.6, 0.5, 0.4))
    _Say(floor, "hdstream:shadowCatcher")
    slab = author.AddMesh(stage, "/World/Slab", shapes.Plane(20, 40), color=(0.5, 0.5, 0.5), translate=(-10, height, 0))
    UsdGeom.PrimvarsAPI(slab).CreatePrimvar("hdstream:visibility:camera", Sdf.ValueTypeNames.Bool, "constant").Set(False)
    author.AddLight(stage, "/World/Sun", "Distant", placement=dict(rotate=(-90, 0, 0)), angle=angle, intensity=10.0)
    author.AddCamera(stage, eye=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1), focalLength=50.0)
    layers = ours.Render(_Save(stage), *SIZE, ("color", "alpha", "position"), samples=1024, maxDepth=0).layers
    found = layers["alpha"][..., 0].astype(np.float64)
    assert not layers["color"][..., :3].any() and np.array_equal(found, layers["color"][..., 3])
    x = layers["position"][..., 0].mean(0)
    expected = np.array([_HiddenShare(value, height, math.radians(angle / 2)) for value in x])
    assert np.abs(found.mean(0) - expected).max() < 0.01
    margin = height * math.tan(math.radians(angle / 2)) + 0.1
    assert (x < -margin).any() and (x > margin).any()
    assert (found[:, x > margin] == 0).all() and np.allclose(found[:, x < -margin], 1, atol=1e-6)


@pytest.mark.parametrize("maxDepth", [0, 3])
def test_pictures_without_catchers_say_the_same(tmp_path, maxDepth):
    """Of pixels that show nothing but the floor: light as it is, over light where nothing else is."""
    caught = _Render(_Room(tmp_path / "caught.usda"), maxDepth=maxDepth)
    lit = _Render(_Room(tmp_path / "lit.usda", catcher=None), maxDepth=maxDepth)
    alone = _Render(_Room(tmp_path / "alone.usda", catcher=None, isWhole=False), maxDepth=maxDepth)
    floor = _Floor(tmp_path)
    lit, alone = (layers["color"][floor][..., :3].astype(np.float64) for layers in (lit, alone))
    alpha = 1 - np.minimum(lit / alone, 1).mean(-1)
    assert np.allclose(caught["alpha"][floor], alpha, atol=2e-6)
    assert np.allclose(caught["color"][floor][:, :3], np.maximum(lit - alone, 0), atol=1e-5)
    assert (alpha > 0.2).any() and (alpha == 0).any()
    if maxDepth > 0:
        assert (lit > alone * 1.01).any()


def _Floor(tmp_path):
    """Pixels that show nothing but the floor, with their neighbours."""
    layers = _Render(_Room(tmp_path / "ids.usda", catcher=None), samples=1)
    isFloor = layers["primId"] == 1  # the box is 0
    for axis in (0, 1):
        for shift in (-1, 1):
            isFloor = isFloor & np.roll(isFloor, shift, axis)
    isFloor[[0, -1], :] = isFloor[:, [0, -1]] = False
    assert isFloor.sum() > 200
    return isFloor


def test_what_is_no_catcher_looks_as_always(tmp_path):
    caught, plain = (_Render(_Room(tmp_path / f"{name}.usda", catcher=catcher))
                     for name, catcher in (("caught", ("hdstream:shadowCatcher", 1)), ("plain", None)))
    others = plain["primId"] == 0
    for axis in (0, 1):
        for shift in (-1, 1):
            others = others & np.roll(plain["primId"] == 0, shift, axis)
    assert others.sum() > 20
    others[:10] = True  # the sky
    assert np.array_equal(caught["color"][others], plain["color"][others])
    assert np.array_equal(caught["primId"], plain["primId"])


def test_samples_of_others_are_no_part_of_the_shadow(tmp_path):
    """Where what stands before a catcher casts no shadow, alpha is its coverage alone: that of a floor that is held out."""
    def CastNothing(stage):
        for name in ("Box", "Hidden"):
            api = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/World/{name}"))
            for kind in ("shadow", "diffuse"):  # rays of lobes find lights too
                api.CreatePrimvar(f"hdstream:visibility:{kind}", Sdf.ValueTypeNames.Bool, "constant").Set(False)

    caught, held = (_Render(_Room(tmp_path / f"{name}.usda", catcher=(f"hdstream:{name}", 1), extras=(CastNothing,)), maxDepth=0)
                    for name in ("shadowCatcher", "holdout"))
    assert caught["color"].tobytes() == held["color"].tobytes()
    assert ((held["alpha"] > 0) & (held["alpha"] < 1)).sum() > 10


def test_a_veil_before_a_catcher_keeps_its_light(tmp_path):
    """What it glows more of comes in proportion to its coverage, whatever happens to the samples that pass it."""
    opacity = 0.5

    def Seen(name, glow):
        def Veil(stage):
            look = author.AddMaterial(stage, "/World/Look", diffuseColor=(0, 0, 0), emissiveColor=glow, opacity=opacity, opacityMode="presence")
            author.AddMesh(stage, "/World/Veil", shapes.Box(20.0, 0.01, 20.0), material=look, translate=(0, 2.0, 0))
        path = _Room(tmp_path / f"{name}.usda", isWhole=False, extras=(Veil,))
        return _Render(path, aovs=("color",), samples=256, maxDepth=0)["color"][20:28, 16:32, :3].mean((0, 1))
    glow = (0.4, 0.2, 0.1)
    coverage = 1 - (1 - opacity) ** 2  # of both sides of the box
    assert Seen("glows", glow) - Seen("black", (0, 0, 0)) == pytest.approx(np.multiply(glow, coverage), rel=0.02)


@pytest.mark.parametrize("name", _NAMES)
def test_names_of_hosts(tmp_path, name):
    """Each is ours; Karma's mode 1 is a holdout; false is nothing."""
    expected = _Render(_Room(tmp_path / "a.usda"))
    found = _Render(_Room(tmp_path / "b.usda", catcher=(name, _NAMES[name])))
    nothing = _Render(_Room(tmp_path / "c.usda", catcher=(name, 0)))
    plain = _Render(_Room(tmp_path / "d.usda", catcher=None))
    assert expected["color"].tobytes() == found["color"].tobytes() != plain["color"].tobytes()
    assert nothing["color"].tobytes() == plain["color"].tobytes()
    if name == "karma:object:holdoutmode":
        matte = _Render(_Room(tmp_path / "e.usda", catcher=(name, 1)))
        assert matte["color"].tobytes() == _Render(_Room(tmp_path / "f.usda", catcher=("hdstream:holdout", 1)))["color"].tobytes()


@pytest.mark.parametrize("settings", [
    {"waveSize": 3001}, {"traversal": "scalar"}, {"traversal": "simd8"},
    {"residency": "stream", "geometryMemory": "16K", "chunkBytes": 1 << 12},
], ids=lambda settings: "-".join(str(value) for value in settings.values()))
def test_bits_depend_on_nothing_else(tmp_path, settings):
    path = _Room(tmp_path / "a.usda")
    expected, found = _Render(path, samples=20), _Render(path, samples=20, **settings)
    for name in expected:
        assert found[name].tobytes() == expected[name].tobytes(), name


def test_parts_of_a_farm_have_the_same_bits(tmp_path):
    import hdstream
    from hdstream import filmSums
    renderer = hdstream.Renderer(_Room(tmp_path / "a.usda"))

    def Prepare(samples=40):
        renderer.Prepare(aovs=["color", "direct"], samples=samples, imageWidth=48, imageHeight=32, camera="/World/Camera")

    def Sums(end, start):
        Prepare(end)
        return renderer.RenderSums(None, start)

    Prepare()
    whole = renderer.RenderPrepared(None)
    blocks = [filmSums.Unpack(filmSums.Pack(Sums(end, [filmSums.BlackSums(48, 32, begin)])))
              for begin, end in ((0, 16), (16, 32), (32, 40))]
    Prepare()
    joined = renderer.RenderPrepared(None, blocks)
    for name, pixels in whole.aovs.items():
        assert pixels.tobytes() == joined.aovs[name].tobytes(), name
    assert whole.aovs["color"][..., 3].max() > 0.2


def test_light_by_its_path_is_that_of_the_picture(tmp_path):
    layers = _Render(_Room(tmp_path / "a.usda"), aovs=("color", "primId", "emission", "direct", "indirect", "crypto_object"))
    floor = _Floor(tmp_path)
    total = sum(layers[name] for name in ("emission", "direct", "indirect"))
    assert not total[floor].any() and total.any()
    box = ~floor & (layers["primId"] == 0)
    inner = box & np.roll(box, 1, 0) & np.roll(box, -1, 0) & np.roll(box, 1, 1) & np.roll(box, -1, 1)
    assert inner.any() and np.allclose(total[inner], layers["color"][inner][:, :3], rtol=1e-5)
    assert not layers["crypto_object00"][floor][:, 1].any()


@pytest.mark.parametrize("isWhole", [True, False])
def test_a_hidden_catcher_does_nothing(tmp_path, isWhole):
    def Hide(stage):
        UsdGeom.Imageable(stage.GetPrimAtPath("/World/Floor")).MakeInvisible()

    hidden = _Render(_Room(tmp_path / "a.usda", isWhole=isWhole, extras=(Hide,)))
    plain = _Render(_Room(tmp_path / "b.usda", catcher=None, isWhole=isWhole, extras=(Hide,)))
    assert hidden["color"].tobytes() == plain["color"].tobytes()


def test_alpha_is_that_of_cycles(tmp_path):
    """A box on a floor under a sun of 20 degrees, the box seen too: blocks of 6 x 6 pixels within 1 %."""
    if importlib.util.find_spec("bpy") is None:
        pytest.skip("needs Blender's Python module")
    stage = author.NewStage(str(tmp_path / "a.usda"))
    floor = author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(0.6, 0.6, 0.6))
    _Say(floor, "hdstream:shadowCatcher")
    author.AddMesh(stage, "/World/Box", shapes.Box(1.0, 1.0, 1.0), color=(0.6, 0.6, 0.6), translate=(0, 0.5, 0))
    author.AddLight(stage, "/World/Sun", "Distant", placement=dict(rotate=(-35, -100, 0)), angle=20.0, intensity=10.0)
    author.AddCamera(stage, eye=(2.0, 3.0, 5.0), target=(0, 0.2, 0), focalLength=30.0)
    path = _Save(stage)
    size = (60, 48)
    alpha = ours.Render(path, *size, ("alpha",), samples=1024, maxDepth=0).layers["alpha"][..., 0]
    out = tmp_path / "cycles.exr"
    script = pathlib.Path(__file__).with_name("cyclesCatcher.py")
    run = subprocess.run([sys.executable, str(script), path, str(out), *map(str, size)], capture_output=True, text=True)
    assert out.exists(), run.stdout[-2000:] + run.stderr[-2000:]
    theirs = imageFile.ReadExr(str(out))["A"]

    def Blocks(image):
        return image.astype(np.float64).reshape(8, 6, 10, 6).mean((1, 3))

    assert np.abs(Blocks(alpha) - Blocks(theirs)).max() < 0.01
    assert ((Blocks(theirs) > 0.1) & (Blocks(theirs) < 0.9)).sum() > 5


def test_adaptive_sampling_sees_the_noise_of_shadows(tmp_path):
    """The spread of pictures of other seeds, laid over white, is the error that was asked for where pixels stopped for it."""
    path = _Room(tmp_path / "room.usda")
    target, seeds = 0.008, 6
    shown, counts = [], []
    for seed in range(seeds):
        layers = _Render(path, ("color", "alpha", "sampleCount"), samples=1024, noise=target, seed=seed)
        shown.append(layers["color"][..., :3].astype(np.float64) @ (0.2126, 0.7152, 0.0722) + 1 - layers["alpha"])
        counts.append(layers["sampleCount"])
    counts = np.array(counts)
    mean, spread = np.mean(shown, 0), np.std(shown, 0, ddof=1)
    floor = _Floor(tmp_path)
    isNoisy = floor & (counts.min(0) > 32) & (counts.max(0) < 1024)
    isStill = floor & (spread == 0)
    assert isNoisy.sum() > 100 and isStill.sum() > 20
    error = np.sqrt(np.mean(spread[isNoisy] ** 2 / (mean[isNoisy] ** 2 + 0.01)))
    assert 0.4 * target < error < 0.9 * target, error
    assert counts[:, isStill].mean() < 0.5 * counts[:, isNoisy].mean()
