# SPDX-License-Identifier: Apache-2.0
"""`hdstream record --scheduler ADDRESS | --workers N`: frames, ranges of samples or tiles on a dask.distributed cluster.

Nothing here schedules: dask does, and does a dead worker's tasks again. The client sends paths and settings; workers
read the stage and write the images; block sums and tiles go from worker to worker. Explained in docs/farm.md.
"""

import contextlib
import logging
import os
import signal
import sys
import time
import uuid

from pxr import Ar

from hdstream import _core, farmWork
from hdstream.console import Say, SayError
from hdstream.errors import EXIT_INTERRUPTED, EXIT_OK, EXIT_USAGE, CommandError, UsageError
from hdstream.frameJob import ProgramOf
from hdstream.progress import ProgressBar, WarningPrinter
from hdstream.recordArguments import FramesOf, JobOf
from hdstream.stage import OpenStage
from hdstream.texts import SecondsText

_CONNECT_SECONDS = 10
_POLL_SECONDS = 0.2
_DEATHS = 10  # of workers while they do one and the same task, after which the task is given up (local clusters)


def RunOnFarm(args, interruption):
    """Renders all frames; returns the exit code."""
    if args.workers and "distributed" not in sys.modules:
        _LimitThreads(args.workers)
    distributed = _ImportDistributed("--scheduler" if args.scheduler else "--workers")
    job = JobOf(args)
    warnings = []
    frames = FramesOf(args, OpenStage(args.stage, args.mask), lambda subject, text: warnings.append(f"{subject}: {text}"))
    _CheckSplit(args, job)
    shown = {}
    for frame in frames:  # workers have working folders of their own
        shown[_Absolute(frame.file)] = ", ".join(output.file for output in frame.outputs) or frame.file
        frame.file = _Absolute(frame.file)
        frame.statsFile = frame.statsFile and _Absolute(frame.statsFile)
        for output in frame.outputs:
            output.file = _Absolute(output.file)
    _MakeTravel(job)
    progress = ProgressBar(args.quiet)
    warn = WarningPrinter(progress, args.verbose)
    for warning in warnings:
        warn(warning)
    interruption.hasWork = True
    try:
        with warn, _Connect(args, distributed) as client:
            numWorkers, devices = _CheckWorkers(client, job, args)
            return _Run(_Farm(client, distributed, job, args, numWorkers, devices, progress, warn, shown), frames, progress)
    except KeyboardInterrupt:
        progress.Clear()
        SayError("hdstream record: interrupted; frames that are done are whole, others are not written")
        return EXIT_INTERRUPTED


def _Run(farm, frames, progress):
    try:
        farm.Record(frames)
    except BaseException:
        farm.Stop()
        raise
    finally:
        progress.Clear()
    return EXIT_OK


class _Farm:
    """A job on a cluster, from its first task to its last file."""

    def __init__(self, client, distributed, job, args, numWorkers, devices, progress, warn, shown):
        self._client = client
        self._distributed = distributed
        self._job = job
        self._args = args
        self._numWorkers = numWorkers
        self._progress = progress
        self._warn = warn
        self._shown = shown
        self._id = f"hdstream-{uuid.uuid4().hex}"
        # All workers together send the scheduler some hundred messages a second at most.
        self._interval = max(0.5, numWorkers / 200.0)
        self._fractions = {}  # task -> share that is done
        self._numTasks = 0
        self._devices = set()
        self._MeetDevices(devices)
        self._start = time.perf_counter()
        client.subscribe_topic(self._id, self._OnEvent)

    def Record(self, frames):
        """Returns when all frames are written. Raises CommandError for the first that cannot be."""
        split = self._args.split or ("samples" if len(frames) == 1 else "frames")
        frameOfFuture = {}
        if split == "frames":
            frameOfFuture = {self._Submit(farmWork.RenderFrame, frame, self._interval): frame for frame in frames}
        else:
            probes = {self._Submit(farmWork.ProbeFrame, frame): frame for frame in frames}
            for probe, result in self._Completed(probes):
                frame = probes[probe]
                self._Check(frame, result)
                if result.get("isThere"):
                    self._Report(frame, result)
                else:
                    frameOfFuture[self._SubmitParts(split, frame, result)] = frame
        for future, result in self._Completed(frameOfFuture):
            self._Report(frameOfFuture[future], result)

    def Stop(self):
        """Gives the job up: what runs ends at its next progress report."""
        with contextlib.suppress(Exception):
            self._client.run(farmWork.Stop, self._id, on_error="ignore")

    # --- Tasks -----------------------------------------------------------------------------------

    def _Submit(self, function, *arguments):
        self._numTasks += 1
        return self._client.submit(function, self._id, self._job, *arguments, pure=False)

    def _SubmitParts(self, split, frame, probe):
        """Tasks of a frame's parts; returns the one that joins them."""
        if probe["deep"] and self._args.split:
            raise UsageError(f"--split {split}: a deep picture cannot be taken apart; its frames can be spread")
        isWhole = probe["deep"] or probe["noise"] > 0.0 or probe["timeLimit"] > 0.0
        if isWhole and self._args.split:
            raise UsageError(f"--split {split}: not together with --noise or --time, which depend on what is split")
        if isWhole:
            return self._Submit(farmWork.RenderFrame, frame, self._interval)
        if split == "tiles" and probe["denoise"]:
            raise UsageError("--split tiles: not together with --denoise, which looks at whole pictures")
        numParts = self._args.parts or self._numWorkers
        if split == "tiles":
            crops = Bands(probe["imageWidth"], probe["imageHeight"], numParts)
            parts = [self._Submit(farmWork.RenderTile, frame, crop, self._interval) for crop in crops]
            return self._Submit(farmWork.JoinTiles, frame, parts)
        first = probe["firstSample"]
        parts = [self._Submit(farmWork.RenderBlocks, frame, begin, end, self._interval)
                 for begin, end in SampleRanges(first, probe["samples"], numParts)]
        return self._Submit(farmWork.JoinBlocks, frame, first, parts)

    def _Completed(self, futures):
        """(future, result) as they finish."""
        waiting = self._distributed.as_completed(futures)
        left = len(futures)
        while left > 0:
            if not waiting.has_ready():
                time.sleep(_POLL_SECONDS)
                self._Show()
                continue
            left -= 1
            future = next(waiting)
            self._fractions[future.key] = 1.0
            yield future, self._ResultOf(future)

    def _ResultOf(self, future):
        try:
            result = future.result()
        except self._distributed.KilledWorker as error:
            raise CommandError(f"the workers of a task died again and again ({error.allowed_failures + 1} times): "
                               "look at their logs, they may lack memory") from None
        except (OSError, self._distributed.CancelledError):
            raise CommandError("the scheduler is gone") from None
        except ImportError as error:  # it has joined after the workers were asked
            raise CommandError(f"a worker has no hdstream ({type(error).__name__}: {error})") from None
        return result

    # --- Reports ---------------------------------------------------------------------------------

    def _OnEvent(self, event):
        _, message = event
        self._fractions[message["task"]] = message["fraction"]

    def _Show(self):
        # A copy: events come on another thread.
        fraction = min(1.0, sum(list(self._fractions.values())) / max(1, self._numTasks))
        seconds = time.perf_counter() - self._start
        left = SecondsText(seconds * (1.0 - fraction) / fraction) + " left" if fraction > 0.0 else "starting"
        self._progress.Show(fraction, f"{self._numWorkers} workers, {left}")

    def _Check(self, frame, result):
        for line in result.get("warnings", ()):
            self._warn(line)
        self._warn.Flush()
        if result.get("isStopped"):
            raise KeyboardInterrupt
        if "error" in result:
            kind = UsageError if result["isUsage"] else CommandError
            raise kind(f"{self._shown[frame.file]}: {result['error']}")
        self._CheckOrigins(result)

    def _CheckOrigins(self, result):
        """Who did a task and its parts: workers may join while a job runs. One of this version has refused what is not for it."""
        for origin in result.get("origins") or [{}]:
            difference = farmWork.DifferenceOf(origin.get("program"), self._job.program)
            if difference:
                raise CommandError(f"worker {origin.get('worker', 'of a task')}: {difference}")
        self._MeetDevices({origin["device"] for origin in result["origins"]})

    def _MeetDevices(self, devices):
        if devices <= self._devices:
            return
        self._devices |= devices
        if len(self._devices) > 1:
            self._warn(f"the workers have different devices ({', '.join(sorted(self._devices))}): equal to the bit is only what "
                       "one model renders; --device NAME chooses")

    def _Report(self, frame, result):
        self._Check(frame, result)
        if self._args.quiet:
            return
        self._progress.Clear()
        if result.get("isThere"):
            Say(f"{self._shown[frame.file]}: is there already")
        else:
            # Of a frame that was split, the last task only adds up.
            isSplit = "parts" in result["statistics"]
            seconds = time.perf_counter() - self._start if isSplit else result["work"]["seconds"]
            Say(f"{self._shown[frame.file]}: {result['width']}x{result['height']}, {result['samples']} samples, "
                f"{SecondsText(seconds)}")


# --- How a frame is split --------------------------------------------------------------------------


def SampleRanges(first, end, numParts):
    """[first, end) in at most `numParts` ranges that begin at borders of blocks, as even as these allow."""
    block = farmWork.BLOCK
    numBlocks = (end - first + block - 1) // block
    numParts = max(1, min(numParts, numBlocks))
    borders = [first + block * (numBlocks * part // numParts) for part in range(numParts)] + [end]
    return list(zip(borders, borders[1:]))


def Bands(width, height, numParts):
    """Bands of whole rows: (left, top, right, bottom)."""
    numParts = max(1, min(numParts, height))
    borders = [height * part // numParts for part in range(numParts + 1)]
    return [(0, top, width, bottom) for top, bottom in zip(borders, borders[1:])]


def _CheckSplit(args, job):
    isAdaptive = job.settings.get("noise") or job.settings.get("timeLimit")
    if args.split in ("samples", "tiles") and isAdaptive:
        raise UsageError(f"--split {args.split}: not together with --noise or --time, which depend on what is split")


# --- The cluster -----------------------------------------------------------------------------------


def _ImportDistributed(option):
    try:
        import distributed
    except ImportError:
        raise UsageError(f"{option}: needs the package distributed: pip install 'hdstream[farm]'") from None
    for name in ("asyncio", "tornado", *logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("asyncio", "distributed", "tornado"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what they say of a lost connection, we say in a line
    return distributed


def _LimitThreads(numWorkers):
    """CPU drivers of the processes to come share the machine's cores (PoCL's variables)."""
    share = str(max(1, (os.cpu_count() or 1) // numWorkers))
    for name in ("POCL_CPU_MAX_CU_COUNT", "POCL_MAX_PTHREAD_COUNT"):
        os.environ.setdefault(name, share)


@contextlib.contextmanager
def _Connect(args, distributed):
    """A client of the scheduler, or of a cluster that lives as long as the command."""
    with contextlib.ExitStack() as stack:
        address = args.scheduler
        if not address:
            address = stack.enter_context(_LocalCluster(args.workers, distributed))
        try:
            client = distributed.Client(address, timeout=_CONNECT_SECONDS)
        except ValueError as error:
            raise UsageError(f"--scheduler {address}: {error}") from None
        except (OSError, TimeoutError):
            raise CommandError(f"--scheduler {address}: cannot be reached") from None
        stack.callback(_CloseQuietly, client)
        yield client


@contextlib.contextmanager
def _LocalCluster(numWorkers, distributed):
    import dask
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is this process's; others inherit that
    try:
        with dask.config.set({"distributed.scheduler.allowed-failures": _DEATHS}):
            cluster = distributed.LocalCluster(n_workers=numWorkers, threads_per_worker=1, processes=True,
                                               memory_limit=0, dashboard_address="127.0.0.1:0",
                                               silence_logs=logging.CRITICAL)
    finally:
        signal.signal(signal.SIGINT, before)
    try:
        yield cluster
    finally:
        _CloseQuietly(cluster)


def _CloseQuietly(thing):
    with contextlib.suppress(Exception):
        thing.close(timeout=_CONNECT_SECONDS)


def _CheckWorkers(client, job, args):
    """All workers have this hdstream and a device. Returns how many there are, and the names of their devices."""
    with contextlib.suppress(TimeoutError):
        client.wait_for_workers(args.workers or 1, timeout=6 * _CONNECT_SECONDS if args.workers else _CONNECT_SECONDS)
    # By value: a worker without the module can still answer.
    call = f"__import__('importlib').import_module('hdstream.farmWork').Describe({job.settings.get('device', '')!r})"
    answers = client.run(eval, call, on_error="return")
    # A connection that broke: that worker has died since, and others do its work.
    answers = {address: answer for address, answer in answers.items() if not isinstance(answer, OSError)}
    if not answers:
        raise CommandError(f"--scheduler {args.scheduler}: it has no workers")
    devices = set()
    for address, answer in sorted(answers.items()):
        if not isinstance(answer, dict):
            raise CommandError(f"worker {address}: has no hdstream ({type(answer).__name__}: {answer})")
        difference = farmWork.DifferenceOf(answer.get("program", (answer["version"], "")), job.program)
        if difference:
            raise CommandError(f"worker {address}: {difference}")
        if "error" in answer:
            raise CommandError(f"worker {address}: {answer['error']}", EXIT_USAGE if job.settings.get("device") else 1)
        devices.add(answer["device"])
    return len(answers), devices


def _MakeTravel(job):
    """Says what workers, with working folders of their own, need to know of a job."""
    job.stage = _Absolute(job.stage if "://" in job.stage else str(Ar.GetResolver().Resolve(job.stage)) or job.stage)
    if job.settings.get("cacheDirectory"):
        job.settings["cacheDirectory"] = _Absolute(job.settings["cacheDirectory"])
    job.program = ProgramOf()


def _Absolute(file):
    """Absolute for files; other addresses of an asset resolver as they are."""
    return file if "://" in file else os.path.abspath(file)
