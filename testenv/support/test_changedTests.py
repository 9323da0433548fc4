# SPDX-License-Identifier: Apache-2.0
"""scripts/test --changed: every file of the tree has a rule, and every rule names tests that are there."""

import pathlib
import re
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import changedTests  # noqa: E402
import runSuite  # noqa: E402
from changedTests import ALWAYS, ROOT, RULES, TESTENV, Selection, Targets  # noqa: E402


def test_every_file_of_the_tree_has_a_rule_and_every_rule_a_file():
    done = subprocess.run(["git", "-C", str(ROOT), "ls-files"], capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("not a git checkout")
    paths = done.stdout.splitlines()
    for path in paths:
        Targets(path)  # raises KeyError
    patterns = [pattern for pattern, _ in RULES]
    unused = [pattern for pattern in patterns
              if not any(next(p for p in patterns if re.match(p, path)) == pattern for path in paths)]
    assert not unused


def test_rules_name_stages_and_tests_that_are_there():
    stages = {"layers", "format", *runSuite.PROGRAMS, *runSuite.PytestFolders()}
    assert set(ALWAYS) <= stages
    for _, targets in RULES:
        for target in targets:
            if "\\" not in target:
                assert target.partition("/")[0] in stages, target
                assert "/" not in target or (TESTENV / target).exists(), target


@pytest.mark.parametrize("paths, wanted", [
    (["kernels/light/select.clh"], {"device": "Light", "stat": "Light", "render": "test_identity.py"}),
    (["hdStream/texture/imageFile.cpp"], {"unit": "", "device": "Texture", "stream": "test_textureStreaming.py"}),
    (["hdStream/python/hdstream/translate/meshes.py"], {"translate": None, "python": "test_edits.py", "render": "test_identity.py"}),
    (["hdStream/hydra/mesh.cpp"], {"hydraHost": None, "hydra": "test_usdrecord.py"}),
    (["docs/lights.md"], {"docs": "test_documentedCommands.py", "cli": "test_settings.py"}),
    (["testenv/render/test_aovs.py", "testenv/translate/test_no.py"], {"render": "test_aovs.py"}),
    (["testenv/translate/test_cameras.py", "testenv/stages/author.py"], {"translate": None, "render": "test_identity.py"}),
    (["testenv/stages/author.py", "testenv/translate/test_cameras.py"], {"translate": None, "render": "test_identity.py"}),
    (["somethingNew.xyz"], {"unit": None, "translate": None}),
    ([], {}),
])
def test_what_a_change_runs(paths, wanted):
    chosen = Selection(paths)
    assert chosen.keys() == {*ALWAYS, *wanted}
    for stage, part in wanted.items():
        assert (chosen[stage] is None) == (part is None)
        assert part is None or any(part in name for name in chosen[stage])


def test_a_layers_suites_are_those_of_its_files():
    chosen = Selection(["testenv/unit/texture/testImageFile.cpp"])["unit"]
    text = (TESTENV / "unit" / "texture" / "testImageFile.cpp").read_text()
    suite = text.split("TEST")[1].split("(")[1].split(",")[0]
    assert f"{suite}.*" in chosen and f"*/{suite}.*" in chosen
    assert len(chosen) < 2 * 40  # a layer's, not all


def test_files_of_commits_of_the_working_tree_and_new_ones_are_found(tmp_path, monkeypatch):
    def Git(*words):
        subprocess.run(["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b", *words], check=True,
                       capture_output=True)

    Git("init", "-b", "main")
    for name in ("same", "committed", "edited"):
        (tmp_path / name).write_text("1")
    Git("add", ".")
    Git("commit", "-m", "first")
    Git("checkout", "-b", "work")
    (tmp_path / "committed").write_text("2")
    Git("commit", "-am", "second")
    (tmp_path / "edited").write_text("2")
    (tmp_path / "new").write_text("1")
    monkeypatch.setattr(changedTests, "ROOT", tmp_path)
    assert changedTests.Files(changedTests.Base()) == ["committed", "edited", "new"]
    assert changedTests.Files("HEAD") == ["edited", "new"]
