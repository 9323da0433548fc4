# SPDX-License-Identifier: Apache-2.0
"""testUnit, testDevice and the Python module with some layers under a sanitizer: sanitizedPart.py --build BUILD --out OUT
[--sanitize address,undefined] [-j N] [--hydra] LAYER...; with --hydra the plug-in and testHydra instead.

A LAYER may be one of its files, too: hydra/renderPass.

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
PLUGIN = "plugin/usd/hdStream.so"
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
    found = re.search(rf"^build {re.escape(target)}: \S+ ([^|\n]*)\|.*\n(?:  (?!LINK_FLAGS).*\n)*?(?:  LINK_FLAGS = (.*)\n)?"
                      r"(?:  .*\n)*?  LINK_LIBRARIES = (.*)\n", text, re.MULTILINE)
    if not found:
        sys.exit(f"{build}/build.ninja: no target {target}")
    return found[1].split(), shlex.split(found[2] or ""), shlex.split(found[3])


def Link(build, target, compiled, options, out):
    """A target of the build, of the compiled files in the place of its own. Layers are archives: of a file that is
    there already nothing is taken from them, and objects of the target itself that are compiled anew are left out."""
    objects, flags, libraries = LinkInputs(build, target)
    anew = {path.name.removesuffix(".o") for path in compiled}
    objects = [name for name in objects
               if not re.match("hdStream/", name) or re.sub(r"^hdStream/|CMakeFiles/[^/]*/|\.cpp\.o$", "", name).replace("/", "_") not in anew]
    subprocess.run(["c++", *options, "-g1", "-o", str(out), *objects, *map(str, compiled), *flags, *libraries], cwd=build, check=True)
    print(out)


def Main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--build", type=pathlib.Path, required=True, help="a build of everything, with Ninja")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--sanitize", default="address,undefined")
    parser.add_argument("-j", type=int, default=2, dest="jobs")
    parser.add_argument("--hydra", action="store_true", help="the plug-in and testHydra, of a build that has them")
    parser.add_argument("layers", nargs="+", metavar="LAYER")
    args = parser.parse_args()
    build, out = args.build.resolve(), args.out.resolve()
    objects = out / "objects"
    objects.mkdir(parents=True, exist_ok=True)
    sanitize = f"-fsanitize={args.sanitize}"
    entries = {pathlib.Path(entry["file"]): entry for entry in json.loads((build / "compile_commands.json").read_text())}
    sources = [path for layer in args.layers for path in sorted((ROOT / "hdStream").glob(f"{layer}.cpp")) or sorted((ROOT / "hdStream" / layer).glob("*.cpp"))]
    if not sources:
        sys.exit(f"{args.layers}: no such layers or files")
    targets = [objects / "_".join(path.relative_to(ROOT / "hdStream").with_suffix(".o").parts) for path in sources]
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        options = ["-O0", "-g1", "-fno-omit-frame-pointer", sanitize]
        list(pool.map(lambda pair: Compile(entries[pair[0]], pair[1], options), zip(sources, targets)))
    if args.hydra:
        plugin = out / PLUGIN
        shutil.copytree((build / PLUGIN).parent, plugin.parent, dirs_exist_ok=True)
        Link(build, PLUGIN, targets, ["-shared", sanitize], plugin)
        Link(build, "testenv/hydra/testHydra", [], ["-pie", sanitize], out / "testHydra") # loads the runtime first
        return
    for program in PROGRAMS:
        Link(build, program, targets, ["-pie", sanitize], out / pathlib.Path(program).name)
    shutil.copy(build / "bin" / KERNEL_COMPILER, out)
    shutil.copytree(build / "python", out / "python", symlinks=True, dirs_exist_ok=True)
    module, = (build / "python" / "hdstream").glob("_core.*.so")
    Link(build, str(module.relative_to(build)), targets, ["-shared", sanitize], out / module.relative_to(build))


if __name__ == "__main__":
    Main()
