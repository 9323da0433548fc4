"""Checks every #include against the order of layers (docs/architecture.md): CheckLayers.py ROOT.

Prints one line for each include that reaches around a layer and exits with 1 if there is any.
"""

import pathlib
import re
import sys

# A layer may include layers of lower rank; layers of one rank are siblings and never include each other.
RANKS = {
    "base": 1, "persist": 2, "device": 3, "stream": 4, "geometry": 5,
    "accel": 6, "texture": 6, "shading": 6, "volume": 7, "film": 7, "scene": 8,
    "integrator": 9, "session": 10, "hydra": 11, "python": 11,
}
# Inside kernels/ the same idea: leaves first, program roots last.
KERNEL_RANKS = {
    "shared": 0, "math": 1, "sample": 2, "stream": 3, "accel": 4, "texture": 4, "shading": 5, "light": 5,
    "volume": 6, "film": 6, "integrator": 7,
}
# Headers that only some layers may see.
MONOPOLIES = [
    (re.compile(r"^CL/"), {"device"}),
    (re.compile(r"^pxr/"), {"hydra"}),
    (re.compile(r"^OpenImageIO/"), {"texture", "film"}),
    (re.compile(r"^OpenColorIO/"), {"texture", "film"}),
    (re.compile(r"^opensubdiv/"), {"geometry"}),
    (re.compile(r"^openvdb/"), {"volume"}),
    (re.compile(r"^nanobind/"), {"python"}),
]
# The façade's own data types are part of it: a front end sees session/ and nothing else.
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]')


def includes(path):
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def check(root):
    errors = []
    for path in sorted((root / "hdStream").rglob("*")):
        if path.suffix not in {".h", ".cpp"}:
            continue
        layer = path.relative_to(root / "hdStream").parts[0]
        for number, target in includes(path):
            where = f"{path.relative_to(root)}:{number}: {layer} includes {target}"
            if target.startswith("hdStream/"):
                other = target.split("/")[1]
                if other != layer and RANKS.get(other, 99) >= RANKS[layer]:
                    errors.append(f"{where}: not a lower layer")
                if layer in {"hydra", "python"} and other not in {layer, "session"}:
                    errors.append(f"{where}: front ends include only session/")
            elif target.startswith("kernels/") and not target.startswith("kernels/shared/"):
                errors.append(f"{where}: host code includes only kernels/shared")
            for pattern, owners in MONOPOLIES:
                if pattern.match(target) and layer not in owners:
                    errors.append(f"{where}: only {', '.join(sorted(owners))} may")
    for path in sorted((root / "kernels").rglob("*")):
        if path.suffix not in {".h", ".clh", ".cl", ".def"}:
            continue
        module = path.relative_to(root / "kernels").parts[0]
        for number, target in includes(path):
            where = f"{path.relative_to(root)}:{number}: {module} includes {target}"
            if target.startswith("hdStream/"):
                errors.append(f"{where}: kernels never include host code")
                continue
            other = target.split("/")[0]
            if other in KERNEL_RANKS and other != module and KERNEL_RANKS[other] >= KERNEL_RANKS[module]:
                errors.append(f"{where}: not a lower module")
    return errors


if __name__ == "__main__":
    found = check(pathlib.Path(sys.argv[1]))
    print("\n".join(found) if found else "layers: every include is in order")
    sys.exit(1 if found else 0)
