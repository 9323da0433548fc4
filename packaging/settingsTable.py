# SPDX-License-Identifier: Apache-2.0
"""The core's table of settings for programs that do not load the core: settingsTable.py MODULES > settings.json

MODULES: the build's folder with the package hdstream. Only what users set is written, in the order in which it is shown."""

import json
import pathlib
import sys


def Rows(core) -> list[dict]:
    """A row a setting: name, label, description, kind, group, choices, minimum, maximum, isAdvanced, default."""
    defaults = core.Settings()
    return [{"name": row.name, "label": row.label, "description": row.description, "kind": row.kind.name,
             "group": row.group.name, "choices": list(row.choices), "minimum": row.minimum, "maximum": row.maximum,
             "isAdvanced": row.isAdvanced, "default": core.GetSetting(defaults, row.name)}
            for row in core.SettingTable() if row.isUserSetting]


if __name__ == "__main__":
    sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "hdstream"))  # the package itself asks for more
    import _core
    print(json.dumps(Rows(_core), indent=1))
