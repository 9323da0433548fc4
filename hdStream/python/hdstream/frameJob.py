# SPDX-License-Identifier: Apache-2.0
"""Frames of one stage written to files: what `hdstream record` does here and what a farm's workers do."""

import dataclasses
import functools
import hashlib
import json
import os
from typing import Any, Dict, Optional, Tuple

from hdstream import _core, filmSums
from hdstream.errors import CommandError
from hdstream.products import Output
from hdstream.renderer import Image, Renderer
from hdstream.resume import AssetHashes, ColorsOf, KeyOf, SamplesInFile, SamplesSaid, SayDone, TextsOf
from hdstream.snapshots import PartFileOf, RemoveParts, Snapshots
from hdstream.textFile import WriteText


def ProgramOf():
    """What two processes must have in common whose work goes into one picture: the version, a hash of the kernels, and one of the
    colour configuration, by its contents."""
    colors = hashlib.blake2b(ColorsOf(AssetHashes()).encode(), digest_size=16).hexdigest()
    return (_core.VERSION, _core.KernelSourceHash(), colors)


@dataclasses.dataclass
class Job:
    """What all frames have in common. Plain values: it travels to other machines."""

    stage: str
    mask: Tuple[str, ...] = ()
    settings: Dict[str, Any] = dataclasses.field(default_factory=dict)  # what the user said, by name
    renderSettingsPrimPath: Optional[str] = None
    renderPassPrimPath: Optional[str] = None
    colorCorrectionMode: str = ""
    resumes: bool = False
    snapshotSeconds: float = 0.0  # 0: none
    program: Tuple[str, ...] = ()  # ProgramOf where the job comes from; empty: not said


@dataclasses.dataclass
class Frame:
    """One frame of a job."""

    timeCode: float
    file: str
    statsFile: Optional[str] = None
    product: Optional[str] = None  # of the render settings, whose camera and size hold
    outputs: Tuple[Output, ...] = ()  # files of products; the first is `file`. Empty: all AOVs go to `file`


class FrameWriter:
    """Prepares, renders and writes frames of a job, one after another. One thread at a time."""

    def __init__(self, job, onWarning, warmth=None):
        self._job = job
        self._assetHashes = AssetHashes()
        self._key = ""
        self.renderer = Renderer(job.stage, job.mask, onWarning, _session=warmth and warmth.TakeSession())

    def Prepare(self, frame):
        """Translates; returns False when the file of the frame is there already."""
        self._Prepare(frame)
        if not self._job.resumes:
            return True
        self._key = KeyOf(self.renderer, self._assetHashes)
        return any(self._SamplesOf(output) < self.renderer.settings["samples"] for output in self._OutputsOf(frame))

    def PrepareSamples(self, frame, samples):
        """For a render that ends after so many samples and whose sums alone are asked for."""
        self._Prepare(frame)
        summed = [name for name in self.renderer.settings["aovs"] if _core.IsSummed(name)]
        self._Prepare(frame, samples=samples, aovs=list(dict.fromkeys(["color"] + summed)), denoise=False)

    def PrepareCrop(self, frame, crop):
        """For the part (left, top, right, bottom) of the image."""
        self._Prepare(frame, crop=crop)

    def _Prepare(self, frame, **further):
        values = {**self._job.settings, **further}
        if frame.outputs and "aovs" not in further:
            values["aovs"] = list(dict.fromkeys(layer.aov for output in frame.outputs for layer in output.layers))
            values["deep"] = any(output.isDeep for output in frame.outputs)
        self.renderer.Prepare(frame.timeCode, renderSettingsPrimPath=self._job.renderSettingsPrimPath,
                              renderPassPrimPath=self._job.renderPassPrimPath, renderProductPrimPath=frame.product, **values)

    def Render(self, frame, onProgress=None):
        """The picture; from the samples on that were kept, when the job resumes."""
        if self._job.snapshotSeconds > 0.0:
            onProgress = Snapshots(self._job.snapshotSeconds, lambda: self._WriteSnapshot(frame), onProgress)
        return self.renderer.RenderPrepared(onProgress, self.StartOf(frame))

    def Finish(self, frame, image: Image):
        """Writes picture, sums and statistics; returns False for a picture without a whole sample, which is not written."""
        settings = self.renderer.settings
        done = settings["samples"] if image.isComplete else image.samples
        outputs = self._OutputsOf(frame) if image.samples > 0 else ()
        writes = [lambda: self._SaveSums(frame, image)]  # first: where a picture cannot be written, they are not lost
        writes += [functools.partial(self._WriteDone, image, output, done) for output in outputs]
        if frame.statsFile and image.samples > 0:
            writes.append(lambda: WriteText("--stats", frame.statsFile, json.dumps(image.statistics, indent=2) + "\n"))
        errors = []
        for write in writes:
            try:
                write()
            except (_core.Error, CommandError) as error:  # costs no other file its picture
                errors.append(error)
        if errors:
            raise _Joined(errors)
        if image.samples == 0:
            return False
        if self._job.snapshotSeconds > 0.0:
            RemoveParts(output.file for output in outputs)
        return True

    def _WriteDone(self, image, output, done):
        """Writes a file of a frame that has `done` samples, and what `--resume` knows it by."""
        isExr = _IsExr(output.file)
        texts = TextsOf(self._KeyOfFile(output), done) if self._job.resumes and isExr else {}
        left = self._Write(image, output, output.file, texts)
        if self._job.resumes and not isExr:
            SayDone(output.file, self._KeyOfFile(output), done)
        if left:
            self.renderer.Warn(output.file, f"no room in this format for {', '.join(left)}; use .exr")

    def _WriteSnapshot(self, frame):
        """What cannot be written now is a warning: the render, which may have taken hours, goes on."""
        image = self.renderer.ImageSoFar()
        try:
            self._SaveSums(frame, image)
            for output in self._OutputsOf(frame):
                if not output.isDeep:  # what is deep is known at the end
                    self._Write(image, output, PartFileOf(output.file), {})
        except (_core.Error, CommandError) as error:
            self.renderer.Warn("--snapshot", str(error))

    def _OutputsOf(self, frame):
        """The files of a prepared frame."""
        return frame.outputs or (Output(frame.file, None, isDeep=self.renderer.settings["deep"]),)

    def _Write(self, image, output, file, texts):
        """Returns the names of layers for which the format has no room."""
        if output.isDeep:
            isHalf = output.layers is not None and output.layers[0].isHalf
            image.WriteDeep(file, {**output.texts, **texts}, isHalf)
            return ()
        layers = None if output.layers is None else [dataclasses.astuple(layer) for layer in output.layers]
        return image.Write(file, self._job.colorCorrectionMode, {**output.texts, **texts}, layers, output.tileSize)

    def _SaveSums(self, frame, image):
        """What `--resume` goes on from."""
        if self._job.resumes and _CanGoOn(self.renderer.settings) and "device" in image.statistics:
            filmSums.Save(filmSums.FileOf(frame.file), self.renderer.Sums(), self._key, image.statistics["device"]["name"])

    def _FileFormat(self, file):
        """What the bits of a file depend on besides the picture."""
        extension = os.path.splitext(file)[1].lower()
        isDisplay = extension in (".png", ".jpg", ".jpeg")
        return f"{extension} {self._job.colorCorrectionMode or os.environ.get('OCIO', '')}" if isDisplay else extension

    def _KeyOfFile(self, output):
        """The picture's key and what the file alone says, such as names of layers and their format."""
        own = repr((self._key, self._FileFormat(output.file), output.layers, sorted(output.texts.items()), output.tileSize,
                    output.isDeep))
        return hashlib.blake2b(own.encode(), digest_size=16).hexdigest()

    def _SamplesOf(self, output):
        """Samples of the picture that is there; 0: it is another one, or cannot be read to its end. Deep files are taken for
        whole where their header is there."""
        file = output.file
        if not _IsExr(file):
            return SamplesSaid(file, self._KeyOfFile(output))
        samples = SamplesInFile(file, self._KeyOfFile(output))
        return samples if samples > 0 and (output.isDeep or not _core.CompareImages(file, file).error) else 0

    def StartOf(self, frame):
        """The sums that were kept of a prepared frame: one or none."""
        settings = self.renderer.settings
        if not self._job.resumes or not _CanGoOn(settings):
            return ()
        kept, device = filmSums.Load(filmSums.FileOf(frame.file), self._key)
        if kept is None or kept.MostSamples() > settings["samples"]:
            return ()  # where it has as many as are asked for, the picture is written of them
        own = _core.FindDevice(settings["device"]).name
        if device != own:
            self.renderer.Warn(frame.file, f"samples of {device} are continued on {own}: its bits are those of neither")
        return (kept,)


def _Joined(errors):
    """One error with the texts of all; the first says what it is."""
    first, text = errors[0], "; ".join(str(error) for error in errors)
    return CommandError(text, first.exitCode) if isinstance(first, CommandError) else type(first)(text)


def _IsExr(file):
    return os.path.splitext(file)[1].lower() == ".exr"


def _CanGoOn(settings):
    """Pixels of adaptive renders stop at different samples; the samples of deep ones cannot be taken apart."""
    return settings["noise"] == 0.0 and not settings["deep"]
