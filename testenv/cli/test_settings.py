# SPDX-License-Identifier: Apache-2.0
"""The settings table as Python, the command line and the docs see it."""

import sys
from pathlib import Path

import pytest

from hdstream import _core

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_is_current():
    """docs/settings.md is what testenv/support/settingsPage.py prints."""
    sys.path.insert(0, str(ROOT / "testenv" / "support"))
    try:
        import settingsPage
    finally:
        sys.path.pop(0)
    assert (ROOT / "docs" / "settings.md").read_text(encoding="utf-8") == settingsPage.PageText()


def test_values_keep_their_types():
    settings = _core.Settings()
    for info in _core.SettingTable():
        value = _core.GetSetting(settings, info.name)
        _core.SetSetting(settings, info.name, value)
        assert _core.GetSetting(settings, info.name) == value
        assert type(_core.GetSetting(settings, info.name)) is type(value)


def test_wrong_values_are_usage_errors():
    with pytest.raises(_core.UsageError, match="--samples"):
        _core.SetSetting(_core.Settings(), "samples", 0)
    with pytest.raises(_core.UsageError, match="--subdivision"):
        _core.SetSetting(_core.Settings(), "subdivision", "some")
