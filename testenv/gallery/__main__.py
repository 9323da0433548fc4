# SPDX-License-Identifier: Apache-2.0
"""Renders the pictures of docs/gallery.md: gallery [NAME...] [--out FOLDER] [--short] [--stageOnly]

For each name (all without any) writes a stage and its images to FOLDER/stages/NAME, renders it by `hdstream record` to
FOLDER/images/gallery/NAME.jpg and puts picture, command and figures into FOLDER/gallery.md. `--out docs` renews
docs/gallery.md; the default is out/gallery. `--short`: hundredths of the content, thumbnails; it shows that all of it works.
"""

import argparse
import importlib
import json
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

TESTENV = pathlib.Path(__file__).resolve().parents[1]
ROOT = TESTENV.parent
sys.path.insert(0, str(TESTENV))

from bench import performancePage  # noqa: E402

_COMMON = ["--camera", "/World/Camera", "--imageWidth", "512"]
# Options of each picture besides those; of galaxy no --denoise, which takes stars for noise.
PICTURES = {
    "forest": ["--samples", "5", "--maxDepth", "4", "--denoise"],
    "mountains": ["--samples", "8", "--maxDepth", "4", "--denoise"],
    "creatures": ["--samples", "10", "--maxDepth", "6", "--denoise"],
    "materials": ["--samples", "8", "--maxDepth", "10", "--denoise"],
    "pawns": ["--samples", "24", "--maxDepth", "12", "--denoise"],
    "city": ["--samples", "10", "--maxDepth", "3", "--denoise"],
    "museum": ["--samples", "8", "--maxDepth", "6", "--denoise", "--textureMemory", "4M"],
    "macro": ["--samples", "6", "--maxDepth", "5", "--denoise"],
    "tops": ["--samples", "24", "--maxDepth", "6", "--denoise"],
    "galaxy": ["--samples", "16", "--maxDepth", "1"],
}
_SHORT = ["--imageWidth", "48", "--samples", "2"]
_SHORT_SIZE = 0.02


def WriteStage(name: str, folder: pathlib.Path, size: float = 1.0) -> pathlib.Path:
    """Path of the stage, which is made in `folder` with its images."""
    folder.mkdir(parents=True, exist_ok=True)
    importlib.import_module(f"gallery.{name}").Write(folder, size)
    return folder / "stage.usdc"


def _Figures(statistics: dict, seconds: float) -> str:
    """One line of the statistics of a render."""
    geometry, texture, image = statistics["geometry"], statistics["texture"], statistics["image"]
    shapes = [f"{geometry[kind]:,} {kind}".replace(",", " ") for kind in ("triangles", "curves", "points") if geometry[kind]]
    if geometry["instances"] > 1000:
        shapes.append(f"{geometry['instances']:,} instances".replace(",", " "))
    if texture["bytesSource"] > 1 << 20:
        shapes.append(f"{texture['textures']} textures of {texture['bytesSource'] / 2**20:.0f} MiB")
    megabytes = lambda value: f"{value / 2**20:.0f} MiB"
    return (f"{', '.join(shapes)}. Device memory at most {megabytes(statistics['memory']['devicePeak'])}, "
            f"process {megabytes(statistics['memory']['hostPeak'])}; {image['width']} x {image['height']}, "
            f"{image['samples']} samples, {seconds:.0f} s of rendering.")


def Render(name: str, stage: pathlib.Path, picture: pathlib.Path, isShort: bool) -> dict:
    """Statistics of `hdstream record`, whose messages go where ours do. Raises CalledProcessError."""
    with tempfile.TemporaryDirectory() as folder:
        statistics = pathlib.Path(folder) / "statistics.json"
        options = [option for option in PICTURES[name] if not isShort or option != "--denoise"]
        command = [sys.executable, "-m", "hdstream", "record", str(stage), str(picture), *_COMMON, *options,
                   *(_SHORT if isShort else ()), "--stats", str(statistics)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return json.loads(statistics.read_text())


def Block(name: str, statistics: dict) -> str:
    """What the page shows of a picture."""
    options = shlex.join([*_COMMON, *PICTURES[name]])
    time = statistics["time"]
    return (f"![{name}](images/gallery/{name}.jpg)\n\n"
            f"<!-- not run: takes minutes; testenv/docs/test_gallery.py runs short forms -->\n\n"
            f"    scripts/gallery {name}    # hdstream record stage.usdc {name}.jpg {options}\n\n"
            f"{_Figures(statistics, time['render'])}\n")


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/gallery", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", metavar="NAME", nargs="*", help=" ".join(PICTURES))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "gallery")
    parser.add_argument("--short", action="store_true", help="little content, thumbnails")
    parser.add_argument("--stageOnly", action="store_true", help="write the stages, render nothing")
    args = parser.parse_args()
    for name in args.names:
        if name not in PICTURES:
            parser.error(f"no picture '{name}'; there are: {' '.join(PICTURES)}")
    page, images = args.out / "gallery.md", args.out / "images" / "gallery"
    images.mkdir(parents=True, exist_ok=True)
    if not page.exists():
        shutil.copy(ROOT / "docs" / "gallery.md", page)
    stages = ROOT / "out" / "gallery" / "stages" if page.resolve() == ROOT / "docs" / "gallery.md" else args.out / "stages"
    for name in args.names or PICTURES:
        stage = WriteStage(name, stages / name, _SHORT_SIZE if args.short else 1.0)
        print(stage, flush=True)
        if args.stageOnly:
            continue
        picture = images / f"{name}.jpg"
        try:
            statistics = Render(name, stage, picture, args.short)
        except subprocess.CalledProcessError as error:
            return error.returncode
        page.write_text(performancePage.Replaced(page.read_text(encoding="utf-8"), name, Block(name, statistics)), encoding="utf-8")
        print(picture, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
