# SPDX-License-Identifier: Apache-2.0
"""What the options of `hdstream record` ask for, checked: a job and its frames, for one process or a farm."""

import os

from hdstream import _core
from hdstream.denoiser import FindDenoiser
from hdstream.errors import CommandError, UsageError
from hdstream.frameJob import Frame, Job
from hdstream.stage import FrameOutputs


def CheckArguments(args):
    """Whatever needs no stage."""
    for name in args.aovs or ():
        if not _core.HasAov(name):
            known = [info.name for info in _core.AovTable()]
            raise UsageError(f"--aovs {name}: none of {', '.join(known)}, primvars:NAME")
    if args.aovs is not None and not args.aovs:
        raise UsageError("--aovs: no names")
    FindDenoiser()
    if args.denoise:
        _core.CheckDenoiser()
    for option in ("split", "parts"):
        if getattr(args, option) and not (args.scheduler or args.workers):
            raise UsageError(f"--{option}: needs --scheduler or --workers")
    if "#" not in args.output:
        _core.CheckImageFile(args.output)
    if args.stats:
        folder = os.path.dirname(args.stats) or "."
        if not os.path.isdir(folder) or os.path.isdir(args.stats) or not os.access(folder, os.W_OK):
            raise CommandError(f"--stats {args.stats}: cannot be written")


def JobOf(args):
    """The options as values that any process can work on."""
    values = {info.name: getattr(args, info.name, None) for info in _core.SettingTable()}
    return Job(args.stage, tuple(args.mask or ()), {name: value for name, value in values.items() if value is not None},
               args.renderSettingsPrimPath, args.colorCorrectionMode, args.resume)


def FramesOf(args, stage):
    """The frames to render, their files checked."""
    outputs = FrameOutputs(stage, args.frames, args.defaultTime, args.output)
    frames = [Frame(timeCode, outputs.FileOf(timeCode),
                    outputs.StatsFileOf(args.stats, timeCode) if args.stats else None)
              for timeCode in outputs.timeCodes]
    for frame in frames:
        _core.CheckImageFile(frame.file)
    return frames
