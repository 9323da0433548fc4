# SPDX-License-Identifier: Apache-2.0
"""What a translation could not represent: one warning per prim, or per kind with its count."""

from hdstream.texts import NumPrimsText


class Reports:
    """Collects counted warnings and passes single ones on at once."""

    def __init__(self, session):
        self._session = session
        self._counts = {}  # text with {count} -> [count, path of the first prim]

    def Warn(self, prim, text):
        self._session.Warn(prim.GetPath().pathString, text)

    def Count(self, prim, text):
        """Counts a prim under `text`, in which {count} becomes the number when flushed."""
        entry = self._counts.setdefault(text, [0, prim.GetPath().pathString])
        entry[0] += 1

    def Flush(self):
        """Writes the counted warnings: the first prim's path, then the text."""
        for text, (count, firstPath) in sorted(self._counts.items()):
            self._session.Warn(firstPath, text.format(count=NumPrimsText(count)))
        self._counts.clear()
