# SPDX-License-Identifier: Apache-2.0
"""testUnit, testDevice and the Python module with some layers under a sanitizer: sanitizedPart.py --build BUILD --out OUT
[--sanitize address,undefined] [-j N] LAYER...

The layers' files are compiled, and linked with what BUILD has of all others (docs/testing.md): a small part
of the time of a build of everything. What is in OUT is compiled again when its source is newer; after edits of headers, remove OUT.
"""

import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAMS = ("testenv/testUnit", "testenv/testDevice")
KERNEL_COMPILER = "hdstreamCompileKernels"


def Compile(entry, target, options):
    """The file of an entry of compile_commands.json, as the build compiles it, with other options."""
    source = pathlib.Path(entry["directory"], entry["file"])
    if target.exists() and target.stat().st_mtime > source.stat().st_mtime:
        return
    words = [word for word in shlex.split(entry["command"])
             if not word.endswith("ccache") and not re.fullmatch(r"-O.|-DNDEBUG|-g.?", word)]
    at = words.index("-o")
    subprocess.run([*words[:at], *options, "-o", str(target), "-c", str(source)], cwd=entry["directory"], check=True)


def LinkInputs(build, target):
    """The objects of a target of build.ninja, and its libraries."""
    text = (build / "build.ninja").read_text().replace("$\n", "")
    found = re.search(rf"^build {re.escape(target)}: \S+ ([^|\n]*)\|.*\n(?:  .*\n)*?  LINK_LIBRARIES = (.*)\n", text, re.MULTILINE)
    if not found:
        sys.exit(f"{build}/build.ninja: no target {target}")
    return found[1].split(), shlex.split(found[2])


def Link(build, target, compiled, options, out):
    """A target of the build, of the compiled files in the place of its own. Layers are archives: of a file that is
    there already nothing is taken from them."""
    objects, libraries = LinkInputs(build, target)
    subprocess.run(["c++", *options, "-g1", "-o", str(out), *objects, *map(str, compiled), *libraries], cwd=build, check=True)
    print(out)


def Main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--build", type=pathlib.Path, required=True, help="a build of everything, with Ninja")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--sanitize", default="address,undefined")
    parser.add_argument("-j", type=int, default=2, dest="jobs")
    parser.add_argument("layers", nargs="+", metavar="LAYER")
    args = parser.parse_args()
    build, out = args.build.resolve(), args.out.resolve()
    objects = out / "objects"
    objects.mkdir(parents=True, exist_ok=True)
    sanitize = f"-fsanitize={args.sanitize}"
    entries = {pathlib.Path(entry["file"]): entry for entry in json.loads((build / "compile_commands.json").read_text())}
    sources = [path for layer in args.layers for path in sorted((ROOT / "hdStream" / layer).glob("*.cpp"))]
    if not sources:
        sys.exit(f"{args.layers}: no such layers")
    targets = [objects / "_".join(path.relative_to(ROOT / "hdStream").with_suffix(".o").parts) for path in sources]
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        options = ["-O0", "-g1", "-fno-omit-frame-pointer", sanitize]
        list(pool.map(lambda pair: Compile(entries[pair[0]], pair[1], options), zip(sources, targets)))
    for program in PROGRAMS:
        Link(build, program, targets, ["-pie", sanitize], out / pathlib.Path(program).name)
    shutil.copy(build / "bin" / KERNEL_COMPILER, out)
    shutil.copytree(build / "python", out / "python", symlinks=True, dirs_exist_ok=True)
    module, = (build / "python" / "hdstream").glob("_core.*.so")
    Link(build, str(module.relative_to(build)), targets, ["-shared", sanitize], out / module.relative_to(build))


if __name__ == "__main__":
    Main()
