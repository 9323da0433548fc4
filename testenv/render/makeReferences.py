# SPDX-License-Identifier: Apache-2.0
"""Makes the reference pictures of the verification cases with Mitsuba 3: makeReferences.py [CASE...]

Writes references/CASE.exr: channels R, G, B (mean, half floats) and V (variance of the mean of the
three channels' average). Needs mitsuba, usd-core and numpy; the tests that compare need none of Mitsuba.
"""

import pathlib
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import mitsubaScene  # noqa: E402
from stages.imageFile import WriteExr  # noqa: E402
from stages.verify import CASES  # noqa: E402


def main(names: list[str]) -> None:
    mitsubaScene.UseVariant()
    (HERE / "references").mkdir(exist_ok=True)
    for name in names or sorted(CASES):
        start = time.time()
        with tempfile.TemporaryDirectory() as folder:
            mean, variance = mitsubaScene.RenderReference(CASES[name].Write(f"{folder}/stage.usda"), CASES[name])
        channels = {c: mean[..., i] for i, c in enumerate("RGB")}
        channels["V"] = variance.mean(-1) * 1e6  # half floats have no 1e-8; the reader divides
        WriteExr(HERE / "references" / f"{name}.exr", channels)
        relMse = (variance / (mean * mean + 0.01)).mean()
        print(f"{name:24s} mean {mean.mean():.5f} noise relMSE {relMse:.1e} {time.time() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
