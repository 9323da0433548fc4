# SPDX-License-Identifier: Apache-2.0
"""hdStream as a render engine of Blender: *Stream*. Explained in docs/blender.md; packaging/blenderExtension.py makes the zip."""

from . import engine, panels, plugin, settings

_PARTS = (settings, engine, panels)


def register():
    plugin.Prepare()
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
