# SPDX-License-Identifier: Apache-2.0
"""The settings table as Python, the command line and the docs see it."""

import argparse
import sys
from pathlib import Path

import pytest

from cliCase import RunHere, WriteStage
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


@pytest.mark.parametrize("text", ["12Q", "", "0", "1,5G", "99999999T"])
def test_wrong_sizes_have_one_text_everywhere(text):
    """The command line's, and that of keywords and attributes, is the core's."""
    from hdstream import options
    for parse, coreParse in ((options.Bytes, _core.ParseBytes), (options.MemorySize, _core.ParseMemorySize)):
        with pytest.raises(_core.UsageError) as core:
            coreParse(text)
        with pytest.raises(argparse.ArgumentTypeError) as raised:
            parse(text)
        assert str(raised.value) == str(core.value)
    if text:
        with pytest.raises(_core.UsageError) as raised:
            _core.SetSetting(_core.Settings(), "geometryMemory", text)
        assert str(raised.value) == f"--geometryMemory: {core.value}"


def test_help_keeps_what_experts_try_in_a_group_of_its_own():
    help = RunHere("record", "--help").out
    before, experts = help.split("for experts", 1)
    for info in _core.SettingTable():
        if info.option:
            assert (f"\n  {info.option}" in experts) == info.isAdvanced, info.name
            assert (f"\n  {info.option}" in before) != info.isAdvanced, info.name


def test_settings_of_memory_and_machine_change_no_bit(tmp_path):
    """--resume takes pictures that differ in these for the same."""
    import hdstream
    renderer = hdstream.Renderer(str(WriteStage(tmp_path)))
    same = dict(imageWidth=12, imageHeight=8, samples=4)
    expected = renderer.Render(**same).aovs["color"]
    assert expected.any()
    for info in _core.SettingTable():
        if info.group in (_core.SettingGroup.Memory, _core.SettingGroup.Machine):
            for value in _OtherValues(info, tmp_path):
                found = renderer.Render(**same, **{info.name: value}).aovs["color"]
                assert (found == expected).all(), (info.name, value)


def _OtherValues(info, folder):
    kinds = _core.SettingKind
    return {kinds.Choice: lambda: info.choices, kinds.Bool: lambda: [True, False], kinds.Memory: lambda: ["64M", "100%"],
            kinds.Text: lambda: [str(folder) if info.name == "cacheDirectory" else _core.FindDevice("").name],
            kinds.Integer: lambda: [16], kinds.Bytes: lambda: [1 << 16], kinds.Number: lambda: [info.maximum]}[info.kind]()
