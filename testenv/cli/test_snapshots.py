# SPDX-License-Identifier: Apache-2.0
"""`--snapshot`: a picture beside the file while it is rendered; with `--resume` also what a killed run goes on from."""

import os
import signal
import subprocess
import time

import exrFile
import numpy as np
import pytest

from hdstream import _core, filmSums

from cliCase import SECONDS, SMALL, AssertFails, Command, RunHere, WriteStage

_LONG = ["-w", "64", "--samples", "1500", "--maxDepth", "1"]


def _StartUntil(condition, *arguments):
    process = subprocess.Popen(Command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + SECONDS
    while not condition() and time.monotonic() < deadline:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    return process


def test_a_picture_lies_beside_its_file_until_that_is_written(tmp_path):
    stage, output, part = WriteStage(tmp_path), tmp_path / "o.exr", tmp_path / "o_part.exr"
    process = _StartUntil(part.exists, "record", stage, output, "-w", "64", "--samples", str(1 << 20), "--snapshot", "0.2")
    assert not output.exists()
    first = part.stat().st_mtime_ns
    deadline = time.monotonic() + SECONDS
    while part.stat().st_mtime_ns == first and time.monotonic() < deadline:
        time.sleep(0.01)
    assert part.stat().st_mtime_ns != first  # again and again
    os.kill(process.pid, signal.SIGSTOP)
    try:  # whole at any time
        _, pixels = exrFile.Read(part)
        assert pixels["A"].max() == 1.0 and 0.0 < pixels["R"].max() < 1e6
    finally:
        os.kill(process.pid, signal.SIGCONT)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=SECONDS)
    assert process.returncode == 130
    assert output.exists() and not part.exists()


def test_snapshots_leave_the_picture_as_it_is(tmp_path):
    stage = WriteStage(tmp_path)
    outputs = [tmp_path / "a.exr", tmp_path / "b.exr"]
    assert RunHere("record", stage, outputs[0], *_LONG, "--aovs", "color,depth").code == 0
    assert RunHere("record", stage, outputs[1], *_LONG, "--aovs", "color,depth", "--snapshot", "0.05").code == 0
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    assert sorted(path.name for path in tmp_path.glob("*.exr")) == ["a.exr", "b.exr"]


def test_a_killed_run_goes_on_from_its_last_snapshot(tmp_path):
    stage, output = WriteStage(tmp_path), tmp_path / "o.exr"
    sums = tmp_path / "o.exr.sums"
    arguments = ["record", stage, output, *_LONG, "--resume"]
    process = _StartUntil(sums.exists, *arguments, "--snapshot", "0.1")
    process.kill()
    process.communicate(timeout=SECONDS)
    assert not output.exists()
    with np.load(sums) as kept:
        found, _ = filmSums.Load(str(sums), str(kept["key"]))
    assert 0 < found.endSample < 1500
    assert RunHere(*arguments, "--snapshot", "60").code == 0
    whole = tmp_path / "whole.exr"
    assert RunHere("record", stage, whole, *_LONG).code == 0
    difference = _core.CompareImages(str(output), str(whole))
    assert not difference.error and all(layer.maxAbs == 0.0 for layer in difference.layers)
    assert not (tmp_path / "o_part.exr").exists()


@pytest.mark.parametrize("further", [["--workers", "1"], ["--scheduler", "tcp://127.0.0.1:1"]])
def test_farms_write_no_snapshots(tmp_path, further):
    AssertFails(RunHere("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--snapshot", "1", *further), 2, "--snapshot")


def test_a_snapshot_that_cannot_be_written_ends_no_render(tmp_path):
    stage, output = WriteStage(tmp_path), tmp_path / "o.exr"
    (tmp_path / "o_part.exr").mkdir()
    result = RunHere("record", stage, output, *_LONG, "--snapshot", "0.05")
    assert result.code == 0 and not result.errors, result.text
    assert any("--snapshot" in line and "o_part.exr" in line for line in result.warnings), result.text
    assert output.exists()
