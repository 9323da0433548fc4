# SPDX-License-Identifier: Apache-2.0
"""Running the command line as users do: a process of its own, its exit code and what it prints."""

import contextlib
import io
import os
import subprocess
import sys

TRIANGLE = """def Mesh "Triangle"
{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
}
"""
SCENE = TRIANGLE + """def DistantLight "Sun"
{
    float inputs:intensity = 1
}
def Camera "main_cam"
{
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "Wide"
{
    float horizontalAperture = 40
    float verticalAperture = 10
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
ANIMATED = TRIANGLE + """def DistantLight "Sun" { float inputs:intensity = 1 }
def Sphere "Ball" {
    double radius = 0.5
    double3 xformOp:translate.timeSamples = { 1: (-1, 0, 1), 24: (1, 0.5, 1) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "main_cam" {
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
SMALL = ["-w", "8", "--samples", "1", "--maxDepth", "1"]
SECONDS = 300  # a command that takes longer hangs; the first one of a session builds kernels


class Result:
    """Exit code and output of a command, stderr split into warnings and the rest."""

    def __init__(self, code, out, err):
        self.code = code
        self.out = out
        lines = err.splitlines()
        self.warnings = [line[len("warning: "):] for line in lines if line.startswith("warning: ")]
        self.errors = [line for line in lines if not line.startswith("warning: ")]
        self.text = f"exit {code}\n{out}\n{err}"


def Command(*arguments):
    return [sys.executable, "-m", "hdstream", *map(str, arguments)]


def Run(*arguments, environment=None, **keywords):
    """Runs `hdstream ARGUMENTS...`."""
    done = subprocess.run(Command(*arguments), capture_output=True, text=True, timeout=SECONDS,
                          env=dict(os.environ, **(environment or {})), **keywords)
    return Result(done.returncode, done.stdout, done.stderr)


def RunHere(*arguments):
    """As Run, in this process: for errors that are found before anything is rendered."""
    from hdstream.cli import Main
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = Main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code
    return Result(code, out.getvalue(), err.getvalue())


def WriteStage(folder, body=SCENE, name="scene.usda", header=""):
    """A .usda file; braces need no lines of their own."""
    path = folder / name
    body = body.replace("}", "\n}\n")
    path.write_text(f"#usda 1.0\n{header}\n{body}", encoding="utf-8")
    return path


def AssertFails(result, code, *parts):
    """One line on stderr, besides warnings, that holds the parts; no traceback anywhere."""
    assert result.code == code, result.text
    assert len(result.errors) == 1, result.text
    assert "Traceback" not in result.text and "internal error" not in result.text
    for part in parts:
        assert str(part) in result.errors[0], result.text
