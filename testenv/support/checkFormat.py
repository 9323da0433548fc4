# SPDX-License-Identifier: Apache-2.0
"""Names every C++ and kernel file that clang-format would change: checkFormat.py CLANG_FORMAT"""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SUFFIXES = {".h", ".cpp", ".cl", ".clh", ".def"}


def main(tool: str) -> int:
    files = sorted(path for folder in ("hdStream", "kernels", "testenv")
                   for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES)
    result = subprocess.run([tool, "--dry-run", "-Werror", *files], capture_output=True, text=True)
    changed = sorted({line.split(":", 1)[0] for line in result.stderr.splitlines() if "error:" in line})
    for path in changed:
        print(f"not formatted: {pathlib.Path(path).relative_to(ROOT)}", file=sys.stderr)
    return result.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
