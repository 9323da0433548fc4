# SPDX-License-Identifier: Apache-2.0
"""Whoever reads what the command says may leave, or never have been there: frames are rendered and written all the same."""

import os
import subprocess

import pytest

from cliCase import ANIMATED, SECONDS, SMALL, AssertFails, Command, Result, Run, WriteStage

_WARNS = "".join(f'def Sphere "S{i}" {{ rel material:binding = </None> }}\n' for i in range(3))
_FRAMES = ["-f", "1:3", "--verbose"]


def _Left():
    """The end to write to of a pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    return os.fdopen(writing, "wb")


def _Full():
    return open("/dev/full", "wb")  # pylint: disable=consider-using-with


@pytest.mark.parametrize("Stream", [_Left, _Full])
@pytest.mark.parametrize("names", [("stdout",), ("stderr",), ("stdout", "stderr")], ids=" ".join)
def test_streams_that_take_nothing_end_no_render(tmp_path, Stream, names):
    stage = WriteStage(tmp_path, ANIMATED + _WARNS)
    command = Command("record", stage, tmp_path / "o.#.exr", *SMALL, *_FRAMES)
    with Stream() as stream:
        taken = dict.fromkeys(names, stream)
        done = subprocess.run(command, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **taken}, env={**os.environ, "HDSTREAM_PROGRESS": "1"},
                              text=True, timeout=SECONDS)
    assert done.returncode == 0, (done.stdout, done.stderr)
    assert len(list(tmp_path.glob("o.?.exr"))) == 3
    assert "Traceback" not in f"{done.stdout}{done.stderr}"


def test_what_was_asked_for_and_cannot_be_written_is_told(tmp_path):
    stage = WriteStage(tmp_path)
    with _Full() as stream:
        done = subprocess.run(Command("info", stage), stdout=stream, stderr=subprocess.PIPE, text=True, timeout=SECONDS)
    AssertFails(Result(done.returncode, "", done.stderr), 1, "No space left on device")


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)], ids=str)
def test_streams_that_are_closed(tmp_path, closed):
    """The picture is the one of open streams, and nothing that is said goes into a file."""
    stage = WriteStage(tmp_path, ANIMATED + _WARNS)
    assert Run("record", stage, tmp_path / "expected.exr", *SMALL).code == 0

    def Close():
        for number in closed:
            os.close(number)

    done = subprocess.run(Command("record", stage, tmp_path / "o.exr", *SMALL), preexec_fn=Close, capture_output=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "o.exr").read_bytes() == (tmp_path / "expected.exr").read_bytes()
    assert (2 in closed) or b"</None>" in done.stderr or b"does not exist" in done.stderr


def test_letters_that_the_locale_lacks_are_escaped(tmp_path):
    """Names of prims are UTF-8, whatever the terminal takes."""
    stage = WriteStage(tmp_path, ANIMATED + 'def Camera "Größe_木" {}\n')
    done = Run("info", stage, environment={"PYTHONIOENCODING": "ascii"})
    assert done.code == 0 and not done.errors, done.text
    assert "/Gr\\xf6\\xdfe_\\u6728" in done.out


@pytest.mark.parametrize("command", [["info", "s.usda"], ["record", "s.usda", "o.exr", *SMALL]], ids=["info", "record"])
def test_a_working_folder_that_is_not_utf8_is_named(tmp_path, command):
    folder = os.fsencode(tmp_path) + b"/bad\xff"
    os.mkdir(folder)
    WriteStage(tmp_path).rename(tmp_path / "s.usda")
    os.rename(tmp_path / "s.usda", folder + b"/s.usda")
    AssertFails(Run(*command, cwd=folder), 2, "bad\\udcff", "not UTF-8")


def test_a_working_folder_from_which_nothing_is_named_may_have_any_name(tmp_path):
    folder = os.fsencode(tmp_path) + b"/bad\xff"
    os.mkdir(folder)
    stage, image = WriteStage(tmp_path), tmp_path / "o.exr"
    for command in (["info", stage], ["record", stage, image, *SMALL], ["compare", image, image], ["devices"]):
        done = Run(*command, cwd=folder)
        assert done.code == 0 and not done.errors, done.text
