# SPDX-License-Identifier: Apache-2.0
"""Light filters leave of a light what their geometry says: footprints on a plate against similar triangles and quadrature
in double precision, written from the definitions in docs/lights.md."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux

pytest.importorskip("hdstream._core")

import closedForm
import ours
from stages import author, imageFile, shapes
from test_lights import _UP, ALBEDO, HEIGHT, WIDTH, _Blocks, _MatrixOf, _PictureOf, _Plate, _Points, _Render

_FLOAT, _COLOR, _FLOATS = Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.FloatArray
_IMAGE = np.array([[[0.9, 0.1, 0.2], [0.3, 0.8, 0.1], [0.2, 0.1, 0.7]], [[0.1, 0.1, 0.1], [0.6, 0.5, 0.1], [1.0, 1.0, 1.0]]])
_LAMP = dict(translate=(0.2, 2.0, 0.1), rotate=(-80, 10, 0))


def _AddFilter(stage, light, kind, path="/World/Filter", placement=None, typed=False, **inputs):
    """A filter of a light; `typed`: as RenderMan's prim type, else as UsdLuxLightFilter with a shader id."""
    if typed:
        prim = stage.DefinePrim(path, kind)
        author.Place(UsdGeom.Xformable(prim), **(placement or {}))
    else:
        lightFilter = UsdLux.LightFilter.Define(stage, path)
        author.Place(lightFilter, **(placement or {}))
        prim = lightFilter.GetPrim()
        lightFilter.CreateShaderIdAttr(kind)
    for name, value in inputs.items():
        name = "inputs:" + name.replace("__", ":")
        if isinstance(value, str):
            isFile = value.startswith("./")
            attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.Asset if isFile else Sdf.ValueTypeNames.Token)
            attribute.Set(Sdf.AssetPath(value) if isFile else value)
        elif isinstance(value, bool):
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Bool).Set(value)
        elif isinstance(value, (list, np.ndarray)):
            prim.CreateAttribute(name, _FLOATS).Set([float(v) for v in np.ravel(value)])
        elif isinstance(value, tuple):
            prim.CreateAttribute(name, _COLOR).Set(Gf.Vec3f(*map(float, value)))
        else:
            prim.CreateAttribute(name, _FLOAT).Set(float(value))
    UsdLux.LightAPI(light).CreateFiltersRel().AddTarget(path)
    return prim


def _Region(p, inputs, axes):
    """1 in the inner box that has grown by the radius, 0 beyond the edge."""
    names = (("width", "left", "right"), ("height", "bottom", "top"), ("depth", "back", "front"))[:axes]
    scales = [inputs.get(f"scale__{name}", 1.0) for name, *_ in names]
    out = [np.maximum(np.maximum(-(inputs.get(name, 1.0) / 2 + inputs.get(f"refine__{low}", 0.0)) * scale - p[:, i],
                                 p[:, i] - (inputs.get(name, 1.0) / 2 + inputs.get(f"refine__{high}", 0.0)) * scale), 0)
           for i, ((name, low, high), scale) in enumerate(zip(names, scales))]
    distance = np.linalg.norm(out, axis=0) - inputs.get("radius", 0.5) * min(scales)
    edge = inputs.get("edgeThickness", inputs.get("edge", 0.0))
    return np.clip(1 - distance / edge, 0, 1) if edge else (distance <= 0).astype(float)


def _Cookie(at, inputs):
    """The image, bilinear within its rect: x to the right and y up as the light sees it."""
    u = at[:, 0] / inputs.get("width", 1.0) + 0.5
    v = 0.5 - at[:, 1] / inputs.get("height", 1.0)
    rows, columns = _IMAGE.shape[:2]
    x, y = np.clip(u * columns - 0.5, 0, columns - 1), np.clip(v * rows - 0.5, 0, rows - 1)
    i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
    s, t = (x - i)[:, None], (y - j)[:, None]
    image = (1 - t) * ((1 - s) * _IMAGE[j, i] + s * _IMAGE[j, i + 1]) + t * ((1 - s) * _IMAGE[j + 1, i] + s * _IMAGE[j + 1, i + 1])
    isInside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    return np.where(isInside[:, None], image * inputs.get("color__tint", (1, 1, 1)), inputs.get("texture__fillColor", (0, 0, 0)))


def _Factor(kind, matrix, inputs, points, light):
    """[n][3] of one filter between lit points [n][3] and a point of the light."""
    inverse = np.linalg.inv(matrix)
    p, q = (np.append(points, np.ones((len(points), 1)), 1) @ inverse)[:, :3], (np.append(light, 1) @ inverse)[:3]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = p[:, 2] / (p[:, 2] - q[2])
        at = p + s[:, None] * (q - p)
    crosses = (s >= 0) & (s <= 1 + 1e-9)
    if kind == "PxrBarnLightFilter":
        region = _Region(at, inputs, 2)
        effect = inputs.get("preBarnEffect", "noEffect")
        inside = region if effect == "cone" else np.where(crosses, region, effect == "noEffect")
        factor = 1 - inside if inputs.get("invert") else inside
    elif kind in ("PxrRodLightFilter", "PxrBlockerLightFilter"):
        factor = 1 + _Region(p, inputs, 3) * (inputs.get("intensity", 0.0) - 1)
    elif kind == "PxrRampLightFilter":
        distance = {"distanceToLight": np.linalg.norm(light - points, axis=1), "linear": -p[:, 2],
                    "spherical": np.linalg.norm(p, axis=1), "radial": np.hypot(p[:, 0], p[:, 1])}[inputs["rampMode"]]
        x = (distance - inputs["falloffRamp__beginDistance"]) / (inputs["falloffRamp__endDistance"] - inputs["falloffRamp__beginDistance"])
        knots, colors = inputs["colorRamp__spline__positions"], np.reshape(inputs["colorRamp__spline__values"], (-1, 3))
        factor = np.stack([np.interp(x, knots, colors[:, c]) for c in range(3)], 1)
    else:
        factor = np.where(crosses[:, None], _Cookie(at, inputs), 1.0)
    factor = factor if factor.ndim == 2 else np.repeat(factor[:, None], 3, 1)
    return 1 + inputs.get("density", 1.0) * (factor - 1)


_RAMP = dict(falloffRamp__beginDistance=0.5, falloffRamp__endDistance=3.0, colorRamp__spline__positions=[0.0, 0.4, 1.0],
             colorRamp__spline__values=[1.0, 0.2, 0.1, 0.3, 0.9, 0.3, 0.1, 0.1, 1.5])
_BELOW = dict(translate=(0.15, 1.4, 0.1), rotate=(-85, 15, 20))
_ASIDE = dict(translate=(0.35, 1.4, 0.2), rotate=(-90, 0, 0))
# light kind, its inputs, [(kind, placement, inputs)]
FILTERS = {
    "point through a window": ("Point", [("PxrBarnLightFilter", _BELOW, dict(width=0.5, height=0.3, radius=0.0))]),
    "rect through a rounded one": ("Rect", [("PxrBarnLightFilter", _BELOW, dict(width=0.4, height=0.3, radius=0.15, refine__left=0.1,
                                                                              scale__width=1.5, scale__height=1.5, edgeThickness=0.1))]),
    "rect, doors in its plane": ("Rect", [("PxrBarnLightFilter", _LAMP, dict(width=0.3, height=0.2, radius=0.0))]),
    "sphere behind a disc": ("Sphere", [("PxrBarnLightFilter", _BELOW, dict(width=0.1, height=0.1, radius=0.2, invert=True, density=0.8))]),
    "doors behind the points": ("Sphere", [("PxrBarnLightFilter", dict(translate=(0.3, 0.2, 0), rotate=(0, 90, 0)),
                                            dict(width=1.2, height=3.0, radius=0.0, preBarnEffect="noLight"))]),
    "cone": ("Point", [("PxrBarnLightFilter", dict(translate=(0.3, 0.2, 0), rotate=(0, 90, 0)),
                        dict(width=1.2, height=2.0, radius=0.1, preBarnEffect="cone"))]),
    "cookie": ("Point", [("PxrCookieLightFilter", _BELOW, dict(width=0.9, height=0.6, texture__map="./cookie.exr",
                                                               texture__fillColor=(0.05, 0.1, 0.2), color__tint=(1, 0.8, 0.6)))]),
    "gobo on a rect": ("Rect", [("PxrGoboLightFilter", _BELOW, dict(width=1.2, height=0.9, map="./cookie.exr"))]),
    "ramp to the light": ("Sphere", [("PxrRampLightFilter", {}, dict(_RAMP, rampMode="distanceToLight"))]),
    "ramp along": ("Distant", [("PxrRampLightFilter", dict(translate=(-1.5, 0, 0), rotate=(0, -90, 0)), dict(_RAMP, rampMode="linear"))]),
    "ramp from a point": ("Distant", [("PxrRampLightFilter", dict(translate=(0.5, 0.1, 0.2)), dict(_RAMP, rampMode="spherical"))]),
    "ramp from an axis": ("Rect", [("PxrRampLightFilter", dict(translate=(0.5, 0.1, 0.2), rotate=(-60, 0, 0)),
                                    dict(_RAMP, rampMode="radial"))]),
    "rod": ("Sphere", [("PxrRodLightFilter", dict(translate=(0.4, 0.1, -0.2), rotate=(10, 30, 0)),
                        dict(width=0.8, height=0.5, depth=0.4, radius=0.3, edgeThickness=0.4, intensity=0.1))]),
    "rod that adds": ("Distant", [("PxrRodLightFilter", dict(translate=(-0.4, 0, 0.2)), dict(radius=0.2, intensity=2.5))]),
    "two multiply": ("Rect", [("PxrBarnLightFilter", _BELOW, dict(width=0.6, height=0.6, radius=0.0)),
                              ("PxrRodLightFilter", dict(translate=(0.2, 0, 0)), dict(radius=0.3, intensity=0.25))]),
    "blocker": ("Sphere", [("PxrBlockerLightFilter", dict(translate=(0.4, 0.1, -0.2)), dict(width=0.8, height=0.5, depth=0.4, radius=0.3,
                                                                                          edge=0.4))]),
    "greatest": ("Point", [("PxrBarnLightFilter", _BELOW, dict(width=0.4, height=0.3, radius=0.0, combineMode="max")),
                           ("PxrBarnLightFilter", _ASIDE, dict(width=0.4, height=0.3, radius=0.0, density=0.8, combineMode="max"))]),
    "least": ("Point", [("PxrBarnLightFilter", _BELOW, dict(width=0.7, height=0.5, radius=0.0, density=0.5, combineMode="min")),
                        ("PxrBarnLightFilter", _ASIDE, dict(width=0.7, height=0.5, radius=0.0, density=0.8, combineMode="min"))]),
    "screen": ("Point", [("PxrRampLightFilter", {}, dict(_RAMP, rampMode="distanceToLight", combineMode="screen")),
                         ("PxrBarnLightFilter", _ASIDE, dict(width=0.6, height=0.5, radius=0.1, density=0.7, combineMode="screen"))]),
    "ways beside each other": ("Point", [
        ("PxrBarnLightFilter", _BELOW, dict(width=0.5, height=0.4, radius=0.0, density=0.9, combineMode="max")),
        ("PxrBarnLightFilter", _ASIDE, dict(width=0.5, height=0.4, radius=0.0, density=0.7, combineMode="max")),
        ("PxrRodLightFilter", dict(translate=(0.2, 0, 0)), dict(radius=0.3, intensity=0.25)),
        ("PxrRampLightFilter", dict(translate=(0.5, 0.1, 0.2)), dict(_RAMP, rampMode="spherical", density=0.6, combineMode="screen")),
        ("PxrRodLightFilter", dict(translate=(-0.4, 0, 0.2)), dict(radius=0.2, intensity=0.5, combineMode="min")),
        ("PxrRodLightFilter", dict(translate=(-0.2, 0, 0.2)), dict(radius=0.2, intensity=0.3, combineMode="min"))]),
}


def _Lamp(stage, kind, path="/World/Light"):
    if kind == "Point":
        return author.AddLight(stage, path, "Sphere", _LAMP, radius=0.5, treatAsPoint=True)
    if kind == "Distant":
        return author.AddLight(stage, path, "Distant", dict(rotate=(-60, 30, 0)), angle=0.0, intensity=2.0)
    inputs = dict(radius=0.2) if kind == "Sphere" else dict(width=0.6, height=0.4)
    return author.AddLight(stage, path, kind, _LAMP, **inputs)


def _Expected(kind, matrix, filters):
    """The picture of the plate under a lamp, given [(kind, matrix, inputs)]."""
    steps = 24 if kind in ("Point", "Distant") else 6  # borders of light are sharp there
    points = _Points(steps)

    def product(light):
        ways = {way: [_Factor(k, m, i, points, light) for k, m, i in filters if i.get("combineMode", "multiply") == way]
                for way in ("multiply", "max", "min", "screen")}
        whole = np.prod([np.ones_like(points), *ways["multiply"]], axis=0)
        whole = whole * np.max(ways["max"], axis=0) if ways["max"] else whole
        whole = whole * np.min(ways["min"], axis=0) if ways["min"] else whole
        return whole * (1 - np.prod(1 - np.minimum(ways["screen"], 1), axis=0)) if ways["screen"] else whole

    if kind == "Distant":
        axis = matrix[2, :3] / np.linalg.norm(matrix[2, :3])
        return _PictureOf(2.0 * axis[1] * product(1e6 * axis), steps)
    if kind == "Point":
        d = matrix[3, :3] - points
        distance = np.linalg.norm(d, axis=1)
        return _PictureOf(np.pi * 0.25 * (d[:, 1] / distance**3)[:, None] * product(matrix[3, :3]), steps)
    patches = closedForm.PatchesOfSphere(matrix, 0.2, 24) if kind == "Sphere" else closedForm.PatchesOfFlat(matrix, 0.6, 0.4, 24)
    total = np.zeros((len(points), 3))
    for centre, normal in zip(*patches[:2]):
        d = centre - points
        distance = np.linalg.norm(d, axis=1)
        cosines = np.maximum(d @ _UP, 0) * np.maximum(-(d @ normal), 0)
        lit = cosines > 0
        if lit.any():
            factor = product(centre)
            total += (patches[2] * cosines / distance**4)[:, None] * factor
    return _PictureOf(total, steps)


def _WriteCookie(folder):
    imageFile.WriteExr(folder / "cookie.exr", {name: _IMAGE[:, :, c] for c, name in enumerate("RGB")})


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_footprint_on_plate(name, tmp_path):
    """Irradiance behind each filter: the mean within 1 %, blocks within 3 % of the brightest."""
    kind, filters = FILTERS[name]
    _WriteCookie(tmp_path)
    stage = _Plate(f"{tmp_path}/a.usda")
    light = _Lamp(stage, kind)
    placed = []
    for i, (filterKind, placement, inputs) in enumerate(filters):
        prim = _AddFilter(stage, light, filterKind, f"/World/Filter{i}", placement, typed=i > 0, **inputs)
        placed.append((filterKind, _MatrixOf(stage, prim.GetPath()), inputs))
    picture = _Render(stage, samples=1024)
    assert picture.warnings == []
    expected = _Expected(kind, _MatrixOf(stage, "/World/Light"), placed)
    assert picture.rgb.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=0.01, abs=1e-4 * expected.max())
    assert np.abs(_Blocks(picture.rgb) - _Blocks(expected)).max() < 0.03 * _Blocks(expected).max()
    plain = _Expected(kind, _MatrixOf(stage, "/World/Light"), [])
    assert np.abs(_Blocks(expected) - _Blocks(plain)).max() > 0.1 * _Blocks(plain).max(), "the filter does nothing here"


def test_the_camera_sees_the_light_through_its_doors(tmp_path):
    """Radiance 1 where the camera's rays pass the opening, else 0 and no alpha."""
    stage = author.NewStage(f"{tmp_path}/a.usda")
    light = author.AddLight(stage, "/World/Light", "Rect", dict(translate=(0, 0, 0)), width=4.0, height=4.0)
    author.AddCamera(stage, eye=(0, 0, -4), target=(0, 0, 0), up=(0, 1, 0), width=40, orthographic=True)
    _AddFilter(stage, light, "PxrBarnLightFilter", placement=dict(translate=(0.5, 0, -1)), width=1.0, height=6.0, radius=0.0)
    stage.GetRootLayer().Save()
    picture = ours.Render(f"{tmp_path}/a.usda", 32, 24, samples=64, maxDepth=0)
    row = picture.rgb[12, :, 0]  # the camera looks along +z: world x grows to the left
    x = -((np.arange(32) + 0.5) / 32 - 0.5) * 4.0
    inside = np.abs(x - 0.5) < 0.5
    assert row[inside] == pytest.approx(1.0)
    assert row[~inside] == pytest.approx(0.0)
    assert picture.layers["color"][12, :, 3] == pytest.approx(inside.astype(float))


def test_multipliers_scale_the_light(tmp_path):
    """PxrIntMultLightFilter: intensity, exposure, saturation of the colour; density is of others."""
    stage = _Plate(f"{tmp_path}/a.usda")
    light = _Lamp(stage, "Rect")
    light.CreateColorAttr(Gf.Vec3f(1.0, 0.5, 0.25))
    plain = _Render(stage, samples=16).rgb
    _AddFilter(stage, light, "PxrIntMultLightFilter", intensity=0.5, exposure=2.0, saturation=0.5)
    picture = _Render(stage, samples=16)
    assert picture.warnings == []
    luminance = np.dot((1.0, 0.5, 0.25), (0.2126, 0.7152, 0.0722))
    factor = 2.0 * (luminance + 0.5 * (np.array((1.0, 0.5, 0.25)) - luminance)) / (1.0, 0.5, 0.25)
    assert picture.rgb == pytest.approx(plain * factor, rel=1e-4)


def test_filters_follow_the_instances_of_their_light(tmp_path):
    """Two instances of a lamp behind doors are two lamps behind doors."""
    pictures = []
    for isInstanced in (True, False):
        stage = _Plate(f"{tmp_path}/{isInstanced}.usda")
        for i, x in enumerate((-0.8, 0.9)):
            if isInstanced:
                prototype = UsdGeom.Xform.Define(stage, "/Lamp")
                lamp = author.AddLight(stage, "/Lamp/Light", "Sphere", dict(translate=(0, 2, 0)), radius=0.1) if i == 0 else lamp
                if i == 0:
                    _AddFilter(stage, lamp, "PxrBarnLightFilter", "/Lamp/Filter", dict(translate=(0, 1.5, 0), rotate=(-90, 0, 0)),
                               width=0.2, height=0.4, radius=0.0)
                    prototype.GetPrim().SetSpecifier(Sdf.SpecifierClass)
                one = UsdGeom.Xform.Define(stage, f"/World/Lamp{i}")
                one.GetPrim().GetReferences().AddInternalReference("/Lamp")
                one.GetPrim().SetInstanceable(True)
                author.Place(one, translate=(x, 0, 0))
            else:
                lamp = author.AddLight(stage, f"/World/Light{i}", "Sphere", dict(translate=(x, 2, 0)), radius=0.1)
                _AddFilter(stage, lamp, "PxrBarnLightFilter", f"/World/Filter{i}", dict(translate=(x, 1.5, 0), rotate=(-90, 0, 0)),
                           width=0.2, height=0.4, radius=0.0)
        picture = _Render(stage, samples=256)
        assert picture.warnings == []
        pictures.append(_Blocks(picture.rgb))
    assert pictures[0].max() > 0
    assert np.abs(pictures[0] - pictures[1]).max() < 0.02 * pictures[1].max()


def _FlatLamp(path, z, isInstanced=False):
    """The picture of a rect light behind doors, whose transform has that z scale."""
    stage = _Plate(path)
    root = "/Lamp" if isInstanced else "/World"
    if isInstanced:
        UsdGeom.Xform.Define(stage, "/Lamp").GetPrim().SetSpecifier(Sdf.SpecifierClass)
        one = UsdGeom.Xform.Define(stage, "/World/Lamp")
        one.GetPrim().GetReferences().AddInternalReference("/Lamp")
        one.GetPrim().SetInstanceable(True)
        author.Place(one, translate=(0.3, 0, 0))
    lamp = author.AddLight(stage, f"{root}/Light", "Rect", dict(translate=(0, 2, 0), rotate=(-90, 0, 0), scale=(1, 1, z)),
                           width=0.3, height=0.2, intensity=20.0)
    _AddFilter(stage, lamp, "PxrBarnLightFilter", f"{root}/Filter", dict(translate=(0, 1.5, 0), rotate=(-90, 0, 0)),
               width=0.2, height=0.4, radius=0.0)
    return _Render(stage, samples=64)


def test_filters_of_a_flat_light_stay(tmp_path):
    """A z scale of 0 means the same light, though the transform has no inverse: the doors are where they are."""
    full, flat = (_FlatLamp(f"{tmp_path}/{z}.usda", z) for z in (1.0, 0.0))
    assert full.warnings == [] and flat.warnings == []
    full, flat = _Blocks(full.rgb), _Blocks(flat.rgb)
    assert full.max() > 10 * full.min()
    assert np.abs(full - flat).max() < 0.02 * full.max()


def test_filters_of_a_flat_light_in_an_instance_say_so(tmp_path):
    """Where the space of the instance is known by the light's inverse alone, what is left out is said of the light."""
    assert _FlatLamp(f"{tmp_path}/a.usda", 1.0, isInstanced=True).warnings == []
    assert _FlatLamp(f"{tmp_path}/b.usda", 0.0, isInstanced=True).warnings == [
        "/World/Lamp/Light: light with a singular transform below an instancer: its filter /World/Lamp/Filter is left out"]


def test_what_is_not_supported_says_so_once(tmp_path):
    """An unknown kind, inputs that are left out, a missing image."""
    stage = _Plate(f"{tmp_path}/a.usda")
    light = _Lamp(stage, "Rect")
    plain = _Render(stage, samples=4).rgb
    _AddFilter(stage, light, "barndoor", "/World/A")
    _AddFilter(stage, light, "PxrCookieLightFilter", "/World/B", map="./none.exr")
    _AddFilter(stage, light, "PxrBarnLightFilter", "/World/C", width=1e4, height=1e4, barnMode="analytic", ri__combineMode="screen")
    light.CreateFiltersRel().AddTarget("/World/None")
    picture = _Render(stage, samples=4)
    assert np.allclose(picture.rgb, plain, rtol=1e-3, atol=1e-4)
    text = "\n".join(picture.warnings)
    for part in ("/World/A: light filter barndoor is not supported yet; left out",
                 "/World/B: light filter has no image that can be read; left out",
                 "/World/C: light filter: not supported and left out: barnMode",
                 "light filter /World/None does not exist; left out"):
        assert text.count(part) == 1, text
