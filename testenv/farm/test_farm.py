# SPDX-License-Identifier: Apache-2.0
"""Pictures of a cluster are those of one process, to the bit, whatever is split and whoever dies."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import exrFile
import numpy as np
import pytest
from pxr import Ar

from cliCase import ANIMATED, SECONDS, AssertFails, Command, Run, RunHere, WriteStage
from farmCase import OPTIONS, SameImages
from farmCluster import Cluster
from hdstream import _core, farmWork
from hdstream.farm import CommandError, _CheckWorkers, _Farm, _MakeTravel
from hdstream.frameJob import Frame, Job, ProgramOf


@pytest.fixture(scope="module", name="farm")
def MakeFarm(tmp_path_factory):
    with Cluster(tmp_path_factory.mktemp("cluster")) as (address, processes):
        yield address, processes


@pytest.fixture(scope="module", name="case")
def MakeCase(tmp_path_factory):
    """(stage, one picture of 72 samples, pictures of three frames) of one process."""
    folder = tmp_path_factory.mktemp("reference")
    stage = WriteStage(folder, ANIMATED)
    single = folder / "single.exr"
    assert RunHere("record", stage, single, *OPTIONS, "--frames", 3, "--samples", 72).code == 0
    assert RunHere("record", stage, folder / "f####.exr", *OPTIONS, "--frames", "1:3", "--samples", 8).code == 0
    return stage, single, folder


def test_frames(farm, case, tmp_path, monkeypatch):
    stage, _, folder = case
    monkeypatch.chdir(tmp_path)  # where workers are not
    result = RunHere("record", stage, "f####.exr", *OPTIONS, "--frames", "1:3", "--samples", 8, "--scheduler", farm[0],
                     "--stats", "s####.json")
    assert result.code == 0 and not result.errors, result.text
    assert len(result.out.splitlines()) == 3
    for number in ("0001", "0002", "0003"):
        assert SameImages(tmp_path / f"f{number}.exr", folder / f"f{number}.exr")
        assert (tmp_path / f"s{number}.json").stat().st_size > 0


@pytest.mark.parametrize("split", [["--split", "samples", "--parts", "3"], ["--split", "tiles", "--parts", "4"], []])
def test_one_frame_in_parts(split, farm, case, tmp_path):
    stage, single, _ = case
    output = tmp_path / "o.exr"
    result = RunHere("record", stage, output, *OPTIONS, "--frames", 3, "--samples", 72, "--scheduler", farm[0], *split)
    assert result.code == 0 and not result.errors, result.text
    assert SameImages(output, single)


@pytest.mark.parametrize("split", [["--split", "samples", "--parts", "3"], ["--split", "tiles", "--parts", "4"]])
def test_mattes_of_a_frame_in_parts(split, farm, case, tmp_path):
    """Ids, coverages and the names in the header."""
    stage, _, _ = case
    options = [*OPTIONS[:-1], "crypto_object,crypto_instance", "--frames", 3, "--samples", 40]
    single, output = tmp_path / "single.exr", tmp_path / "o.exr"
    assert RunHere("record", stage, single, *options).code == 0
    result = RunHere("record", stage, output, *options, "--scheduler", farm[0], *split)
    assert result.code == 0 and not result.errors, result.text
    texts, channels = exrFile.Read(single)
    assert sum(name.endswith("/manifest") and "/Ball" in text for name, text in texts.items()) == 2
    again, parts = exrFile.Read(output)
    assert {name: text for name, text in texts.items() if name.startswith("cryptomatte/")} == \
        {name: text for name, text in again.items() if name.startswith("cryptomatte/")}
    assert len(channels) == 24 and channels.keys() == parts.keys()
    assert all(np.array_equal(pixels.view(np.uint32), parts[name].view(np.uint32)) for name, pixels in channels.items())


def test_a_worker_sees_an_edited_stage(farm, tmp_path):
    """Workers stay from job to job; the layers of the last one must not."""
    stage = WriteStage(tmp_path, ANIMATED)
    for intensity in ("1", "2", "3"):
        stage.write_text(stage.read_text().replace(f"intensity = {int(intensity) - 1}", f"intensity = {intensity}"))
        assert RunHere("record", stage, tmp_path / "farm.exr", *OPTIONS, "--samples", 2, "--scheduler", farm[0]).code == 0
        assert Run("record", stage, tmp_path / "one.exr", *OPTIONS, "--samples", 2).code == 0
        assert SameImages(tmp_path / "farm.exr", tmp_path / "one.exr")


def test_ranges_and_bands_cover_everything_once():
    from hdstream.farm import Bands, SampleRanges
    for first, end, numParts in ((0, 64, 3), (0, 72, 4), (16, 17, 5), (0, 5, 1), (32, 1000, 7)):
        ranges = SampleRanges(first, end, numParts)
        assert ranges[0][0] == first and ranges[-1][1] == end and len(ranges) <= numParts
        assert all(a[1] == b[0] for a, b in zip(ranges, ranges[1:]))
        assert all(begin % 16 == 0 and begin < stop for begin, stop in ranges)
    for height, numParts in ((10, 3), (2, 5), (7, 1)):
        bands = Bands(6, height, numParts)
        assert [band[1] for band in bands[1:]] == [band[3] for band in bands[:-1]]
        assert bands[0][:3] == (0, 0, 6) and bands[-1][3] == height and all(band[1] < band[3] for band in bands)


def test_a_killed_workers_work_is_done_again(case, tmp_path):
    stage, _, _ = case
    with Cluster(tmp_path, 2) as (address, processes):
        command = Command("record", stage, tmp_path / "f####.exr", *OPTIONS, "--frames", "1:8", "--samples", 800,
                          "--scheduler", address)
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as client:
            line = client.stdout.readline()  # a frame is there, others are under way
            assert "f00" in line, client.stderr.read()
            processes["worker1"].send_signal(signal.SIGKILL)
            _, err = client.communicate(timeout=SECONDS)
        assert client.returncode == 0 and not err, err
    files = sorted(path.name for path in tmp_path.glob("f*.exr"))
    assert files == [f"f{number:04}.exr" for number in range(1, 9)], "nothing is lost"
    again = tmp_path / "again.exr"
    assert RunHere("record", stage, again, *OPTIONS, "--frames", 8, "--samples", 800).code == 0
    assert SameImages(tmp_path / "f0008.exr", again)


def test_workers_of_this_machine(case, tmp_path):
    stage, single, _ = case
    result = Run("record", stage, tmp_path / "o.exr", *OPTIONS, "--frames", 3, "--samples", 72, "--workers", 2)
    assert result.code == 0 and not result.errors, result.text
    assert SameImages(tmp_path / "o.exr", single)


def test_ctrl_c_leaves_whole_files_or_none(farm, case, tmp_path):
    stage, _, _ = case
    command = Command("record", stage, tmp_path / "f####.exr", *OPTIONS, "--frames", "1:40", "--samples", 4000,
                      "--scheduler", farm[0])
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as client:
        assert client.stdout.readline()
        client.send_signal(signal.SIGINT)
        _, err = client.communicate(timeout=SECONDS)
    assert client.returncode == 130 and "interrupted" in err and "Traceback" not in err, err
    time.sleep(1.0)
    files = sorted(tmp_path.iterdir())
    assert files and len(files) < 40 and all(path.name.startswith("f") for path in files), "no temporary files"
    # What is there are the frames that one process makes: the first and the last that were finished stand for all.
    for path in {files[0], max(files, key=lambda path: path.stat().st_mtime_ns)}:
        whole = tmp_path / "whole.exr"
        assert RunHere("record", stage, whole, *OPTIONS, "--frames", int(path.stem[1:]), "--samples", 4000).code == 0
        assert SameImages(path, whole)
    # The workers are free again.
    assert RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--samples", 2, "--scheduler", farm[0]).code == 0


# --- Errors ----------------------------------------------------------------------------------------


def test_errors_of_the_stage_are_one_line(farm, case, tmp_path):
    stage, _, _ = case
    result = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--camera", "none", "--scheduler", farm[0])
    AssertFails(result, 2, "--camera none")
    result = RunHere("record", tmp_path / "no.usda", tmp_path / "o.exr", *OPTIONS, "--scheduler", farm[0])
    AssertFails(result, 1, "no.usda")
    result = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--device", "nonsense", "--scheduler", farm[0])
    AssertFails(result, 2, "worker", "--device nonsense")


def test_adaptive_frames_are_not_split(farm, case, tmp_path):
    stage, _, _ = case
    result = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--noise", 0.1, "--split", "samples", "--scheduler", farm[0])
    AssertFails(result, 2, "--split samples", "--noise")
    whole = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--noise", 0.1, "--scheduler", farm[0])
    assert whole.code == 0, whole.text


def test_unreachable_scheduler(case, tmp_path, monkeypatch):
    from hdstream import farm
    monkeypatch.setattr(farm, "_CONNECT_SECONDS", 1)
    result = RunHere("record", case[0], tmp_path / "o.exr", *OPTIONS, "--scheduler", "tcp://127.0.0.1:9")
    AssertFails(result, 1, "--scheduler tcp://127.0.0.1:9", "cannot be reached")


def test_a_scheduler_without_workers_and_workers_without_hdstream(case, tmp_path):
    stage, _, _ = case
    empty = {"PYTHONPATH": "", "PYTHONSAFEPATH": "1"}
    with Cluster(tmp_path, 1, environment=empty) as (address, _):
        if subprocess.run([sys.executable, "-c", "import hdstream"], env=dict(os.environ, **empty), cwd="/",
                          capture_output=True).returncode == 0:
            pytest.skip("hdstream is installed for this Python")
        result = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--scheduler", address)
    AssertFails(result, 1, "worker", "has no hdstream")


@pytest.mark.parametrize("options, part", [
    (["--workers", "0"], "--workers"), (["--workers", "2", "--scheduler", "x"], "not allowed with"),
    (["--split", "rows"], "--split"), (["--split", "tiles"], "--split: needs"), (["--parts", "3"], "--parts: needs")])
def test_bad_options(options, part, case, tmp_path):
    AssertFails(RunHere("record", case[0], tmp_path / "o.exr", *options), 2, part)


class FakeClient:
    """Of workers that answer so."""

    def __init__(self, answers=None):
        self._answers = answers

    def wait_for_workers(self, *_, **__):
        pass

    def run(self, *_, **__):
        return self._answers

    def subscribe_topic(self, *_):
        pass


def AnswerOf(device, program=None):
    program = program or ProgramOf()
    return {"version": program[0], "program": program, "device": device}


def CheckAnswers(answers):
    return _CheckWorkers(FakeClient(answers), Job("", program=ProgramOf()), SimpleNamespace(workers=None, scheduler="x"))


def MakeFarmOf(devices, warn):
    return _Farm(FakeClient(), None, Job("", program=ProgramOf()), None, 2, devices, None, warn, {"f": "f"})


def ResultOf(device, program=None):
    return {"origins": [{"worker": "tcp://b", "program": program or ProgramOf(), "device": device}]}


def test_different_devices_are_said():
    """Also of workers that join while the job runs; once each."""
    lines = []
    assert CheckAnswers({"a": AnswerOf("One"), "b": AnswerOf("Two")}) == (2, {"One", "Two"})
    MakeFarmOf({"One", "Two"}, lines.append)
    assert len(lines) == 1 and "One, Two" in lines[0]
    late = MakeFarmOf({"One"}, FlushedList(lines))
    for device in ("One", "Two", "Two"):
        late._Check(Frame(1.0, "f"), ResultOf(device))
    assert len(lines) == 2 and "One, Two" in lines[1]


class FlushedList:
    """What _Farm warns with."""

    def __init__(self, lines):
        self._lines = lines

    def __call__(self, line):
        self._lines.append(line)

    def Flush(self):
        pass


@pytest.mark.parametrize("program, words", [
    (("0.0", *ProgramOf()[1:]), "has hdstream 0.0, this is"), ((_core.VERSION, "x", ProgramOf()[2]), "has other kernels"),
    ((*ProgramOf()[:2], "x"), "has another color configuration"),
])
def test_other_programs_are_refused_whenever_they_join(program, words, monkeypatch):
    with pytest.raises(CommandError, match=f"worker b: {words}"):
        CheckAnswers({"a": AnswerOf("One"), "b": AnswerOf("Two", program)})
    with pytest.raises(CommandError, match=f"worker tcp://b: {words}"):  # one that is too old to refuse
        MakeFarmOf({"One"}, FlushedList([]))._Check(Frame(1.0, "f"), ResultOf("One", program))
    with pytest.raises(CommandError, match="another hdstream"):  # too old to say
        MakeFarmOf({"One"}, FlushedList([]))._Check(Frame(1.0, "f"), {"isThere": True})
    for part in (ResultOf("One", program), {}):  # nor are its parts joined
        for Join in (farmWork.JoinTiles, lambda *arguments: farmWork.JoinBlocks(*arguments[:3], 0, arguments[3])):
            result = Join("job", Job("none.usda", program=ProgramOf()), Frame(1.0, "none.exr"), [ResultOf("One"), part])
            assert result["error"].startswith("worker ") and not result["isUsage"]
    # The worker itself, before it writes anything.
    monkeypatch.setattr(farmWork, "_Worker", lambda: SimpleNamespace(address="tcp://b"))
    monkeypatch.setattr(farmWork, "ProgramOf", lambda: program)
    result = farmWork.RenderFrame("job", Job("none.usda", program=ProgramOf()), Frame(1.0, "none.exr"))
    assert result["error"].startswith(f"worker tcp://b: {words}") and not result["isUsage"]


def test_color_configurations_are_told_apart_by_their_contents(tmp_path, monkeypatch):
    """Of a client with $OCIO and a worker without it, half a picture would have other colours."""
    monkeypatch.delenv("OCIO", raising=False)
    plain = ProgramOf()
    text = """ocio_profile_version: 1
roles: {default: lin, scene_linear: lin}
displays: {d: [!<View> {name: v, colorspace: lin}]}
colorspaces: [!<ColorSpace> {name: lin}%s]
"""
    other = ", !<ColorSpace> {name: dim, to_reference: !<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1]}}"
    programs = []
    for name, content in (("a", text % ""), ("b", text % ""), ("c", text % other)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "config.ocio").write_text(content)
        monkeypatch.setenv("OCIO", str(tmp_path / name / "config.ocio"))
        programs.append(ProgramOf())
    assert programs[0] == programs[1] and len({plain, *programs}) == 3
    assert farmWork.DifferenceOf(plain, programs[0]) == "has another color configuration than this process"


def test_a_worker_without_hdstream_that_joins_is_a_line():
    def Raise():
        raise ModuleNotFoundError("No module named 'hdstream'")

    farm = MakeFarmOf({"One"}, FlushedList([]))
    farm._distributed = SimpleNamespace(KilledWorker=KeyError, CancelledError=KeyError)
    with pytest.raises(CommandError, match="a worker has no hdstream"):
        farm._ResultOf(SimpleNamespace(result=Raise))


def test_files_that_fail_a_worker_are_named(monkeypatch):
    """What is raised would be taken for a lost scheduler."""
    def Fail(*_):
        raise PermissionError(13, "Permission denied", "/nowhere/o.exr")

    monkeypatch.setattr(farmWork, "_Worker", lambda: SimpleNamespace(address="tcp://b"))
    monkeypatch.setattr(farmWork, "_WriterOf", Fail)
    result = farmWork.RenderFrame("job", Job("none.usda"), Frame(1.0, "none.exr"))
    assert result == {"error": "worker tcp://b: /nowhere/o.exr: Permission denied", "isUsage": False}


def test_paths_of_a_job_are_those_of_the_client(tmp_path, monkeypatch):
    """The cache's too, and a stage that the resolver finds elsewhere."""
    stage = WriteStage(tmp_path, ANIMATED)
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    job = Job("../" + stage.name, settings={"cacheDirectory": "cache", "samples": 2})
    _MakeTravel(job)
    assert job.stage == str(stage) and job.settings == {"cacheDirectory": str(tmp_path / "work" / "cache"), "samples": 2}
    monkeypatch.setattr(Ar, "GetResolver", lambda: SimpleNamespace(Resolve=lambda name: tmp_path / name))
    job = Job(stage.name)
    _MakeTravel(job)
    assert job.stage == str(stage) and job.settings == {}
    job = Job("asset://shot.usd")
    _MakeTravel(job)
    assert job.stage == "asset://shot.usd"


def test_a_worker_that_dies_while_it_is_asked_is_left_out():
    from distributed.comm.core import CommClosedError
    dead = CommClosedError("in <TCP (closed) Scheduler Broadcast>: Stream is closed")
    assert CheckAnswers({"a": AnswerOf("One"), "b": dead}) == (1, {"One"})
    with pytest.raises(CommandError, match="no workers"):
        CheckAnswers({"b": dead})


def test_without_distributed(case, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    AssertFails(RunHere("record", case[0], tmp_path / "o.exr", "--scheduler", "x"), 2, "hdstream[farm]")


def test_results_name_parts(farm, case, tmp_path):
    import json
    stage, _, _ = case
    stats = tmp_path / "s.json"
    result = RunHere("record", stage, tmp_path / "o.exr", *OPTIONS, "--samples", 48, "--parts", 3, "--scheduler", farm[0],
                 "--stats", stats)
    assert result.code == 0, result.text
    assert len(json.loads(stats.read_text())["parts"]) == 3
