# SPDX-License-Identifier: Apache-2.0
"""What a farm's workers do: functions that dask calls by name, with plain values in and out (docs/farm.md).

A process keeps the stage of the job it last worked for: frames and parts of one job share what is loaded and
prepared. One task at a time in a process, whatever the number of the worker's threads.
"""

import threading
import time

import numpy as np

from hdstream import _core, filmSums
from hdstream.errors import EXIT_USAGE, CommandError
from hdstream.frameJob import FrameWriter, ProgramOf
from hdstream.mattes import JoinHeaders

BLOCK = _core.SAMPLE_BLOCK
_JOINED = 8  # blocks of a frame that are in memory as a film has them
_lock = threading.Lock()
_stopped = set()  # jobs that were given up
_current = None   # (job's id, its FrameWriter, its warnings)


def Describe(device):
    """What the client wants to know before it sends work. Never raises."""
    program = {"version": _core.VERSION, "program": ProgramOf()}
    try:
        return {**program, "device": _core.FindDevice(device).name}
    except _core.Error as error:
        return {**program, "error": str(error)}


def DifferenceOf(program, own):
    """What keeps the work of a process with that ProgramOf out of the pictures of another; empty: nothing."""
    if not program or program[0] != own[0]:
        return f"has {f'hdstream {program[0]}' if program else 'another hdstream'}, this is {own[0]}"
    if tuple(program[:2]) != tuple(own[:2]):
        return "has other kernels than this process"
    return "" if tuple(program) == tuple(own) else "has another color configuration than this process"


def Stop(jobId):
    """Ends the tasks of a job that run here, and those that still come."""
    _stopped.add(jobId)


def ProbeFrame(jobId, job, frame):
    """How a frame may be split: its size, samples, and what is there of it already."""
    def Work(writer):
        isMissing = writer.Prepare(frame)
        settings = writer.renderer.settings
        kept = next(iter(writer.StartOf(frame)), None) if isMissing else None
        isBorder = kept is not None and kept.endSample % BLOCK == 0 and kept.MostSamples() == kept.endSample
        names = ("imageWidth", "imageHeight", "samples", "noise", "timeLimit", "denoise", "deep")
        return {"isThere": not isMissing, "firstSample": kept.endSample if isBorder else 0,
                **{name: settings[name] for name in names}}

    return _Do(jobId, job, Work)


def RenderFrame(jobId, job, frame, interval=1.0):
    """Renders and writes a whole frame."""
    def Work(writer):
        if not writer.Prepare(frame):
            return {"isThere": True}
        image = writer.Render(frame, _Reporter(jobId, interval))
        if not image.isComplete:
            return {"isStopped": True}
        writer.Finish(frame, image)
        return _Summary(image)

    return _Do(jobId, job, Work)


def RenderBlocks(jobId, job, frame, begin, end, interval=1.0):
    """Sums of each block of the samples [begin, end); begin is a multiple of BLOCK."""
    def Work(writer):
        blocks = []
        report = _Reporter(jobId, interval, (end - begin + BLOCK - 1) // BLOCK)
        for first in range(begin, end, BLOCK):
            writer.PrepareSamples(frame, min(first + BLOCK, end))
            settings = writer.renderer.settings
            black = filmSums.BlackSums(settings["imageWidth"], settings["imageHeight"], first)
            sums = writer.renderer.RenderSums(report, [black])
            if sums is None:
                return {"isStopped": True}
            blocks.append(filmSums.Pack(sums))
            report.numDone += 1
        return {"blocks": blocks}

    return _Do(jobId, job, Work)


def JoinBlocks(jobId, job, frame, firstSample, parts):
    """Writes a frame of the sums of its blocks, in their order, and what was kept of [0, firstSample)."""
    def Work(writer):
        writer.Prepare(frame)
        film = list(writer.StartOf(frame)) if firstSample > 0 else []
        blocks = [block for part in parts for block in part["blocks"]]
        for first in range(0, len(blocks), _JOINED):  # packed they take less than half
            some = [filmSums.Unpack(block) for block in blocks[first:first + _JOINED]]
            writer.PrepareSamples(frame, some[-1].endSample)
            film = [writer.renderer.RenderSums(None, film + some)]
        writer.Prepare(frame)
        image = writer.renderer.RenderPrepared(None, film)
        image.statistics["parts"] = [part["work"] for part in parts]
        writer.Finish(frame, image)
        return {**_Summary(image), "origins": _OriginsOf(parts)}

    return _FirstBad(job, parts) or _Do(jobId, job, Work)


def RenderTile(jobId, job, frame, crop, interval=1.0):
    """Arrays of a part (left, top, right, bottom) of the image."""
    def Work(writer):
        writer.PrepareCrop(frame, crop)
        image = writer.renderer.RenderPrepared(_Reporter(jobId, interval))
        if not image.isComplete:
            return {"isStopped": True}
        # The frame stays prepared for tiles that follow; the arrays are views of memory that goes.
        return {"aovs": {name: np.array(pixels) for name, pixels in image.aovs.items()}, "headers": image.headers,
                **_Summary(image)}

    return _Do(jobId, job, Work)


def JoinTiles(jobId, job, frame, parts):
    """Writes a frame of bands of rows, from top to bottom."""
    def Work(writer):
        writer.Prepare(frame)
        names = parts[0]["aovs"]
        aovs = {name: np.concatenate([part["aovs"][name] for part in parts]) for name in names}
        headers = JoinHeaders([part["headers"] for part in parts])
        image = writer.renderer.ImageOf(aovs, parts[0]["samples"], {"parts": [part["statistics"] for part in parts]}, headers)
        writer.Finish(frame, image)
        return {**_Summary(image), "origins": _OriginsOf(parts)}

    return _FirstBad(job, parts) or _Do(jobId, job, Work)


def _Summary(image):
    return {"samples": image.samples, "width": image.width, "height": image.height, "statistics": image.statistics}


def _FirstBad(job, parts):
    """What keeps parts from being joined, as a result; None: nothing."""
    bad = next((part for part in parts if "error" in part or "isStopped" in part), None)
    for origin in _OriginsOf(parts) if bad is None and job.program else ():
        difference = DifferenceOf(origin.get("program"), job.program)
        if difference:  # a worker that is too old to refuse
            return {"error": f"worker {origin.get('worker', 'of a part')}: {difference}", "isUsage": False}
    return bad


def _OriginsOf(parts):
    return [origin for part in parts for origin in part.get("origins") or [{}]]


def _Do(jobId, job, work):
    """Runs `work(writer)`; errors of stages and files become values: trying again would not help."""
    start = time.perf_counter()
    with _lock:
        if jobId in _stopped:
            return {"isStopped": True}
        address = _Worker().address
        program = ProgramOf()
        difference = job.program and DifferenceOf(program, job.program)
        if difference:  # it has joined after the client asked
            return {"error": f"worker {address}: {difference}", "isUsage": False}
        try:
            writer, warnings = _WriterOf(jobId, job)
            result = work(writer)
        except (_core.Error, CommandError) as error:
            isUsage = isinstance(error, _core.UsageError) or getattr(error, "exitCode", None) == EXIT_USAGE
            return {"error": str(error), "isUsage": isUsage}
        except OSError as error:  # the client takes those that are raised for a lost scheduler
            file = f"{error.filename}: " if error.filename else ""
            return {"error": f"worker {address}: {file}{error.strerror or error}", "isUsage": False}
        _Tell(jobId, 1.0)
        device = _core.FindDevice(job.settings.get("device", "")).name
        origin = {"worker": address, "program": program, "device": device}
        return {**result, "warnings": list(warnings), "origins": [origin, *result.get("origins", ())],
                "work": {"seconds": time.perf_counter() - start, "device": device}}


def _WriterOf(jobId, job):
    global _current  # pylint: disable=global-statement
    if _current is None or _current[0] != jobId:
        _current = None  # frees its device memory first
        warnings = []
        _current = (jobId, FrameWriter(job, warnings.append), warnings)
    return _current[1], _current[2]


def _Worker():
    from distributed import get_worker
    return get_worker()


def _Tell(jobId, fraction):
    """The client hears which share of this task is done."""
    worker = _Worker()
    worker.log_event(jobId, {"task": str(worker.get_current_task()), "fraction": fraction})


class _Reporter:
    """Progress of a task to the client, at most once an interval; ends the render when the job is given up."""

    def __init__(self, jobId, interval, numRenders=1):
        self._jobId = jobId
        self._interval = interval
        self._numRenders = numRenders
        self._last = time.monotonic()
        self.numDone = 0  # renders of the task that are finished

    def __call__(self, progress):
        now = time.monotonic()
        if now - self._last >= self._interval:
            self._last = now
            _Tell(self._jobId, (self.numDone + progress.fraction) / self._numRenders)
        return self._jobId not in _stopped
