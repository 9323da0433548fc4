# SPDX-License-Identifier: Apache-2.0
"""The render engine: Blender's own host of Hydra delegates, with our settings, passes, status and messages.

A final render goes in steps: the plug-in tells Blender that it has converged whenever a step is over, so that control comes
back here, where the status is shown and messages are reported, and the next step begins.
"""

import itertools

import bpy

from . import leftOut, passes, plugin, settings

_STEP_SECONDS = 0.2  # of a final render, after which it can be cancelled
_names = itertools.count()


class StreamRenderEngine(bpy.types.HydraRenderEngine):
    bl_idname = "HYDRA_STREAM"
    bl_label = "Stream"
    bl_use_preview = True
    bl_use_gpu_context = False  # frames are in host memory
    bl_use_materialx = True
    bl_delegate_id = "HdStreamRendererPlugin"

    def get_render_settings(self, engine_type):
        isViewport = engine_type == "VIEWPORT"
        values = settings.Values(self._Scene(), isViewport)
        values["hostExporter"] = "blender"
        values["hostStatusName"] = self._Name()
        values["enableInteractive"] = isViewport
        if not isViewport:
            values["hostStepSeconds"] = _STEP_SECONDS
            layer = self._layer
            values |= {f"aovToken:{item.name}": item.output for item in self._Passes(layer)}
        return values

    # --- Final renders and previews ------------------------------------------------------------------

    def update(self, data, depsgraph):
        self._scene, self._layer = depsgraph.scene, depsgraph.view_layer
        if self._HasProblem():
            return
        super().update(data, depsgraph)
        if not self.engine_ptr:
            self._Tell("ERROR", "Stream: Blender could not make the renderer; its terminal says why")
        elif not self.is_preview:
            self._TellOnce([("WARNING", line) for line in _LeftOut(depsgraph)])

    def render(self, depsgraph):
        if not getattr(self, "engine_ptr", None):
            return
        import _bpy_hydra

        for item in self._Passes(depsgraph.view_layer):
            if not item.isBuiltIn:
                self.add_pass(item.name, len(item.channels), item.channels, layer=depsgraph.view_layer.name)
        status = None
        while not self._IsCancelled():
            # The step after the one in which the render was done shows its last picture.
            isLast = status is not None and status["isDone"]
            _bpy_hydra.engine_render(self.engine_ptr)
            status = plugin.Status(self._Name())
            if status is None or isLast:
                break
            self._Show(status, f"{depsgraph.scene.name}, {depsgraph.view_layer.name}")
        for layer in self.get_result().layers if not self.is_preview else ():
            passes.Finish(layer)
        self._Report(status)

    def update_render_passes(self, scene, render_layer):
        for item in passes.Of(scene, render_layer):
            self.register_pass(scene, render_layer, item.name, len(item.channels), item.channels, item.kind)

    # --- Viewport ------------------------------------------------------------------------------------

    def view_update(self, context, depsgraph):
        self._scene = depsgraph.scene
        if not self._HasProblem():
            super().view_update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        if plugin.Problem():
            self.update_stats("", plugin.Problem())
            return
        super().view_draw(context, depsgraph)
        status = plugin.Status(self._Name()) if getattr(self, "engine_ptr", None) else None
        if status is not None:
            self._Show(status, "")
            self._Report(status)

    # --- Both ----------------------------------------------------------------------------------------

    def _Scene(self):
        return getattr(self, "_scene", None) or bpy.context.scene

    def _Name(self):
        """By which the plug-in tells this engine's status."""
        if not getattr(self, "_name", ""):
            self._name = f"engine {next(_names)}"
        return self._name

    def _Passes(self, layer):
        return passes.Of(self._Scene(), layer)[:1 if self.is_preview else None]

    def _HasProblem(self):
        problem = plugin.Problem()
        if problem:
            self._Tell("ERROR", problem)
        return bool(problem)

    def _Show(self, status, title):
        if status["error"]:
            self.update_stats("", status["error"])
            return
        self.update_progress(status["fraction"])
        self.update_stats(title, StatusLine(status))

    def _Report(self, status):
        """What went wrong, each line once for an engine."""
        if status is None:
            return
        lines = [("WARNING", line) for line in status["warnings"]]
        if status["error"]:
            lines.append(("ERROR", f"Stream: {status['error']}"))
        self._TellOnce(lines)

    def _TellOnce(self, lines):
        told = self.__dict__.setdefault("_told", set())
        for kind, line in lines:
            if line not in told:
                told.add(line)
                self._Tell(kind, line)

    # Functions of Blender's own cannot be replaced by tests.

    def _Tell(self, kind, line):
        self.report({kind}, line)

    def _IsCancelled(self):
        return self.test_break()


def _LeftOut(depsgraph):
    """What is only told of a scene never stops its render."""
    try:
        return leftOut.Lines(depsgraph)
    except Exception as error:  # pylint: disable=broad-except
        return [f"Stream: cannot tell what Blender does not hand over: {type(error).__name__}: {error}"]


def StatusLine(status):
    """Samples, time left, bytes of geometry and textures: the most that was in device memory, and all that was loaded."""
    if status["fraction"] <= 0.0:
        return "Preparing the scene"
    total = status["samplesTotal"]
    done = total if status["fraction"] >= 1.0 else status["samplesDone"]
    words = [f"Sample {done}/{total}"]
    if not status["isDone"]:
        words.append(f"Left {_Clock(status['secondsElapsed'] * (1.0 / status['fraction'] - 1.0))}")
    statistics = status["statistics"] or {}
    kinds = [statistics.get(name) or {} for name in ("geometry", "texture")]
    resident = sum(kind.get("peakBytes", 0) + kind.get("alwaysResidentBytes", 0) for kind in kinds)
    words.append(f"Resident {_Bytes(resident)}")
    words.append(f"Loaded {_Bytes(sum(kind.get('uploadedBytes', 0) for kind in kinds))}")
    return " | ".join(words)


def _Clock(seconds):
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes:02d}:{seconds:02d}"


def _Bytes(count):
    for unit in ("B", "K", "M"):
        if count < 1024:
            return f"{count:.0f}{unit}"
        count /= 1024
    return f"{count:.2f}G"


register, unregister = bpy.utils.register_classes_factory((StreamRenderEngine,))
