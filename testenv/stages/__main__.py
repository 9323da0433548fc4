# SPDX-License-Identifier: Apache-2.0
"""`python testenv/stages NAME OUT` writes a stage: demo, terrain, forest, meshes, grove, materialBalls,
curveShapes, glass, hair, hairBalls, pointCloud, media, smoke, island, skyRoom, sunRoom, panelRoom, displacedBall,
gems, mirrorRoom, softboxes, wideSky
or a verification case.

OUT's extension (.usda, .usdc) chooses the format. `terrain`, `forest`, `meshes`, `grove`, `hair`, `hairBalls` and
`pointCloud` take a size as a third argument, and `island` a fraction (0.01, 0.1, 1), whose counts it prints. Without
arguments it lists the names.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from stages import bench, curves, demo, glass, grove, hair, island, materialX, media, rooms, smoke, smooth, subdivided  # noqa: E402
from stages.verify import CASES  # noqa: E402

_WRITERS = {"demo": demo.WriteDemo, "terrain": bench.WriteTerrain, "forest": bench.WriteForest, "meshes": bench.WriteMeshes,
            "grove": grove.WriteGrove, "materialBalls": materialX.WriteMaterialBalls, "media": media.WriteMedia,
            "smoke": smoke.WriteSmoke, "glass": glass.WriteGlass, "curveShapes": curves.WriteShapes,
            "hair": curves.WriteHair, "hairBalls": hair.WriteHairBalls, "pointCloud": curves.WritePointCloud, "island": island.WriteIsland,
            "skyRoom": rooms.WriteSkyRoom, "sunRoom": rooms.WriteSunRoom, "panelRoom": rooms.WritePanelRoom,
            "displacedBall": subdivided.WriteDisplacedBall, **smooth.WRITERS}


def main(arguments: list[str]) -> int:
    names = sorted(_WRITERS) + sorted(CASES)
    if len(arguments) < 2 or arguments[0] not in names:
        print("usage: python testenv/stages NAME OUT [SIZE]; names: " + " ".join(names), file=sys.stderr)
        return 2
    name, path = arguments[0], str(pathlib.Path(arguments[1]).resolve())
    size = [float(a) if name == "island" else int(a) for a in arguments[2:3]]
    if name in CASES:
        CASES[name].Write(path)
    else:
        counts = _WRITERS[name](path, *size)
        for what, count in counts.items() if name == "island" else ():
            print(f"{what}: {count:,}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
