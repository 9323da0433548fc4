# SPDX-License-Identifier: Apache-2.0
"""Nodes of the package MaterialX's libraries that hdStream does not know: unknownNodes.py [--all].

Every node definition that could feed a surface, or is one or a closure of one, is looked up in hdStream's registry of nodes;
those that are not there are printed, by group. --all also prints those that are.
"""

import argparse
import sys

import MaterialX

from hdstream import _core

_KINDS = ("float", "integer", "boolean", "color3", "color4", "vector2", "vector3", "vector4", "multioutput", "matrix33", "matrix44",
          "surfaceshader", "BSDF", "EDF", "VDF")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    library = MaterialX.createDocument()
    MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library)
    nodes = {}
    for definition in library.getNodeDefs():
        if definition.getType() in _KINDS:
            identifier = definition.getName()
            key = (definition.getNodeGroup(), definition.getNodeString())
            nodes.setdefault(key, []).append((_core.IsKnownShader(identifier), identifier))
    for (group, node), states in sorted(nodes.items()):
        unknown = " ".join(sorted(identifier for isKnown, identifier in states if not isKnown))
        if options.all or unknown:
            print(f"{'unknown' if unknown else 'known':<8} {group:<14} {node:<28} {unknown[:80]}")
    print(f"{sum(all(isKnown for isKnown, _ in states) for states in nodes.values())} of {len(nodes)} nodes are known")
    return 0


if __name__ == "__main__":
    sys.exit(main())
