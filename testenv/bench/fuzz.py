# SPDX-License-Identifier: Apache-2.0
"""Fuzzing: mutated stages, images, cache files, command lines and settings.

    fuzz.py KIND [--seconds 600] [--seed 1] [--first 0] [--folder FOLDER]
    fuzz.py KIND --seed S --case N          # one case, alone

Each case runs in a child process with limits of memory and time. Wrong are: a crash, a hang, a traceback, an exit code or output
that docs/command-line.md does not promise, a pixel that is not finite, a picture that a damaged cache has changed. Findings are
printed and kept below the folder. The exit code is 1 when there are any. Explained in docs/stability.md.
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "fuzz"), str(pathlib.Path(__file__).resolve().parents[1])]

from driver import Fuzzer  # noqa: E402
from kinds import KINDS  # noqa: E402


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=sorted(KINDS))
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--case", type=int, help="only this one")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("fuzz"))
    args = parser.parse_args()
    fuzzer = Fuzzer(args.kind, args.seed, args.folder, lambda finding: print(f"{finding.folder.name}: {finding.wrong}", flush=True))
    if args.case is not None:
        fuzzer.RunCount(1, args.case)
    else:
        fuzzer.RunFor(args.seconds, args.first)
    print(f"{args.kind}: {fuzzer.numCases} cases, {sum(fuzzer.Counts().values())} findings of {len(fuzzer.Counts())} kinds")
    for wrong, count in fuzzer.Counts().items():
        print(f"  {count} x {wrong}")
    return 1 if fuzzer.findings else 0


if __name__ == "__main__":
    sys.exit(main())
