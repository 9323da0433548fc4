# SPDX-License-Identifier: Apache-2.0
"""For testusdview --testScript: lets the picture that `usdview ARGUMENTS` opened converge, says what it is, and ends.

$HDSTREAM_VIEW_PICTURE: a file that gets a picture of the whole window. Fails when the view is of one colour.
"""

import os
import time

from pxr.Usdviewq.qt import QtGui, QtWidgets

_SECONDS = 300  # a picture that takes longer does not converge


def _Wait(view, seconds):
    end = time.monotonic() + seconds
    for _ in range(3):  # what was asked for reaches the renderer with the next drawing
        view.updateGL()
        QtWidgets.QApplication.processEvents()
    while not view._renderer.IsConverged():
        QtWidgets.QApplication.processEvents()
        time.sleep(0.01)
        if time.monotonic() > end:
            raise RuntimeError(f"not converged after {seconds} s")
    view.updateGL()
    QtWidgets.QApplication.processEvents()


def testUsdviewInputFunction(appController):
    view = appController._stageView
    target = os.environ.get("HDSTREAM_VIEW_PICTURE")
    if target:
        appController._mainWindow.resize(1160, 700)
        appController._dataModel.viewSettings.showHUD = False
        appController._dataModel.viewSettings.ambientLightOnly = False
        appController._dataModel.viewSettings.domeLightTexturesVisible = True
    else:
        view.setFixedSize(64, 48)
    cameras = [prim for prim in appController._dataModel.stage.Traverse() if prim.GetTypeName() == "Camera"]
    appController._dataModel.viewSettings.cameraPrim = cameras[0]
    _Wait(view, _SECONDS)
    image = appController.GrabViewportShot().convertToFormat(QtGui.QImage.Format_RGBA8888)
    data = bytes(image.constBits())
    assert len({data[i:i + 3] for i in range(0, len(data), 4)}) > 8, "the view is empty"
    print(f"usdview: {view.rendererDisplayName}, {image.width()} x {image.height()}")
    if target:
        appController._mainWindow.grab().save(target)
