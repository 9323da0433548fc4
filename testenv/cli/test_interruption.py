# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C keeps what is rendered so far; a full disk is one line and leaves nothing half-written."""

import os
import resource
import signal
import subprocess
import time

import pytest

from hdstream import filmSums
from hdstream.renderer import Image

from cliCase import ANIMATED, SECONDS, SMALL, AssertFails, Command, Result, Run, RunHere, WriteStage

ENDLESS = ["-w", "64", "--samples", str(1 << 20), "--maxDepth", "1"]


def DefaultInterrupt():
    """Ctrl-C works in the child even where this process ignores it, as background jobs do."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def StartRendering(stage, output, *options):
    """A render that would take hours, once its first samples are done."""
    process = subprocess.Popen(Command("record", stage, output, *ENDLESS, *options),
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env=dict(os.environ, HDSTREAM_PROGRESS="1"), preexec_fn=DefaultInterrupt)
    seen = ""
    deadline = time.monotonic() + SECONDS
    while "samples" not in seen and time.monotonic() < deadline:
        text = os.read(process.stderr.fileno(), 4096).decode()
        seen += text
        assert text, f"it ended early: {seen}"
    return process


def test_ctrl_c_writes_what_is_rendered(tmp_path):
    output, stats = tmp_path / "o.exr", tmp_path / "s.json"
    process = StartRendering(WriteStage(tmp_path), output, "--stats", stats)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=SECONDS)
    result = Result(process.returncode, out, err)
    assert result.code == 130, result.text
    assert "interrupted" in err and "Traceback" not in err
    from hdstream import _core
    image = _core.CompareImages(str(output), str(output))
    assert not image.error and (image.width, image.height) == (64, 46)
    assert all(layer.numNonFinite == 0 for layer in image.layers)
    assert stats.exists()


@pytest.mark.parametrize("seconds", [0.25, 1.5])
def test_ctrl_c_before_rendering(tmp_path, seconds):
    """While modules load, the stage is read or kernels are built: one line, the old image is kept."""
    caches = {"HDSTREAM_CACHE_DIR": str(tmp_path / "cache"), "POCL_CACHE_DIR": str(tmp_path / "pocl")}
    output = tmp_path / "o.exr"
    output.write_bytes(b"old")
    process = subprocess.Popen(Command("record", WriteStage(tmp_path), output, *ENDLESS), text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(os.environ, **caches),
                               preexec_fn=DefaultInterrupt)
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=SECONDS)
    # Python itself may still be starting, and dies of the signal then.
    assert process.returncode in (130, -signal.SIGINT), err
    if process.returncode == 130:
        assert "Traceback" not in err and "interrupted" in err, err
    if output.read_bytes() != b"old":  # a fast machine was rendering already
        from hdstream import _core
        assert "writing what is rendered" in err and not _core.CompareImages(str(output), str(output)).error


@pytest.mark.parametrize("owner, name", [(filmSums, "Save"), (Image, "Write")])
def test_ctrl_c_while_a_frame_is_written(tmp_path, monkeypatch, owner, name):
    """That frame is as whole as without it, and the next one is not begun."""
    stage = WriteStage(tmp_path, ANIMATED)
    record = ["record", stage, tmp_path / "o.#.exr", *SMALL, "-f", "1:2", "--resume", "--stats", tmp_path / "s.#.json"]
    assert RunHere(*record).code == 0
    picture = (tmp_path / "o.1.exr").read_bytes()
    for file in [*tmp_path.glob("o.*"), *tmp_path.glob("s.*")]:
        file.unlink()
    write = getattr(owner, name)

    def Interrupted(*arguments):
        os.kill(os.getpid(), signal.SIGINT)
        return write(*arguments)

    monkeypatch.setattr(owner, name, Interrupted)
    result = RunHere(*record)
    AssertFails(result, 130, "interrupted")
    assert (tmp_path / "o.1.exr").read_bytes() == picture and (tmp_path / "s.1.json").exists()
    assert not (tmp_path / "o.2.exr").exists()


def LimitFileSize():
    """No file may grow above 1000 bytes, as on a disk that is full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


def test_full_disk(tmp_path):
    stage = WriteStage(tmp_path)
    output = tmp_path / "o.exr"
    assert Run("record", stage, output, *SMALL).code == 0
    before = output.read_bytes()
    result = Run("record", stage, output, "-w", "256", "--samples", "1", preexec_fn=LimitFileSize)
    AssertFails(result, 1, "o.exr")
    assert output.read_bytes() == before, "the old image is kept"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["o.exr", "scene.usda"]


def test_full_disk_for_statistics(tmp_path):
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.png", "-w", "8", "--samples", "1",
                 "--stats", "/dev/full")
    AssertFails(result, 1, "/dev/full")
    assert (tmp_path / "o.png").exists()


def LimitMemory():
    """So much address space that the command starts, and no more than four gigabytes."""
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))


def test_memory_runs_out(tmp_path):
    """The path state of so many paths takes six gigabytes."""
    result = Run("record", WriteStage(tmp_path), tmp_path / "o.exr", *SMALL, "--residency", "stream", "--waveSize", str(1 << 24),
                 preexec_fn=LimitMemory)
    AssertFails(result, 1, "device memory for path state", "bytes are in use")
    assert not (tmp_path / "o.exr").exists()
