# SPDX-License-Identifier: Apache-2.0
"""A stage that is let go once its last frame is prepared: the bits of one that stays, and files of which nothing is read close.

The oracle is the picture of a renderer that keeps its stage. Little host memory makes each page of arrays that are read again,
from what is left of the stage.
"""

import gc
import subprocess
import sys
import threading

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Gf, Sdf, Usd, UsdGeom, Vt

import hdstream
from hdstream import _core, preparedStage
from hdstream.translate import rereading
from stages import author, island, shapes, streaming

_SMALLEST = 4096  # bytes of arrays that are read again
_OPTIONS = dict(camera="/World/Camera", imageWidth=48, imageHeight=32, samples=2, residency="stream", geometryMemory="300K",
                chunkBytes=1 << 15, noCache=True, hostMemory=1 << 14, waveSize=1 << 10,
                aovs=["color", "depth", "primId", "instanceId"])
_OF_ISLAND = dict(_OPTIONS, geometryMemory="40M", hostMemory=1 << 24, instanceChunks=256, waveSize=0, imageWidth=24, imageHeight=16,
                  samples=1)


@pytest.fixture(autouse=True)
def smallIsLarge(monkeypatch):
    monkeypatch.setattr(rereading, "SMALLEST", _SMALLEST)
    monkeypatch.setattr(preparedStage, "LARGE_STAGE", 1)


def _WriteNative(path):
    """Native instances of a file with a large mesh, some of them inside of others' prototype."""
    folder = path.parent
    part = Usd.Stage.CreateNew(str(folder / "part.usdc"))
    part.SetDefaultPrim(UsdGeom.Xform.Define(part, "/Part").GetPrim())
    author.AddMesh(part, "/Part/Mesh", shapes.Sphere(0.5, 24, 24), color=(0.7, 0.4, 0.2))
    part.GetRootLayer().Save()
    pair = Usd.Stage.CreateNew(str(folder / "pair.usdc"))
    pair.SetDefaultPrim(UsdGeom.Xform.Define(pair, "/Pair").GetPrim())
    author.AddMesh(pair, "/Pair/Own", shapes.Sphere(0.3, 20, 20), color=(0.2, 0.4, 0.7))
    for name, x in (("Left", -0.6), ("Right", 0.6)):
        inner = UsdGeom.Xform.Define(pair, f"/Pair/{name}")
        inner.AddTranslateOp().Set((x, 0.5, 0))
        inner.GetPrim().GetReferences().AddReference("./part.usdc")
        inner.GetPrim().SetInstanceable(True)
    pair.GetRootLayer().Save()
    stage = author.NewStage(str(path))
    for i in range(4):
        outer = UsdGeom.Xform.Define(stage, f"/World/Pair{i}")
        outer.AddTranslateOp().Set((2 * i - 3, 0, 0))
        outer.GetPrim().GetReferences().AddReference("./pair.usdc")
        outer.GetPrim().SetInstanceable(True)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, "/World/Camera", eye=(0, 2, 9), target=(0, 0, 0))
    stage.GetRootLayer().Save()


def _WriteCurves(path):
    """Curves with widths by vertex and a mesh with indexed colours."""
    stage = author.NewStage(str(path))
    rng = np.random.default_rng(7)
    roots = rng.uniform(-2, 2, (600, 1, 3)) * [1, 0, 1]
    points = roots + np.linspace(0, 1, 4)[None, :, None] * rng.normal([0, 1, 0], 0.2, (600, 1, 3))
    grass = UsdGeom.BasisCurves.Define(stage, "/World/Grass")
    grass.CreateTypeAttr("cubic")
    grass.CreateBasisAttr("bspline")
    grass.CreateWrapAttr("pinned")
    grass.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(600, 4, np.int32)))
    grass.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.reshape(-1, 3).astype(np.float32)))
    grass.CreateWidthsAttr(Vt.FloatArray.FromNumpy(rng.uniform(0.01, 0.03, 2400).astype(np.float32)))
    grass.SetWidthsInterpolation("vertex")
    ball = shapes.Sphere(0.6, 40, 40)
    author.AddMesh(stage, "/World/Ball", ball)
    colors = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Ball")).CreatePrimvar(
        "displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform")
    colors.Set([Gf.Vec3f(*rng.uniform(0.1, 0.9, 3)) for _ in range(2000)])
    colors.SetIndices(Vt.IntArray.FromNumpy(rng.integers(0, 2000, len(ball.counts)).astype(np.int32)))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, "/World/Camera", eye=(0, 2, 6), target=(0, 0.3, 0))
    stage.GetRootLayer().Save()


def _WriteIslands(path):
    """Islands by one more level of instancing: an instancer of few instances has all the rest below it."""
    one = path.with_name("one.usdc")
    island.WriteIsland(one, 0.0003)
    island.WriteArchipelago(path, one, 4, 0.0003)


def _WriteInherited(path):
    """An ancestor of everything has a constant primvar with many indices."""
    stage = author.NewStage(str(path))
    palette = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World")).CreatePrimvar(
        "palette", Sdf.ValueTypeNames.Color3fArray, "constant")
    palette.Set([(0.7, 0.4, 0.2), (0.2, 0.4, 0.7)])
    palette.SetIndices(Vt.IntArray.FromNumpy(np.arange(2000, dtype=np.int32) % 2))
    author.AddMesh(stage, "/World/Large", shapes.Sphere(1.0, 40, 40))
    for i in range(20):
        author.AddMesh(stage, f"/World/Small{i}", shapes.Sphere(0.2, 6, 6), translate=(0.4 * i - 4, 1.3, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, "/World/Camera", eye=(0, 2, 6), target=(0, 0.3, 0))
    stage.GetRootLayer().Save()


_WRITERS = {
    "overlap": lambda path: streaming.WriteOverlap(str(path), meshes=6, rings=20),
    "island": lambda path: island.WriteIsland(path, 0.0003),
    "islands": _WriteIslands,
    "inherited": _WriteInherited,
    "native instances": _WriteNative,
    "curves": _WriteCurves,
}


@pytest.mark.parametrize("name", list(_WRITERS))
def test_the_bits_are_those_of_a_stage_that_stays(name, tmp_path):
    path = tmp_path / "stage.usdc"
    _WRITERS[name](path)
    options = _OF_ISLAND if name.startswith("island") else _OPTIONS
    kept = hdstream.Renderer(path).Render(**options)
    renderer = hdstream.Renderer(path)
    renderer.Prepare(**options)
    renderer.ReleaseStage()
    renderer.ReleaseStage()  # once more does nothing
    image = renderer.RenderPrepared()
    assert image.statistics["memory"]["arraysReadAgain"] > 0
    for aov, pixels in kept.aovs.items():
        assert image.aovs[aov].tobytes() == pixels.tobytes(), aov
    assert renderer.warnings == []


def _OpenFiles(folder):
    """Names of the stage's files that OpenUSD has open."""
    gc.collect()
    files = (layer.realPath for layer in Sdf.Layer.GetLoadedLayers())
    return {file.rpartition("/")[2] for file in files if file.startswith(str(folder))}


@pytest.mark.parametrize("name", ["island", "islands"])
def test_files_of_which_nothing_is_read_again_are_closed(name, tmp_path):
    path = tmp_path / "stage.usdc"
    _WRITERS[name](path)
    renderer = hdstream.Renderer(path)
    renderer.Prepare(**_OF_ISLAND)
    every = _OpenFiles(tmp_path)
    assert {"stage.usdc", "Pebbles0.usdc", "Ground0.usdc", "Trees0.usdc"} <= every
    numPrims = len(list(renderer.stage.Traverse()))
    renderer.ReleaseStage()
    left = _OpenFiles(tmp_path)
    assert "Pebbles0.usdc" in every - left, "small meshes are of no use any more"
    assert {"stage.usdc", "Ground0.usdc", "Trees0.usdc", "Scattered0.usdc"} <= left
    assert 0 < len(list(renderer.stage.Traverse())) < numPrims
    renderer.RenderPrepared()
    del renderer
    assert _OpenFiles(tmp_path) == set()


def test_arrays_of_instancers_stay_mapped(tmp_path):
    """OpenUSD makes copies of mapped arrays when it closes their file: that one stays open."""
    count = 2_000_000
    part = Usd.Stage.CreateNew(str(tmp_path / "part.usdc"))
    part.SetDefaultPrim(UsdGeom.Scope.Define(part, "/Part").GetPrim())
    instancer = UsdGeom.PointInstancer.Define(part, "/Part/Things")
    author.AddMesh(part, "/Part/Things/Thing", shapes.Sphere(0.1, 4, 6))
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path("/Part/Things/Thing")])
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.zeros(count, np.int32)))
    places = np.random.default_rng(3).uniform(-50, 50, (count, 3)).astype(np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(places))
    part.GetRootLayer().Save()
    path = tmp_path / "stage.usda"
    stage = author.NewStage(str(path))
    stage.DefinePrim("/World/Part").GetReferences().AddReference("./part.usdc")
    author.AddMesh(stage, "/World/Large", shapes.Sphere(1.0, 40, 40))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, "/World/Camera", eye=(0, 2, 90), target=(0, 0, 0))
    stage.GetRootLayer().Save()
    del part, instancer, stage
    gc.collect()
    assert _OpenFiles(tmp_path) == set()
    others = _core.ArrayCounts()["bytes"]
    renderer = hdstream.Renderer(path)
    renderer.Prepare(**_OPTIONS)
    before = _AnonymousBytes()
    renderer.ReleaseStage()
    assert _AnonymousBytes() < before + places.nbytes // 4
    assert [prim.GetName() for prim in renderer.stage.Traverse()] == ["World", "Large"], "of the instancer a file is enough"
    left = []

    class Layer:
        def __del__(self):
            left.append(_core.ArrayCounts()["bytes"])

    renderer._prepared._mappedLayers.append(Layer())
    assert _core.ArrayCounts()["bytes"] > others
    del renderer
    assert left == [others], "when layers close, the scene and its arrays are gone"
    assert _OpenFiles(tmp_path) == set()


def test_an_ancestor_of_which_a_primvar_is_large_keeps_no_prims(tmp_path):
    path = tmp_path / "stage.usdc"
    _WriteInherited(path)
    renderer = hdstream.Renderer(path)
    renderer.Prepare(**_OPTIONS)
    renderer.ReleaseStage()
    assert [prim.GetName() for prim in renderer.stage.Traverse()] == ["World", "Large"]


def _WriteLayered(path):
    """A ball that grows, whose points a stronger layer has otherwise, and which has another one below it in a payload."""
    ball = shapes.Sphere(1.0, 40, 40)
    payload = Usd.Stage.CreateNew(str(path.with_name("payload.usda")))
    payload.SetDefaultPrim(author.AddMesh(payload, "/More", shapes.Sphere(0.5, 40, 40), translate=(2, 0, 0)).GetPrim())
    payload.GetRootLayer().Save()
    layers = []
    for name, size in (("base", 0.6), ("over", 0.4)):
        stage = author.NewStage(str(path.with_name(f"{name}.usda")))
        mesh = author.AddMesh(stage, "/World/Ball", ball)
        for time in (1, 2):
            mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.float32(size * time) * ball.points.astype(np.float32)), time)
        if name == "base":
            stage.DefinePrim("/World/Ball/More").GetPayloads().AddPayload("./payload.usda")
            author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
            author.AddCamera(stage, "/World/Camera", eye=(0, 2, 6), target=(0, 0.3, 0))
        stage.GetRootLayer().Save()
    root = Sdf.Layer.CreateNew(str(path))
    root.subLayerPaths = ["./over.usda", "./base.usda"]
    root.Save()


_CHANGES = {
    "muted": lambda stage, folder: stage.MuteLayer(str(folder / "over.usda")),
    "unloaded": lambda stage, folder: stage.Unload("/World/Ball/More"),
    "held": lambda stage, folder: stage.SetInterpolationType(Usd.InterpolationTypeHeld),
}


@pytest.mark.parametrize("name", list(_CHANGES))
def test_what_was_said_of_the_stage_holds_for_what_is_left(name, tmp_path):
    """Muted layers, payloads that are not loaded, samples that are held."""
    path = tmp_path / "stage.usda"
    _WriteLayered(path)
    whole = hdstream.Renderer(path).Render(1.5, **_OPTIONS)

    def Changed():
        renderer = hdstream.Renderer(path)
        _CHANGES[name](renderer.stage, tmp_path)
        renderer.Prepare(1.5, **_OPTIONS)
        return renderer

    expected = Changed().RenderPrepared()
    assert expected.aovs["color"].tobytes() != whole.aovs["color"].tobytes()
    renderer = Changed()
    renderer.ReleaseStage()
    image = renderer.RenderPrepared()
    assert name == "unloaded" or image.statistics["memory"]["arraysReadAgain"] > 0
    for aov, pixels in expected.aovs.items():
        assert image.aovs[aov].tobytes() == pixels.tobytes(), aov
    assert ("payload.usda" in _OpenFiles(tmp_path)) == (name != "unloaded")


def _AnonymousBytes():
    """Memory of this process without pages of files."""
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("RssAnon:"))


def test_a_stage_without_large_arrays(tmp_path):
    path = tmp_path / "stage.usda"
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 8, 8))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddCamera(stage, "/World/Camera", eye=(0, 2, 6), target=(0, 0, 0))
    stage.GetRootLayer().Save()
    del stage
    renderer = hdstream.Renderer(path)
    renderer.Prepare(**_OPTIONS)
    renderer.ReleaseStage()
    assert not list(renderer.stage.Traverse())
    assert renderer.RenderPrepared().aovs["color"].any()


def test_the_function_for_one_picture_lets_its_own_stage_go(tmp_path):
    path = tmp_path / "stage.usdc"
    island.WriteIsland(path, 0.0003)
    seen = []
    image = hdstream.Render(path, onProgress=lambda progress: seen.append(_OpenFiles(tmp_path)), **_OF_ISLAND)
    assert seen and all("Ground0.usdc" in files and "Pebbles0.usdc" not in files for files in seen)
    stage = Usd.Stage.Open(str(path))
    ofCaller = hdstream.Render(stage, **_OF_ISLAND)
    assert "Pebbles0.usdc" in _OpenFiles(tmp_path), "of a caller's stage nothing is closed"
    assert image.aovs["color"].tobytes() == ofCaller.aovs["color"].tobytes()


@pytest.mark.parametrize("large", [1, 1 << 30])
def test_nothing_else_can_be_prepared(monkeypatch, tmp_path, large):
    monkeypatch.setattr(preparedStage, "LARGE_STAGE", large)
    path = tmp_path / "stage.usda"
    streaming.WriteOverlap(str(path), meshes=2, rings=8)
    renderer = hdstream.Renderer(path)
    with pytest.raises(hdstream.UsageError, match="nothing is prepared"):
        renderer.ReleaseStage()
    renderer.Prepare(**_OPTIONS)
    renderer.ReleaseStage()
    assert bool(renderer.stage.GetPrimAtPath("/World/Dome")) == (large > 1), "a small stage stays"
    with pytest.raises(hdstream.UsageError, match="^the stage has been released: nothing else can be prepared of it$"):
        renderer.Prepare(**_OPTIONS)
    other = hdstream.Renderer(Usd.Stage.Open(str(path)))
    other.Prepare(**_OPTIONS)
    with pytest.raises(hdstream.UsageError, match="^ReleaseStage: the stage was opened by the caller, who may let it go$"):
        other.ReleaseStage()
    assert other.RenderPrepared().isComplete


def test_the_command_lets_it_go_with_the_last_frame(tmp_path):
    """Two frames of one stage, of which the second is prepared from all of it."""
    path = tmp_path / "stage.usda"
    streaming.WriteOverlap(str(path), meshes=4, rings=20)
    stage = Usd.Stage.Open(str(path))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Ball1")).GetPointsAttr()
    still = points.Get()
    for time in (1, 2):
        points.Set([(0.8 + 0.2 * time) * point for point in still], time)
    stage.GetRootLayer().Save()
    script = f"""
import sys
import threading
from hdstream import cli, preparedStage
from hdstream.renderer import Renderer

preparedStage.LARGE_STAGE = 1
release = Renderer.ReleaseStage

def Said(self):
    release(self)
    print("released", flush=True)

Renderer.ReleaseStage = Said
sys.exit(cli.Main(sys.argv[1:]))
"""
    command = [sys.executable, "-c", script, "record", str(path), str(tmp_path / "out.##.exr"), "--frames", "1:2",
               "--imageWidth", "48", "--samples", "2", "--camera", "/World/Camera", "--noCache"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = [line for line in done.stdout.splitlines() if line == "released" or "samples" in line]
    assert len(lines) == 3 and lines[1] == "released", lines  # after the first picture is written
    for time in (1, 2):
        image = hdstream.Renderer(path).Render(time, camera="/World/Camera", imageWidth=48, samples=2, noCache=True)
        image.Write(tmp_path / "python.exr")
        compared = _core.CompareImages(str(tmp_path / "python.exr"), str(tmp_path / f"out.0{time}.exr"))
        assert not compared.error and all(layer.numDifferingPixels == 0 for layer in compared.layers)


def test_other_threads_may_translate_meanwhile(tmp_path):
    """Readers of other stages come while those of the stage are looked for."""
    stage = author.NewStage(str(tmp_path / "a.usda"))
    points = author.AddMesh(stage, "/World/Ball", shapes.Sphere(1, 40, 40)).GetPointsAttr()
    values = np.array(points.Get())
    Read = lambda attribute: np.array(attribute.Get())
    kept = [rereading.Again(points, Usd.TimeCode.Default(), values, Read) for _ in range(2000)]
    isOver = threading.Event()

    def Translate():
        while not isOver.is_set():
            kept.append(rereading.Again(points, Usd.TimeCode.Default(), values, Read))

    other = Usd.Stage.CreateInMemory()
    interval = sys.getswitchinterval()
    thread = threading.Thread(target=Translate)
    sys.setswitchinterval(1e-6)
    thread.start()
    try:
        for _ in range(30):
            rereading.MoveToPart(other)
    finally:
        isOver.set()
        thread.join()
        sys.setswitchinterval(interval)
    assert len(kept) > 2000
