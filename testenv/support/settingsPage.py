# SPDX-License-Identifier: Apache-2.0
"""Prints docs/settings.md from the core's settings table: settingsPage.py > docs/settings.md"""

from hdstream import _core

from wrapMarkdown import Wrapped

HEAD = """# Settings

This page lists every setting. One table describes them (hdStream/session/settings.def): the options of `hdstream record`,
the keywords of `Renderer.Render`, the attributes `hdstream:NAME` of UsdRenderSettings prims (both front ends) and the
render settings that Hydra hosts show all come from it. A new setting is a row of the table, the code that reads the setting,
and this page, which `python testenv/support/settingsPage.py` writes.
"""
ADVANCED = """
## For experts

Nobody needs these for a picture: they are here for measurements and comparisons. `hdstream record --help` has them in
a group of their own, hosts of the plug-in show them last, with "(advanced)" in their names.

"""
HOST = """
## Decided by the host

Hosts of the plug-in decide these (image size, camera, purposes ...), so Hydra shows no control for them, and render
settings prims have attributes of their own.

"""


def _RangeOf(info):
    kind = _core.SettingKind
    if info.kind == kind.Choice:
        return ", ".join(info.choices)
    if info.kind == kind.Bool:
        return "true, false"
    if info.kind in (kind.Integer, kind.Number, kind.Bytes):
        return f"{info.minimum:.10g} to {info.maximum:.10g}"
    return {kind.Text: "text", kind.Memory: "a size or a percentage", kind.Names: "names"}[info.kind]


def _DefaultOf(info):
    value = _core.GetSetting(_core.Settings(), info.name)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return ", ".join(value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _Table(rows):
    lines = ["| setting | option | default | values | meaning |", "|---|---|---|---|---|"]
    for info in rows:
        option = f"`{info.option}`" if info.option else ""
        lines.append(f"| `{info.name}` | {option} | {_DefaultOf(info)} | {_RangeOf(info)} | {info.description} |")
    return "\n".join(lines) + "\n"


def PageText():
    table = _core.SettingTable()
    user = _Table([info for info in table if info.isUserSetting and not info.isAdvanced])
    advanced = _Table([info for info in table if info.isAdvanced])
    host = _Table([info for info in table if not info.isUserSetting])
    return Wrapped(f"{HEAD}\n{user}{ADVANCED}{advanced}{HOST}{host}")


if __name__ == "__main__":
    print(PageText(), end="")
