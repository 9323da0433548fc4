# SPDX-License-Identifier: Apache-2.0
"""The suite's own counting: no failure may get lost between a test program and the closing line."""

import pathlib
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import runSuite  # noqa: E402
from runSuite import Counts, Outcome, ReadJUnit, RunReporting, RunStages  # noqa: E402
from suiteReport import CpuSecondsByFile, NotRunLines  # noqa: E402

GOOGLETEST = """<testsuites tests="4" failures="1" disabled="1" errors="0"><testsuite name="A">
<testcase name="Passes" status="run" result="completed"/>
<testcase name="Fails" status="run" result="completed"><failure message="one"/><failure message="two"/></testcase>
<testcase name="IsSkipped" status="run" result="skipped"><skipped message="/a/test.cpp:5&#x0A;SKIPPED: no\nscreen"/></testcase>
<testcase name="DISABLED_IsOff" status="notrun" result="suppressed"/>
</testsuite></testsuites>"""
PYTEST = """<testsuites><testsuite name="pytest" errors="1" failures="1" skipped="1" tests="4">
<testcase name="a"/><testcase name="b"><failure/></testcase><testcase name="c"><error/></testcase>
<testcase name="d"><skipped type="pytest.skip" message="no mitsuba">test_d.py:3: no mitsuba</skipped></testcase>
<testcase name="test_e"><skipped message="collection skipped">('test_e.py', 2, "Skipped: could not import 'e'")</skipped>
</testcase><testcase name="f"><skipped type="pytest.xfail" message=""/></testcase></testsuite></testsuites>"""


@pytest.mark.parametrize("text, counts, reasons", [
    (GOOGLETEST, Counts(1, 1, 2), ["no screen", "it is disabled"]),
    (PYTEST, Counts(1, 2, 3), ["no mitsuba", "could not import 'e'", "pytest.xfail"])])
def test_cases_are_counted_once_each_and_skips_keep_their_reasons(text, counts, reasons, tmp_path):
    (tmp_path / "report.xml").write_text(text)
    assert ReadJUnit(tmp_path / "report.xml") == (counts, reasons)


def test_cpu_seconds_of_files_are_those_of_their_tests_and_processes(tmp_path):
    work = "import time\nend = time.process_time() + {}\nwhile time.process_time() < end: pass\n"
    (tmp_path / "conftest.py").write_text((runSuite.TESTENV / "conftest.py").read_text()
                                          .replace("__file__", repr(str(runSuite.TESTENV / "conftest.py"))))
    (tmp_path / "test_busy.py").write_text(f"""import subprocess, sys, time, pytest
@pytest.fixture(scope="module")
def busy():
    exec({work.format(0.2)!r})
def test_a(busy): pass
def test_b(): subprocess.run([sys.executable, "-c", {work.format(0.3)!r}])
""")
    (tmp_path / "test_idle.py").write_text("def test_c(): pass\ndef test_d(): assert False\n")
    report = tmp_path / "report.xml"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", tmp_path, f"--junitxml={report}"]
    outcome = RunReporting(command, report, None, "stage")
    assert outcome.counts == Counts(3, 1, 0)
    assert outcome.files.keys() == {"stage/test_busy", "stage/test_idle"}
    assert outcome.files["stage/test_busy"] >= 0.5 and sum(outcome.files.values()) <= outcome.cpu
    report.write_text("""<a><testcase classname="S" time="1.5"/><testcase classname="S" time="2"/><testcase classname="T/0"/></a>""")
    assert CpuSecondsByFile("device", report) == {"device/S": 3.5, "device/T/0": 0.0}


@pytest.mark.parametrize("program, counts", [
    ("import os; os.abort()", Counts(0, 1, 0)),  # dies before it reports
    ("import sys; sys.exit(1)", Counts(0, 1, 0)),
    ("open(sys.argv[1], 'w').write('<testsuites><testcase/>')", Counts(0, 1, 0)),  # dies while it reports
    ("open(sys.argv[1], 'w').write('<a><testcase/></a>'); sys.exit(3)", Counts(1, 1, 0)),  # dies after it
    ("open(sys.argv[1], 'w').write('<a><testcase/></a>')", Counts(1, 0, 0)),
    ("open(sys.argv[1], 'w').write('<a/>'); sys.exit(5)", Counts(0, 0, 0)),  # pytest found nothing for -k
])
def test_a_bad_end_is_a_failure(program, counts, tmp_path):
    report = tmp_path / "report.xml"
    assert RunReporting([sys.executable, "-c", "import sys; " + program, str(report)], report, None).counts == counts


def test_stages_of_several_jobs_are_all_counted_and_shown(capsys):
    stages = {f"s{i}": {f"s{i}": lambda i=i: Outcome(Counts(i, i % 2, 1), "what went wrong" if i == 3 else "")}
              for i in range(6)}
    assert RunStages(stages, 3) == (Counts(15, 3, 6), {f"s{i}": [] for i in range(6)}, {})
    output = capsys.readouterr().out
    assert all(f"s{i} " in output for i in range(6)) and "s3:\nwhat went wrong\ns3 " in output


def test_parts_of_a_stage_are_one_line_and_the_longest_start_first(capsys, monkeypatch):
    monkeypatch.setattr(runSuite, "LONGEST", ("b/slow", "b"))
    started = []
    Part = lambda name, *outcome: lambda: started.append(name) or Outcome(*outcome)
    stages = {"a": {"a": Part("a", Counts(1, 0, 0), "")},
              "b": {"b/slow": Part("b/slow", Counts(2, 1, 0), "oh", (), 1.5, {"b/slow": 1.5}),
                    "b": Part("b", Counts(4, 0, 1), "", ["why"], 2.0, {"b/one": 0.5, "b/two": 1.5})}}
    assert RunStages(stages, 1) == (Counts(7, 1, 1), {"a": [], "b": ["why"]}, {"b/slow": 1.5, "b/one": 0.5, "b/two": 1.5})
    assert started == ["b/slow", "b", "a"]
    lines = capsys.readouterr().out.split("\n")
    assert [line.split()[:6] for line in lines if line.startswith("b ")] == [["b", "6", "passed", "1", "failed", "1"]]
    assert any("3.5 s of CPU time" in line for line in lines) and "oh" in lines


def test_parts_hold_every_test_once():
    """A part takes exactly what the rest leaves out; the files that are parts are there."""
    taken = [part for part in runSuite.LONGEST if "/" in part]
    assert len(set(runSuite.LONGEST)) == len(runSuite.LONGEST)
    found = []
    for stage in runSuite.PytestFolders():
        parts = runSuite.FolderParts(stage, "")
        rest = [str(word) for word in parts.pop(stage)]
        assert str(runSuite.TESTENV / stage) in rest
        for part, command in parts.items():
            assert command[-1] == runSuite.TESTENV / part and command[-1].is_file()
            assert f"--ignore={command[-1]}" in rest
        assert len(parts) == sum(word.startswith("--ignore") for word in rest)
        found += parts
    for stage in runSuite.PROGRAMS:
        parts = runSuite.ProgramParts(stage, "program", "")
        rest = parts.pop(stage)[-1]
        assert rest == "--gtest_filter=-" + ":".join(command[-1].partition("=")[2] for command in parts.values())
        found += parts
    assert sorted(found) == sorted(taken)


def test_a_hanging_program_is_stopped_and_its_output_kept(monkeypatch):
    monkeypatch.setattr(runSuite, "STAGE_LIMIT_SECONDS", 0.5)
    code, output, _ = runSuite.RunQuietly([sys.executable, "-c", "print('before', flush=True); import time; time.sleep(60)"], None)
    assert code != 0 and "before" in output and "stopped after 0.5 s" in output


def test_every_area_that_was_not_run_is_named_with_its_reason():
    lines = NotRunLines({"format": "no clang-format", "unit": "not asked for", "stat": "not asked for"},
                        {"render": ["no mitsuba", "no mitsuba", "no wind"], "device": [], "hydra": ["usdview: no X"]})
    assert lines == ["Not run:", "  format: no clang-format", "  unit, stat: not asked for",
                     "  live oracles: 2 tests of render: no mitsuba", "  render: 1 test: no wind",
                     "  usdview: 1 test of hydra: usdview: no X"]
    assert NotRunLines({}, {"render": []}) == ["Not run: nothing, every area was."]


def test_stages_that_lack_what_they_need_are_named_and_missing_programs_fail(tmp_path, monkeypatch):
    monkeypatch.setattr(runSuite.shutil, "which", lambda name: None)
    stages, absent = runSuite.Stages(tmp_path, "", {}, tmp_path, {})
    assert absent.keys() == {"format", "hydraHost"}
    assert all(run().counts == Counts(0, 1, 0) for run in stages["unit"].values())  # only the one of Hydra may be missing
    stages, absent = runSuite.Stages(tmp_path, "Word", {}, tmp_path, {})
    assert absent.keys() == {"layers", "format", "hydraHost"} and not absent.keys() & stages.keys()


def test_processes_of_parts_find_modules_compiled(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    package = tmp_path / "python" / "hdstream"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    run = subprocess.run([sys.executable, "-c", "import hdstream; print(hdstream.__cached__)"], capture_output=True, text=True,
                         env=runSuite.Environment(tmp_path, str(tmp_path)))
    assert pathlib.Path(run.stdout.strip()).is_file(), run.stderr


def test_the_block_stands_before_the_counts_which_are_last(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["test", "--build", str(tmp_path), "layers"])
    assert runSuite.Main() == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "1 passed, 0 failed, 0 skipped"
    block = lines[lines.index("Not run:"):-1]
    assert any("unit, " in line and line.endswith(": not asked for") for line in block)
    assert any(line.startswith("  hydraHost: ") for line in block)
