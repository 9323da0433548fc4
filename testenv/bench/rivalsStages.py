# SPDX-License-Identifier: Apache-2.0
"""The stages that renderers are compared on: generated ones, and real ones below a folder that is given."""

import pathlib
from dataclasses import dataclass

from stages import bench, grove, matter, rooms
from stages.verify import CASES


@dataclass(frozen=True)
class StageFile:
    name: str
    path: str
    camera: str
    maxDepth: int


_GENERATED = {
    "terrain": (bench.WriteTerrain, 4),
    # Dr.Jit traces what happens at an instance anew for each of them: with 20 000 Mitsuba's llvm variant takes minutes and gigabytes.
    "forest": (lambda path: bench.WriteForest(path, instances=1000, species=5), 4),
    "grove": (lambda path: grove.WriteGrove(path, triangles=2_000_000), 4),
    "cloud": (matter.WriteCloud, matter.MAX_DEPTH),
    "ink": (matter.WriteInk, matter.MAX_DEPTH),
    "jade": (matter.WriteJade, matter.MAX_DEPTH),
    "wax": (matter.WriteWax, matter.MAX_DEPTH),
    "skyRoom": (rooms.WriteSkyRoom, rooms.MAX_DEPTH),
    "sunRoom": (rooms.WriteSunRoom, rooms.MAX_DEPTH),
    "panelRoom": (rooms.WritePanelRoom, rooms.MAX_DEPTH),
    "smallForest": (lambda path: bench.WriteForest(path, instances=100, species=8, leaves=300), 3),
}
REAL = {  # name -> file below the folder of real scenes, camera
    "chess": ("chess/chess_preview.usda", "/Lights/camera"),
    "bookstore": ("bookstore/bookstore.usda", "/World/camera1_0"),
    "coffee": ("coffee/coffee.usdc", "/World/camera"),
    "ycb": ("ycb/ycb.usda", "/World/close"),
}
_REAL_DEPTH = 8
SHORT = ["smallForest"]
NAMES = [*REAL, *_GENERATED, *CASES]


def Default(scenes: str | None) -> list[str]:
    """All real stages where their folder is given, and the generated ones that stand for large scenes and for rooms."""
    return [*(REAL if scenes else ()), "grove", "skyRoom", "sunRoom", "panelRoom", "forest"]


def Make(name: str, scenes: str | None, folder: pathlib.Path) -> StageFile:
    """Writes a generated stage into the folder unless it is there, or finds a real one."""
    if name in REAL:
        file, camera = REAL[name]
        if not scenes:
            raise ValueError(f"stage {name} needs --scenes")
        path = pathlib.Path(scenes) / file
        if not path.is_file():
            raise ValueError(f"stage {name}: there is no {path}")
        return StageFile(name, str(path), camera, _REAL_DEPTH)
    path = folder / f"{name}.usdc"
    if name in CASES:
        if not path.exists():
            CASES[name].Write(str(path))
        return StageFile(name, str(path), "/World/Camera", CASES[name].maxDepth)
    if name not in _GENERATED:
        raise ValueError(f"no stage {name}; there are {', '.join(NAMES)}")
    write, maxDepth = _GENERATED[name]
    if not path.exists():
        write(str(path))
    return StageFile(name, str(path), "/World/Camera", maxDepth)
