# SPDX-License-Identifier: Apache-2.0
"""Fuzzing in short: some cases of each kind from fixed seeds, in worker processes (testenv/bench/fuzz.py runs as many as there
is time for). A finding fails with its folder's text; what had been found has a test of its own beside what was wrong."""

import random

import pytest

pytest.importorskip("hdstream._core")

import byteMutation
import textMutation
from driver import Fuzzer
from kinds import KINDS
from stages import fuzzBase


@pytest.mark.parametrize("kind, count", [("usd", 16), ("image", 10), ("cache", 3), ("commandline", 40), ("settings", 10),
                                         ("ies", 8), ("materialX", 4), ("volume", 12)])
def test_nothing_is_found(kind, count, tmp_path):
    assert kind in KINDS
    fuzzer = Fuzzer(kind, 7, tmp_path)
    fuzzer.RunCount(count)
    assert fuzzer.numCases == count
    assert not fuzzer.findings, "\n".join((finding.folder / "finding.txt").read_text() for finding in fuzzer.findings)


def test_crashes_and_exits_are_found(tmp_path):
    """The driver itself: what ends a worker is a finding with its files, and the next case has a new worker."""
    fuzzer = Fuzzer("selfTest", 1, tmp_path)
    fuzzer.RunCount(5)
    assert [(finding.number, finding.wrong.split(",")[0]) for finding in fuzzer.findings] == [
        (1, "the process ended: SIGSEGV"), (2, "the process ended: exit code 3"), (3, "wrong")]
    assert all((finding.folder / "case.txt").read_text() == str(finding.number) for finding in fuzzer.findings)
    assert fuzzer.numCases == 5


def test_samples_that_are_not_finite_are_found(tmp_path, monkeypatch):
    """In the statistics, since pictures show them black: of any command that records."""
    import fuzzKind
    import judge

    monkeypatch.chdir(tmp_path)
    stage = tmp_path / "stage.usda"
    stage.write_text('#usda 1.0\ndef Camera "main_cam" {}\ndef SphereLight "Lamp" {}\n')
    kind = fuzzKind.Kind(tmp_path, 1)
    small = ("--imageWidth", 4, "--samples", 1)
    assert kind.Record(stage.name, *small) == ""
    files = list(tmp_path.glob(judge.STATISTICS_PATTERN))
    assert len(files) == 1 and judge.SampleVerdict(files[0].read_text()) == ""
    statistics = files[0].read_text().replace('"nanSamples": 0', '"nanSamples": 3')
    assert judge.SampleVerdict(statistics) == "3 samples are not finite"
    files[0].write_text(statistics)
    arguments = ["record", stage.name, "out.exr", "--stats", judge.STATISTICS]
    assert judge.Verdict(0, "", arguments) == "3 samples are not finite"
    files[0].unlink()
    assert judge.Verdict(0, "", arguments) == "exit code 0 without statistics"


def test_a_hang_is_found(tmp_path, monkeypatch):
    import driver

    monkeypatch.setattr(driver, "CPU_SECONDS", 1)
    fuzzer = Fuzzer("selfTest", 1, tmp_path)
    assert fuzzer.RunCase(100).startswith("hangs")
    assert fuzzer.RunCase(0) == ""
    fuzzer.Close()


def test_mutations_are_repeatable_and_change_something():
    texts = fuzzBase.Texts()
    mutated = [textMutation.Mutated(texts[0], random.Random(f"1-{n}"), texts) for n in range(50)]
    assert mutated == [textMutation.Mutated(texts[0], random.Random(f"1-{n}"), texts) for n in range(50)]
    assert sum(text != texts[0] for text in mutated) > 40 and len(set(mutated)) > 40
    data = bytes(range(256)) * 8
    assert len({byteMutation.Mutated(data, random.Random(n)) for n in range(50)}) > 45
    assert byteMutation.Mutated(b"", random.Random(1)) == b""
