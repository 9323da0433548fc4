# SPDX-License-Identifier: Apache-2.0
"""Draws a stage through UsdImagingGLEngine as OpenUSD's own test program testUsdImagingGLBasicDrawing does,
with any renderer: engineScript.py JOB.json

Runs in OpenUSD's Python under an X server. The job holds that program's arguments, the pictures to write
(one a time code or complexity) and the renderer. Deviations from the program, which lights with fixed-function
lights that only Storm knows: "-lighting" without "-sceneLights" is a distant light from the same direction
whose irradiance is pi (so that a Lambert surface shows albedo * cosine) and a dome of 0.2; complexity is a
uniform subdivision level; domes hide the clear colour with "-sceneLights" only. Values go to 8 bits as they are, clamped.
"""

import json
import math
import sys

from OpenGL import GL
from PySide6 import QtGui, QtOpenGL, QtWidgets
from pxr import CameraUtil, Gf, Sdf, Usd, UsdGeom, UsdImagingGL, UsdLux

_PURPOSES = {"guides": "guide", "render": "render", "proxy": "proxy"}
_POLICIES = {"matchVertically": CameraUtil.MatchVertically, "matchHorizontally": CameraUtil.MatchHorizontally,
             "fit": CameraUtil.Fit, "crop": CameraUtil.Crop, "dontConform": CameraUtil.DontConform}
_CULL_STYLES = {"none": "NO_OPINION", "nothing": "NOTHING", "back": "BACK", "front": "FRONT",
                "backUnlessDoubleSided": "BACK_UNLESS_DOUBLE_SIDED"}


class Arguments:
    """The words of a command line after the program's name."""

    def __init__(self, words):
        self._words = words

    def Has(self, name):
        return f"-{name}" in self._words

    def Texts(self, name):
        """The values of an option up to the next one; negative numbers are values."""
        if not self.Has(name):
            return []
        values = []
        for word in self._words[self._words.index(f"-{name}") + 1:]:
            if word.startswith("-") and word[1:2].isalpha():
                break
            values.append(word)
        return values

    def Text(self, name, default):
        return (self.Texts(name) or [default])[0]

    def Numbers(self, name, default=()):
        return [float(text) for text in self.Texts(name)] or list(default)


class Canvas:
    """An OpenGL context with a frame buffer that the engine presents to."""

    def __init__(self, width, height):
        self._application = QtWidgets.QApplication(sys.argv[:1])
        self._surface = QtGui.QOffscreenSurface()
        self._surface.create()
        self._context = QtGui.QOpenGLContext()
        self._context.create()
        self._context.makeCurrent(self._surface)
        self._buffer = QtOpenGL.QOpenGLFramebufferObject(width, height, QtOpenGL.QOpenGLFramebufferObject.Depth)
        self._buffer.bind()

    def Clear(self):
        GL.glClearColor(0, 0, 0, 0)
        GL.glClear(GL.GL_COLOR_BUFFER_BIT | GL.GL_DEPTH_BUFFER_BIT)

    def Save(self, path):
        self._buffer.toImage().convertToFormat(QtGui.QImage.Format_RGB888).save(path)


def ShownPurposes(arguments):
    """Guides and render hidden, proxy shown, unless told."""
    shown = {"guides": False, "render": False, "proxy": True}
    for name in shown:
        shown[name] = arguments.Text(f"{name}Purpose", "show" if shown[name] else "hide") == "show"
    return shown


def FramingTranslation(stage, arguments):
    """Of the view matrix, y up."""
    if not arguments.Has("frameAll"):
        return Gf.Vec3d(*arguments.Numbers("translate", (0, -1000, -2500)))
    purposes = ["default"] + [_PURPOSES[name] for name, isShown in ShownPurposes(arguments).items() if isShown]
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), purposes, True).ComputeWorldBound(stage.GetPseudoRoot())
    box = bounds.ComputeAlignedRange()
    centre, size = box.GetMidpoint(), box.GetSize().GetLength()
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        return Gf.Vec3d(-centre[0], -centre[2], -centre[1] - size)
    return Gf.Vec3d(-centre[0], -centre[1], -centre[2] - size)


def SetCamera(engine, stage, arguments, translation, width, height):
    path = arguments.Text("camera", "")
    if path:
        engine.SetCameraPath(Sdf.Path(path))
        return
    view = Gf.Matrix4d().SetTranslate(translation)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        view = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), -90)) * view
    frustum = Gf.Frustum()
    frustum.SetPerspective(60.0, True, width / height, 1.0, 100000.0)
    engine.SetCameraState(view, frustum.ComputeProjectionMatrix())


def SetFraming(engine, arguments, width, height):
    data, display = arguments.Numbers("dataWindow"), arguments.Numbers("displayWindow")
    engine.SetRenderBufferSize(Gf.Vec2i(width, height))
    if data:
        dataWindow = Gf.Rect2i(Gf.Vec2i(int(data[0]), int(data[1])), int(data[2]), int(data[3]))
    else:
        dataWindow = Gf.Rect2i(Gf.Vec2i(0, 0), width, height)
    if display:
        displayWindow = Gf.Range2f(Gf.Vec2f(display[0], display[1]),
                                   Gf.Vec2f(display[0] + display[2], display[1] + display[3]))
    else:
        displayWindow = Gf.Range2f(Gf.Vec2f(0, 0), Gf.Vec2f(width, height))
    aspect = (arguments.Numbers("pixelAspectRatio") or [1.0])[0]
    engine.SetFraming(CameraUtil.Framing(displayWindow, dataWindow, aspect))
    engine.SetOverrideWindowPolicy(_POLICIES[arguments.Text("windowPolicy", "matchVertically")])


def AddLights(stage, arguments, translation):
    """The program's light, as light prims in the session layer."""
    if not arguments.Has("lighting") or arguments.Has("sceneLights"):
        return
    if arguments.Has("camlight"):
        towards = Gf.Vec3d(translation[0], translation[2], translation[1])
    else:
        towards = Gf.Vec3d(0, -0.5, 0.5)
    stage.SetEditTarget(stage.GetSessionLayer())
    sun = UsdLux.DistantLight.Define(stage, "/hdStreamTestSun")
    sun.CreateNormalizeAttr(True)
    sun.CreateIntensityAttr(math.pi)
    matrix = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), towards.GetNormalized()))
    UsdGeom.Xformable(sun).AddTransformOp().Set(matrix)
    UsdLux.DomeLight.Define(stage, "/hdStreamTestSky").CreateIntensityAttr(0.2)


def MakeParameters(arguments):
    parameters = UsdImagingGL.RenderParams()
    shown = ShownPurposes(arguments)
    parameters.showGuides, parameters.showRender, parameters.showProxy = shown["guides"], shown["render"], shown["proxy"]
    parameters.complexity = (arguments.Numbers("complexity") or [1.0])[0]
    parameters.clearColor = Gf.Vec4f(*arguments.Numbers("clear", (1.0, 0.5, 0.1, 1.0)))
    parameters.enableSceneMaterials = not arguments.Has("disableSceneMaterials")
    parameters.cullStyle = getattr(UsdImagingGL.CullStyle,
                                   f"CULL_STYLE_{_CULL_STYLES[arguments.Text('cullStyle', 'nothing')]}")
    planes = arguments.Numbers("clipPlane")
    if planes:
        parameters.clipPlanes = [Gf.Vec4d(*planes[:4])]
    return parameters


def main(job):
    arguments = Arguments(job["arguments"])
    width, height = job["size"]
    canvas = Canvas(width, height)
    stage = Usd.Stage.Open(arguments.Text("stage", ""))
    engine = UsdImagingGL.Engine()
    plugins = {engine.GetRendererDisplayName(plugin): plugin for plugin in engine.GetRendererPlugins()}
    if not engine.SetRendererPlugin(plugins[job["renderer"]]):
        raise RuntimeError(f"{job['renderer']} cannot be set")
    translation = FramingTranslation(stage, arguments)
    AddLights(stage, arguments, translation)
    SetCamera(engine, stage, arguments, translation, width, height)
    SetFraming(engine, arguments, width, height)
    parameters = MakeParameters(arguments)
    for name, value in {"samples": job["samples"], "subdivision": "complexity", "domeLightCameraVisibility": arguments.Has("sceneLights")}.items():
        engine.SetRendererSetting(name, value)
    engine.SetRendererAov(arguments.Text("rendererAov", "color"))
    times = arguments.Numbers("times") or [None]
    complexities = arguments.Numbers("complexities") or [parameters.complexity]
    views = [(time, complexity) for complexity in complexities for time in times]
    for (time, complexity), picture in zip(views, job["pictures"]):
        # The program takes -999, and no time at all, for the default time.
        parameters.frame = Usd.TimeCode.Default() if time in (None, -999) else Usd.TimeCode(time)
        parameters.complexity = complexity
        canvas.Clear()
        engine.Render(stage.GetPseudoRoot(), parameters)
        while not engine.IsConverged():
            canvas.Clear()
            engine.Render(stage.GetPseudoRoot(), parameters)
        canvas.Save(picture)
    del engine  # while its context is current


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as stream:
        main(json.load(stream))
