# SPDX-License-Identifier: Apache-2.0
"""OpenUSD's own errors and warnings as single lines that name the prim or file.

A delegate keeps them off stderr; they are taken and turned into warnings where a session exists.
"""

import re

from pxr import Tf, UsdUtils

from hdstream import materialXFiles
from hdstream.errors import OneLine
from hdstream.texts import NumPrimsText

_ERROR = re.compile(r"Error in '.*?' at line \d+ in file .*? : '(.*?)'\s*(?=$|\n\s*Error in )", re.DOTALL)
_CLIP = "Unable to open clip layer @"  # the translation says so, with the prim
_UNOPENED = re.compile(r"Could not open asset @([^@]*\.mtlx)@", re.IGNORECASE)
_PRIM = re.compile(r"^In <([^>]*)>: *(.*)$")
_NOT_APPLIED = re.compile(r"^Found material bindings on prim at path \((.*)\) but MaterialBindingAPI is not applied on the prim$")
_CYCLE = re.compile(r"Cycle detected:.*?(?= *\((?:instantiating|recomposing) |$)", re.DOTALL)  # each place on a line of its own
_GOES_ON = re.compile(r"\s*\n; ")  # after what the reader of a layer has said
_SESSION_LAYER = re.compile(r"@,@anon:[^@]*@")
_ORIGIN = re.compile(r" *\((?:instantiating|recomposing)[^()]*stage on stage @[^@]*@ <[^>]*>\)\.?$")


class Diagnostics:
    """Collects all diagnostics from its creation on."""

    def __init__(self):
        self._delegate = UsdUtils.CoalescingDiagnosticDelegate()

    def Take(self):
        """(subject, text) of everything since the last call, each once, in order; prims with bindings but no
        MaterialBindingAPI, of which older exporters write a stage full, as one."""
        found, notApplied = {}, set()
        for diagnostic in self._delegate.TakeUncoalescedDiagnostics():
            text = _GOES_ON.sub("; ", str(diagnostic.commentary))
            for line in _CYCLE.sub(_OneLineOfCycle, text).splitlines():
                entry = _Parse(line.strip())
                if entry is None or _IsOutdated(entry[1]):
                    continue
                if binding := _NOT_APPLIED.match(entry[1]):
                    notApplied.add(binding.group(1))
                else:
                    found[entry] = None
        if notApplied:
            count = NumPrimsText(len(notApplied))
            found[min(notApplied), f"material bindings without MaterialBindingAPI, which not every OpenUSD takes: {count}"] = None
        return list(found)

    def WarnOf(self, session):
        """Passes what was collected on as warnings of the session."""
        for subject, text in self.Take():
            session.Warn(subject, text)


def _OneLineOfCycle(match):
    """How a cycle of references goes, without the session layer that each of its places names."""
    return _SESSION_LAYER.sub("@", OneLine(match.group()))


def _Parse(line):
    """The prim a diagnostic names, and its text without the addresses of stages in memory."""
    line = _ORIGIN.sub("", line)
    if not line:
        return None
    match = _PRIM.match(line)
    return (match.group(1), OneLine(match.group(2))) if match else ("USD", OneLine(line))


def _IsOutdated(text):
    """Whether OpenUSD could not open a MaterialX file that was read since, or a value clip."""
    if text.startswith(_CLIP):
        return True
    match = _UNOPENED.search(text)
    return match is not None and materialXFiles.IsRead(match.group(1))


def MessagesOf(error):
    """The texts of a Tf.ErrorException, outermost last."""
    texts = [OneLine(text) for text in _ERROR.findall(str(error))]
    return texts or [OneLine(error)]


TfError = Tf.ErrorException
