# SPDX-License-Identifier: Apache-2.0
"""Time and traffic against memory budgets, for docs/memory-budgets.md: budgets.py --out FOLDER [--short]

Two stages: a grove, of which the camera sees nearly all trees, against --geometryMemory; a hall of paintings against
--textureMemory. In one process and for each budget: a render that begins with an empty pool, kernels and prepared pages being
there. Every picture must have the bits of the one with the largest budget. Writes the blocks of FOLDER/memory-budgets.md, and
tables (CSV) and charts (SVG) below FOLDER/images; `--out docs` renews docs/memory-budgets.md. The short form measures nothing.
"""

import argparse
import os
import pathlib
import shutil
import sys
import tempfile

TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTENV)]

from bench import performancePage  # noqa: E402
from bench.recordRun import FreshCache  # noqa: E402
from bench.sceneRun import Scene, TracingSeconds  # noqa: E402
from gallery import museum  # noqa: E402
from stages import grove  # noqa: E402
from support.svgChart import Chart  # noqa: E402

_PAGE = TESTENV.parent / "docs" / "memory-budgets.md"
_GEOMETRY = (100, 70, 50, 35, 25, 15, 10, 5)  # percent of all pages
_TEXTURES = (100, 30, 10, 3, 1, 0.5)
_HEAD = ["budget, % of all", "MiB", "seconds", "over 100 %", "loaded over unique"]


def Measure(scene: Scene, samples: int, kind: str, percentages, **settings) -> performancePage.Table:
    """A row a budget of `kind`, geometry or texture."""
    name = f"{kind}Memory"
    rows, pictures = [], set()
    # Prepares everything and builds the kernels; another budget, so that the first row has a new pool too.
    scene.Render(1, **settings, **{name: f"{percentages[-1]}%"})
    for percentage in percentages:
        picture, statistics = scene.Render(samples, **settings, **{name: f"{percentage}%"})
        pictures.add(picture.tobytes())
        seconds, about = TracingSeconds(statistics), statistics[kind]
        rows.append([percentage, about["budget"] / 2**20, seconds, seconds / rows[0][2] if rows else 1.0,
                     about["uploadedBytes"] / max(1, about["uniqueBytesLoaded"])])
    assert len(pictures) == 1, "the pictures differ"
    return performancePage.Table(f"budgets-{kind}", _HEAD, rows)


def Charts(kind: str, table: performancePage.Table) -> list:
    """Time and traffic against the budget."""
    budgets = [row[0] for row in table.rows]
    time = Chart(f"{kind}: time", f"--{kind}Memory, % of all", "time over that at 100 %")
    time.Add("time", budgets, [row[3] for row in table.rows])
    traffic = Chart(f"{kind}: traffic", f"--{kind}Memory, % of all", "bytes loaded over those needed once")
    traffic.Add("traffic", budgets, [row[4] for row in table.rows])
    return [(f"budgets-{kind}-time", time), (f"budgets-{kind}-traffic", traffic)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--short", action="store_true")
    args = parser.parse_args()
    pick = lambda full, short: short if args.short else full
    page = args.out / _PAGE.name
    args.out.mkdir(parents=True, exist_ok=True)
    if not page.exists():
        shutil.copy(_PAGE, page)
    samples, width = pick(64, 1), pick(320, 32)
    size = dict(imageWidth=width, imageHeight=width * 9 // 16, maxDepth=4)
    with tempfile.TemporaryDirectory() as text:
        folder = pathlib.Path(text)
        size["cacheDirectory"] = str(FreshCache(folder / "cache", os.environ.get("HDSTREAM_CACHE_DIR", "")))
        grove.WriteGrove(str(folder / "grove.usdc"), pick(1_000_000, 20_000), pick(grove.TREE_TRIANGLES, 2_000))
        museum.Write(folder, pick(0.5, 0.05))
        chunk = dict(chunkBytes=pick(1 << 20, 1 << 14))
        tables = {
            "geometry": Measure(Scene(folder / "grove.usdc", "/World/Camera", **size, **chunk), samples, "geometry",
                                pick(_GEOMETRY, (100, 50)), residency="stream"),
            "texture": Measure(Scene(folder / "stage.usdc", "/World/Camera", **size), samples, "texture",
                               pick(_TEXTURES, (100, 50)), residency="auto", prepare="eager"),
        }
    for kind, table in tables.items():
        block = performancePage.Block([*Charts(kind, table), table], args.out / "images", "images")
        page.write_text(performancePage.Replaced(page.read_text(encoding="utf-8"), kind, block), encoding="utf-8")


if __name__ == "__main__":
    main()
