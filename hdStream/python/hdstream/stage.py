# SPDX-License-Identifier: Apache-2.0
"""Opening a stage and choosing its time codes, as usdrecord does."""

import os
import re

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from hdstream.diagnostics import MessagesOf, TfError
from hdstream.errors import CommandError, UsageError
from hdstream.materialXFiles import ReplaceFiles
from hdstream.pipeWatch import IS_PIPE, StandIn, Watched

_MOST_FRAMES = 1_000_000
_LAST_FRAME = 2 ** 53  # doubles hold every whole number up to it
_PLACEHOLDER = re.compile(r"^[^#]*(#+(?:\.(#+))?)[^#]*$")


def _OpenPastPipes(Open):
    """(stage, paths of pipes among its files). Of pipes that are value clips OpenUSD raises an error: then once more without."""
    paths = []
    while True:
        try:
            with Watched() as pipes:
                stage = Open()
            return stage, list(dict.fromkeys(paths + pipes.paths))
        except TfError:
            if set(pipes.paths) <= set(paths):
                raise
        for file in pipes.paths:
            StandIn(file)
        paths += pipes.paths


def OpenStage(path, maskPaths=()):
    """The stage, with a population mask when paths are given."""
    resolved = str(Ar.GetResolver().Resolve(path))
    if not resolved:
        raise CommandError(f"{path}: no such file")
    if os.path.exists(resolved) and not os.path.isfile(resolved):  # of a pipe OpenUSD would wait for the writer
        raise CommandError(f"{path}: not a USD stage: is not a file")
    mask = Usd.StagePopulationMask()
    for maskPath in maskPaths or ():
        if not Sdf.Path.IsValidPathString(maskPath) or not Sdf.Path(maskPath).IsAbsolutePath():
            raise UsageError(f"--mask {maskPath}: not an absolute prim path")
        mask.Add(maskPath)
    try:
        stage, pipes = _OpenPastPipes(lambda: Usd.Stage.OpenMasked(path, mask) if maskPaths else Usd.Stage.Open(path))
    except TfError as error:
        causes = [text for text in MessagesOf(error) if not text.startswith("Failed to open layer")]
        raise CommandError(f"{path}: not a USD stage: {causes[0] if causes else 'cannot be read'}") from None
    if not stage:
        raise CommandError(f"{path}: not a USD stage")
    for file in pipes:
        Tf.Warn(f"{file} {IS_PIPE}")
    for file, problem in ReplaceFiles(stage):
        Tf.Warn(f"{file} {problem}")
    return stage


def StartTimeOf(stage, isDefaultTime):
    """The time code of a single frame."""
    return Usd.TimeCode.Default().GetValue() if isDefaultTime else stage.GetStartTimeCode()


class FrameOutputs:
    """The time codes to render and the file of each."""

    def __init__(self, stage, frames, isDefaultTime, output):
        self._output = output
        match = _PLACEHOLDER.match(output)
        self._placeholder = match.group(1) if match else None
        precision = len(match.group(2) or "") if match else 0
        if "#" in output and not match:
            raise UsageError(f"{output}: more than one frame placeholder")
        if frames is not None:
            self.timeCodes, needed = ParseFrames(frames)
            if len(self.timeCodes) > 1 and not match:
                raise UsageError(f"{output}: --frames {frames} needs a frame placeholder such as ####")
            if match and precision < needed:
                raise UsageError(f"{output}: --frames {frames} needs a placeholder with {needed} digits "
                                 f"after the dot, as ####.{'#' * needed}")
        else:
            if match:
                raise UsageError(f"{output}: a frame placeholder needs --frames")
            self.timeCodes = [StartTimeOf(stage, isDefaultTime)]
        self._format = f"0{len(self._placeholder)}.{precision}f" if match else ""

    def FileOf(self, timeCode):
        if not self._placeholder:
            return self._output
        return self._output.replace(self._placeholder, format(timeCode, self._format))

    def StatsFileOf(self, file, timeCode):
        """The statistics file of a frame: a placeholder in its name is honoured too."""
        match = _PLACEHOLDER.match(file)
        if not match or not self._placeholder:
            return file
        digits = len(match.group(2) or "")
        return file.replace(match.group(1), format(timeCode, f"0{len(match.group(1))}.{digits}f"))


def ParseFrames(spec):
    """usdrecord's frame specs: (time codes, digits after the dot that tell them apart)."""
    timeCodes = []
    precision = 0
    for part in spec.split(","):
        try:
            if part.endswith(":"):
                raise ValueError("OpenUSD's parser crashes where a range has no end")
            codes = UsdUtils.TimeCodeRange.CreateFromFrameSpec(part)
            ends = (codes.startTimeCode.GetValue(), codes.endTimeCode.GetValue())
            if not all(abs(end) <= _LAST_FRAME for end in ends):
                raise ValueError("infinite, or so large that frames cannot be told apart")
            length = ends[1] - ends[0]
            if len(timeCodes) + length / codes.stride >= _MOST_FRAMES:
                raise UsageError(f"--frames {spec}: more than {_MOST_FRAMES} frames")
            timeCodes.extend(code.GetValue() for code in codes)
        except (TfError, ValueError):
            raise UsageError(f"--frames {part}: not a frame spec such as 101, 101:105 or 101:109x2") from None
        ends, _, stride = part.partition("x")
        precision = max(precision, *(len(text.partition(".")[2].rstrip("0")) for text in (stride, *ends.split(":"))))
    if not timeCodes:
        raise UsageError(f"--frames {spec}: no frames")
    return timeCodes, precision
