# SPDX-License-Identifier: Apache-2.0
"""Messages that docs/troubleshooting.md explains are messages that the program has."""

import pathlib
import re

_ROOT = pathlib.Path(__file__).resolve().parents[2]
_SOURCES = ("*.cpp", "*.h", "*.py")


def _Literals() -> str:
    """All sources; texts that are written in several pieces are joined."""
    text = "\n".join(path.read_text(encoding="utf-8") for pattern in _SOURCES
                     for path in sorted((_ROOT / "hdStream").rglob(pattern)))
    return re.sub(r'"\s*\n\s*f?"', "", text)


def test_every_message_is_in_the_sources():
    page = (_ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
    messages = [cell for cell in re.findall(r"^\| `([^`]+)` \|", page, re.MULTILINE)]
    assert len(messages) > 25
    literals = _Literals()
    missing = [message for message in messages if message not in literals]
    assert not missing
