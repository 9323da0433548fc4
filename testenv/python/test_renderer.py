# SPDX-License-Identifier: Apache-2.0
"""The package as docs/python.md shows it: arrays, edits, progress, cancelling, errors, going on."""

import threading

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt

from cliCase import SCENE, Run, WriteStage

SMALL = {"imageWidth": 24, "samples": 20, "maxDepth": 2}


@pytest.fixture(name="stage")
def MakeStage(tmp_path):
    return Usd.Stage.Open(str(WriteStage(tmp_path)))


def Same(a, b):
    return a.aovs.keys() == b.aovs.keys() and all(np.array_equal(a.aovs[name], b.aovs[name]) for name in a.aovs)


def test_arrays_are_the_pixels_of_the_command_line(tmp_path):
    import hdstream
    from stages.imageFile import ReadExr
    path = WriteStage(tmp_path)
    image = hdstream.Render(str(path), aovs=["color", "depth", "primId"], **SMALL)
    assert {name: (array.shape, array.dtype.name) for name, array in image.aovs.items()} == {
        "color": ((17, 24, 4), "float32"), "depth": ((17, 24, 1), "float32"), "primId": ((17, 24), "int32")}
    assert image.channels["color"] == ["R", "G", "B", "A"]
    assert (image.width, image.height, image.samples, image.isComplete) == (24, 17, 20, True)
    assert image.statistics["rays"]["camera"] == 24 * 17 * 20
    assert Run("record", path, tmp_path / "o.exr", "-w", 24, "--samples", 20, "--maxDepth", 2,
               "--aovs", "color,depth,primId").code == 0
    assert image.Write(tmp_path / "api.exr") == []
    assert (tmp_path / "api.exr").read_bytes() == (tmp_path / "o.exr").read_bytes()
    channels = ReadExr(tmp_path / "o.exr")
    assert channels is not None
    assert image._repr_png_()[:4] == b"\x89PNG"


def test_edits_are_in_the_next_picture_and_geometry_is_not_prepared_again(stage):
    import hdstream
    renderer = hdstream.Renderer(stage)
    first = renderer.Render(**SMALL)
    stage.GetAttributeAtPath("/Sun.inputs:intensity").Set(2.0)
    stage.GetAttributeAtPath("/main_cam.xformOp:translate").Set(Gf.Vec3d(0.5, 0, 8))
    second = renderer.Render(**SMALL)
    assert not Same(first, second)
    assert Same(second, hdstream.Renderer(stage).Render(**SMALL)), "the bits of a fresh renderer"
    geometry = second.statistics["geometry"]
    assert geometry["chunksBuilt"] + geometry["chunksFromCache"] == 0
    array = first.aovs["color"]
    del renderer, first
    assert np.isfinite(array).all() and not array.flags.writeable


def test_a_crop_has_the_bits_of_the_image(stage):
    import hdstream
    renderer = hdstream.Renderer(stage)
    values = {**SMALL, "aovs": ["color", "depth", "primId", "instanceId"]}
    whole = renderer.Render(**values)
    part = renderer.Render(crop=(5, 3, 20, 11), **values)
    for name, pixels in part.aovs.items():
        np.testing.assert_array_equal(pixels, whole.aovs[name][3:11, 5:20])
    with pytest.raises(hdstream.UsageError, match="crop"):
        renderer.Render(crop=(5, 3, 25, 11), **values)


def test_progress_and_cancelling(stage):
    import hdstream
    renderer = hdstream.Renderer(stage)
    fractions = []
    image = renderer.Render(onProgress=lambda progress: fractions.append(progress.fraction), **SMALL)
    assert image.isComplete and fractions == sorted(fractions) and fractions[-1] == pytest.approx(1.0)
    endless = {**SMALL, "samples": 1 << 20}
    image = renderer.Render(onProgress=lambda progress: progress.samplesDone < 2, **endless)
    assert not image.isComplete and image.samples >= 1 and np.isfinite(image.aovs["color"]).all()
    begun = threading.Event()
    threading.Thread(target=lambda: (begun.wait(60), renderer.Cancel())).start()
    image = renderer.Render(onProgress=lambda progress: begun.set(), **endless)
    assert not image.isComplete
    assert renderer.Render(**SMALL).isComplete, "it may go on"


@pytest.mark.parametrize("prepare", ["lazy", "eager"])
def test_progress_says_how_much_is_prepared(tmp_path, prepare):
    """Prims that are planned, then, where all pages are made first, chunks whose pages are there."""
    import hdstream
    from pxr import Usd, UsdGeom
    numPrims = 3000
    stage = Usd.Stage.CreateInMemory()
    for i in range(numPrims):
        mesh = UsdGeom.Mesh.Define(stage, f"/mesh{i}")
        mesh.CreatePointsAttr([(i, 0, 0), (i + 0.5, 0, 0), (i, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    prims, chunks = [], []

    def OnProgress(progress):
        if progress.fraction == 0:
            prims.append((progress.prims.done, progress.prims.total))
            chunks.append((progress.chunks.done, progress.chunks.total))
        else:
            assert progress.prims.total == progress.chunks.total == 0

    hdstream.Renderer(stage).Render(onProgress=OnProgress,
                                  **{**SMALL, "prepare": prepare, "residency": "stream", "noCache": True})
    assert prims == sorted(prims) and {total for _, total in prims} == {numPrims}
    assert len({done for done, _ in prims}) > 2 and prims[-1][0] == numPrims, "some are done, then all"
    assert {total for _, total in chunks} == ({0} if prepare == "lazy" else {0, numPrims})
    assert all(done <= total for done, total in chunks)


def test_exceptions_of_the_callback_come_through(stage):
    import hdstream

    def OnProgress(progress):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        hdstream.Renderer(stage).Render(onProgress=OnProgress, **SMALL)


def test_a_cancelled_picture_goes_on_to_the_bits_of_one(stage):
    import hdstream
    renderer = hdstream.Renderer(stage)
    whole = renderer.Render(**{**SMALL, "samples": 40})
    renderer.Render(onProgress=lambda progress: progress.samplesDone < 3, **{**SMALL, "samples": 1 << 20})
    sums = renderer.Sums()
    assert 0 < sums.endSample < 40 and sums.words.shape == (17, 24, 12)
    other = hdstream.Renderer(stage)
    other.Prepare(**{**SMALL, "samples": 40})
    assert Same(other.RenderPrepared(start=[sums]), whole)


def test_sums_pack_and_unpack(stage, tmp_path):
    import hdstream
    from hdstream import filmSums
    renderer = hdstream.Renderer(stage)
    renderer.Render(**{**SMALL, "samples": 16})
    sums = renderer.Sums()
    packed = filmSums.Pack(sums)
    assert sum(plane.size for name, plane in packed.items() if name != "shape") < 7 * 24 * 17, "zeros do not travel"
    filmSums.Save(str(tmp_path / "a.sums"), sums, "key", "device")
    for again in (filmSums.Unpack(packed), filmSums.Load(str(tmp_path / "a.sums"), "key")[0]):
        assert (again.width, again.height, again.firstSample, again.endSample) == (24, 17, 0, 16)
        np.testing.assert_array_equal(again.words, sums.words)
    assert filmSums.Load(str(tmp_path / "a.sums"), "other") == (None, "")
    (tmp_path / "a.sums").write_bytes((tmp_path / "a.sums").read_bytes()[:100])
    assert filmSums.Load(str(tmp_path / "a.sums"), "key") == (None, "")


def test_errors_are_the_packages(stage, tmp_path):
    import hdstream
    renderer = hdstream.Renderer(stage)
    with pytest.raises(TypeError, match="no setting 'sample'"):
        renderer.Render(sample=3)
    with pytest.raises(hdstream.UsageError, match="--camera none"):
        renderer.Render(camera="none")
    with pytest.raises(hdstream.UsageError, match="samples"):
        renderer.Render(samples=0)
    with pytest.raises(hdstream.UsageError, match="prepared"):
        hdstream.Renderer(stage).RenderPrepared()
    with pytest.raises(hdstream.Error, match="missing.usda"):
        hdstream.Renderer(tmp_path / "missing.usda")
    assert issubclass(hdstream.UsageError, hdstream.Error)
    with pytest.raises(AttributeError):
        hdstream.Nothing  # pylint: disable=pointless-statement
    assert set(hdstream.__all__) <= set(dir(hdstream))


@pytest.mark.parametrize("values, text", [
    (dict(purposes="render"), "purposes"),
    (dict(purposes=["renders"]), "'renders' is none of default"),
    (dict(purposes=Vt.TokenArray(["renders"])), "'renders' is none of default"),
    (dict(purposes=5), "--purposes: must be a list of names"),
    (dict(purposes={"render"}), "purposes: {'render'} is of no use"),
    (dict(samples=[2]), r"samples: \[2\] is of no use"),
    (dict(imageWidth="wide"), "must be a whole number"),
    (dict(imageHeight=Gf.Vec2i(2)), "imageHeight: .* is of no use"),
    (dict(crop=(0, 0, 10)), r"crop \(0, 0, 10\)"),
    (dict(crop=(0.5, 0, 10, 10)), "four whole numbers"),
    (dict(camera=Gf.Vec3f(1)), "no such camera"),
])
def test_values_of_other_types_are_wrong_usage(stage, values, text):
    import hdstream
    with pytest.raises(hdstream.UsageError, match=text):
        hdstream.Renderer(stage).Render(**{**SMALL, **values})


def test_masks_and_cameras_as_they_are_meant(stage):
    import hdstream
    with pytest.raises(hdstream.UsageError, match="list of prim paths"):
        hdstream.Renderer(stage.GetRootLayer().realPath, mask="/Triangle")
    with pytest.raises(hdstream.UsageError, match="SetPopulationMask"):
        hdstream.Renderer(stage, mask=["/Triangle"])
    renderer = hdstream.Renderer(stage)
    wide = renderer.Render(camera=stage.GetPrimAtPath("/Wide").GetPath(), **SMALL)
    assert Same(wide, renderer.Render(camera="/Wide", **SMALL)) and wide.height == 6


def test_a_renderer_that_renders_takes_nothing_else_on(stage):
    """Neither of another thread nor of its own callback; the render in progress has its bits, and may still be cancelled."""
    import hdstream
    renderer = hdstream.Renderer(stage)
    expected = renderer.Render(**SMALL)
    errors = []

    def Try(*calls):
        for call in calls:
            try:
                call()
            except hdstream.Error as error:
                errors.append(str(error))

    def Further():
        Try(lambda: renderer.Render(**SMALL), lambda: renderer.Prepare(imageWidth=8), renderer.RenderPrepared, renderer.ReleaseStage)

    def OnProgress(progress):
        if not errors:
            Further()
            other = threading.Thread(target=Further)
            other.start()
            other.join()

    image = renderer.Render(onProgress=OnProgress, **SMALL)
    assert len(errors) == 8 and all("busy" in error for error in errors), errors
    assert image.isComplete and Same(image, expected)
    assert Same(renderer.Render(**SMALL), expected)


def Elsewhere(function):
    """What it raised, or None, on another thread."""
    errors = []

    def Work():
        try:
            function()
        except Exception as error:  # pylint: disable=broad-except
            errors.append(error)

    thread = threading.Thread(target=Work)
    thread.start()
    thread.join()
    return errors[0] if errors else None


@pytest.mark.parametrize("call", ["Layers", "Statistics", "Deep", "Film"])
def test_a_renderer_is_busy_until_its_result_is_read(stage, call):
    """Reading it takes time, on first hits for one, in which other threads run."""
    import hdstream
    from hdstream import _core
    errors = []

    class Session(_core.Session):
        """Between its calls another thread asks for something else."""

    def Read(self, *arguments):
        errors.append(Elsewhere(lambda: renderer.Prepare(imageWidth=8)))
        return getattr(_core.Session, call)(self, *arguments)

    setattr(Session, call, Read)
    expected = hdstream.Renderer(stage).Render(deep=True, **SMALL)
    renderer = hdstream.Renderer(stage, _session=Session())
    renderer.Prepare(deep=True, **SMALL)
    if call == "Film":
        assert renderer.RenderSums().words.shape[:2] == (expected.height, expected.width)
    else:
        image = renderer.RenderPrepared()
        assert Same(image, expected) and np.array_equal(image.deep.samples, expected.deep.samples)
    assert errors and all(isinstance(error, hdstream.UsageError) and "busy" in str(error) for error in errors), errors


def test_nobody_prepares_between_the_halves_of_a_render(stage):
    """Each time that the renderer is free another thread prepares a frame at once."""
    import hdstream
    renderer = hdstream.Renderer(stage)
    expected = renderer.Render(**SMALL)
    errors = []

    class Lock:
        def __init__(self, lock):
            self.acquire, self._lock = lock.acquire, lock

        def release(self):
            self._lock.release()
            if not errors:
                errors.append("being prepared")
                errors[0] = Elsewhere(lambda: renderer.Prepare(imageWidth=8))

    renderer._isBusy = Lock(renderer._isBusy)
    assert Same(renderer.Render(**SMALL), expected)
    assert errors == [None] and renderer.settings["imageWidth"] == 8


def test_a_renderer_leaves_no_stage_behind(tmp_path):
    """Its layers would be found again, stale, when the file is opened once more."""
    import hdstream
    from pxr import Sdf
    path = str(WriteStage(tmp_path))
    hdstream.Render(path, **SMALL)
    assert Sdf.Layer.Find(path) is None


def test_warnings(tmp_path):
    import hdstream
    body = SCENE + 'def Volume "Smoke" {}'
    lines = []
    hdstream.Renderer(str(WriteStage(tmp_path, body)), onWarning=lines.append).Render(**SMALL)
    assert len(lines) == 1 and "/Smoke" in lines[0]
    with pytest.warns(hdstream.RenderWarning, match="/Smoke"):
        hdstream.Render(str(WriteStage(tmp_path, body)), **SMALL)


def test_materialX_files_of_a_stage_that_the_caller_opened_are_named_once(tmp_path):
    """Reading them would edit the caller's layers."""
    import hdstream
    path = WriteStage(tmp_path, SCENE + 'def "Looks" (references = @looks.mtlx@</MaterialX/Materials>) {}')
    stage = Usd.Stage.Open(str(path))
    before = stage.GetRootLayer().ExportToString()
    lines = []
    renderer = hdstream.Renderer(stage, onWarning=lines.append)
    renderer.Render(**SMALL)
    renderer.Render(**SMALL)
    assert len([line for line in lines if line.startswith("looks.mtlx: is not read in a stage that the caller opened")]) == 1, lines
    assert stage.GetRootLayer().ExportToString() == before


def test_keywords_win_over_the_render_settings_prim(tmp_path):
    import hdstream
    body = SCENE + """def RenderSettings "Render" { int2 resolution = (32, 16); int hdstream:samples = 3
        custom token[] includedPurposes = ["default", "guide"] }"""
    renderer = hdstream.Renderer(str(WriteStage(tmp_path, body)))
    renderer.Prepare(renderSettingsPrimPath="/Render")
    assert (renderer.settings["samples"], renderer.settings["imageWidth"]) == (3, 32)
    renderer.Prepare(renderSettingsPrimPath="/Render", samples=5, purposes=["render"])
    assert (renderer.settings["samples"], renderer.settings["purposes"]) == (5, ["default", "render"])


@pytest.mark.parametrize("authored, purposes, warning", [
    ('token[] includedPurposes = ["renders", "proxy"]', ["default", "proxy"],
     "includedPurposes: 'renders' is none of default, render, proxy, guide; ignored"),
    ("int includedPurposes = 5", ["default", "render"], "includedPurposes 5 is no list of names; ignored"),
    ('token includedPurposes = "proxy"', ["default", "render"], "includedPurposes 'proxy' is no list of names; ignored"),
    ('string[] includedPurposes = ["proxy"]', ["default", "proxy"], None),
])
def test_purposes_of_the_render_settings_prim_are_checked(tmp_path, authored, purposes, warning):
    import hdstream
    lines = []
    stage = str(WriteStage(tmp_path, SCENE + f'def RenderSettings "Render" {{ {authored} }}'))
    renderer = hdstream.Renderer(stage, onWarning=lines.append)
    renderer.Prepare(renderSettingsPrimPath="/Render")
    assert renderer.settings["purposes"] == purposes
    assert lines == ([f"/Render: {warning}"] if warning else [])


@pytest.mark.parametrize("extension", ["usdc", "usda"])
def test_a_stage_may_be_saved_between_renders(extension, tmp_path):
    """OpenUSD writes into crate files, whose large arrays are read again where the camera comes near: nothing was rendered."""
    import hdstream
    path = tmp_path / f"scene.{extension}"
    stage = Usd.Stage.Open(str(WriteStage(tmp_path, SCENE)))
    side = 120
    rows, columns = np.mgrid[:side, :side].astype(np.float32)
    points = np.stack([columns / side - 0.5, rows / side - 0.5, np.sin(rows * columns) / 30], 2).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(corner), 4, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(
        np.stack([corner, corner + 1, corner + side + 1, corner + side], 1).astype(np.int32).ravel()))
    stage.Export(str(path))
    del stage, mesh
    small = {**SMALL, "samples": 1}
    renderer = hdstream.Renderer(str(path))
    first = renderer.Render(**small)
    renderer.stage.GetAttributeAtPath("/main_cam.xformOp:translate").Set(Gf.Vec3d(0, 0, 4))
    renderer.Render(**small)
    for z in (2, 1.5):
        renderer.stage.GetAttributeAtPath("/main_cam.xformOp:translate").Set(Gf.Vec3d(0, 0, z))
        renderer.stage.Save()
        saved = renderer.Render(**small)
        assert not Same(first, saved) and Same(saved, hdstream.Renderer(str(path)).Render(**small))
    assert Same(saved, renderer.Render(**small))
