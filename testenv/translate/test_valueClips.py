# SPDX-License-Identifier: Apache-2.0
"""Attributes that only value clips hold: declared in no layer of the stage, but by their schemas and in the manifest.

Oracle: a stage whose prims have the same values as time samples of their own.
"""

import pytest
from pxr import Sdf

from hdstream import _core
from hdstream.translate.stageEdits import StageTranslation
from translateCase import StageOf, Translate

TRIANGLE = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]"
# {0}: metadata of the prim that may have the clips.
TOPOLOGY = {
    "group": f"""def Xform "A" ({{0}}) {{{{
        def Xform "Moving" {{{{
            uniform token[] xformOpOrder = ["xformOp:translate"]
            double3 xformOp:translate
            def Mesh "M" {{{{ {TRIANGLE} }}}}
        }}}}
        def Sphere "Ball" {{{{ def Mesh "Below" {{{{ {TRIANGLE} }}}} }}}}
        def BasisCurves "Hair" {{{{ int[] curveVertexCounts = [4] }}}}
        def Points "Dots" {{{{ }}}}
        def SphereLight "Lamp" (prepend apiSchemas = ["ShapingAPI"]) {{{{ }}}}
        def Camera "Cam" {{{{ }}}}
    }}}}""",
    "gprim": f"""def Mesh "A" ({{0}}) {{{{ {TRIANGLE}
        def Mesh "Below" {{{{ {TRIANGLE} }}}}
    }}}}""",
    "instances": f"""def Xform "I" (instanceable = true; references = </Class>) {{{{ }}}}
    def Xform "J" (instanceable = true; references = </Class>) {{{{ }}}}
    class Xform "Class" {{{{ def Xform "A" ({{0}}) {{{{
        def Mesh "M" {{{{ {TRIANGLE}\nuniform token[] xformOpOrder = ["xformOp:translate"]\ndouble3 xformOp:translate }}}}
        def PointInstancer "P" {{{{ rel prototypes = </Class/A/P/Proto>\ndef Sphere "Proto" {{{{ }}}} }}}}
    }}}} }}}}""",
    "prototypes": f"""def Xform "A" ({{0}}) {{{{
        def PointInstancer "P" {{{{ rel prototypes = </A/Outer/Proto> }}}}
        def Mesh "Outer" {{{{ def Xform "Proto" {{{{ def Mesh "M" {{{{ {TRIANGLE} }}}} }}}} }}}}
    }}}}""",
}
VISIBLE = ("visibility", "token", {0: "inherited", 2: "invisible", 3: "inherited"})
COLOR = ("primvars:displayColor", "color3f[]", {0: [(1, 0, 0)], 3: [(0, 1, 0)]})
OPACITY = ("primvars:displayOpacity", "float[]", {0: [0.25], 3: [1.0]})
POINTS = ("points", "point3f[]", {0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], 3: [(0, 0, 3), (1, 0, 0), (0, 1, 0)]})
FOUR = {0: [(0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 0, 0)], 3: [(0, 0, 3), (1, 0, 0), (2, 1, 0), (3, 0, 0)]}
VELOCITIES = ("velocities", "vector3f[]", {0: [(0, 0, 1)] * 3, 3: [(0, 2, 0)] * 3})
MOVE = ("xformOp:translate", "double3", {0: (0, 0, 0), 3: (3, 6, 9)})
INDICES = ("protoIndices", "int[]", {0: [0, 0]})
POSITIONS = ("positions", "point3f[]", {0: [(0, 0, 0), (5, 0, 0)], 3: [(0, 3, 0), (5, 0, 0)]})
NORMALS = ("normals", "normal3f[]", {0: [(0, 0, 1)] * 3, 3: [(0, 1, 0)] * 3})
VALUES = {
    "group": {
        "/A": [VISIBLE], "/A/Moving": [MOVE],
        "/A/Moving/M": [POINTS, COLOR, OPACITY, NORMALS, VELOCITIES],
        "/A/Ball": [COLOR, ("radius", "double", {0: 1.0, 3: 4.0})], "/A/Ball/Below": [POINTS],
        "/A/Hair": [("points", "point3f[]", FOUR), ("widths", "float[]", {0: [0.1] * 4, 3: [0.4] * 4}), COLOR],
        "/A/Dots": [POINTS, ("widths", "float[]", {0: [0.1, 0.2, 0.3], 3: [1, 2, 3]})],
        "/A/Lamp": [VISIBLE, ("inputs:intensity", "float", {0: 1.0, 3: 10.0}), ("inputs:color", "color3f", {0: (1, 1, 1), 3: (1, 0, 0)}),
                    ("inputs:radius", "float", {0: 1.0, 3: 2.0}), ("inputs:shaping:cone:angle", "float", {0: 90.0, 3: 30.0})],
        "/A/Cam": [("focalLength", "float", {0: 50.0, 3: 20.0}), ("exposure", "float", {0: 0.0, 3: 3.0})],
    },
    "gprim": {"/A": [VISIBLE, POINTS, COLOR, NORMALS], "/A/Below": [POINTS, OPACITY]},
    "instances": {"/A": [VISIBLE], "/A/M": [POINTS, COLOR, VISIBLE, MOVE],
                  "/A/P": [INDICES, POSITIONS]},
    "prototypes": {
        "/A/P": [INDICES, POSITIONS,
                 ("velocities", "vector3f[]", {0: [(0, 1, 0), (0, 0, 0)], 3: [(0, 2, 0), (1, 0, 0)]}),
                 ("accelerations", "vector3f[]", {0: [(0, 1, 0), (0, 2, 0)], 3: [(0, 0, 0), (0, 2, 0)]}),
                 COLOR],
        "/A/Outer": [POINTS, COLOR], "/A/Outer/Proto": [VISIBLE], "/A/Outer/Proto/M": [POINTS, OPACITY],
    },
}
SHUTTER = 'def Camera "Shutter" { double shutter:open = -0.25\ndouble shutter:close = 0.5 }'
CLIPS = ('clips = {{ dictionary default = {{ string primPath = "/A"\nasset[] assetPaths = [@{0}@]\nasset manifestAssetPath = @{0}@\n'
         "double2[] active = [(0, 0)]\ndouble2[] times = [(0, 0), (9, 9)] }} }}")


def _AddSamples(layer, values, root=""):
    """Values as time samples of prims of a layer, below a path."""
    for path, attributes in values.items():
        prim = Sdf.CreatePrimInLayer(layer, root + path)
        for name, kind, samples in attributes:
            spec = prim.attributes.get(name) or Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Find(kind))
            for time, value in samples.items():
                layer.SetTimeSample(spec.path, time, type(spec.typeName.defaultValue)(value))


def _Stages(name, tmp_path, isShutterOpen=False):
    """(with clips, with the same as time samples)"""
    clip = Sdf.Layer.CreateNew(str(tmp_path / "clip.usda"))
    _AddSamples(clip, VALUES[name])
    clip.Save()
    text = TOPOLOGY[name] + (SHUTTER.replace("{", "{{").replace("}", "}}") if isShutterOpen else "")
    clipped, baked = StageOf(text.format(CLIPS.format(clip.identifier))), StageOf(text.format(""))
    _AddSamples(baked.GetRootLayer(), VALUES[name], "/Class" if name == "instances" else "")
    return clipped, baked


@pytest.mark.parametrize("isShutterOpen", [False, True])
@pytest.mark.parametrize("name", TOPOLOGY)
def test_they_count_as_time_samples_do(name, isShutterOpen, tmp_path):
    clipped, baked = _Stages(name, tmp_path, isShutterOpen)
    dumps = set()
    for time in (0.0, 1.0, 2.0, 2.5, 3.0):
        dump = Translate(baked, time).Dump()
        assert Translate(clipped, time).Dump() == dump, time
        dumps.add(dump)
    assert len(dumps) >= 4  # they vary; what is invisible need not


def _Hide(stage):
    stage.GetAttributeAtPath("/A.visibility").Set("invisible", 1.0)


def _Widen(stage):
    stage.GetAttributeAtPath("/A/Ball.radius").Set(7.0, 1.0)


def _Brighten(stage):
    stage.GetAttributeAtPath("/A/Lamp.inputs:intensity").Set(9.0, 1.0)


def _Stop(stage):
    stage.GetPrimAtPath("/A").ClearMetadata("clips")


@pytest.mark.parametrize("edit, numPrims", [(_Hide, 9), (_Widen, 2), (_Brighten, 1), (_Stop, 9)])
def test_edits_below_them(edit, numPrims, tmp_path):
    """Only what changed is translated again, and is what a fresh session has."""
    stage, _ = _Stages("group", tmp_path)
    session = _core.Session()
    translation = StageTranslation(stage, session, lambda: None)
    assert translation.Update(1.0) == 9
    before = session.Dump()
    edit(stage)
    assert translation.Update(1.0) == numPrims
    assert session.Dump() == Translate(stage, 1.0).Dump() != before
