# SPDX-License-Identifier: Apache-2.0
"""The comparison with other renderers: its numbers on data whose truth is known, its scene against the tests' own reader,
and one small run of the command with whatever renderers are installed."""

import csv
import pathlib
import subprocess
import sys

import numpy as np
import pytest

TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTENV), str(TESTENV / "bench"), str(TESTENV / "render")]

import rivalsLadder  # noqa: E402
import rivalsScene  # noqa: E402
import stageReader  # noqa: E402
from stages import author, bench, shapes  # noqa: E402


def test_a_ladder_knows_samples_and_seconds_between_its_rungs():
    """Two repeats of error = 0.4 / samples, which take 0.7 + 0.03 and 0.5 + 0.04 seconds a sample."""
    samples = [1, 2, 4, 8, 16]
    ladder = rivalsLadder.Ladder(samples, [0.4 / n for n in samples], [[0.7 + 0.03 * n for n in samples], [0.5 + 0.04 * n for n in samples]])
    assert ladder.fixed == pytest.approx([0.7, 0.5]) and ladder.perSample == pytest.approx([0.03, 0.04])
    assert ladder.SamplesTo(0.4 / 11) == pytest.approx(11)
    assert ladder.SecondsTo(0.4 / 11) == pytest.approx([1.03, 0.94])
    assert ladder.SamplingSecondsTo(0.4 / 11) == pytest.approx([0.33, 0.44])
    assert ladder.SamplesTo(1.0) == 1  # what one sample reaches costs one sample
    assert ladder.SecondsTo(0.4 / 30) == pytest.approx([1.6, 1.7])
    assert ladder.SamplesTo(0.4 / 33) is None and ladder.SecondsTo(0.4 / 33) is None  # more than twice the highest rung
    assert rivalsLadder.Ratio([2.0, 3.0, 1.0], [1.0, 1.0, 2.0]) == (2.0, 0.5, 3.0)
    assert rivalsLadder.Ratio(None, [1.0]) is None
    assert rivalsLadder.FitSeconds(samples, [0.03 * n for n in samples]) == pytest.approx((0.0, 0.03), abs=1e-9)


def test_a_ladder_ends_where_the_goal_is_reached_and_samples_take_the_time():
    assert not rivalsLadder.IsHighEnough([0.1, 0.3], error=0.02, goal=0.01, longest=60)
    assert rivalsLadder.IsHighEnough([0.1, 0.3], error=0.01, goal=0.01, longest=60)
    assert not rivalsLadder.IsHighEnough([20.0, 21.0], error=0.005, goal=0.01, longest=60)  # mostly what a render costs by itself
    assert rivalsLadder.IsHighEnough([20.0, 31.0], error=0.5, goal=0.01, longest=60)  # the next would take more than a minute


def test_error_is_free_of_the_references_noise():
    """A reference of twice the picture's variance: the plain relMSE would be three times too large."""
    rng = np.random.default_rng(1)
    truth = np.full((200, 300, 3), 0.5)
    noisy = lambda sigma: truth + rng.normal(0, sigma, truth.shape)
    halves = (noisy(0.02), noisy(0.02))
    error, trimmed = rivalsLadder.Errors(noisy(0.01), halves)
    assert error == pytest.approx(0.01**2 / (0.25 + 0.01), rel=0.1)
    assert trimmed < error
    ratio, difference = rivalsLadder.Bias((noisy(0.02) * 1.1, noisy(0.02) * 1.1), halves)
    assert ratio == pytest.approx(1.1, rel=1e-3)
    assert difference == pytest.approx(0.05**2 / 0.26, rel=0.1)


def _Centroids(triangles: np.ndarray) -> np.ndarray:
    """[n][3] of [n][3][3], in an order of its own."""
    rows = triangles.mean(1).round(4)
    return rows[np.lexsort(rows.T)]


def test_instances_stand_where_the_tests_reader_puts_them(tmp_path):
    path = tmp_path / "forest.usda"
    bench.WriteForest(str(path), instances=12, species=3, leaves=5)
    plain = rivalsScene.Read(path, "/World/Camera")
    assert plain.NumTriangles()[0] < plain.NumTriangles()[1]
    world = [(mesh.points[mesh.triangles] @ place[:3, :3] + place[3, :3]) for mesh in plain.meshes for place in mesh.places]
    expected = [part.positions for part in stageReader.ReadStage(path).parts]
    assert _Centroids(np.concatenate(world)) == pytest.approx(_Centroids(np.concatenate(expected)), abs=1e-3)


def _PlaneOf(path, **inputs) -> str:
    stage = author.NewStage(str(path))
    look = author.AddMaterial(stage, "/World/Looks/Look", **inputs)
    author.AddMesh(stage, "/World/Plane", shapes.Plane(1, 1), material=look)
    author.AddCamera(stage, eye=(0, 1, 3))
    stage.GetRootLayer().Save()
    return str(path)


def test_a_surface_that_glows_is_read(tmp_path):
    plain = rivalsScene.Read(_PlaneOf(tmp_path / "glow.usda", emissiveColor=(2.0, 1.0, 0.5)), "/World/Camera")
    assert plain.materials[plain.meshes[0].material]["emissiveColor"] == (2.0, 1.0, 0.5)


def test_what_is_not_the_same_to_all_is_refused(tmp_path):
    path = _PlaneOf(tmp_path / "cutOut.usda", opacityThreshold=0.5)
    with pytest.raises(ValueError, match="/World/Looks/Look.*opacityThreshold"):
        rivalsScene.Read(path, "/World/Camera")


def test_the_command_compares_what_is_installed(tmp_path):
    folders = ["--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache")]
    run = subprocess.run([sys.executable, str(TESTENV / "bench/rivals.py"), "--short", *folders], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    rows = list(csv.DictReader(open(tmp_path / "out/rivals.csv")))
    renderers = {row["renderer"] for row in rows}
    assert {"hdstream", "hdstream 100%", "hdstream 30%"} <= renderers
    for renderer in ("mitsuba scalar", "mitsuba llvm", "mitsuba preview", "cycles"):
        assert (renderer in renderers) == (f"not installed: {renderer}" not in run.stdout)
    errors = lambda renderer: [float(row["relMSE"]) for row in rows if row["renderer"] == renderer]
    upTo = next(i for i, error in enumerate(errors("hdstream")) if error <= 5e-3) + 1  # higher rungs are there when these are fast
    assert upTo >= 3
    assert errors("hdstream")[:upTo] == errors("hdstream 100%")[:upTo] == errors("hdstream 30%")[:upTo]  # the same bits
    assert errors("hdstream") == sorted(errors("hdstream"), reverse=True)
    table = run.stdout.split("references, hdstream against")[1].split("hdstream / the others")[0].splitlines()
    ratios = [float(line.split("|")[3]) for line in table if line.startswith("| ") and "ratio" not in line]
    assert len(ratios) == len(renderers) and all(abs(ratio - 1) < 0.02 for ratio in ratios)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"rivals.csv", "rivals-smallForest.csv", "rivals-smallForest.svg",
                                                                    "rivals-smallForest-sheet.png"}


@pytest.mark.parametrize("arguments, words", [
    (["--stages", "nowhere"], "no stage nowhere"), (["--stages", "chess"], "chess needs --scenes"),
    (["--stages", "chess", "--scenes", "nothing"], "there is no nothing/chess"), (["--renderers", "toaster"], "no renderer toaster")])
def test_wrong_use_is_one_line(arguments, words, tmp_path):
    run = subprocess.run([sys.executable, str(TESTENV / "bench/rivals.py"), *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 2
    assert words in run.stderr.splitlines()[-1]


def test_block_error_sees_means_and_not_noise():
    """Two pictures of one mean differ by their noise over 8; a factor of 1.1 differs by 0.1 / 1.05."""
    import comparison

    rng = np.random.default_rng(3)
    flat = np.full((96, 128, 3), 0.4)
    assert comparison.BlockError(flat + rng.normal(0, 0.04, flat.shape), flat) == pytest.approx(0.1 / 8, rel=0.1)
    assert comparison.BlockError(1.1 * flat, flat) == pytest.approx(0.1 / 1.05, rel=1e-6)


def test_lobe_bands_are_cosines():
    """A ball whose brightness is the cosine: the mean over a band's area is 2/3 (b^3 - a^3) / (b^2 - a^2)."""
    import lobes

    at = (np.arange(400) + 0.5) / 200 - 1
    cosine = np.sqrt(np.maximum(1 - at[:, None] ** 2 - at[None, :] ** 2, 0))
    expected = [2 / 3 * (b**3 - a**3) / (b**2 - a**2) for a, b in lobes._BANDS]
    assert lobes.Bands(np.repeat(cosine[..., None], 3, -1)) == pytest.approx(expected, rel=5e-3)
