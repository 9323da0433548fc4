# SPDX-License-Identifier: Apache-2.0
"""The suite's own counting: no failure may get lost between a test program and the closing line."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from runSuite import Counts, Outcome, ReadJUnit, RunReporting, RunStages  # noqa: E402

GOOGLETEST = """<testsuites tests="4" failures="1" disabled="1" errors="0"><testsuite name="A">
<testcase name="Passes" status="run" result="completed"/>
<testcase name="Fails" status="run" result="completed"><failure message="one"/><failure message="two"/></testcase>
<testcase name="IsSkipped" status="run" result="skipped"><skipped message="why"/></testcase>
<testcase name="DISABLED_IsOff" status="notrun" result="suppressed"/>
</testsuite></testsuites>"""
PYTEST = """<testsuites><testsuite name="pytest" errors="1" failures="1" skipped="1" tests="4">
<testcase name="a"/><testcase name="b"><failure/></testcase><testcase name="c"><error/></testcase>
<testcase name="d"><skipped type="pytest.skip"/></testcase></testsuite></testsuites>"""


@pytest.mark.parametrize("text, counts", [(GOOGLETEST, Counts(1, 1, 2)), (PYTEST, Counts(1, 2, 1))])
def test_cases_are_counted_once_each(text, counts, tmp_path):
    (tmp_path / "report.xml").write_text(text)
    assert ReadJUnit(tmp_path / "report.xml") == counts


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
    stages = {f"s{i}": lambda i=i: Outcome(Counts(i, i % 2, 1), "what went wrong" if i == 3 else "") for i in range(6)}
    assert RunStages(stages, 3) == Counts(15, 3, 6)
    output = capsys.readouterr().out
    assert all(f"s{i} " in output for i in range(6)) and "s3:\nwhat went wrong\ns3 " in output
