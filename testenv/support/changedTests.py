# SPDX-License-Identifier: Apache-2.0
"""What a change can break: from the files that differ from a commit to the stages, folders and files of tests to run.

`scripts/test --changed [COMMIT]` uses it. It is a quick look before a commit, not a proof: the whole suite is the proof.
"""

import pathlib
import re
import subprocess

TESTENV = pathlib.Path(__file__).resolve().parent.parent
ROOT = TESTENV.parent
# Run whatever has changed.
ALWAYS = ("layers", "format", "support")

# A pattern of paths, and what to run; the first that matches a path decides. `stage` is a whole stage, `stage/file.py` a file
# of a pytest stage, `stage/layer` the tests of a layer in a GoogleTest program. \1 is what the pattern caught; layers that have
# no tests in a program are left out.
RULES = (
    # Tests and what they share.
    (r"testenv/(unit|device|stat)/(\w+)/", (r"\1/\2",)),
    (r"testenv/hydra/.*(\.cpp|\.h|CMakeLists\.txt)$", ("hydraHost",)),
    (r"testenv/(\w+)/(test\w*\.py)$", (r"\1/\2",)),
    (r"testenv/bench/.*rivals", ("cli/test_rivals.py",)),
    (r"testenv/bench/budgets", ("docs/test_memoryBudgets.py",)),
    (r"testenv/bench/fuzz", ("fuzz",)),
    (r"testenv/bench/", ("cli/test_performancePage.py",)),
    (r"testenv/gallery/", ("docs/test_gallery.py",)),
    (r"testenv/stages/", ("translate", "render/test_identity.py")),
    (r"testenv/support/.*\.(cpp|h)$", ("unit", "stat", "device/accel", "device/stream")),
    (r"testenv/support/(documented|notebook|settings)", ("docs/test_documentedCommands.py", "cli/test_settings.py", "python/test_docs.py")),
    (r"testenv/support/", ()),
    (r"testenv/render/", ("render/test_harness.py", "render/test_identity.py", "render/test_closed_form.py")),
    (r"testenv/stream/", ("stream/test_geometryStreaming.py", "stream/test_textureStreaming.py")),
    (r"testenv/(cli|docs|farm|fuzz|hydra|install|python|translate)/", (r"\1",)),
    (r"testenv/", ("translate",)),
    # The front ends.
    (r"hdStream/python/hdstream/translate/", ("translate", "python/test_edits.py", "render/test_identity.py")),
    (r"hdStream/python/hdstream/(farm\w*|resume|frameJob|filmSums)\.py$", ("farm",)),
    (r"hdStream/python/", ("python", "cli/test_usage.py", "cli/test_record.py", "cli/test_info.py", "cli/test_settings.py")),
    (r"hdStream/hydra/", ("hydraHost", "hydra/test_usdrecord.py")),
    # Layers, with what shows their work in pictures.
    (r"hdStream/(session)/", (r"unit/\1", r"device/\1", "cli/test_settings.py", "cli/test_statistics.py", "python")),
    (r"hdStream/(stream|accel|geometry)/", (r"unit/\1", r"device/\1", "stream/test_geometryStreaming.py")),
    (r"hdStream/(persist)/", (r"unit/\1", "stream/test_cacheDamage.py")),
    (r"hdStream/(texture)/", (r"unit/\1", r"device/\1", "stream/test_textureStreaming.py")),
    (r"(hdStream|kernels)/(volume)/", (r"unit/\2", "render/test_volumes.py")),
    (r"hdStream/(scene)/", ("unit/scene", "unit/geometry", "translate", "render/test_identity.py")),
    (r"hdStream/(film)/", (r"unit/\1", "device/session", "render/test_aovs.py")),
    (r"hdStream/(shading|integrator|device)/", (r"unit/\1", r"device/\1", r"stat/\1", "render/test_identity.py")),
    (r"hdStream/(base)/", ("unit", "render/test_identity.py")),
    # Kernels: pictures of both forms of everything, and the layer's own tests.
    (r"kernels/(film|shared)/", ("device/device", "device/integrator", "render/test_identity.py", "render/test_aovs.py")),
    (r"kernels/(\w+)/", (r"device/\1", r"stat/\1", "render/test_identity.py")),
    # Pages and what builds and packs.
    (r"docs/gallery\.md|docs/images/gallery/", ("docs/test_gallery.py", "docs/test_documentedCommands.py")),
    (r"docs/python\.(md|ipynb)$", ("python/test_docs.py", "docs/test_documentedCommands.py")),
    (r"docs/performance\.md$", ("cli/test_performancePage.py", "docs/test_documentedCommands.py")),
    (r"(docs/|README\.md)", ("docs/test_documentedCommands.py", "cli/test_settings.py")),
    (r"packaging/blender/|(packaging|scripts)/(blender|settingsTable)", ("install/test_blenderExtension.py", "hydra/test_blender.py")),
    (r"(scripts|packaging|\.ci)/|CHANGELOG\.md|pyproject\.toml", ("install/test_packaging.py", "install/test_scripts.py")),
    (r"cmake/|hdStream/CMakeLists\.txt|CMake|plugInfo\.json", ("unit", "install/test_findOpenUsd.py")),
    (r"(LICENSE|\.\w[\w-]*)$", ()),
)


def Base() -> str:
    """The commit that changes are counted from: where this branch left its upstream, or main, else the last commit."""
    for name in ("@{upstream}", "origin/main", "main"):
        found = _Git("merge-base", "HEAD", name)
        if found:
            return found[0]
    return "HEAD"


def Files(commit: str) -> list:
    """Paths that differ from the commit: in commits since, in the working tree, or not tracked yet."""
    return sorted({*_Git("diff", "--name-only", commit, "--"), *_Git("ls-files", "--others", "--exclude-standard")})


def _Git(*arguments) -> list:
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)
    return done.stdout.splitlines() if done.returncode == 0 else []


def Targets(path: str) -> list:
    """What a changed file asks for, as RULES writes it. Raises KeyError for a file that no rule knows."""
    for pattern, targets in RULES:
        found = re.match(pattern, path)
        if found:
            return [target for target in map(found.expand, targets) if _IsThere(target)]
    raise KeyError(path)


def _IsThere(target: str) -> bool:
    """False for a layer without tests in a program, and for a test file that is no more."""
    return "/" not in target or (TESTENV / target).exists()


def Selection(paths: list) -> dict:
    """Stage -> the tests to run in it, or None for all of them: names of files of a pytest stage, patterns of a GoogleTest
    program's suites. Files that no rule knows ask for all fast stages."""
    chosen = dict.fromkeys(ALWAYS)
    for path in paths:
        try:
            targets = Targets(path)
        except KeyError:
            targets = ["unit", "translate"]
        for target in targets:
            stage, _, part = target.partition("/")
            if not part:
                chosen[stage] = None
            elif chosen.get(stage, ()) is not None:
                chosen[stage] = sorted({*chosen.get(stage, ()), *([part] if part.endswith(".py") else _Suites(stage, part))})
    return chosen


def _Suites(program: str, layer: str) -> set:
    """Patterns of the suites of a layer's tests, also those with parameters."""
    texts = [path.read_text(encoding="utf-8") for path in (TESTENV / program / layer).glob("*.cpp")]
    names = {name for text in texts for name in re.findall(r"^TEST(?:_F|_P)?\((\w+),", text, re.MULTILINE)}
    return {f"{prefix}{name}.*" for name in names for prefix in ("", "*/")}
