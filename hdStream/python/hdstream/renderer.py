# SPDX-License-Identifier: Apache-2.0
"""Stages rendered to arrays: what `import hdstream` offers and what the command line is made of (docs/python.md)."""

from __future__ import annotations

import contextlib
import json
import os
import threading
import warnings
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from pxr import Usd

from hdstream import _core
from hdstream.denoiser import FindDenoiser
from hdstream.framing import FREE_CAMERA_PATH
from hdstream.image import Image
from hdstream.preparedStage import PreparedStage
from hdstream.processTime import SecondsSinceStart

Progress = _core.Progress


class RenderWarning(UserWarning):
    """Something in a stage that cannot be drawn as it is authored; names the prim."""


class Renderer:
    """Renders a stage, again and again; what did not change in between is kept.

    Parameters
    ----------
    stage : pxr.Usd.Stage or str
        A stage that the caller may edit between renders, or the path of one to open. MaterialX files (.mtlx) are read
        where it is a path, or where OpenUSD has usdMtlx.
    mask : sequence of str, optional
        Absolute prim paths; only these prims, their ancestors and descendants are loaded. For paths of stages only.
    onWarning : callable, optional
        Called with each warning, one line, once. Default: `warnings.warn` with `RenderWarning`. May be called on any
        thread.

    Raises
    ------
    hdstream.Error
        The file is missing or no stage.
    hdstream.UsageError
        A path of `mask` is no absolute prim path.

    Notes
    -----
    Threads: one at a time, the one that edits the stage; only `Cancel` may be called from any thread, at any time. Where a
    second one prepares or renders, or a callback does, UsageError is raised, and the render in progress goes on.
    Rendering releases Python's lock. Several renderers may render at once, each on a thread of its own.
    """

    def __init__(self, stage: Union[Usd.Stage, str, "os.PathLike[str]"], mask: Sequence[str] = (),
                 onWarning: Optional[Callable[[str], None]] = None, *, _session: Optional[_core.Session] = None) -> None:
        FindDenoiser()
        # Not a method: a cycle through the session would be kept for ever.
        self._session = _session or _core.Session(onWarning or _WarnOnce())
        self._isCancelled = threading.Event()
        self._isBusy = threading.Lock()
        self._prepared = PreparedStage(stage, mask, self._session)

    @property
    def stage(self) -> Usd.Stage:
        """The stage; edits of it are in the next render. After `ReleaseStage` what is left of it."""
        return self._prepared.stage

    @property
    def warnings(self) -> List[str]:
        """All warnings since the stage was last translated as a whole, each "SUBJECT: TEXT"."""
        return self._session.Warnings()

    def Render(self, timeCode: Union[float, Usd.TimeCode, None] = None,
               onProgress: Optional[Callable[[_core.Progress], Any]] = None, **settings: Any) -> Image:
        """Renders one picture. Blocks.

        Parameters
        ----------
        timeCode : float or pxr.Usd.TimeCode, optional
            Default: the stage's startTimeCode.
        onProgress : callable, optional
            Called on this thread after each wave of rays with an object of `samplesDone`, `samplesTotal` (per pixel),
            `fraction` (of all work, 0 to 1), `secondsElapsed`, `secondsLeft` (an estimate) and `previewStride` (0 until
            every pixel has a sample). While the scene is prepared `fraction` is 0, and `prims` (that are planned) and
            `chunks` (whose pages are made, where all are before the first ray) have `done` and `total`, 0 where there
            is nothing to say. Returning `False` cancels; an exception cancels and is raised.
        **settings
            As `Prepare`.

        Returns
        -------
        Image
            With `isComplete` False when it was cancelled.

        Raises
        ------
        hdstream.UsageError
            A setting has no use, or the stage has no such camera.
        hdstream.Error
            There is no device, memory runs out, or the camera cannot be read.
        TypeError
            There is no setting of that name.
        KeyboardInterrupt
            Ctrl-C, on the main thread.
        """
        with self._Alone():  # as a whole: between the two another thread might prepare a frame of its own
            self._PrepareFrame(timeCode, **settings)
            return self._Image(self._RenderFilm(onProgress, ()))

    def Prepare(self, timeCode: Union[float, Usd.TimeCode, None] = None, *,
                renderSettingsPrimPath: Optional[str] = None, renderProductPrimPath: Optional[str] = None,
                renderPassPrimPath: Optional[str] = None,
                crop: Optional[Tuple[int, int, int, int]] = None, **settings: Any) -> None:
        """Brings the scene up to date with the stage, without rendering.

        Values that changed on cameras, lights, materials, groups and gprims translate these prims alone; any other
        edit, another time code, and edits of gprims in stages with instances translate the whole stage again. Meshes
        whose arrays did not change keep their prepared geometry in the first case, and find it in the persistent cache
        in the second.

        Parameters
        ----------
        timeCode : float or pxr.Usd.TimeCode, optional
            Default: the stage's startTimeCode.
        renderSettingsPrimPath : str, optional
            A UsdRenderSettings prim that fills what `settings` leave open. Default: the stage's own.
        renderPassPrimPath : str, optional
            A UsdRenderPass prim, whose collections say what is drawn and seen (docs/film.md). Its `renderSource` are the
            render settings where `renderSettingsPrimPath` says none.
        renderProductPrimPath : str, optional
            The product of the render settings whose camera and size hold; its render vars do not. Default: the first,
            with its render vars.
        crop : (int, int, int, int), optional
            left, top, right, bottom in pixels of the image, y down, right and bottom exclusive: only that part is
            rendered, with the bits that it has in the whole image.
        **settings
            Names and values of the settings table (docs/settings.md): `samples=16`, `imageWidth=640`,
            `aovs=["color", "depth"]`, `camera="main_cam"` (a name or a path) ... None: not given.

        Raises
        ------
        hdstream.UsageError, hdstream.Error, TypeError
            As `Render`.
        """
        with self._Alone():
            self._PrepareFrame(timeCode, renderSettingsPrimPath, renderProductPrimPath, renderPassPrimPath, crop, **settings)

    def RenderPrepared(self, onProgress: Optional[Callable[[_core.Progress], Any]] = None,
                       start: Sequence[_core.FilmSums] = ()) -> Image:
        """Renders what was prepared. Blocks. As `Render`, but for `start` and `Cancel`.

        Parameters
        ----------
        onProgress : callable, optional
            As in `Render`.
        start : sequence of FilmSums, optional
            Sums of earlier renders of the same scene and settings (`Sums`): only the samples that they lack are
            rendered; the bits are those of one render. The first may hold any number of samples, each other one a
            block of 16 or the beginning of one.

        Raises
        ------
        hdstream.UsageError
            Also for sums of another size or order, and for sums together with the setting `noise`.
        """
        with self._Alone():
            return self._Image(self._RenderFilm(onProgress, start))

    def FillCache(self, onProgress: Optional[Callable[[_core.Progress], Any]] = None) -> Optional[_core.PreparedAmount]:
        """Makes all pages of the prepared frame that the persistent cache does not have, so that renders find them, also those of
        other processes and other cameras that look at the same dicing. Needs no device. Blocks.

        Parameters
        ----------
        onProgress : callable, optional
            As in `Render`; `textures` has `done` and `total` too.

        Returns
        -------
        PreparedAmount
            With `chunks`, `chunksBuilt` (the others were there), `chunkBytes`, `textures` and `texturesBuilt`. None when it
            was cancelled.

        Raises
        ------
        hdstream.UsageError
            Nothing is prepared, or the setting `noCache` is on.
        hdstream.Error
            The cache cannot be written, or has no room for all.
        """
        with self._Alone():
            return self._session.Prepare(self._Frame().settings, self._Asking(onProgress))

    def ImageSoFar(self) -> Image:
        """The picture as it is. May be called inside of `onProgress`, on its thread, once `previewStride` is 1.

        Returns
        -------
        Image
            With `isComplete` False. Its statistics are those so far.

        Raises
        ------
        hdstream.Error
            Nothing has been rendered yet.
        """
        return self._Image(False)

    def _Image(self, isComplete):
        hasImage = self._session.HasImage()
        samples = json.loads(self._session.Statistics())["image"]["samples"] if hasImage else 0
        layers = self._session.Layers() if samples > 0 else []
        # Asked for last: finding first hits takes time and rays, and may warn.
        statistics = json.loads(self._session.Statistics()) if hasImage else {}
        deep = self._session.Deep() if samples > 0 and self._Frame().settings.deep else None
        return Image(layers, self._Frame(), isComplete, samples, statistics, deep)

    def RenderSums(self, onProgress: Optional[Callable[[_core.Progress], Any]] = None,
                   start: Sequence[_core.FilmSums] = ()) -> Optional[_core.FilmSums]:
        """As `RenderPrepared`, but gives the film's sums and no arrays; None when it was cancelled."""
        with self._Alone():
            return self._session.Film() if self._RenderFilm(onProgress, start) else None

    def ImageOf(self, aovs: Mapping[str, np.ndarray], samples: int, statistics: Mapping[str, Any],
                headers: Optional[Mapping[str, Mapping[str, str]]] = None) -> Image:
        """The prepared frame as an image of arrays that were rendered elsewhere, of shapes and types as `Image.aovs`, with
        headers as `Image.headers`."""
        layers = []
        for name, pixels in aovs.items():
            layers.append(_core.ImageLayer(name, _core.ChannelsOf(name), np.ascontiguousarray(pixels)))
            layers[-1].header = dict((headers or {}).get(name, {}))
        return Image(layers, self._Frame(), True, samples, dict(statistics))

    def _Frame(self):
        frame = self._prepared.frame
        if frame is None:
            raise _core.UsageError("nothing is prepared")
        return frame

    def _PrepareFrame(self, timeCode, renderSettingsPrimPath=None, renderProductPrimPath=None, renderPassPrimPath=None,
                      crop=None, **settings):
        """As Prepare. For callers that are alone."""
        known = {info.name for info in _core.SettingTable()}
        for name in settings:
            if name not in known:
                raise TypeError(f"there is no setting '{name}' (docs/settings.md lists all)")
        self._isCancelled.clear()
        _core.RefreshColorConfig()
        self._prepared.Prepare(timeCode, settings, renderSettingsPrimPath, renderProductPrimPath, renderPassPrimPath, crop)

    def _RenderFilm(self, onProgress, start):
        """True when it was not cancelled. For callers that are alone until they have read the film."""
        frame = self._Frame()
        self._session.SetFrontEndTimes(self._prepared.loadSeconds, frame.translateSeconds, SecondsSinceStart())
        result = self._session.Render(frame.settings, self._Asking(onProgress), list(start), self._isCancelled.is_set)
        return result == _core.RenderResult.Complete

    def _Asking(self, onProgress):
        """A callback for the core: whether it may go on."""
        return lambda progress: not self._isCancelled.is_set() and (onProgress is None or onProgress(progress) is not False)

    @contextlib.contextmanager
    def _Alone(self):
        """The core's session has no locks, and what is prepared is freed and made anew. Held until what was rendered has been
        read: that lets other threads run."""
        if not self._isBusy.acquire(blocking=False):
            raise _core.UsageError("the renderer is busy: another thread, or the callback's own render, prepares or renders with it")
        try:
            yield
        finally:
            self._isBusy.release()

    def Sums(self) -> _core.FilmSums:
        """What another render of the scene can begin with (`RenderPrepared`): the film of the last render.

        Returns
        -------
        FilmSums
            48 bytes a pixel, with `firstSample`, `endSample` (every pixel has the samples below it) and `words`, the
            film's memory as uint32 of shape (height, width, 12).

        Raises
        ------
        hdstream.Error
            Nothing has been rendered yet.
        """
        return self._session.Film()

    def Cancel(self) -> None:
        """Ends the render in progress, also inside a wave, or the next one that is prepared already. From any thread; does not
        wait."""
        self._isCancelled.set()

    @property
    def settings(self) -> Dict[str, Any]:
        """All settings of the prepared frame by name, completed from the camera and the render settings prim."""
        settings = self._Frame().settings
        values = {info.name: _core.GetSetting(settings, info.name) for info in _core.SettingTable()}
        return {**values, "displayWindow": list(settings.displayWindow), "dataWindowMin": list(settings.dataWindowMin)}

    def SceneText(self) -> str:
        """The prepared scene as text: all values, hashes of long arrays. Equal scenes have equal texts."""
        return self._session.Dump()

    def CameraPaths(self) -> List[str]:
        """Paths of the stage's cameras, sorted; without the one that frames a stage."""
        return sorted(path for path in self._session.Scene().cameras if path != FREE_CAMERA_PATH)

    def AssetFiles(self) -> List[str]:
        """Files, besides the stage's, that the prepared scene reads: images, light profiles, volumes."""
        return sorted(self._session.Scene().AssetFiles())

    def Warn(self, subject: str, text: str) -> None:
        """Adds a warning of the caller, for the statistics too."""
        self._session.Warn(subject, text)

    def ReleaseStage(self) -> None:
        """Lets a large stage go once the last frame is prepared: what OpenUSD has of prims, and files of which nothing is read
        while the frame is rendered. After it nothing else can be prepared, whatever the stage.

        Raises
        ------
        hdstream.UsageError
            Nothing is prepared, or the stage is the caller's.
        """
        with self._Alone():
            self._Frame()
            self._prepared.Release()


def Render(stage: Union[Usd.Stage, str, "os.PathLike[str]"], timeCode: Union[float, Usd.TimeCode, None] = None,
           onProgress: Optional[Callable[[_core.Progress], Any]] = None, **settings: Any) -> Image:
    """Renders a stage once: `Renderer(stage).Render(timeCode, onProgress, **settings)`. A stage that it opens itself is let go
    before it renders (`Renderer.ReleaseStage`)."""
    renderer = Renderer(stage)
    renderer.Prepare(timeCode, **settings)
    if not isinstance(stage, Usd.Stage):
        renderer.ReleaseStage()
    return renderer.RenderPrepared(onProgress)


class _WarnOnce:
    """The default for warnings; each line once."""

    def __init__(self):
        self._lines = set()

    def __call__(self, line):
        if line not in self._lines:
            self._lines.add(line)
            warnings.warn(line, RenderWarning, stacklevel=2)
