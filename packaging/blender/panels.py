# SPDX-License-Identifier: Apache-2.0
"""Panels: those of the settings are made from the table; Blender's own are shown for this engine too."""

import bpy

from . import passes, settings
from .engine import StreamRenderEngine

_ENGINES = {StreamRenderEngine.bl_idname}
_TITLES = {"Quality": "Sampling and Light Paths", "Picture": "Picture and Denoising", "Memory": "Memory and Residency",
           "Machine": "Device and Cache"}


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = _ENGINES

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def _SettingsPanel(name, title, where=None, rows=(), parent="", isClosed=False):
    """A panel of some rows of the table; `where` gets the property group of a scene's settings."""

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for row in rows:
            layout.prop(where(context.scene.hdstream), row["name"])

    words = {"bl_label": title, "draw": draw, "bl_options": {"DEFAULT_CLOSED"} if isClosed else set()}
    if parent:
        words["bl_parent_id"] = parent
    return type(name, (_Panel, bpy.types.Panel), words)


def _Final(groups):
    return groups.final


def _Viewport(groups):
    return groups.viewport


def _Machine(groups):
    return groups.machine


def _OfSettings():
    """A panel for each group of the table, in its order; inside it one for what experts try."""
    panels = []
    for group in dict.fromkeys(row["group"] for row in settings.ROWS):
        rows = [row for row in settings.ROWS if row["group"] == group]
        users, experts = ([row for row in rows if row["isAdvanced"] == isAdvanced] for isAdvanced in (False, True))
        name, title = f"STREAM_RENDER_PT_{group.lower()}", _TITLES.get(group, group)
        if not settings.IsOfPicture(rows[0]):
            panels.append(_SettingsPanel(name, title, _Machine, users, isClosed=True))
            panels.append(_SettingsPanel(f"{name}_experts", "For Experts", _Machine, experts, name, isClosed=True))
            continue
        panels.append(_SettingsPanel(name, title))
        for suffix, label, where in (("viewport", "Viewport", _Viewport), ("final", "Render", _Final)):
            part = f"{name}_{suffix}"
            panels.append(_SettingsPanel(part, label, where, users, name))
            panels.append(_SettingsPanel(f"{part}_experts", "For Experts", where, experts, part, isClosed=True))
    return panels


class STREAM_RENDER_PT_film(_Panel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(context.scene.render, "film_transparent", text="Transparent")
        if hasattr(context.scene, "cycles"):
            self.layout.prop(context.scene.cycles, "film_exposure", text="Exposure")


class STREAM_RENDER_PT_export(_Panel, bpy.types.Panel):
    bl_label = "Scene Export"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(context.scene.hydra, "export_method")


class STREAM_VIEW_LAYER_PT_passes(_Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(heading="Include")
        for switch in passes.SWITCHES:
            column.prop(context.view_layer, switch)
        column.prop(context.view_layer.hdstream, "use_denoising_data")


class STREAM_LIGHT_PT_light(_Panel, bpy.types.Panel):
    """What of a light comes through Hydra."""

    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light

    def draw(self, context):
        layout, light = self.layout, context.light
        layout.row().prop(light, "type", expand=True)
        layout.use_property_split = True
        layout.use_property_decorate = False
        names = ["color", "energy"]
        names += {"POINT": ["shadow_soft_size"], "SPOT": ["shadow_soft_size", "spot_size", "spot_blend", "show_cone"],
                  "SUN": ["angle"], "AREA": ["shape", "size"]}[light.type]
        if light.type == "AREA" and light.shape in {"RECTANGLE", "ELLIPSE"}:
            names.append("size_y")
        column = layout.column()
        for name in ("use_temperature", "temperature"):
            if hasattr(light, name):  # since Blender 4.5
                column.prop(light, name)
        for name in names:
            column.prop(light, name)
        for name in ("exposure", "normalize"):
            if hasattr(light, name):
                column.prop(light, name)


_CLASSES = (*_OfSettings(), STREAM_RENDER_PT_film, STREAM_RENDER_PT_export, STREAM_VIEW_LAYER_PT_passes, STREAM_LIGHT_PT_light)

# Of the panels that Blender shows for its own engines: those that say nothing here, and those of Eevee that do.
_NOT_SHOWN = {"RENDER_PT_stamp", "DATA_PT_light", "DATA_PT_spot", "NODE_DATA_PT_light", "DATA_PT_falloff_curve",
              "RENDER_PT_freestyle", "RENDER_PT_gpencil", "SCENE_PT_audio"}
_OF_EEVEE = {"MATERIAL_PT_preview", "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface",
             "EEVEE_MATERIAL_PT_displacement", "EEVEE_WORLD_PT_surface", "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture",
             "DATA_PT_preview", "PARTICLE_PT_render"}


def _Blenders():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and panel.__name__ not in _NOT_SHOWN:
            yield panel
        elif panel.__name__ in _OF_EEVEE and {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"} & set(engines):
            yield panel


def register():
    for item in _CLASSES:
        bpy.utils.register_class(item)
    for panel in _Blenders():
        panel.COMPAT_ENGINES.add(StreamRenderEngine.bl_idname)


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        if panel not in _CLASSES:
            getattr(panel, "COMPAT_ENGINES", set()).discard(StreamRenderEngine.bl_idname)
    for item in reversed(_CLASSES):
        bpy.utils.unregister_class(item)
