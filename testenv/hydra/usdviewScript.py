# SPDX-License-Identifier: Apache-2.0
"""What a user does in usdview, for testusdview --testScript; driven and judged by test_usdview.py.

Runs in OpenUSD's Python, with nothing but OpenUSD's modules and Qt. $HDSTREAM_VIEW_JOB is a JSON file with
the folder of the results, the renderer and the picks to make. Every step lets the picture converge and
saves it: NAME.png for the eye and NAME.raw (RGBA8, rows from the top) for comparisons. report.json holds
the steps with their sizes and what was picked; it is written last, so a missing one means a bad end.
"""

import ctypes
import json
import os
import sys
import time

from pxr import Gf, Sdf, UsdGeom, UsdImagingGL, UsdLux, UsdShade
from pxr.Usdviewq.qt import QtCore, QtGui, QtWidgets

SIZE = (320, 240)  # pixels
CONVERGE_SECONDS = 180  # a picture that takes longer does not converge


class Viewer:
    """usdview's window as its user sees it. Main thread only."""

    def __init__(self, appController, job):
        self.app = appController
        self.view = appController._stageView
        self.settings = appController._dataModel.viewSettings
        self.out = job["out"]
        self.samples = job["samples"]
        self.report = {"steps": {}, "picks": {}}
        self.view.setFixedSize(*SIZE)
        self.settings.showHUD = False  # it shows times

    @property
    def stage(self):
        return self.app._dataModel.stage

    def Events(self, seconds=0.0):
        """Lets usdview work: at least a few rounds of events, and as long as told."""
        end = time.monotonic() + seconds
        for _ in range(10):
            QtWidgets.QApplication.processEvents()
        while time.monotonic() < end:
            QtWidgets.QApplication.processEvents()
            time.sleep(0.005)

    def Converge(self):
        """Draws until the renderer says that nothing better will come."""
        self.view.updateView()
        end = time.monotonic() + CONVERGE_SECONDS
        # What was edited reaches the renderer with the next drawing, not before.
        for _ in range(3):
            self.view.updateGL()
            self.Events()
        while not self.view._renderer.IsConverged():
            self.Events(0.01)
            if time.monotonic() > end:
                raise RuntimeError(f"not converged after {CONVERGE_SECONDS} s")
        self.view.updateGL()
        self.Events()

    def Shoot(self, name):
        """Converges and saves the picture."""
        start = time.monotonic()
        self.Converge()
        image = self.app.GrabViewportShot().convertToFormat(QtGui.QImage.Format_RGBA8888)
        image.save(os.path.join(self.out, f"{name}.png"), "PNG")
        with open(os.path.join(self.out, f"{name}.raw"), "wb") as stream:
            stream.write(bytes(image.constBits()))
        self.report["steps"][name] = {"width": image.width(), "height": image.height(),
                                      "seconds": round(time.monotonic() - start, 3),
                                      "renderer": self.view.rendererDisplayName}
        print(f"step {name}: {time.monotonic() - start:.2f} s", flush=True)

    def SelectRenderer(self, displayName):
        for plugin in UsdImagingGL.Engine.GetRendererPlugins():
            if UsdImagingGL.Engine.GetRendererDisplayName(plugin) == displayName:
                self.app._rendererPluginChanged(plugin)
                self.Events()
                if self.view.rendererDisplayName != displayName:
                    raise RuntimeError(f"usdview did not switch to {displayName}")
                for setting in self.view._renderer.GetRendererSettingsList():
                    if setting.key in ("samples", "convergedSamplesPerPixel"):
                        self.view.SetRendererSetting(setting.key, self.samples)
                return
        raise RuntimeError(f"there is no renderer {displayName}")

    def Mouse(self, kind, button, position, modifiers):
        """Sends one mouse event, as the window system would."""
        local = QtCore.QPointF(*position)
        isHeld = kind != QtCore.QEvent.MouseButtonRelease
        event = QtGui.QMouseEvent(kind, local, self.view.mapToGlobal(local),
                                  button if kind != QtCore.QEvent.MouseMove else QtCore.Qt.NoButton,
                                  button if isHeld else QtCore.Qt.NoButton, modifiers)
        QtWidgets.QApplication.sendEvent(self.view, event)
        self.Events()

    def Drag(self, start, end):
        """Orbits: the left button with Alt held, in ten moves, drawing in between."""
        modifiers = QtCore.Qt.AltModifier
        self.Mouse(QtCore.QEvent.MouseButtonPress, QtCore.Qt.LeftButton, start, modifiers)
        for step in range(1, 11):
            position = [a + (b - a) * step / 10 for a, b in zip(start, end)]
            self.Mouse(QtCore.QEvent.MouseMove, QtCore.Qt.LeftButton, position, modifiers)
        self.Mouse(QtCore.QEvent.MouseButtonRelease, QtCore.Qt.LeftButton, end, modifiers)

    def PixelOf(self, point):
        """Where the picture shows a world point, y down."""
        frustum = self.view.resolveCamera()[0].frustum
        ndc = (frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()).Transform(Gf.Vec3d(*point))
        return (0.5 + 0.5 * ndc[0]) * SIZE[0], (0.5 - 0.5 * ndc[1]) * SIZE[1]

    def Pick(self, name, point):
        """Picks at a world point, as a click there does, and notes what usdview got."""
        _, frustum = self.view.computePickFrustum(*self.PixelOf(point))
        hit, _, path, instance, _, _ = self.view.pick(frustum)
        self.report["picks"][name] = {"path": str(path), "instance": instance, "hit": hit and list(hit)}

    def UseCamera(self, path):
        self.app._cameraSelectionChanged(self.stage.GetPrimAtPath(path))

    def Redice(self):
        """Dices surfaces for the present camera, as a user does with the renderer's command: else they keep the rates
        of the first camera that the renderer has drawn."""
        self.Events()
        for command in self.view.GetRendererCommands():
            if command.commandName == "redice":
                self.view.InvokeRendererCommand(command)


def SelectingAndOrbiting(viewer, renderer):
    viewer.UseCamera("/World/Camera")
    viewer.SelectRenderer(renderer)
    viewer.Redice()
    viewer.Shoot("start")
    viewer.Drag((160, 120), (220, 130))
    viewer.Shoot("orbit")
    viewer.UseCamera("/World/Camera")
    viewer.Shoot("orbitUndone")
    viewer.UseCamera("/World/Side")
    viewer.Shoot("otherCamera")
    viewer.UseCamera("/World/Camera")
    viewer.Shoot("otherCameraUndone")


def EditAndUndo(viewer, name, attribute, value):
    """Sets an attribute's value, shoots, sets the old one again, shoots."""
    old = attribute.Get()
    attribute.Set(value)
    viewer.Shoot(name)
    attribute.Set(old)
    viewer.Shoot(f"{name}Undone")


def Editing(viewer):
    stage = viewer.stage
    stage.SetEditTarget(stage.GetSessionLayer())
    EditAndUndo(viewer, "transform", stage.GetAttributeAtPath("/World/Box.xformOp:translate"), Gf.Vec3d(-0.4, 0.9, 1))
    EditAndUndo(viewer, "camera", stage.GetAttributeAtPath("/World/Camera.focalLength"), 60.0)
    EditAndUndo(viewer, "material", UsdShade.Shader.Get(stage, "/World/Looks/Red/Surface").GetInput("diffuseColor").GetAttr(),
                Gf.Vec3f(0.05, 0.1, 0.9))
    EditAndUndo(viewer, "light", UsdLux.DistantLight.Get(stage, "/World/Sun").GetIntensityAttr(), 0.2)
    EditAndUndo(viewer, "radius", UsdGeom.Sphere.Get(stage, "/World/Ball").GetRadiusAttr(), 0.8)
    points = UsdGeom.Mesh.Get(stage, "/World/Box").GetPointsAttr()
    EditAndUndo(viewer, "points", points, [Gf.Vec3f(p[0], 2 * p[1], p[2]) for p in points.Get()])
    EditAndUndo(viewer, "instances", stage.GetAttributeAtPath("/World/Scatter.positions"),
                [(-2, 2.2, -1), (0, 1.2, -1), (2, 1.8, -1)])
    box = UsdGeom.Imageable.Get(stage, "/World/Box")
    box.MakeInvisible()
    viewer.Shoot("visibility")
    box.MakeVisible()
    viewer.Shoot("visibilityUndone")
    row = UsdGeom.Imageable.Get(stage, "/World/Row")
    row.MakeInvisible()
    viewer.Shoot("instancerHidden")
    row.MakeVisible()
    viewer.Shoot("instancerHiddenUndone")
    ball = stage.GetPrimAtPath("/World/Ball")
    ball.SetActive(False)
    viewer.Shoot("removed")
    ball.SetActive(True)
    viewer.Shoot("removedUndone")


def Purposes(viewer):
    viewer.settings.displayRender = True
    viewer.Shoot("purposeRender")
    viewer.settings.displayRender, viewer.settings.displayProxy = False, True
    viewer.Shoot("purposeProxy")
    viewer.settings.displayProxy, viewer.settings.displayGuide = False, True
    viewer.Shoot("purposeGuide")
    viewer.settings.displayRender, viewer.settings.displayGuide = True, False
    viewer.Shoot("purposeRenderAgain")


def Picking(viewer, picks):
    for name, point in picks.items():
        viewer.Pick(name, point)
    viewer.Shoot("picked")
    selection = viewer.app._dataModel.selection
    position = viewer.PixelOf(picks["mesh"])
    viewer.Mouse(QtCore.QEvent.MouseButtonPress, QtCore.Qt.LeftButton, position, QtCore.Qt.NoModifier)
    viewer.Mouse(QtCore.QEvent.MouseButtonRelease, QtCore.Qt.LeftButton, position, QtCore.Qt.NoModifier)
    viewer.Events(0.2)
    viewer.report["clicked"] = [str(prim.GetPath()) for prim in selection.getPrims()]
    viewer.Shoot("selected")
    selection.clearPrims()
    viewer.Shoot("selectionCleared")


def Buffers(viewer):
    """The other AOVs, through the menu's own function."""
    viewer.report["aovs"] = list(viewer.view.GetRendererAovs())
    for name in ("depth", "normal", "primId"):
        if name in viewer.report["aovs"]:
            viewer.view.SetRendererAov(name)
            viewer.Shoot(f"aov_{name}")
    viewer.view.SetRendererAov("color")
    viewer.Shoot("aovColor")


def Pausing(viewer):
    """Paused and stopped renderers take edits and show them when they go on."""
    light = UsdLux.DistantLight.Get(viewer.stage, "/World/Sun").GetIntensityAttr()
    for begin in (viewer.view.SetRendererPaused, viewer.view.SetRendererStopped):
        begin(True)
        viewer.Events(0.1)
        light.Set(0.2)
        viewer.Events(0.3)
        light.Set(2.0)
        viewer.Events(0.1)
        begin(False)
    viewer.Shoot("resumed")


def Switching(viewer, renderer):
    """To the other renderers and back: at rest, and while it renders."""
    for other in ("GL", "Embree"):
        if other != renderer and other in viewer.report["available"]:
            viewer.SelectRenderer(other)
            viewer.Shoot(f"renderer{other}")
            viewer.SelectRenderer(renderer)
            viewer.Redice()
            viewer.Shoot(f"backFrom{other}")
    for _ in range(3):
        viewer.view._renderer.SetRendererSetting("samples", 4096)
        viewer.UseCamera("/World/Side")
        viewer.Events(0.1)
        viewer.SelectRenderer("GL")
        viewer.Events(0.1)
        viewer.SelectRenderer(renderer)
    viewer.UseCamera("/World/Camera")
    viewer.Redice()
    viewer.Shoot("switched")


def Reloading(viewer, renderer):
    """The file changes on disk and back; the stage is closed and opened again."""
    path = viewer.stage.GetRootLayer().realPath
    with open(path, encoding="utf-8") as stream:
        text = stream.read()
    for name, content in (("reloaded", text.replace("(0.5, 0.5, 0.5)", "(0.1, 0.4, 0.1)")), ("reloadedUndone", text)):
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(content)
        viewer.app._reloadStage()
        viewer.Shoot(name)
    viewer.app._reopenStage()  # closes the renderer; usdview starts its default one when it draws
    viewer.settings.showHUD = False
    viewer.Converge()
    viewer.SelectRenderer(renderer)
    viewer.UseCamera("/World/Camera")
    viewer.Redice()
    viewer.Shoot("reopened")


def MakeSteps(viewer, renderer, picks):
    SelectingAndOrbiting(viewer, renderer)
    Editing(viewer)
    Purposes(viewer)
    Picking(viewer, picks)
    Buffers(viewer)
    Pausing(viewer)
    Switching(viewer, renderer)
    Reloading(viewer, renderer)


def KeepNoneAlive():
    """Workaround for PySide6 6.12 with Python before 3.12, where None is counted like any object: usdview
    24.11 loses about six references to None a repaint, and Python aborts ("deallocating None") after some
    minutes or at the end. Nothing to do from Python 3.12 on."""
    if sys.version_info < (3, 12):
        ctypes.c_ssize_t.from_address(id(None)).value += 1 << 40


def testUsdviewInputFunction(appController):
    KeepNoneAlive()
    with open(os.environ["HDSTREAM_VIEW_JOB"], encoding="utf-8") as stream:
        job = json.load(stream)
    viewer = Viewer(appController, job)
    viewer.report["available"] = [UsdImagingGL.Engine.GetRendererDisplayName(plugin)
                                  for plugin in UsdImagingGL.Engine.GetRendererPlugins()]
    viewer.settings.ambientLightOnly = False  # no light at the camera
    viewer.settings.displayRender, viewer.settings.displayProxy, viewer.settings.displayGuide = True, False, False
    MakeSteps(viewer, job["renderer"], job["picks"])
    # Closed by testusdview while it renders: a good end is exit code 0.
    viewer.view._renderer.SetRendererSetting("samples", 4096)
    viewer.UseCamera("/World/Side")
    viewer.Events(0.1)
    with open(os.path.join(job["out"], "report.json"), "w", encoding="utf-8") as stream:
        json.dump(viewer.report, stream, indent=1)
