# SPDX-License-Identifier: Apache-2.0
"""Light path expressions and light groups: parts add up to colour, groups are what their lights make alone, lobes are what
numerical integrals say, and bits depend on nothing else.

The automaton against a matcher of another make: unit/film/testLightPaths.cpp.
"""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hdstream
from hdstream import _core, filmSums
from lightPathCase import LIGHTS, RenderLightPaths, WriteLightPathStage
from stages.media import WriteMedia

_GROUPS = ("lightGroup:key", "lightGroup:fill", "lightGroup:sun", "lightGroup:panel", "lightGroup:default", "lpe:C.*O")
_PARTS = {
    "lobes": ("emission", "diffuse", "specular", "transmission"),
    "bounces": ("emission", "direct", "indirect"),
    "both": ("emission", "directDiffuse", "indirectDiffuse", "directSpecular", "indirectSpecular", "directTransmission",
             "indirectTransmission"),
    "groups": _GROUPS,
    "ends": ("lpe:C.*<L[^D]'key'>", "lpe:C.*[^'key']"),
    "smoothness": ("emission", "lpe:C<.D>.*[LO]", "lpe:C<.G>.*[LO]", "lpe:C<.S>.*[LO]"),
    "second": ("emission", "direct", "lpe:C.<RD>.*[LO]", "lpe:C.<R[^D]>.*[LO]", "lpe:C.T.*[LO]"),
}
_ALL = tuple(dict.fromkeys(name for names in _PARTS.values() for name in names))


@pytest.fixture(scope="module", name="stage")
def MakeStage(tmp_path_factory):
    return WriteLightPathStage(tmp_path_factory.mktemp("lightPaths") / "all.usda")


@pytest.fixture(scope="module", name="image")
def MakeImage(stage):
    return RenderLightPaths(stage, ("color",) + _ALL)


@pytest.mark.parametrize("parts", _PARTS.values(), ids=_PARTS)
def test_parts_add_up_to_colour(image, parts):
    color = image.aovs["color"][..., :3]
    total = sum(image.aovs[name].astype(np.float64) for name in parts)
    assert np.abs(total - color).max() <= 1e-5 * color.max()
    assert (np.abs(total - color) <= 1e-5 * np.maximum(color, 1e-3)).all()
    for name in parts:
        if name != "directTransmission":  # through glass light is transmitted twice
            assert image.aovs[name].max() > 0.01, name


def test_parts_add_up_to_colour_where_light_scatters_in_matter(tmp_path):
    # Subsurface scattering, lamps inside of fog, milk; no lobe of theirs may be lost or counted twice.
    WriteMedia(str(tmp_path / "media.usda"))
    aovs = ("color", *_PARTS["lobes"], "direct", "indirect")
    image = RenderLightPaths(tmp_path / "media.usda", aovs, samples=4, imageWidth=64, imageHeight=32).aovs
    color = image["color"][..., :3]
    for parts in (_PARTS["lobes"], ("emission", "direct", "indirect")):
        total = sum(image[name].astype(np.float64) for name in parts)
        assert (np.abs(total - color) <= 1e-5 * np.maximum(color, color.max() * 1e-2)).all(), parts


def _Blocks(pixels):
    """Means of blocks of 8 x 8 pixels."""
    height, width, channels = pixels.shape
    blocks = pixels.reshape(height // 8, 8, width // 8, 8, channels).swapaxes(1, 2).reshape(-1, 64, channels)
    return blocks.mean(1)


@pytest.mark.parametrize("name, light", [(name, name.split(":")[1]) for name in _GROUPS[:4]] + [("lightGroup:default", "sky")])
def test_a_group_is_what_its_lights_make_alone(name, light, tmp_path):
    """Several renders of each, of other seeds, tell how far means of 8 x 8 pixels lie apart by chance."""
    whole = WriteLightPathStage(tmp_path / "all.usda")
    alone = WriteLightPathStage(tmp_path / "alone.usda", (light,))
    settings = {"samples": 16, "imageWidth": 64, "imageHeight": 48}
    parts = np.array([_Blocks(RenderLightPaths(whole, ("color", name), seed=seed, **settings).aovs[name]) for seed in range(8)])
    own = []
    for seed in range(8):
        layers = RenderLightPaths(alone, ("color", "lpe:C.*L"), seed=seed, **settings).aovs
        own.append(_Blocks(layers["lpe:C.*L"]))  # without what glows by its material
    own = np.array(own)
    error = np.sqrt((parts.var(0, ddof=1) + own.var(0, ddof=1)) / len(parts)) + 1e-4 + 0.002 * own.mean(0)
    z = (parts.mean(0) - own.mean(0)) / error
    assert np.sqrt((z ** 2).mean()) < 1.5, np.sqrt((z ** 2).mean())
    assert np.abs(z).max() < 8.0
    assert abs(parts.mean() / own.mean() - 1.0) < 0.03
    assert parts.mean() > 1e-3


_PLANE = """#usda 1.0
(
    upAxis = "Y"
)
def Xform "World" {
    def Camera "Camera" {
        token projection = "orthographic"
        float2 clippingRange = (0.1, 100)
        double3 xformOp:translate = (0, 5, 5)
        float3 xformOp:rotateXYZ = (-45, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
    }
    def DomeLight "Sky" {
    }
    def Mesh "Floor" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-50, 0, 50), (50, 0, 50), (50, 0, -50), (-50, 0, -50)]
        uniform token subdivisionScheme = "none"
        rel material:binding = </World/Paint>
    }
    def Material "Paint" {
        token outputs:surface.connect = </World/Paint/S.outputs:surface>
        def Shader "S" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.8, 0.6, 0.4)
            int inputs:useSpecularWorkflow = 1
            color3f inputs:specularColor = (0.9, 0.3, 0.02)
            float inputs:roughness = 0.6
            token outputs:surface
        }
    }
}
"""


def _PlaneIntegrals(coat=0.0):
    """What the plane's two lobes send of a dome of radiance 1 to a viewer at 45 degrees, under a coat of that weight: the
    formulas of UsdPreviewSurface, by the midpoint rule over the hemisphere, in double precision."""
    count = 1200
    cosine = (np.arange(count) + 0.5) / count
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    z, phi = np.meshgrid(cosine, angle)
    sine = np.sqrt(1.0 - z * z)
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], -1)
    wo = np.array([np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    h = wi + wo
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    schlick = (1.0 - (h @ wo)) ** 5
    f0 = np.array([0.9, 0.3, 0.02])
    fresnel = f0 + (1.0 - f0) * schlick[..., None]
    alpha2 = 0.6 ** 4
    distribution = alpha2 / (np.pi * ((h[..., 2] ** 2) * (alpha2 - 1.0) + 1.0) ** 2)

    def Lambda(cos):
        return 0.5 * (np.sqrt(1.0 + alpha2 * (1.0 - cos * cos) / (cos * cos)) - 1.0)

    left = (1.0 - coat * (0.04 + 0.96 * schlick))[..., None]
    masking = 1.0 / (1.0 + Lambda(wo[2]) + Lambda(z))
    weight = 2.0 * np.pi / count / count
    diffuse = (np.array([0.8, 0.6, 0.4]) * (1.0 - fresnel) / np.pi * left * z[..., None]).sum((0, 1)) * weight
    specular = (left * fresnel * (distribution * masking / (4.0 * wo[2] * z) * z)[..., None]).sum((0, 1)) * weight
    return diffuse, specular


def test_lobes_of_unlike_colours_are_what_integrals_say(tmp_path):
    """The share of the diffuse lobe in what the plane reflects is another in each channel: a lobe that is chosen for all of
    them together, by luminance, would be wrong in each."""
    stage = tmp_path / "plane.usda"
    stage.write_text(_PLANE, encoding="utf-8")
    layers = RenderLightPaths(stage, ("color", "diffuse", "specular"), imageWidth=64, imageHeight=64, samples=64).aovs
    for name, expected in zip(("diffuse", "specular"), _PlaneIntegrals()):
        mean = layers[name].reshape(-1, 3).mean(0)
        assert np.allclose(mean, expected, rtol=0.006), (name, mean, expected)


def test_a_smooth_coat_over_a_rough_lobe_is_told_apart(tmp_path):
    """A coat of roughness 0 is a mirror: it sends Schlick's share of the dome at 45 degrees."""
    stage = tmp_path / "coat.usda"
    stage.write_text(_PLANE.replace("float inputs:roughness", "float inputs:clearcoat = 1\nfloat inputs:clearcoatRoughness = 0\n"
                                    "float inputs:roughness"), encoding="utf-8")
    names = ("lpe:C<RD>L", "lpe:C<RG>L", "lpe:C<RS>L")
    layers = RenderLightPaths(stage, ("color",) + names, imageWidth=64, imageHeight=64, samples=64).aovs
    mirror = np.full(3, 0.04 + 0.96 * (1.0 - np.sqrt(0.5)) ** 5)
    for name, expected in zip(names, (*_PlaneIntegrals(coat=1.0), mirror)):
        mean = layers[name].reshape(-1, 3).mean(0)
        assert np.allclose(mean, expected, rtol=0.01), (name, mean, expected)


def test_multipliers_of_lobes_are_those_of_their_lobe(tmp_path):
    """A light's `diffuse` and `specular` change their lobes alone."""
    stage = tmp_path / "plane.usda"
    parts = []
    for diffuse, specular in ((1.0, 1.0), (0.25, 1.0), (1.0, 0.5)):
        light = f'def DomeLight "Sky" {{\nfloat inputs:diffuse = {diffuse}\nfloat inputs:specular = {specular}'
        stage.write_text(_PLANE.replace('def DomeLight "Sky" {', light), encoding="utf-8")
        layers = RenderLightPaths(stage, ("color", "diffuse", "specular"), imageWidth=32, imageHeight=32, samples=256).aovs
        parts.append({name: layers[name].reshape(-1, 3).mean(0) for name in ("diffuse", "specular")})
    plain, lessDiffuse, lessSpecular = parts
    assert np.allclose(lessDiffuse["diffuse"], 0.25 * plain["diffuse"], rtol=0.01)
    assert np.allclose(lessDiffuse["specular"], plain["specular"], rtol=0.02)
    assert np.allclose(lessSpecular["specular"], 0.5 * plain["specular"], rtol=0.02)
    assert np.allclose(lessSpecular["diffuse"], plain["diffuse"], rtol=0.01)


def test_colour_has_the_bits_of_a_render_without(stage, image):
    """And path state, kernels' features aside, is what it was."""
    plain = RenderLightPaths(stage, ("color",))
    assert plain.aovs["color"].tobytes() == image.aovs["color"].tobytes()
    noisy = RenderLightPaths(stage, ("noisy",))
    assert plain.statistics["memory"] == noisy.statistics["memory"]


@pytest.mark.parametrize("settings", [{"residency": "stream", "geometryMemory": "30%", "chunkBytes": 4096}, {"waveSize": 4096},
                                      {"residency": "stream", "geometryMemory": "30%", "chunkBytes": 4096, "waveSize": 1024},
                                      {"residency": "stream", "geometryMemory": "30%", "request": "first"},
                                      {"traversal": "scalar"}], ids=["pool", "waves", "slotsUsedAgain", "first", "scalar"])
def test_bits_depend_on_nothing_else(stage, image, settings):
    other = RenderLightPaths(stage, ("color",) + _ALL, **settings)
    for name, pixels in image.aovs.items():
        assert pixels.tobytes() == other.aovs[name].tobytes(), name


def test_each_is_the_same_beside_others_and_alone(stage, image):
    for name in ("diffuse", "lightGroup:key", "lpe:C.<RD>.*[LO]"):
        assert RenderLightPaths(stage, (name,)).aovs[name].tobytes() == image.aovs[name].tobytes()


_SETTINGS = {"imageWidth": 48, "imageHeight": 32, "camera": "/World/Camera", "noCache": True}


def _Sums(renderer, samples, start):
    renderer.Prepare(aovs=["color", "diffuse", "lightGroup:key"], samples=samples, **_SETTINGS)
    return renderer.RenderSums(None, start)


def test_parts_of_a_farm_and_renders_that_go_on_have_the_same_bits(stage):
    renderer = hdstream.Renderer(str(stage))
    renderer.Prepare(aovs=["color", "diffuse", "lightGroup:key"], samples=40, **_SETTINGS)
    whole = renderer.RenderPrepared(None)
    blocks = [_Sums(renderer, end, [filmSums.BlackSums(48, 32, begin)]) for begin, end in ((0, 16), (16, 32), (32, 40))]
    travelled = [filmSums.Unpack(filmSums.Pack(block)) for block in blocks]
    assert travelled[0].lightPaths == ["C<RD>.*[LO]", "C.*<L.'key'>"]
    renderer.Prepare(aovs=["color", "diffuse", "lightGroup:key"], samples=40, **_SETTINGS)
    joined = renderer.RenderPrepared(None, travelled)
    begun = _Sums(renderer, 24, [])
    renderer.Prepare(aovs=["color", "diffuse", "lightGroup:key"], samples=40, **_SETTINGS)
    resumed = renderer.RenderPrepared(None, [begun])
    for name, pixels in whole.aovs.items():
        assert pixels.tobytes() == joined.aovs[name].tobytes(), name
        assert pixels.tobytes() == resumed.aovs[name].tobytes(), name


def test_sums_of_other_expressions_are_refused(stage):
    renderer = hdstream.Renderer(str(stage))
    sums = _Sums(renderer, 16, [])
    renderer.Prepare(aovs=["color", "specular"], samples=32, **_SETTINGS)
    with pytest.raises(_core.UsageError, match="other light path expressions"):
        renderer.RenderPrepared(None, [sums])


def test_adaptive_samples_add_up_too(stage):
    layers = RenderLightPaths(stage, ("color", "sampleCount") + _PARTS["lobes"], samples=96, noise=0.05, imageWidth=48,
                              imageHeight=32).aovs
    assert len(np.unique(layers["sampleCount"])) > 1
    total = sum(layers[name].astype(np.float64) for name in _PARTS["lobes"])
    assert np.allclose(total, layers["color"][..., :3], rtol=1e-5, atol=1e-6)


def test_lights_without_samples_are_black_and_groups_without_lights_too(tmp_path):
    stage = WriteLightPathStage(tmp_path / "fill.usda", ("fill",))
    layers = RenderLightPaths(stage, ("color", "lightGroup:key", "lightGroup:nobody", "lightGroup:fill")).aovs
    assert not layers["lightGroup:key"].any() and not layers["lightGroup:nobody"].any() and layers["lightGroup:fill"].any()


def test_all_lights_are_in_their_groups():
    assert set(LIGHTS) == {name.split(":")[1] for name in _GROUPS[:4]} | {"sky"}


_VARYING = ("diffuse", "lightGroup:key", "direct")


def _WithVariances(renderer, samples, seed=0):
    aovs = ["color", "variance", *_VARYING, *(f"variance:{name}" for name in _VARYING), "lpe:C.*[LO]", "variance:lpe:C.*[LO]"]
    renderer.Prepare(aovs=aovs, samples=samples, seed=seed, **_SETTINGS)
    return renderer.RenderPrepared(None).aovs


@pytest.mark.parametrize("samples", [2, 16, 21, 32, 40, 64])
def test_the_variance_of_all_light_is_that_of_colour(stage, samples):
    """By samples and by blocks, with the last block whole or begun."""
    layers = _WithVariances(hdstream.Renderer(str(stage)), samples)
    colour, all_ = layers["variance"][..., 0].astype(float), layers["variance:lpe:C.*[LO]"][..., 0].astype(float)
    rounding = 1e-6 * (layers["color"][..., :3].astype(float) @ (0.2126, 0.7152, 0.0722)) ** 2  # of a mean of squares less a square
    assert colour.max() > 0 and (np.abs(all_ - colour) <= 1e-4 * colour + rounding).all()


def test_variances_are_what_renders_of_other_seeds_spread_by(stage):
    """Against the spread of 48 renders. From fewer than two blocks samples count as independent, which states too much."""
    renderer = hdstream.Renderer(str(stage))
    runs = [_WithVariances(renderer, 64, seed) for seed in range(48)]
    for name in _VARYING:
        spread = np.mean(np.var([run[name] @ (0.2126, 0.7152, 0.0722) for run in runs], axis=0, ddof=1))
        told = np.mean([run[f"variance:{name}"][..., 0] for run in runs])
        assert spread > 0 and 0.9 < told / spread < 2.0, name


def test_variances_of_parts_have_the_bits_of_the_whole(stage):
    renderer = hdstream.Renderer(str(stage))
    settings = {"aovs": ["color", "variance:diffuse", "ambientOcclusion"], **_SETTINGS}
    renderer.Prepare(samples=40, **settings)
    whole = renderer.RenderPrepared(None)
    parts = []
    for begin, end in ((0, 16), (16, 32), (32, 40)):
        renderer.Prepare(samples=end, **settings)
        parts.append(renderer.RenderSums(None, [filmSums.BlackSums(48, 32, begin)]))
    renderer.Prepare(samples=40, **settings)
    joined = renderer.RenderPrepared(None, parts)
    renderer.Prepare(samples=24, **settings)
    begun = renderer.RenderSums(None, [])
    renderer.Prepare(samples=40, **settings)
    for other in (joined, renderer.RenderPrepared(None, [begun])):
        for name, pixels in whole.aovs.items():
            assert pixels.tobytes() == other.aovs[name].tobytes(), name


@pytest.mark.parametrize("name", ["variance:depth", "variance:", "variance:primvars:st", "variance:crypto_object", "variance:variance:diffuse"])
def test_only_light_has_variances(name):
    assert not _core.HasAov(name)
    with pytest.raises(_core.UsageError, match="there is no AOV"):
        _core.CheckAovs([name])
