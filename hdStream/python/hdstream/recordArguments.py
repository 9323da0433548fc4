# SPDX-License-Identifier: Apache-2.0
"""What the options of `hdstream record` ask for, checked: a job and its frames, for one process or a farm."""

import math
import os

from hdstream import _core
from hdstream.denoiser import FindDenoiser
from hdstream.errors import CommandError, UsageError
from hdstream.frameJob import Frame, Job
from hdstream.products import FindPictures, HasProducts, Output
from hdstream.renderSettings import SettingsPathOf
from hdstream.stage import FrameOutputs, ParseFrames, StartTimeOf


def CheckArguments(args):
    """Whatever needs no stage."""
    for name in args.aovs or ():
        if not _core.HasAov(name):
            known = [info.name for info in _core.AovTable()]
            raise UsageError(f"--aovs {name}: none of {', '.join(known)}, primvars:NAME, lpe:EXPRESSION, lightGroup:NAME, variance:NAME of light")
    if args.aovs is not None and not args.aovs:
        raise UsageError("--aovs: no names")
    if args.mask is not None and not args.mask:
        raise UsageError("--mask: no paths")
    if args.aovs:
        _core.CheckAovs(list(args.aovs))
    FindDenoiser()
    if args.denoise:
        _core.CheckDenoiser()
    for option in ("split", "parts"):
        if getattr(args, option) and not (args.scheduler or args.workers):
            raise UsageError(f"--{option}: needs --scheduler or --workers")
    if args.snapshot and (args.scheduler or args.workers):
        raise UsageError("--snapshot: not with --scheduler or --workers")
    if args.output is None and args.aovs:
        raise UsageError("--aovs: files of render products hold the render vars of their product; say OUT to choose others")
    if args.output is None and args.deep:
        raise UsageError("--deep: render products say by their productType whether they are deep; say OUT")
    if args.deep and os.path.splitext(args.output)[1].lower() != ".exr":
        raise UsageError(f"--deep: {args.output} is no .exr, and only these are deep")
    if args.deep and args.aovs and args.aovs != ["color"]:
        raise UsageError("--deep: a deep file holds colour and depth alone, and no other --aovs")
    if args.output is not None and "#" not in args.output:
        _core.CheckImageFile(args.output, list(args.aovs or ()))
    if args.stats:
        folder = os.path.dirname(args.stats) or "."
        if not os.path.isdir(folder) or os.path.isdir(args.stats) or not os.access(folder, os.W_OK):
            raise CommandError(f"--stats {args.stats}: cannot be written")


def JobOf(args):
    """The options as values that any process can work on."""
    values = {info.name: getattr(args, info.name, None) for info in _core.SettingTable()}
    return Job(args.stage, tuple(args.mask or ()), {name: value for name, value in values.items() if value is not None},
               args.renderSettingsPrimPath, args.renderPassPrimPath, args.colorCorrectionMode, args.resume,
               args.snapshot)


def FramesOf(args, stage, warn):
    """The frames to render, their files checked. `warn(subject, text)` is called."""
    frames = _FramesOfOutput(args, stage) if args.output is not None else _FramesOfProducts(args, stage, warn)
    files = [file for frame in frames for file in [output.file for output in frame.outputs] or [frame.file]]
    for frame in frames:
        for output in frame.outputs or [Output(frame.file, None)]:
            _core.CheckImageFile(output.file, list(args.aovs or ()) if output.layers is None else [_MainLayer(output.layers).aov])
    if args.stats:
        _CheckStatsFiles({frame.statsFile for frame in frames}, {"the picture": files, "the stage": [args.stage]})
    return frames


def _MainLayer(layers):
    """Which of a file's layers formats with room for one store."""
    return next((layer for layer in layers if layer.aov == "color"), layers[0])


def FramesToPrepare(args, stage, warn):
    """The frames that FramesOf gives, without their files; where there is neither OUT nor a product, those of one picture."""
    if args.output is None and HasProducts(stage, SettingsPathOf(stage, args.renderSettingsPrimPath, args.renderPassPrimPath,
                                                                 _Session(warn)), _Session(warn)):
        return _FramesOfProducts(args, stage, warn)
    timeCodes = ParseFrames(args.frames)[0] if args.frames is not None else [StartTimeOf(stage, args.defaultTime)]
    return [Frame(timeCode, "") for timeCode in timeCodes]


def _CheckStatsFiles(statsFiles, others):
    nounByFile = {os.path.realpath(file): noun for noun, files in others.items() for file in files}
    for file in statsFiles:
        if os.path.realpath(file) in nounByFile:
            raise UsageError(f"--stats {file}: is {nounByFile[os.path.realpath(file)]} too, which it would overwrite")


def _FramesOfOutput(args, stage):
    outputs = FrameOutputs(stage, args.frames, args.defaultTime, args.output)
    frames = [Frame(timeCode, outputs.FileOf(timeCode), outputs.StatsFileOf(args.stats, timeCode) if args.stats else None)
              for timeCode in outputs.timeCodes]
    _CheckOneFrameEach(args, [(frame.file, frame.timeCode) for frame in frames])
    if args.stats and "#" in args.stats:
        _CheckOneFrameEach(args, [(frame.statsFile, frame.timeCode) for frame in frames])
    return frames


def _CheckOneFrameEach(args, files):
    """Raises UsageError where two time codes have one file."""
    timeOf = {}
    for file, timeCode in files:
        other = timeOf.setdefault(os.path.abspath(file), timeCode)
        if other != timeCode and not math.isnan(other):
            raise UsageError(f"--frames {args.frames}: {file} would hold both {other:.17g} and {timeCode:.17g}; its placeholder "
                             "needs more digits after the dot")


def _FramesOfProducts(args, stage, warn):
    """A frame for each time and each picture that products need; products that differ in files alone share one."""
    session = _Session(warn)
    path = SettingsPathOf(stage, args.renderSettingsPrimPath, args.renderPassPrimPath, session)
    pictures = FindPictures(stage, path, session)
    if args.stats and (len(pictures) > 1 or args.frames):
        raise UsageError("--stats: one file cannot hold the statistics of several pictures; say OUT")
    frames, productOf = [], {}
    timeCodes = ParseFrames(args.frames)[0] if args.frames is not None else [StartTimeOf(stage, args.defaultTime)]
    for timeCode in timeCodes:
        for picture in pictures:
            outputs = picture.OutputsAt(timeCode)
            for index, output in enumerate(outputs):
                path = str(picture.prims[index].GetPath())
                if "#" in output.file:
                    if math.isnan(timeCode):
                        raise UsageError(f"{path}: productName {output.file}: a frame placeholder needs a frame, and "
                                         "--defaultTime has none")
                    names = FrameOutputs(stage, args.frames or f"{timeCode:.0f}", args.defaultTime, output.file)
                    output.file = names.FileOf(timeCode)
                other = productOf.setdefault(os.path.abspath(output.file), (path, timeCode))
                if other != (path, timeCode):
                    raise UsageError(f"{path}: {output.file} is also written by {other[0]} at {other[1]:g}; a productName of "
                                     "several frames needs #### or values over time")
            frames.append(Frame(timeCode, outputs[0].file, args.stats, picture.product, tuple(outputs)))
    return frames


class _Session:
    """What finds products warns here."""

    def __init__(self, warn):
        self.Warn = warn
