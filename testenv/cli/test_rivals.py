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

import rivalsMeasure  # noqa: E402
import rivalsScene  # noqa: E402
import stageReader  # noqa: E402
from stages import author, bench, shapes  # noqa: E402


def test_fits_recover_what_was_put_in():
    samples = [2, 4, 8, 16]
    fixed, perSample = rivalsMeasure.FitSeconds(samples, [0.7 + 0.03 * n for n in samples])
    assert (fixed, perSample) == pytest.approx((0.7, 0.03))
    assert rivalsMeasure.FitSeconds(samples, [0.03 * n for n in samples]) == pytest.approx((0.0, 0.03), abs=1e-9)
    assert rivalsMeasure.FitError(samples, [0.4 * n**-1.2 for n in samples]) == pytest.approx((0.4, 1.2))


def test_a_ladder_must_be_longer_than_what_a_render_costs_by_itself():
    assert rivalsMeasure.IsLongEnough([2, 8, 32], [0.5 + 0.03 * n for n in (2, 8, 32)])
    assert not rivalsMeasure.IsLongEnough([2, 8, 32], [20 + 0.2 * n for n in (2, 8, 32)])
    assert rivalsMeasure.IsLongEnough([32, 128, 512], [20 + 0.2 * n for n in (32, 128, 512)])


def test_error_is_free_of_the_references_noise():
    """A reference of twice the picture's variance: the plain relMSE would be three times too large."""
    rng = np.random.default_rng(1)
    truth = np.full((200, 300, 3), 0.5)
    noisy = lambda sigma: truth + rng.normal(0, sigma, truth.shape)
    halves = (noisy(0.02), noisy(0.02))
    error, trimmed = rivalsMeasure.Errors(noisy(0.01), halves)
    assert error == pytest.approx(0.01**2 / (0.25 + 0.01), rel=0.1)
    assert trimmed < error
    ratio, difference = rivalsMeasure.Bias((noisy(0.02) * 1.1, noisy(0.02) * 1.1), halves)
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


def test_what_is_not_the_same_to_all_is_refused(tmp_path):
    path = str(tmp_path / "glow.usda")
    stage = author.NewStage(path)
    glow = author.AddMaterial(stage, "/World/Looks/Glow", emissiveColor=(2.0, 1.0, 0.5))
    author.AddMesh(stage, "/World/Plane", shapes.Plane(1, 1), material=glow)
    author.AddCamera(stage, eye=(0, 1, 3))
    stage.GetRootLayer().Save()
    with pytest.raises(ValueError, match="/World/Looks/Glow.*emissiveColor"):
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
    assert errors("hdstream") == errors("hdstream 100%") == errors("hdstream 30%")  # the same bits
    assert errors("hdstream") == sorted(errors("hdstream"), reverse=True)
    table = run.stdout.split("references, hdstream against")[1].split("equal-error")[0].splitlines()
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
