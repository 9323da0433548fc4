# SPDX-License-Identifier: Apache-2.0
"""What each output costs when it is used, and that what is not used costs nothing.

    python testenv/bench/outputCost.py STAGE... [--width 320] [--samples 16] [--repeats 5] [--sets "NAME;..."]
    python testenv/bench/outputCost.py STAGE... --without BUILD [--repeats 9]
    python testenv/bench/outputCost.py --kernels TREE

The first form renders each stage with and without each set of outputs, in turn, in one process: CPU seconds of all threads over
`RenderPrepared`, which other work on the machine disturbs less than it does seconds of a clock. Ratios are of neighbours in time: of
each repeat a set's seconds over the mean of the two renders of colour alone around it; the median, and the interval between the
quartiles. The first render of each set, which compiles kernels and loads pages, is not counted.

The second form compares this program with another build of it, one without the code of an output, say of the commit before
(PYTHONPATH of its folder `python`): colour alone, processes in turn, the same bits and CPU seconds of rendering. The cache
folder is shared, so both read the same pages.

The third form compares the kernels with those of another source tree of the program, as the C preprocessor (cpp) leaves them:
with no feature of kernels/shared/features.def, and with each that both trees have, alone. What has the same text has the same bits and
takes the same time.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

SETS = {
    "depth, normal, position, albedo, primId": dict(aovs=("depth", "normal", "position", "albedo", "primId")),
    "motionForward, motionBackward": dict(aovs=("motionForward", "motionBackward")),
    "variance, sampleCount": dict(aovs=("variance", "sampleCount")),
    "crypto_object": dict(aovs=("crypto_object",)),
    "three Cryptomattes": dict(aovs=("crypto_object", "crypto_material", "crypto_instance")),
    "a deep picture": dict(deep=True),
    "a deep picture and crypto_object": dict(deep=True, aovs=("crypto_object",)),
    "ambientOcclusion": dict(aovs=("ambientOcclusion",)),
    "one light path expression": dict(aovs=("lpe:C<RD>.*L",)),
    "one light group": dict(aovs=("lightGroup:default",)),
    "emission, diffuse, specular, transmission": dict(aovs=("emission", "diffuse", "specular", "transmission")),
    "nine light path expressions": dict(aovs=(
        "emission", "directDiffuse", "indirectDiffuse", "directSpecular", "indirectSpecular", "directTransmission",
        "indirectTransmission", "direct", "indirect")),
    "a shadow catcher": dict(catcher=True),
}


def _AddCatcher(stage):
    """The largest mesh by its extent, which is mostly what all stands on, shows only what others do to its light."""
    from pxr import Gf, Sdf, Usd, UsdGeom
    cache = UsdGeom.BBoxCache(stage.GetStartTimeCode(), ["default", "render"])
    meshes = [prim for prim in stage.Traverse(Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh) and not prim.IsInstanceProxy()]
    largest = max(meshes, key=lambda prim: Gf.Vec3d(cache.ComputeWorldBound(prim).ComputeAlignedRange().GetSize()).GetLength())
    UsdGeom.PrimvarsAPI(largest).CreatePrimvar("hdstream:shadowCatcher", Sdf.ValueTypeNames.Bool).Set(True)


class _Case:
    """A renderer that renders one set again and again."""

    def __init__(self, path, width, samples, aovs=(), deep=False, catcher=False, **further):
        import hdstream
        from pxr import Usd
        stage = str(path)
        if catcher:
            stage = Usd.Stage.Open(str(path))
            stage.SetEditTarget(stage.GetSessionLayer())
            _AddCatcher(stage)
        self._renderer = hdstream.Renderer(stage, onWarning=lambda line: None)
        self._settings = dict(aovs=["color", *aovs], deep=deep, imageWidth=width, samples=samples, **further)
        self.pathState = 0

    def Render(self):
        """CPU seconds."""
        self._renderer.Prepare(**self._settings)
        start = time.process_time()
        image = self._renderer.RenderPrepared()
        seconds = time.process_time() - start
        self.pathState = image.statistics["memory"]["pathState"]
        self.deep = image.statistics["memory"].get("deep", 0)
        self.color = image.aovs["color"].tobytes()
        return seconds


def _Quartiles(values):
    return statistics.quantiles(values, n=4, method="inclusive") if len(values) > 1 else [values[0]] * 3


def Measure(stage, width, samples, repeats, names):
    """{set: (ratios, CPU seconds more, path state bytes, deep bytes, same colour)} and the CPU seconds of colour alone."""
    base = _Case(stage, width, samples)
    cases = {name: _Case(stage, width, samples, **SETS[name]) for name in names}
    for case in (base, *cases.values()):
        case.Render()
    ratios, more, bases = {name: [] for name in names}, {name: [] for name in names}, []
    for _ in range(repeats):
        before = base.Render()
        for name, case in cases.items():
            seconds = case.Render()
            after = base.Render()
            ratios[name].append(seconds / (0.5 * (before + after)))
            more[name].append(seconds - 0.5 * (before + after))
            bases.append(before)
            before = after
    rows = {name: (ratios[name], more[name], case.pathState, case.deep, case.color == base.color) for name, case in cases.items()}
    return rows, bases, base.pathState


def _PrintCosts(args):
    names = args.sets.split(";") if args.sets else list(SETS)
    for stage in args.stages:
        rows, bases, pathState = Measure(stage, args.width, args.samples, args.repeats, names)
        print(f"\n{pathlib.Path(stage).stem}: {args.width} pixels wide, {args.samples} samples, {args.repeats} repeats; colour alone takes "
              f"{statistics.median(bases):.2f} CPU s, path state {pathState / 1e6:.1f} MB; load {os.getloadavg()[0]:.1f}\n")
        print("| outputs beside color | CPU time over color | quartiles | CPU s more | path state MB | color |")
        print("|---|---|---|---|---|---|")
        for name, (ratios, more, state, deep, isSame) in rows.items():
            low, median, high = _Quartiles(ratios)
            deepText = f" (and {deep / 1e6:.1f} of the host)" if deep else ""
            print(f"| {name} | {median:.2f} | {low:.2f} to {high:.2f} | {statistics.median(more):+.2f} | {state / 1e6:.1f}{deepText} | "
                  f"{'same bits' if isSame else 'other bits'} |", flush=True)


_WORKER = """
import hashlib, json, resource, sys, time
import hdstream
stage, width, samples, cache = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
renderer = hdstream.Renderer(stage, onWarning=lambda line: None)
times = []
for _ in range(4):
    renderer.Prepare(imageWidth=width, samples=samples, cacheDirectory=cache)
    start = time.process_time()
    image = renderer.RenderPrepared()
    times.append(time.process_time() - start)
print(json.dumps({"seconds": min(times[1:]), "hash": hashlib.sha256(image.aovs["color"].tobytes()).hexdigest(),
                  "pathState": image.statistics["memory"]["pathState"]}))
"""


def _Worker(build, stage, args, cache):
    result = subprocess.run([sys.executable, "-c", _WORKER, str(stage), str(args.width), str(args.samples), cache], check=True,
                            stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(build)})
    return json.loads(result.stdout.splitlines()[-1])


def _PrintUnused(args):
    """This program over the other one: the least of three renders of each process, ratios of neighbours."""
    builds = {"with": os.environ["PYTHONPATH"].split(os.pathsep)[0], "without": args.without}
    print("| stage | CPU time over the build without | quartiles | CPU s | path state | color |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as cache:
        for stage in args.stages:
            runs = {name: [] for name in builds}
            for repeat in range(args.repeats + 1):
                for name in sorted(builds, reverse=repeat % 2 == 0):
                    run = _Worker(builds[name], stage, args, cache)
                    if repeat > 0:
                        runs[name].append(run)
            ratios = [a["seconds"] / b["seconds"] for a, b in zip(runs["with"], runs["without"])]
            low, median, high = _Quartiles(ratios)
            isSame = len({run["hash"] for both in runs.values() for run in both}) == 1
            states = {run["pathState"] for both in runs.values() for run in both}
            print(f"| {pathlib.Path(stage).stem} | {median:.3f} | {low:.3f} to {high:.3f} | "
                  f"{statistics.median(run['seconds'] for run in runs['with']):.2f} | {'same' if len(states) == 1 else 'OTHER'} | "
                  f"{'same bits' if isSame else 'OTHER BITS'} |", flush=True)


_ROWS = re.compile(r"HDS_(?:FEATURE|VARIANT)\(((?:[^()\"]|\([^()]*\)|\"[^\"]*\")*)\)")


def _Features(tree):
    """{macro: value that it is tried with} of a source tree."""
    text = re.sub(r"/\*.*?\*/", "", (tree / "kernels/shared/features.def").read_text(encoding="utf-8"), flags=re.DOTALL)
    values = {}
    for row in _ROWS.findall(text):
        cells = [cell.strip() for cell in row.split(",")]
        if len(cells) > 2 and cells[0] in ("bool", "std::uint32_t"):
            values[cells[2]] = "1" if cells[0] == "bool" else cells[4]
        elif len(cells) > 1 and cells[1].startswith("HDS_"):
            values[cells[1]] = "1"
    return values


def _Preprocessed(tree, root, defines):
    """The text of a kernel program."""
    return subprocess.run(["cpp", "-P", "-x", "c", "-D__OPENCL_VERSION__=120", "-D__OPENCL_C_VERSION__=120", f"-I{tree}/kernels", *defines,
                           f"{tree}/kernels/{root}"], check=True, stdout=subprocess.PIPE, text=True).stdout


def _PrintKernels(other):
    own = pathlib.Path(__file__).resolve().parents[2]
    roots = re.findall(r'HDS_PROGRAM\(\w+, "([^"]+)"', (other / "kernels/shared/features.def").read_text(encoding="utf-8"))
    mine, theirs = _Features(own), _Features(other)
    print(f"features that only this tree has: {', '.join(sorted(set(mine) - set(theirs))) or 'none'}")
    same, differing = 0, []
    for macro in [None, *sorted(set(mine) & set(theirs))]:
        defines = [] if macro is None else [f"-D{macro}={mine[macro]}"]
        for root in roots:
            texts = [_Preprocessed(tree, root, defines) for tree in (own, other)]
            assert all(len(text) > 1000 for text in texts), f"{root}: nothing is left of it"
            same += texts[0] == texts[1]
            if texts[0] != texts[1]:
                differing.append(f"{root} with {macro or 'no feature'}")
    print(f"{same} texts of kernel programs are the same; {len(differing)} differ{': ' + ', '.join(differing) if differing else ''}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", nargs="*")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--sets", default="", help="names of the table, divided by semicolons")
    parser.add_argument("--without", metavar="BUILD", help="folder `python` of a build to compare with")
    parser.add_argument("--kernels", metavar="TREE", type=pathlib.Path, help="source tree whose kernels are compared")
    args = parser.parse_args()
    if args.kernels:
        _PrintKernels(args.kernels)
        return
    (_PrintUnused if args.without else _PrintCosts)(args)


if __name__ == "__main__":
    main()
