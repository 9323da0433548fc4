# SPDX-License-Identifier: Apache-2.0
"""Hair in pictures: furnaces, closed forms of what lobes scatter, the helper nodes' formulas, closures, and paths that do not
matter to the bits. The formula itself: device/shading/testHair.cpp; Mitsuba's: test_hairMitsuba.py."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from cardStrip import Strip
from pxr import Sdf, UsdShade, Vt
from stages import author, curves, shapes
from stages.hair import AddHair, OfColor, OfDisplayColor, OfMelanin
from stages.materialX import AddNode, AddSurface

_T = Sdf.ValueTypeNames


def _Fibre(stage, path, material, width=1.0, tilt=0.0, isRibbon=False, x=0.0, color=None):
    """A straight fibre in the plane of y and z, `tilt` degrees from y towards +z, longer than the picture is high."""
    normals = [(0.0, 0.0, 1.0)] if isRibbon else None
    hair = curves.AddCurves(stage, path, [np.array([(0, -20.0, 0), (0, 20.0, 0)])], width, type="linear", normals=normals,
                            normalInterpolation="constant", color=color, translate=(x, 0, 0), rotate=(tilt, 0, 0))
    author.Bind(hair.GetPrim(), material)
    return hair


def _Stage(path, fill, light=("Dome", {}), width=1.0):
    """A stage seen along -z; `fill(stage)` adds to it. \\return its path."""
    stage = author.NewStage(str(path))
    fill(stage)
    if light is not None:
        author.AddLight(stage, "/World/Light", light[0], **light[1])
    author.AddCamera(stage, eye=(0, 0, 40), width=10.0 * width, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return str(path)


def _Render(path, size=16, samples=256, maxDepth=1, **settings):
    return ours.Render(path, size, size, samples=samples, maxDepth=maxDepth, **settings)


def _Attenuations(h, theta, ior=1.55, absorption=0.0):
    """What R, TT, TRT and the rest scatter, of a hit at the offset h: Chiang et al. 2016, section 4.2."""
    gammaO = np.arcsin(h)
    cosine = np.cos(theta) * np.cos(gammaO)
    sinT = np.sqrt(1 - cosine**2) / ior
    cosT = np.sqrt(1 - sinT**2)
    f = 0.5 * (((ior * cosine - cosT) / (ior * cosine + cosT))**2 + ((cosine - ior * cosT) / (cosine + ior * cosT))**2)
    index = np.sqrt(ior**2 - np.sin(theta)**2) / np.cos(theta)
    left = np.exp(-2 * absorption * np.cos(np.arcsin(h / index)) / np.sqrt(1 - (np.sin(theta) / ior)**2))
    tt = (1 - f)**2 * left
    return np.array([f, tt, tt * f * left, tt * (f * left)**2 / (1 - f * left)])


@pytest.mark.parametrize("roughness", [0.1, 0.4, 1.0])
@pytest.mark.parametrize("isRibbon", [False, True], ids=["round", "ribbon"])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, roughness, isRibbon):
    # Fibres side by side and behind one another, straight and bent, thick and thin: light goes from one to the other.
    def Fill(stage):
        material = AddHair(stage, "/World/Look", roughness=(roughness, roughness), cuticle=0.52)
        for index, tilt in enumerate((0, 35, -60, 75)):
            _Fibre(stage, f"/World/Fibre{index}", material, 0.25, tilt, isRibbon, 0.3 * index - 0.45)
        random = np.random.default_rng(4)
        bent = [np.cumsum(random.normal(size=(6, 3)) * 0.3, 0) for _ in range(12)]
        hair = curves.AddCurves(stage, "/World/Bent", bent, 0.08, wrap="pinned", normals=[(0, 0.1, 1)] if isRibbon else None,
                                normalInterpolation="constant")
        author.Bind(hair.GetPrim(), material)

    rgb = _Render(_Stage(tmp_path / "a.usda", Fill), samples=1024, maxDepth=200).rgb
    assert rgb.mean() == pytest.approx(1.0, abs=0.003)
    assert np.abs(rgb.reshape(2, 8, 2, 8, 3).mean((1, 3)) - 1.0).max() < 0.01


@pytest.mark.parametrize("isRibbon", [False, True], ids=["round", "ribbon"])
@pytest.mark.parametrize("tilt", [0.0, 40.0, -70.0])
def test_a_fibre_under_an_even_sky_is_what_its_lobes_scatter(tmp_path, isRibbon, tilt):
    """Column by column across the fibre. Rays through it meet nothing: one event, whatever the depth."""
    absorption, tints = np.array([0.1, 0.5, 2.0]), np.array([(1.0, 0.5, 0.2), (0.8, 1.0, 0.6), (0.3, 0.9, 1.0)])

    def Fill(stage):
        material = AddHair(stage, "/World/Look", absorption, (0.3, 0.3), cuticle=0.53, ior=1.4,
                           **{f"tint_{name}": tuple(tint) for name, tint in zip(("R", "TT", "TRT"), tints)})
        # The camera sees a tilted ribbon from the side of its normal, at an angle.
        _Fibre(stage, "/World/Fibre", material, 1.0, tilt, isRibbon)

    rgb = _Render(_Stage(tmp_path / "a.usda", Fill), samples=1024, maxDepth=8).rgb.mean(0)
    h = (np.arange(16 * 64) + 0.5) / (16 * 32) - 1
    lobes = np.stack([_Attenuations(h, np.radians(tilt), 1.4, a) for a in absorption], -1)
    expected = (lobes * tints[[0, 1, 2, 2], None]).sum(0).reshape(16, 64, 3).mean(1)
    np.testing.assert_allclose(rgb, expected, rtol=0.012)


def test_a_tapered_curl_scatters_once_what_goes_through_it(tmp_path):
    """Bent fibres whose radius changes: light that leaves by the far wall is not scattered there again."""
    def Fill(stage):
        tints = dict(tint_R=(0, 0, 0), tint_TRT=(0, 0, 0))
        material = AddHair(stage, "/World/Look", ior=1.0, roughness=((0.001, 0.001),) * 3, **tints)  # a tube of air
        angle = np.linspace(0, 9, 24)
        curl = np.stack([0.3 * np.cos(angle), 0.12 * angle - 0.5, 0.3 * np.sin(angle)], -1)
        hair = curves.AddCurves(stage, "/World/Curl", [curl], np.linspace(0.15, 0.05, 24), wrap="pinned")
        author.Bind(hair.GetPrim(), material)
        author.AddMesh(stage, "/World/Wall", shapes.Plane(20, 20), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0), translate=(0, 0, -2))

    # A way through is one bounce. Where a ray meets more than three walls in a row, a depth of 4 would show less.
    path = _Stage(tmp_path / "a.usda", Fill)
    few = _Render(path, 48, samples=64, maxDepth=4).rgb
    many = _Render(path, 48, samples=64, maxDepth=40).rgb
    assert few.mean() == pytest.approx(many.mean(), rel=2e-3)
    assert many.mean() == pytest.approx(0.5, rel=0.01)


def test_lights_that_are_sampled_and_found_are_one(tmp_path):
    """Between six walls that glow light comes from all sides; mesh lights are chosen, sampled, and found by rays."""
    def Fill(stage):
        material = AddHair(stage, "/World/Look", roughness=(0.3, 0.3))
        for index, tilt in enumerate((0, 50)):
            hair = curves.AddCurves(stage, f"/World/Fibre{index}", [np.array([(0, -0.9, 0), (0, 0.9, 0)])], 0.3, type="linear",
                                    translate=(0.5 * index - 0.25, 0, 0), rotate=(tilt, 0, 0))
            author.Bind(hair.GetPrim(), material)
        glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0, 0, 0), emissiveColor=(1, 1, 1), roughness=1.0, ior=1.0)
        for index, (rotate, translate) in enumerate((((0, 0, 0), (0, 1, 0)), ((0, 0, 0), (0, -1, 0)), ((90, 0, 0), (0, 0, 1)),
                                                     ((90, 0, 0), (0, 0, -1)), ((0, 0, 90), (1, 0, 0)), ((0, 0, 90), (-1, 0, 0)))):
            author.AddMesh(stage, f"/World/Wall{index}", shapes.Plane(100, 100), material=glow, doubleSided=True, rotate=rotate,
                           translate=50 * np.array(translate))

    rgb = _Render(_Stage(tmp_path / "a.usda", Fill, None), samples=1024, maxDepth=60).rgb
    assert rgb.mean() == pytest.approx(1.0, abs=0.004)


@pytest.mark.parametrize("kind", ["Distant", "Sphere"])
def test_lights_before_and_behind_a_fibre_add_up(tmp_path, kind):
    """One of two lights is chosen for each sample, whatever its side; lamps are found by rays as well."""
    def Picture(*sides):
        def Fill(stage):
            _Fibre(stage, "/World/Fibre", AddHair(stage, "/World/Look", roughness=(0.2, 0.2)))
            for side in sides:
                if kind == "Distant":
                    placed, inputs = dict(rotate=(0, 90 - 70 * side, 0)), dict(intensity=20.0 if side > 0 else 2.0, angle=0.0)
                else:
                    placed, inputs = dict(translate=(3, 0.5, 5 * side)), dict(intensity=20.0 if side > 0 else 2.0, radius=1.5)
                author.AddLight(stage, f"/World/Light{side + 1}", kind, placed, **inputs)

        return _Render(_Stage(tmp_path / f"{sides}.usda", Fill, None), samples=2048).rgb.mean((0, 1))

    front, back, both = Picture(1), Picture(-1), Picture(1, -1)
    assert min(front.min(), back.min()) > 0.05 * both.max()
    assert both == pytest.approx(front + back, rel=0.005)


def _Helper(kind, output, type, **inputs):
    """A function that adds a helper node to a stage; what it gives is (shader, output)."""
    def Build(stage, path):
        node, _ = AddNode(stage, path, f"ND_{kind}", **{name: value(stage) if callable(value) else value for name, value in inputs.items()})
        node.CreateOutput(output, type)
        if type == _T.Float3:
            return AddNode(stage, f"{path}Color", "ND_convert_vector3_color3", **{"in": (node, output)})
        pair = [AddNode(stage, f"{path}Channel{k}", "ND_extract_vector2", _T.Float, index=k, **{"in": (node, output)}) for k in (0, 1)]
        return AddNode(stage, f"{path}Color", "ND_combine3_color3", in1=pair[0], in2=pair[1], in3=0.0)
    return Build


def _Roughness(longitudinal, azimuthal, scale=1.0):
    """Chiang et al. 2016, eqs. 7 and 8."""
    x, y = longitudinal, azimuthal
    return ((0.726 * x + 0.812 * x**2 + 3.7 * x**20) * scale)**2, 0.265 * y + 1.194 * y**2 + 5.372 * y**22, 0.0


def _OfColor(color, b):
    """Chiang et al. 2016, eq. 9."""
    return (np.log(color) / (5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5))**2


def _OfMelanin(concentration, redness):
    """d'Eon et al. 2011, section 6.1, with MaterialX's scale of the concentration."""
    eumelanin, pheomelanin = np.array([0.419, 0.697, 1.37]), np.array([0.187, 0.4, 1.05])
    return -np.log(1 - concentration) * ((1 - redness) * eumelanin + redness * pheomelanin)


def _Computed(value):
    """The same number, of a primvar that is missing: the program computes it."""
    return lambda stage: AddNode(stage, f"/World/Computed{str(value).replace('.', '_')}", "ND_geompropvalue_float", _T.Float,
                                 geomprop="missing", default=value)


_COLOR = (0.8, 0.4, 0.05)
_HELPERS = {
    **{f"roughness_{name}": (_Roughness(0.35, 0.6, scale), ("chiang_hair_roughness", f"roughness_{name}", _T.Float2),
                             dict(longitudinal=0.35, azimuthal=0.6)) for name, scale in (("R", 1.0), ("TT", 0.5), ("TRT", 2.0))},
    "roughness_high": (_Roughness(1.0, 0.95, 0.7), ("chiang_hair_roughness", "roughness_TT", _T.Float2),
                       dict(longitudinal=1.4, azimuthal=0.95, scale_TT=0.7)),
    "roughness_computed": (_Roughness(0.35, 0.6), ("chiang_hair_roughness", "roughness_R", _T.Float2),
                           dict(longitudinal=_Computed(0.35), azimuthal=_Computed(0.6))),
    "roughness_default": (_Roughness(0.1, 0.2), ("chiang_hair_roughness", "roughness_R", _T.Float2), {}),
    "color": (_OfColor(np.array(_COLOR), 0.3), ("chiang_hair_absorption_from_color", "absorption", _T.Float3),
              dict(color=_COLOR, azimuthal_roughness=0.3)),
    "color_computed": (_OfColor(np.array(_COLOR), 0.9), ("chiang_hair_absorption_from_color", "absorption", _T.Float3),
                       dict(color=_COLOR, azimuthal_roughness=_Computed(0.9))),
    "color_black": (_OfColor(np.full(3, 0.001), 0.2), ("chiang_hair_absorption_from_color", "absorption", _T.Float3),
                    dict(color=(0.0, 0.0, -1.0))),
    "melanin": (_OfMelanin(0.6, 0.3), ("deon_hair_absorption_from_melanin", "absorption", _T.Float3),
                dict(melanin_concentration=0.6, melanin_redness=0.3)),
    "melanin_computed": (_OfMelanin(0.95, 1.0), ("deon_hair_absorption_from_melanin", "absorption", _T.Float3),
                         dict(melanin_concentration=_Computed(0.95), melanin_redness=1.0)),
    "melanin_default": (_OfMelanin(0.25, 0.5), ("deon_hair_absorption_from_melanin", "absorption", _T.Float3), {}),
}


@pytest.fixture(scope="module")
def Helpers(tmp_path_factory):
    strip = Strip(tmp_path_factory.mktemp("hair") / "strip.usda")
    for name, (_, (kind, output, type), inputs) in _HELPERS.items():
        def Glow(card, build=_Helper(kind, output, type, **inputs)):
            emission = build(strip.stage, f"/World/Helper{card.number}")
            edf = AddNode(strip.stage, f"/World/Edf{card.number}", "ND_uniform_edf", _T.Token, color=emission)
            author.Bind(card.mesh.GetPrim(), AddSurface(strip.stage, f"/World/Glow{card.number}", "ND_surface", edf=edf))
        strip.Add(name, Glow)
    strip.Render(samples=1)
    assert strip.picture.warnings == []
    return strip


@pytest.mark.parametrize("name", sorted(_HELPERS))
def test_helper_nodes_are_their_formulas(Helpers, name):
    np.testing.assert_allclose(Helpers.Pixels(name)[:, :3], np.tile(_HELPERS[name][0], (4, 1)), rtol=5e-5)


def _Picture(tmp_path, name, material, **settings):
    """Three fibres of a material under a sun and a sky. material: a function of the stage."""
    def Fill(stage):
        look = material(stage)
        for index, tilt in enumerate((0, 40, -50)):
            _Fibre(stage, f"/World/Fibre{index}", look, 0.3, tilt, index == 2, 0.33 * index - 0.33)
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-30, 50, 0)), intensity=3.0, angle=10.0)

    path = _Stage(tmp_path / f"{name}.usda", Fill, ("Dome", dict(intensity=0.5)))
    return _Render(path, 24, **{"samples": 64, "maxDepth": 4, **settings})


def _Hair(absorption=(0.2, 0.5, 1.0), **inputs):
    return lambda stage: AddHair(stage, "/World/Look", absorption, **inputs)


def _Closure(build):
    """A material whose closure `build(stage, hair)` makes of the closure of hair."""
    def Add(stage):
        AddHair(stage, "/World/Look", (0.2, 0.5, 1.0))
        hair = UsdShade.Shader.Get(stage, "/World/Look/Hair")
        return AddSurface(stage, "/World/Look", "ND_surface", bsdf=build(stage, (hair, "out")))
    return Add


def _Diffuse(stage):
    return AddNode(stage, "/World/Look/Diffuse", "ND_oren_nayar_diffuse_bsdf", _T.Token, color=(0.7, 0.3, 0.1))


def test_a_factor_is_that_of_the_tints(tmp_path):
    factor = (0.5, 0.8, 1.0)
    byFactor = _Picture(tmp_path, "factor", _Closure(lambda stage, hair: AddNode(
        stage, "/World/Look/Less", "ND_multiply_bsdfC", _T.Token, in1=hair, in2=factor)))
    byTints = _Picture(tmp_path, "tints", _Hair(tint_R=factor, tint_TT=factor, tint_TRT=factor))
    assert byFactor.layers["color"].tobytes() == byTints.layers["color"].tobytes()


@pytest.mark.parametrize("other", ["diffuse", "nothing"])
def test_a_mix_with_another_closure_is_the_mean_of_both(tmp_path, other):
    def Mix(share):
        def Build(stage, hair):
            background = dict(bg=_Diffuse(stage)) if other == "diffuse" else {}
            return AddNode(stage, "/World/Look/Mix", "ND_mix_bsdf", _T.Token, fg=hair, mix=share, **background)
        return _Closure(Build)

    settings = dict(samples=1024, maxDepth=0)
    half = _Picture(tmp_path, "half", Mix(0.5), **settings)
    # Light that is scattered once is linear in the closure.
    hair, diffuse = (_Picture(tmp_path, str(share), Mix(share), **settings).rgb for share in (1.0, 0.0))
    mean = (hair + diffuse) / 2
    assert np.abs(hair - diffuse).mean() > 0.1 * mean.mean()
    assert half.rgb.mean((0, 1)) == pytest.approx(mean.mean((0, 1)), rel=0.01)
    assert half.warnings == []


@pytest.mark.parametrize("isRibbon", [False, True], ids=["round", "ribbon"])
def test_what_lies_on_hair_takes_what_it_reflects(tmp_path, isRibbon):
    """Hair that absorbs nothing below a reflection is invisible in a furnace; where it absorbs all, the reflection is left."""
    def Fibre(absorption):
        def Fill(stage):
            AddHair(stage, "/World/Look", absorption, tint_R=(1.0,) * 3 if absorption[0] == 0.0 else (0.0,) * 3)
            top = AddNode(stage, "/World/Look/Top", "ND_dielectric_bsdf", _T.Token, ior=1.8, roughness=(0.3, 0.3))
            hair = UsdShade.Shader.Get(stage, "/World/Look/Hair"), "out"
            layer = AddNode(stage, "/World/Look/Layer", "ND_layer_bsdf", _T.Token, top=top, base=hair)
            _Fibre(stage, "/World/Fibre", AddSurface(stage, "/World/Look", "ND_surface", bsdf=layer), 1.0, 20.0, isRibbon)
        picture = _Render(_Stage(tmp_path / "a.usda", Fill), samples=2048, maxDepth=1)
        assert picture.warnings == []
        return picture.rgb[:, 3:13].mean((0, 1))
    assert Fibre((0.0, 0.0, 0.0)) == pytest.approx(np.ones(3), abs=0.01)
    assert (Fibre((1e4, 1e4, 1e4)) > 0.05).all()  # (0.8 / 2.8)^2 along the normal, less what a rough lobe loses


def test_primvars_are_read_by_curve_and_by_vertex(tmp_path):
    """Curves of one prim with a colour each, as prims with constants; a colour that changes along a curve."""
    colours = np.array([(0.9, 0.5, 0.2), (0.3, 0.6, 0.9)])
    lines = [np.array([(x, -20.0, 0), (x, 20.0, 0)]) for x in (-0.25, 0.25)]

    def One(stage):
        look = AddHair(stage, "/World/Look", OfDisplayColor(stage, "/World/Absorption"))
        hair = curves.AddCurves(stage, "/World/Both", lines, 0.4, type="linear")
        hair.CreateDisplayColorAttr(Vt.Vec3fArray.FromNumpy(colours.astype(np.float32)))
        hair.CreateDisplayColorPrimvar("uniform")
        author.Bind(hair.GetPrim(), look)

    def Two(stage):
        for index, (line, colour) in enumerate(zip(lines, colours)):
            look = AddHair(stage, f"/World/Look{index}", OfColor(stage, f"/World/Absorption{index}", tuple(colour)))
            hair = curves.AddCurves(stage, f"/World/Hair{index}", [line], 0.4, type="linear")
            author.Bind(hair.GetPrim(), look)

    def Vertex(stage):
        look = AddHair(stage, "/World/Look", OfDisplayColor(stage, "/World/Absorption"))
        hair = curves.AddCurves(stage, "/World/Hair", [np.array([(0, -1.0, 0), (0, 1.0, 0)])], 1.2, type="linear",
                                color=[(1.0, 1.0, 1.0), (0.01, 0.01, 0.01)])
        author.Bind(hair.GetPrim(), look)

    one, two = (_Render(_Stage(tmp_path / f"{fill.__name__}.usda", fill)).rgb for fill in (One, Two))
    np.testing.assert_allclose(one, two, atol=2e-5)
    assert np.abs(one[:, 4] - one[:, 12]).mean() > 0.03
    rows = _Render(_Stage(tmp_path / "vertex.usda", Vertex), samples=64).rgb[:, 6:10].mean((1, 2))
    quarters = rows.reshape(4, 4).mean(1)  # from the top, where it is dark
    assert (np.diff(quarters) > 0.01).all()


@pytest.mark.parametrize("traversal", ["simd8", "scalar"])
def test_bits_do_not_depend_on_how_it_is_rendered(tmp_path, traversal):
    expected = _Picture(tmp_path, "a", _Hair())
    assert expected.warnings == []
    other = _Picture(tmp_path, "b", _Hair(), traversal=traversal, waveSize=3001)
    assert other.layers["color"].tobytes() == expected.layers["color"].tobytes()


def test_what_of_hair_no_ray_sees_changes_no_bits(tmp_path):
    """The features of hair, in the kernels of pictures without it: curves that are no hair keep their inner walls."""
    def Fill(isThere):
        def Add(stage):
            glass = author.AddMaterial(stage, "/World/Glass", diffuseColor=(0.5, 0.4, 0.3), opacity=0.5, roughness=0.3)
            for index, tilt in enumerate((0, 40)):
                _Fibre(stage, f"/World/Tube{index}", glass, 0.3, tilt, False, 0.4 * index - 0.2)
            if isThere:
                # Behind the tubes in the order of paths, which are in the numbers of rays that pass.
                far = curves.AddCurves(stage, "/World/UnseenHair", [np.array([(9, 0, 9.0), (9, 0.1, 9)])], 0.01,
                                       type="linear")
                author.Bind(far.GetPrim(), AddHair(stage, "/World/Look"))
            author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-30, 50, 0)), intensity=3.0, angle=1.0)
        return Add

    without, having = (_Render(_Stage(tmp_path / f"{isThere}.usda", Fill(isThere)), 24, samples=16, maxDepth=4)
                       for isThere in (False, True))
    assert without.layers["color"].tobytes() == having.layers["color"].tobytes()


def test_light_path_expressions_tell_sides_apart_and_add_up(tmp_path):
    """Hair is glossy: what comes from the side of the hit is reflected, the rest is transmitted. A tube of air transmits all."""
    names = ("emission", "diffuse", "specular", "transmission", "lpe:C<RG>.*[LO]", "lpe:C<TG>.*[LO]")

    def Layers(name, material):
        return _Picture(tmp_path, name, material, aovs=("color", "albedo", *names)).layers

    hair = Layers("hair", _Hair())
    total = sum(hair[name].astype(np.float64) for name in names[:4])
    np.testing.assert_allclose(total, hair["color"][..., :3], atol=1e-5 * hair["color"].max())
    np.testing.assert_array_equal(hair["specular"], hair["lpe:C<RG>.*[LO]"])
    np.testing.assert_array_equal(hair["transmission"], hair["lpe:C<TG>.*[LO]"])
    assert hair["specular"].mean() > 0.02 and hair["transmission"].mean() > 0.02 and hair["diffuse"].max() == 0.0
    air = Layers("air", _Hair((0, 0, 0), ior=1.0, roughness=((0.001, 0.001),) * 3))
    assert air["specular"].mean() < 0.02 * air["transmission"].mean()


def test_the_albedo_is_what_the_lobes_scatter(tmp_path):
    def Fill(stage):
        _Fibre(stage, "/World/Fibre", AddHair(stage, "/World/Look", (0.1, 0.5, 2.0), ior=1.4))

    layers = _Render(_Stage(tmp_path / "a.usda", Fill), samples=1, aovs=("color", "albedo", "normal")).layers
    h = (np.arange(16) + 0.5) / 8 - 1
    expected = np.stack([_Attenuations(h, 0.0, 1.4, absorption).sum(0) for absorption in (0.1, 0.5, 2.0)], -1)
    np.testing.assert_allclose(layers["albedo"][8], expected, atol=2e-4)
    np.testing.assert_allclose(layers["normal"][8], np.stack([h, 0 * h, np.sqrt(1 - h**2)], -1), atol=2e-4)


def test_a_direction_of_its_own_is_where_the_lobes_lie(tmp_path):
    """A ball whose hair lies along y, by hand, has a highlight that a ball along x has turned by a quarter."""
    def Picture(name, direction):
        def Fill(stage):
            look = AddHair(stage, "/World/Look", (0.5, 0.5, 0.5), curve_direction=direction)
            author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.48, 48, 96), material=look)
        light = ("Distant", dict(placement=dict(rotate=(0, 0, 0)), intensity=3000.0, angle=5.0))
        return _Render(_Stage(tmp_path / f"{name}.usda", Fill, light), 32, samples=64, maxDepth=1).rgb.mean(-1)

    alongY, alongX = Picture("y", (0.0, 1.0, 0.0)), Picture("x", (1.0, 0.0, 0.0))
    assert np.abs(np.rot90(alongY) - alongX).mean() < 0.03 * alongX.mean()
    assert np.abs(alongY - alongX).mean() > 0.1 * alongX.mean()


def test_opacity_and_emission_are_those_of_the_surface(tmp_path):
    """Half of a fibre without hair's light, and what it emits, over a bright sky that is seen through it."""
    def Fill(stage):
        look = AddHair(stage, "/World/Look", (50.0, 50.0, 50.0), opacity=0.25, tint_R=(0.0, 0.0, 0.0))
        edf = AddNode(stage, "/World/Look/Edf", "ND_uniform_edf", _T.Token, color=(2.0, 1.0, 0.0))
        AddSurface(stage, "/World/Look", "ND_surface", bsdf=(UsdShade.Shader.Get(stage, "/World/Look/Hair"), "out"), edf=edf, opacity=0.25)
        _Fibre(stage, "/World/Fibre", look, width=2.0)

    middle = _Render(_Stage(tmp_path / "a.usda", Fill), samples=1024).rgb[:, 6:10].mean((0, 1))
    # Passed by one wall: rays do not meet the far one.
    assert middle == pytest.approx([0.75 + 0.25 * 2, 0.75 + 0.25, 0.75], abs=0.02)


def test_rough_bounces_make_hair_rougher_behind_them(tmp_path):
    """filterGlossy is a bias that leaves energy alone: what absorbs nothing stays invisible."""
    rgb = _Picture(tmp_path, "filtered", _Hair((0.0, 0.0, 0.0)), filterGlossy=1.0, samples=256).rgb
    plain = _Picture(tmp_path, "plain", _Hair((0.0, 0.0, 0.0)), samples=256).rgb
    assert rgb.mean() == pytest.approx(plain.mean(), rel=0.02)
    assert rgb.tobytes() != plain.tobytes()


_FILE = """<?xml version="1.0"?>
<materialx version="1.39">
  <deon_hair_absorption_from_melanin name="melanin" type="vector3">
    <input name="melanin_concentration" type="float" value="0.5"/>
  </deon_hair_absorption_from_melanin>
  <chiang_hair_roughness name="roughness" type="multioutput">
    <input name="longitudinal" type="float" value="0.3"/>
    <input name="azimuthal" type="float" value="0.3"/>
  </chiang_hair_roughness>
  <chiang_hair_bsdf name="hair" type="BSDF">
    <input name="roughness_R" type="vector2" nodename="roughness" output="roughness_R"/>
    <input name="roughness_TT" type="vector2" nodename="roughness" output="roughness_TT"/>
    <input name="roughness_TRT" type="vector2" nodename="roughness" output="roughness_TRT"/>
    <input name="absorption_coefficient" type="vector3" nodename="melanin"/>
  </chiang_hair_bsdf>
  <surface name="surface" type="surfaceshader">
    <input name="bsdf" type="BSDF" nodename="hair"/>
  </surface>
  <surfacematerial name="Hair" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface"/>
  </surfacematerial>
</materialx>
"""


def test_a_file_of_materialx_gives_the_bits_of_the_same_prims(tmp_path):
    pytest.importorskip("MaterialX")
    import hdstream

    (tmp_path / "hair.mtlx").write_text(_FILE)

    def Prims(stage):
        _Fibre(stage, "/World/Fibre", AddHair(stage, "/World/Look", OfMelanin(stage, "/World/Melanin", 0.5, 0.5)))

    def File(stage):
        _Fibre(stage, "/World/Fibre", UsdShade.Material.Define(stage, "/World/Empty"))
        stage.DefinePrim("/World/Looks").GetReferences().AddReference("hair.mtlx", "/MaterialX")
        stage.GetPrimAtPath("/World/Fibre").GetRelationship("material:binding").SetTargets(["/World/Looks/Materials/Hair"])

    prims, file = (hdstream.Renderer(_Stage(tmp_path / f"{fill.__name__}.usda", fill)).Render(camera="/World/Camera", imageWidth=16, samples=16)
                   for fill in (Prims, File))
    assert prims.aovs["color"].tobytes() == file.aovs["color"].tobytes()
    assert prims.aovs["color"][8, 8, :3].max() < 0.9  # not the sky
