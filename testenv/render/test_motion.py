# SPDX-License-Identifier: Apache-2.0
"""Motion blur against the average of still pictures at many times within the shutter's interval."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

pytest.importorskip("hdstream._core")

import hdstream
from stages import author, motion, shapes

WIDTH, HEIGHT, BLOCK = 48, 36, 6
STILLS, STILL_SAMPLES = 32, 16
SETTINGS = dict(imageWidth=WIDTH, imageHeight=HEIGHT, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=1,
                noCache=True)


def Color(renderer, time, **settings):
    """The picture of a renderer, or of a stage."""
    if not isinstance(renderer, hdstream.Renderer):
        renderer = hdstream.Renderer(renderer, onWarning=lambda line: None)
    return renderer.Render(time, **{**SETTINGS, **settings}).aovs["color"][..., :3].astype(np.float64)


def Blocks(picture):
    return picture.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3).mean((1, 3))


@pytest.mark.parametrize("name", motion.SCENES)
def test_blur_is_the_average_of_stills(name, tmp_path):
    """The stills are pictures of the stage at other times: the front end, the device's poses and its normals take no part."""
    stage = hdstream.Renderer(motion.Write(tmp_path / "a.usda", name), onWarning=lambda line: None)
    blurred = Color(stage, motion.FRAME, samples=STILLS * STILL_SAMPLES)
    middles = (np.arange(STILLS) + 0.5) / STILLS
    times = motion.FRAME + motion.SHUTTER[0] + middles * (motion.SHUTTER[1] - motion.SHUTTER[0])
    stills = [Color(stage, time, samples=STILL_SAMPLES, seed=i, motionBlur="off") for i, time in enumerate(times)]
    average = np.mean(stills, 0)
    still = Color(stage, motion.FRAME, samples=STILLS * STILL_SAMPLES, motionBlur="off")
    # A still stands for 1/32 of the time, in which an edge passes a part of a pixel.
    assert np.abs(Blocks(blurred) - Blocks(average)).max() < 0.012
    # How much of what the motion does to the picture is there: a shutter that is a fifth shorter shows 0.7 of it.
    effect = average - still
    assert np.sqrt((effect ** 2).mean()) > 0.01, "the test would show little"
    assert abs(((blurred - still) * effect).sum() / (effect ** 2).sum() - 1) < 0.1


def test_an_instance_that_slides_is_a_mesh_whose_points_do(tmp_path):
    """The map inwards, which its record has, against points in the world, path by path."""
    box = shapes.Box(1.4, 0.8, 0.3)
    ends = [Gf.Vec3d(-2.5, 0.5, 0.2), Gf.Vec3d(2.0, -0.4, 0.6)]
    pictures = []
    for movesPoints in (False, True):
        path = motion.Write(tmp_path / f"{movesPoints}.usda")
        stage = Usd.Stage.Open(path)
        mesh = author.AddMesh(stage, "/World/Box", box, color=(0.8, 0.5, 0.2), translate=(0, 0, 0), rotate=(20, 50, 10), scale=(1.5, 0.7, 1.0))
        mesh.GetNormalsAttr().Clear()
        atRest = UsdGeom.Xformable(mesh).GetLocalTransformation()
        if movesPoints:
            UsdGeom.Xformable(mesh).ClearXformOpOrder()
            placed = np.array([atRest.Transform(Gf.Vec3d(*map(float, point))) for point in box.points])
            motion.SetPoints(mesh, *(placed + np.array(end) for end in ends))
        else:
            way = UsdGeom.Xformable(mesh).MakeMatrixXform()
            for time, end in zip((0.0, 2.0), ends):
                way.Set(atRest * Gf.Matrix4d().SetTranslate(end), time)
        stage.GetRootLayer().Save()
        pictures.append(Color(path, motion.FRAME, samples=8))
    # A path may meet an edge on either side of it by rounding.
    assert (np.abs(pictures[0] - pictures[1]).max(-1) > 1e-3).mean() < 0.01
    assert np.abs(pictures[0] - Color(path, motion.FRAME, samples=8, motionBlur="off")).mean() > 0.01, "the test would show little"


def test_a_closed_shutter_and_no_blur_are_the_same_bits(tmp_path):
    closed = Color(motion.Write(tmp_path / "closed.usda", "way", "polygons", shutter=(0.0, 0.0)), motion.FRAME, samples=2)
    stage = motion.Write(tmp_path / "open.usda", "way", "polygons")
    off = Color(stage, motion.FRAME, samples=2, motionBlur="off")
    assert closed.tobytes() == off.tobytes()
    assert closed.tobytes() != Color(stage, motion.FRAME, samples=2).tobytes()


def test_what_rests_has_the_bits_it_has_without_shutter(tmp_path):
    opened = Color(motion.Write(tmp_path / "open.usda"), motion.FRAME, samples=2)
    closed = Color(motion.Write(tmp_path / "closed.usda", shutter=(0.0, 0.0)), motion.FRAME, samples=2)
    assert opened.tobytes() == closed.tobytes()


def test_first_hits_are_the_frames(tmp_path):
    """Depth and ids show the scene at the frame, blurred or not."""
    stage = motion.Write(tmp_path / "a.usda", "nested", "surface", "camera")
    depths = [hdstream.Render(stage, motion.FRAME, **SETTINGS, samples=1, motionBlur=blur, aovs=["cameraDepth"]).aovs["cameraDepth"]
              for blur in ("on", "off")]
    same = np.isclose(*depths, rtol=1e-3)
    assert same.mean() > 0.98  # silhouettes of poses that are interpolated


def test_what_emits_moves_as_what_does_not(tmp_path):
    """Meshes that emit, by their material or as mesh lights, cover what the same meshes cover without: to the bit."""
    pictures, lines = [], []
    for emits in (True, False):
        stage = author.NewStage(tmp_path / f"{emits}.usda")
        camera = author.AddCamera(stage, eye=(0, 0, 6), focalLength=40.0)
        camera.CreateShutterOpenAttr(motion.SHUTTER[0])
        camera.CreateShutterCloseAttr(motion.SHUTTER[1])
        author.AddLight(stage, "/World/Sun", "Distant", intensity=1.0)  # a stage without lights would have a dome
        glow = author.AddMaterial(stage, "/World/Glow", emissiveColor=(3.0, 1.0, 1.0)) if emits else None
        motion.AddWay(author.AddMesh(stage, "/World/Lamp", shapes.Box(0.5, 0.5, 0.5), material=glow), (-3, 0, 0), (3, 0, 0), degrees=90.0)
        bulb = author.AddMesh(stage, "/World/Bulb", shapes.Box(0.3, 0.3, 0.3))
        motion.AddWay(bulb, (-3, 1, 0), (3, 1, 0))
        points = bulb.GetPointsAttr()
        atRest = points.Get()
        for time, factor in ((motion.FRAME - 1, 1.0), (motion.FRAME + 1, 2.0)):
            points.Set([factor * point for point in atRest], time)
        if emits:
            UsdLux.MeshLightAPI.Apply(bulb.GetPrim())
        picture = hdstream.Renderer(stage, onWarning=lines.append).Render(motion.FRAME, **SETTINGS, samples=8).aovs["color"]
        pictures.append(picture[..., 3])
    assert not [line for line in lines if "blurred" in line]
    assert 0.0 < (pictures[0] % 1.0 > 0.0).mean(), "nothing is blurred"
    assert pictures[0].tobytes() == pictures[1].tobytes()


def _Lit(path, light, shutter=motion.SHUTTER):
    """A floor below what `light(stage)` adds."""
    stage = author.NewStage(path)
    light(stage)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(6, 6), color=(0.8, 0.7, 0.6), translate=(0, 0, 0))
    camera = author.AddCamera(stage, eye=(0, 3, 6), focalLength=40.0)
    camera.CreateShutterOpenAttr(shutter[0])
    camera.CreateShutterCloseAttr(shutter[1])
    stage.GetRootLayer().Save()
    return path


def _Scaled(stage, path, scales):
    scale = UsdGeom.Xform.Define(stage, path).AddScaleOp()
    for time, value in zip((motion.FRAME - 1, motion.FRAME + 1), scales):
        scale.Set(Gf.Vec3f(*value), time)


def test_lights_at_infinity_know_of_no_scale(tmp_path):
    """Suns and skies below scales and slides rest: the bits, and the kernels, of a closed shutter."""
    def Add(stage):
        _Scaled(stage, "/World/Sizes", [(0.5,) * 3, (2.0,) * 3])
        _Scaled(stage, "/World/Sizes/Tall", [(1.0, 1.0, 1.0), (1.0, 3.0, 1.0)])
        author.AddLight(stage, "/World/Sizes/Sky", "Dome", dict(rotate=(20, 30, 0)), intensity=0.3)
        sun = author.AddLight(stage, "/World/Sizes/Tall/Sun", "Distant", intensity=2.0)  # along z
        UsdGeom.Xformable(sun).AddRotateXOp().Set(-90.0)  # down, along the scale
        slide = UsdGeom.Xform.Define(stage, "/World/Slides").AddTranslateOp()
        slide.Set(Gf.Vec3d(-1, 0, 0), motion.FRAME - 1)
        slide.Set(Gf.Vec3d(1, 2, 0), motion.FRAME + 1)
        author.AddLight(stage, "/World/Slides/Sun", "Distant", dict(rotate=(-60, 20, 0)), intensity=1.0, angle=5.0)

    opened, closed = (hdstream.Render(_Lit(tmp_path / f"{i}.usda", Add, shutter), motion.FRAME, **SETTINGS, samples=4)
                      for i, shutter in enumerate((motion.SHUTTER, (0.0, 0.0))))
    assert opened.statistics["accuracy"]["lightParts"] == 0
    assert opened.aovs["color"].tobytes() == closed.aovs["color"].tobytes()


def test_many_lights_that_change_have_fewer_parts_each(tmp_path):
    """At most 2^17 together; a line and the statistics tell. The mean over the shutter stays that of each light."""
    def Add(count):
        def Author(stage):
            instancer = UsdGeom.PointInstancer.Define(stage, "/World/Lamps")
            instancer.CreatePositionsAttr([(0.1 * (i % 40) - 2.0, 3.0, 0.1 * (i // 40) - 1.5) for i in range(count)])
            instancer.CreateProtoIndicesAttr([0] * count)
            lamp = author.AddLight(stage, "/World/Lamps/Lamp", "Sphere", radius=0.02, normalize=True)
            for time, intensity in ((motion.FRAME - 1, 0.0), (motion.FRAME + 1, 80.0 / count)):
                lamp.GetIntensityAttr().Set(intensity, time)
            instancer.CreatePrototypesRel().SetTargets(["/World/Lamps/Lamp"])

        return Author

    images, lines = [], []
    for count in (1000, 1100):
        lines.append([])
        renderer = hdstream.Renderer(_Lit(tmp_path / f"{count}.usda", Add(count)), onWarning=lines[-1].append)
        images.append(renderer.Render(motion.FRAME, **SETTINGS, samples=64))
    assert [image.statistics["accuracy"]["lightParts"] for image in images] == [128 * 1000, 64 * 1100]
    said = ["have 64 parts of it at most" in line for line in lines[1]]
    assert sum(said) == 1 and not any("parts of it" in line for line in lines[0])
    means = [image.aovs["color"][..., :3].mean() for image in images]
    assert means[0] == pytest.approx(means[1], rel=0.02)
