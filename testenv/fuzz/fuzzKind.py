# SPDX-License-Identifier: Apache-2.0
"""What all kinds of fuzzing share. A kind makes its case `number` from (seed, number) alone, writes what it reads into its
folder and runs it in this process; `Run` returns what is wrong with the outcome, or "". Run by worker.py, since a case may
crash."""

import contextlib
import io
import pathlib
import random

from judge import STATISTICS, STATISTICS_PATTERN, Verdict


class Kind:
    """One case at a time; files lie in `folder`, which is the present directory."""

    def __init__(self, folder, seed):
        self.folder, self.seed = pathlib.Path(folder), seed
        self.number, self._written = 0, []

    def Run(self, number: int) -> str:
        self.number = number
        for old in self._written:
            old.unlink(missing_ok=True)
        self._written.clear()
        return self.RunCase(random.Random(f"{self.seed}-{number}"))

    def Write(self, name: str, content) -> str:
        """Writes a file of this case; returns its name, which no other case has: OpenUSD keeps layers by their names."""
        stem, dot, extension = name.rpartition(".")
        path = self.folder / f"{stem}{self.number}{dot}{extension}"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        self._written.append(path)
        return path.name

    def Command(self, *arguments) -> str:
        """What is wrong with a command's exit code, output, image and statistics."""
        from hdstream.cli import Main

        arguments = [str(argument) for argument in arguments]
        if arguments[0] == "record":
            arguments[3:3] = ["--stats", STATISTICS]  # a later --stats wins
        for old in self.folder.glob(STATISTICS_PATTERN):
            old.unlink()
        (self.folder / "command.txt").write_text(repr(arguments), encoding="utf-8")
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = Main(arguments)
            except SystemExit as end:
                code = end.code
        return Verdict(code, err.getvalue(), arguments)

    def Record(self, stage, *options) -> str:
        """A small picture of a stage."""
        for old in self.folder.glob("out.*"):
            old.unlink()
        return self.Command("record", stage, "out.exr", "--quiet", *options)
