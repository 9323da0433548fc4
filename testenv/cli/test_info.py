# SPDX-License-Identifier: Apache-2.0
"""`info`, `devices` and `cache` say what is there."""

import json

from cliCase import AssertFails, Run, RunHere, WriteStage

NESTED = """class "Leaf"
{
    def Mesh "Strip"
    {
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 2, 1, 4]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)]
        uniform token subdivisionScheme = "none"
    }
    def Mesh "Quad"
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        uniform token subdivisionScheme = "none"
    }
}
class "Pair"
{
    def Xform "A" (instanceable = true; references = </Leaf>) {}
    def Xform "B" (instanceable = true; references = </Leaf>) {}
}
def Xform "World"
{
    def Xform "P1" (instanceable = true; references = </Pair>) {}
    def Xform "P2" (instanceable = true; references = </Pair>) {}
    def Xform "P3" (instanceable = true; references = </Pair>) {}
    def PointInstancer "Points"
    {
        int[] protoIndices = [0, 0, 0, 0, 0]
        point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0)]
        rel prototypes = </World/Points/Sheet>
        def Mesh "Sheet"
        {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
            uniform token subdivisionScheme = "none"
        }
    }
    def Camera "Cam" {}
    def SphereLight "Lamp" {}
}
"""


def test_info_counts_through_the_hierarchy(tmp_path):
    stage = WriteStage(tmp_path, NESTED)
    result = Run("info", stage, "--json", tmp_path / "i.json")
    assert result.code == 0 and not result.errors, result.text
    info = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    # 3 pairs of 2 leaves of 2 meshes, and 5 sheets; unique: strip, quad, sheet.
    assert info["instances"] == 3 * 2 * 2 + 5
    assert info["meshes"] == 3 and info["triangles"] == 3 + 2 + 1
    assert info["primTypes"]["Mesh"] == 3 * 2 * 2 + 1 and info["primTypes"]["Camera"] == 1
    assert info["cameraPaths"] == ["/World/Cam"] and info["lights"] == 1
    assert "6 triangles" in result.out and "17 drawn" in result.out


def test_info_as_json_on_stdout(tmp_path):
    result = RunHere("info", WriteStage(tmp_path, NESTED), "--json", "-")
    assert result.code == 0 and json.loads(result.out)["meshes"] == 3
    AssertFails(RunHere("info", WriteStage(tmp_path, NESTED), "--json", tmp_path / "none" / "i.json"), 1, "i.json")


def test_info_names_textures(tmp_path):
    body = """def Material "M"
{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @tex.png@
        float3 outputs:rgb
    }
}
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    rel material:binding = </M>
}
"""
    import numpy as np
    from hdstream import _core
    pixels = np.full((4, 8, 4), 0.5, np.float32)
    _core.WriteImage(str(tmp_path / "tex.png"), [_core.ImageLayer("color", ["R", "G", "B", "A"], pixels)])
    result = RunHere("info", WriteStage(tmp_path, body), "--json", "-")
    texture, = json.loads(result.out)["textures"]
    assert (texture["file"], texture["width"], texture["height"]) == ("tex.png", 8, 4)
    assert texture["bytesSource"] == 8 * 4 * texture["channels"]


def test_devices_marks_the_one_that_renders():
    from hdstream import _core

    result = Run("devices")
    assert result.code == 0 and "compute units" in result.out
    lines = [line for line in result.out.splitlines() if line.endswith(" (default)")]
    assert lines == [f"{_core.FindDevice('').name} (default)"]


def test_cache_is_shown_and_cleared(tmp_path):
    environment = {"HDSTREAM_CACHE_DIR": str(tmp_path / "cache")}
    stage = WriteStage(tmp_path)
    assert Run("cache", environment=environment).code == 0
    assert Run("record", stage, tmp_path / "o.exr", "-w", "8", "--samples", "1", environment=environment).code == 0
    shown = Run("cache", environment=environment)
    assert str(tmp_path / "cache") in shown.out and ": 0 B" not in shown.out
    assert "deleted" in Run("cache", "--clear", environment=environment).out
    assert ": 0 B" in Run("cache", environment=environment).out


def test_curves_and_points_are_counted(tmp_path):
    body = """
    def BasisCurves "Hair" {
        uniform token type = "linear"
        int[] curveVertexCounts = [2, 2]
        point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)]
        float[] widths = [0.1] (interpolation = "constant")
    }
    def Points "Dots" {
        point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 0, 0)]
        float[] widths = [0.1, 0.1, 0.1]
    }
"""
    result = RunHere("info", WriteStage(tmp_path, body), "--json", "-")
    info = json.loads(result.out)
    assert (info["curves"], info["points"], info["meshes"], info["triangles"]) == (2, 3, 0, 0)
    assert "2, 3 points" in RunHere("info", WriteStage(tmp_path, body)).out
