# SPDX-License-Identifier: Apache-2.0
"""Instances that lie in chunks give the bits of those in tables, with resident geometry and with any pool.

The oracle is the resident mode with all records in tables, whose pictures testenv/render compares with closed forms.
"""

import random

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Sdf, Usd, UsdGeom, Vt

from stages import crowd
from streamCase import Case

_LEAST = 1  # instances from which on they lie in chunks: of the group that has most
_COPIES = {"in the root": 0, "in a group": 3}  # of the crowd, by one more level of instancing


@pytest.fixture(scope="module", params=_COPIES.values(), ids=_COPIES)
def Crowd(tmp_path_factory, request):
    path = tmp_path_factory.mktemp("crowd") / "stage.usda"
    crowd.WriteCrowd(str(path), copies=request.param)
    return Case(path).RenderResident(instanceChunks=0)


def _AssertStreams(case, least=_LEAST, **settings):
    """Case.AssertStreams compares accounts of resident geometry too, which has other chunks in tables."""
    layers, statistics = case.Render(residency="stream", instanceChunks=least, **settings)
    case.AssertBits(layers)
    geometry = statistics["geometry"]
    assert geometry["peakBytes"] <= geometry["budget"]
    return geometry


@pytest.mark.parametrize("settings", [
    dict(residency="resident"),
    dict(residency="resident", traversal="scalar"),
    dict(residency="resident", traversal="flat"),
    dict(residency="mapped"),
], ids=lambda settings: "-".join(settings.values()))
def test_without_streaming(Crowd, settings):
    layers, statistics = Crowd.Render(instanceChunks=_LEAST, **settings)
    Crowd.AssertBits(layers)
    isFlat = settings.get("traversal") == "flat"
    assert (statistics["wave"]["traversal"] == "flat") == (statistics["geometry"]["flatTriangles"] > 1000) == isFlat
    tables, chunks = Crowd.statistics["geometry"], statistics["geometry"]
    assert chunks["chunks"] > tables["chunks"] + 10
    assert chunks["instances"] == tables["instances"]
    assert chunks["alwaysResidentBytes"] < tables["alwaysResidentBytes"] - 90 * 1200


@pytest.mark.parametrize("pool", ["100%", "79%", "50%", "30%", "15%", "5%", "2%"])
def test_any_pool_gives_the_same_bits(Crowd, pool):
    _AssertStreams(Crowd, geometryMemory=pool)


@pytest.mark.parametrize("settings", [
    dict(traversal="scalar"),
    dict(geometryEviction="flush"),
    dict(traversal="scalar", geometryEviction="flush"),
    dict(waveSize=1000),
    dict(waveSize=1 << 20),
    dict(prepare="eager"),
    dict(hostMemory=1 << 16),
], ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()))
def test_other_ways_give_the_same_bits(Crowd, settings):
    _AssertStreams(Crowd, geometryMemory="10%", **settings)


@pytest.mark.parametrize("settings", [dict(), dict(traversal="scalar"), dict(geometryEviction="flush"), dict(waveSize=1000)],
                         ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()) or "lru")
@pytest.mark.parametrize("pool", ["100%", "10%"])
@pytest.mark.parametrize("entries", [32, 128])
def test_a_page_table_of_any_size_gives_the_same_bits(Crowd, entries, pool, settings):
    """The smaller one has room for 28 pages, and for eight requests: of very many rays that wait those of few are heard."""
    geometry = _AssertStreams(Crowd, geometryMemory=pool, pageEntries=entries, **settings)
    assert 2 * geometry["chunks"] > entries
    assert geometry["evictions"] > 0
    assert geometry["requestsDropped"] > 0 or entries > 32
    direct = _AssertStreams(Crowd, geometryMemory=pool, pageEntries=1 << 20, **settings)
    assert direct["requestsDropped"] == 0
    assert direct["alwaysResidentBytes"] - geometry["alwaysResidentBytes"] == 8 * 2 * geometry["chunks"] - (128 + 14 * entries)


def test_a_pool_of_one_way_is_enough(Crowd):
    """It has to hold the largest chunk beside the largest one of instances, as one ray may need both at once."""
    with pytest.raises(Crowd.core.Error, match="cannot hold the largest chunk, which takes") as error:
        Crowd.Render(residency="stream", instanceChunks=_LEAST, geometryMemory="16")
    needed = int(str(error.value).split("which takes ")[1].split()[0])
    assert _AssertStreams(Crowd, geometryMemory=str(needed))["evictions"] > 1000


def test_the_design_of_the_report_keeps_tables(Crowd):
    layers, statistics = Crowd.Render(residency="stream", instanceChunks=_LEAST, request="first", geometryMemory="30%")
    Crowd.AssertBits(layers)
    assert statistics["geometry"]["chunks"] == Crowd.statistics["geometry"]["chunks"]


def test_few_instances_stay_in_tables(Crowd):
    layers, statistics = Crowd.Render(residency="resident")
    Crowd.AssertBits(layers)
    assert statistics["geometry"]["chunks"] == Crowd.statistics["geometry"]["chunks"]


@pytest.mark.parametrize("settings", [
    dict(residency="resident"),
    dict(residency="stream", geometryMemory="10%"),
    dict(residency="stream", geometryMemory="10%", traversal="scalar"),
], ids=lambda settings: "-".join(settings.values()))
@pytest.mark.parametrize("copies", _COPIES.values(), ids=_COPIES)
def test_beside_what_moves(tmp_path, copies, settings):
    """Kernels know of motion, and of instances that are placed at rest, perhaps in a group that moves, each with its colour."""
    path = str(tmp_path / "stage.usda")
    crowd.WriteCrowd(path, copies=copies)
    stage = Usd.Stage.Open(path)
    if copies:
        translate = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Sea")).AddTranslateOp()
        for time in (0.0, 1.0):
            translate.Set((0.3 * time, 0.0, 0.1 * time), time)
    world = "/World/Sea/Prototype" if copies else "/World"
    colors = np.random.default_rng(3).uniform(size=(1200, 3)).astype(np.float32)
    placed = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"{world}/Crowd"))
    placed.CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex").Set(Vt.Vec3fArray.FromNumpy(colors))
    points = UsdGeom.Mesh.Get(stage, f"{world}/Ball1").GetPointsAttr()
    still = np.array(points.Get())
    for time in (0.0, 1.0):
        points.Set(Vt.Vec3fArray.FromNumpy(still * np.float32(1 + 0.5 * time)), time)
    stage.GetRootLayer().Save()
    case = Case(path, timeCode=Usd.TimeCode(0.0), shutter=(0.0, 1.0)).RenderResident(instanceChunks=0)
    layers, statistics = case.Render(instanceChunks=_LEAST, **settings)
    case.AssertBits(layers)
    assert statistics["geometry"]["chunks"] > case.statistics["geometry"]["chunks"]
    assert len(np.unique(layers["primvars:displayColor"])) > 100


def test_edits_bring_other_chunks(Crowd):
    """The arrays that pages are made of are those of the present version."""
    case = Crowd.Fresh()
    for hides in (True, False):
        for path, prim in dict(case.session.Scene().geometry).items():
            if path.endswith("/Veil"):
                prim.placement.visible = not hides
                case.session.SetGeometry(path, prim)
        case.RenderResident(instanceChunks=0)
        _AssertStreams(case, geometryMemory="20%")


@pytest.mark.parametrize("settings", [
    dict(residency="resident"),
    dict(residency="stream", geometryMemory="10%"),
], ids=lambda settings: "-".join(settings.values()))
def test_a_group_that_moves_gives_its_place_to_what_it_places(tmp_path, settings):
    """The root has most instances, and they move: those of what they place lie in chunks."""
    path = str(tmp_path / "stage.usda")
    crowd.WriteCrowd(path, instances=90, rings=6, copies=120)
    stage = Usd.Stage.Open(path)
    sea = UsdGeom.PointInstancer.Get(stage, "/World/Sea")
    positions = np.array(sea.GetPositionsAttr().Get())
    for time in (0.0, 1.0):
        sea.GetPositionsAttr().Set(Vt.Vec3fArray.FromNumpy(positions + np.float32(0.1 * time)), time)
    stage.GetRootLayer().Save()
    for shutter in ((0.0, 0.0), (0.0, 1.0)):
        case = Case(path, timeCode=Usd.TimeCode(0.0), shutter=shutter).RenderResident(instanceChunks=0)
        layers, statistics = case.Render(instanceChunks=_LEAST, **settings)
        case.AssertBits(layers)
        inTables = statistics["geometry"]["alwaysResidentBytes"] / case.statistics["geometry"]["alwaysResidentBytes"]
        assert statistics["geometry"]["chunks"] > case.statistics["geometry"]["chunks"]
        assert inTables < 0.9, "of the root's, or of those of its prototype"


class _EditedCrowd:
    """A session whose instancers come to place more or less, elsewhere, or nothing."""

    def __init__(self, path, seed):
        self.case, self._random = Case(path), random.Random(seed)
        scene = self.case.session.Scene()
        self._first = {"instancers": dict(scene.instancers), "geometry": dict(scene.geometry)}

    def _Set(self, session, kind, path, prim):
        (session.SetInstancer if kind == "instancers" else session.SetGeometry)(path, prim)

    def _Placed(self, prim, instances, visible):
        place = prim.placement
        return self.case.core.Placement(place.worldFromObject, place.instancerPath, instances, visible)

    def _Replace(self, kind, path, prim, placement, **fields):
        if kind == "instancers":
            other = self.case.core.InstancerPrim(placement)
            other.instanceTransforms = fields.get("transforms", prim.instanceTransforms)
        else:
            other = self.case.core.GeometryPrim(prim.geometry, placement, prim.purpose, prim.materialPath)
            other.doubleSided = prim.doubleSided
        self._Set(self.case.session, kind, path, other)

    def _List(self):
        """An instancer places only its first instances."""
        path = self._random.choice(sorted(self._first["instancers"]))
        count = max(1, round(self._random.random() ** 2 * np.asarray(self._first["instancers"][path].instanceTransforms).size / 16))
        for kind, prims in self._first.items():
            for name, prim in prims.items():
                if prim.placement.instancerPath == path:
                    listed = np.array([i for i in prim.placement.instances if i < count], np.int32)
                    self._Replace(kind, name, prim, self._Placed(prim, listed, prim.placement.visible))

    def _Hide(self):
        kind = self._random.choice(sorted(self._first))
        path = self._random.choice(sorted(self._first[kind]))
        prim = self._first[kind][path]
        self._Replace(kind, path, prim, self._Placed(prim, prim.placement.instances, self._random.random() < 0.6))

    def _Move(self):
        """Some of its instances come to places where they cannot be drawn."""
        path = self._random.choice(sorted(self._first["instancers"]))
        prim = self._first["instancers"][path]
        matrices = np.array(prim.instanceTransforms).reshape(-1, 4, 4).copy()
        matrices[:, 3, :3] += self._random.uniform(-0.3, 0.3)
        matrices[: self._random.choice([0, 0, len(matrices) // 2]), :3, :3] = 0.0
        self._Replace("instancers", path, prim, prim.placement, transforms=matrices)

    def Edit(self):
        for _ in range(self._random.randrange(1, 4)):
            self._random.choice([self._List, self._List, self._Hide, self._Move])()

    def Fresh(self):
        """A new session that is told what there is now."""
        fresh = self.case.Fresh()
        scene = self.case.session.Scene()
        for kind in self._first:
            for path, prim in dict(getattr(scene, kind)).items():
                self._Set(fresh.session, kind, path, prim)
        return fresh


@pytest.mark.parametrize("seed", range(3))
def test_a_chain_of_edits_gives_the_bits_of_a_fresh_session(tmp_path, seed):
    """Groups have more instances than others, and fewer again: chunks go from one to the other."""
    path = str(tmp_path / "stage.usda")
    crowd.WriteCrowd(path, instances=240, rings=4, copies=130)
    edited = _EditedCrowd(path, seed)
    numChunks = set()
    for step in range(8):
        edited.Edit()
        least = (1, 30, 100)[step % 3]
        fresh = edited.Fresh().RenderResident(instanceChunks=0)
        edited.case.layers, edited.case.statistics = fresh.layers, fresh.statistics
        geometry = _AssertStreams(edited.case, least=least, geometryMemory="25%")
        layers, statistics = fresh.Render(residency="resident", instanceChunks=least)
        fresh.AssertBits(layers)
        inTables = edited.case.Render(residency="resident", instanceChunks=0)[1]["geometry"]  # with what is hidden
        numChunks.add(geometry["chunks"] - inTables["chunks"])
        assert geometry["chunks"] - inTables["chunks"] == statistics["geometry"]["chunks"] - fresh.statistics["geometry"]["chunks"]
        assert geometry["instances"] == statistics["geometry"]["instances"]
    assert len(numChunks) >= 3
