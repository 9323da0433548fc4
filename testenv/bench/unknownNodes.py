# SPDX-License-Identifier: Apache-2.0
"""Nodes of the package MaterialX's libraries that hdStream does not know: unknownNodes.py [--all].

Every node definition feeds a surface of its own, or is one, in one stage, which is drawn with one sample; those whose
definition a warning calls unknown are printed, by group. --all also prints those that are known. BSDF, EDF and VDF nodes
are not asked, since surfaces put together of them are not drawn.
"""

import argparse
import pathlib
import re
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "render")]

import MaterialX  # noqa: E402
from pxr import Sdf, UsdShade  # noqa: E402
from stages import author, shapes  # noqa: E402
from stages.materialX import AddNode  # noqa: E402

import hdstream  # noqa: E402

_PATTERNS = ("float", "integer", "boolean", "color3", "color4", "vector2", "vector3", "vector4", "multioutput", "matrix33", "matrix44")


def _Definitions() -> list:
    """(group, node, id) of what could feed a surface or is one."""
    library = MaterialX.createDocument()
    MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library)
    kept = (*_PATTERNS, "surfaceshader")
    return sorted((d.getNodeGroup(), d.getNodeString(), d.getName(), d.getType()) for d in library.getNodeDefs() if d.getType() in kept)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    definitions = _Definitions()
    with tempfile.TemporaryDirectory() as folder:
        stage = author.NewStage(f"{folder}/stage.usda")
        for i, (_, _, identifier, kind) in enumerate(definitions):
            material = UsdShade.Material.Define(stage, f"/World/Looks/M{i}")
            if kind == "surfaceshader":
                surface = AddNode(stage, f"/World/Looks/M{i}/Node", identifier, Sdf.ValueTypeNames.Token)[0]
            else:
                node = AddNode(stage, f"/World/Looks/M{i}/Node", identifier)
                surface = AddNode(stage, f"/World/Looks/M{i}/Surface", "ND_surface_unlit", Sdf.ValueTypeNames.Token,
                                  emission_color=node)[0]
            material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))
            author.AddMesh(stage, f"/World/Ball{i}", shapes.Plane(1, 1), material=material)
        author.AddCamera(stage)
        stage.GetRootLayer().Save()
        lines = []
        renderer = hdstream.Renderer(f"{folder}/stage.usda", onWarning=lines.append)
        renderer.Prepare(imageWidth=4, imageHeight=4, samples=1)
    unknown = {int(found) for line in lines if "not supported" in line for found in re.findall(r"/World/Looks/M(\d+)", line)}
    known = {}
    for i, (group, node, identifier, _) in enumerate(definitions):
        known.setdefault((group, node), []).append((i not in unknown, identifier))
    for (group, node), states in sorted(known.items()):
        if options.all or not all(state for state, _ in states):
            word = "known" if all(state for state, _ in states) else "unknown"
            print(f"{word:<8} {group:<14} {node:<28} {' '.join(i for state, i in states if not state)[:80]}")
    print(f"{sum(all(s for s, _ in states) for states in known.values())} of {len(known)} nodes are known")
    return 0


if __name__ == "__main__":
    sys.exit(main())
