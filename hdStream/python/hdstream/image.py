# SPDX-License-Identifier: Apache-2.0
"""A picture that was rendered: its arrays, and the files that it is written to (docs/python.md)."""

from __future__ import annotations

import os
import tempfile
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from hdstream import _core
from hdstream.frameSetup import MakeMetadata
from hdstream.preparedStage import Frame


class Image:
    """A picture: arrays by the names of AOVs. Independent of the renderer that made it.

    Attributes
    ----------
    aovs : dict of str to numpy.ndarray
        float32 of shape (height, width, channels), rows from top to bottom; ids are int32 of shape (height, width).
        Read-only. Names, units and spaces: docs/film.md. Colour is linear Rec. 709, premultiplied by alpha.
    channels : dict of str to list of str
        Names of the last dimension: R, G, B, A; X, Y, Z; Z; id.
    headers : dict of str to dict of str to str
        What an AOV adds to an EXR's header: of Cryptomattes the names of what they show.
    deep : DeepImage or None
        Where the setting `deep` asks for it, samples a surface by pixel (docs/film.md): `counts`, uint32 of shape (height,
        width), and `samples`, float32 of shape (all counts, 6): Z, ZBack, R, G, B, A, pixel by pixel from front to back.
    width, height : int
        Pixels.
    samples : int
        Samples that every pixel has.
    isComplete : bool
        False when rendering was cancelled.
    statistics : dict
        As `--stats` writes it; seconds, bytes, counts (docs/command-line.md).
    """

    def __init__(self, layers: Sequence[_core.ImageLayer], frame: Frame, isComplete: bool, samples: int,
                 statistics: Dict[str, Any], deep: Optional[_core.DeepImage] = None) -> None:
        self.deep = deep
        self.isComplete = isComplete
        self.samples = samples
        self.statistics = statistics
        self._layers = list(layers)
        self._settings = frame.settings
        self._camera = frame.camera
        self._frameTime = frame.frameTime
        self.width: int = frame.settings.imageWidth
        self.height: int = frame.settings.imageHeight
        self.aovs: Mapping[str, np.ndarray] = {layer.name: layer.pixels for layer in self._layers}
        self.channels: Mapping[str, List[str]] = {layer.name: list(layer.channels) for layer in self._layers}
        self.headers: Mapping[str, Mapping[str, str]] = {layer.name: dict(layer.header)
                                                         for layer in self._layers if layer.header}

    def Write(self, file: Union[str, "os.PathLike[str]"], colorCorrectionMode: str = "",
              texts: Optional[Mapping[str, str]] = None,
              layers: Optional[Sequence[Tuple[str, str, bool]]] = None,
              tileSize: Tuple[int, int] = (0, 0)) -> List[str]:
        """Writes an image file, whole or not at all.

        Parameters
        ----------
        file : str
            `.exr` (all AOVs, linear), `.png` and `.jpg` (colour, display-referred), `.tif`, `.hdr` (linear).
        colorCorrectionMode : {"", "disabled", "sRGB", "openColorIO"}
            For `.png` and `.jpg`; "" is OpenColorIO when `$OCIO` is set, else sRGB.
        texts : mapping of str to str, optional
            Further entries of an EXR's header.
        layers : sequence of (str, str, bool), optional
            What is written: the AOV, its name in the file, whether an EXR has it as halves. Default: all, as floats.
        tileSize : (int, int)
            Width and height of the tiles of an EXR, in pixels; 0: it consists of scan lines.

        Returns
        -------
        list of str
            AOVs that the format has no room for.

        Raises
        ------
        hdstream.Error
            Names file and reason; the old file stays.
        """
        metadata = self._Metadata(texts)
        metadata.tileSize = list(tileSize)
        written = self._layers
        if layers is not None:
            byName = {layer.name: layer for layer in self._layers}
            written = []
            for aov, name, isHalf in layers:
                written.append(_core.ImageLayer(byName[aov]))
                written[-1].name, written[-1].isHalf = name, isHalf
        aovs = {name: aov for aov, name, _ in layers or ()}
        return _core.WriteImage(os.fspath(file), written, colorCorrectionMode, metadata, aovs)

    def WriteDeep(self, file: Union[str, "os.PathLike[str]"], texts: Optional[Mapping[str, str]] = None,
                  isHalf: bool = False) -> None:
        """Writes the deep picture to an `.exr`, whole or not at all.

        Parameters
        ----------
        file : str
            Of scan lines, with R, G, B, A, Z and ZBack.
        texts : mapping of str to str, optional
            Further entries of its header.
        isHalf : bool
            R, G, B and A are halves: alpha is no longer that of the flat picture to the last digit.

        Raises
        ------
        hdstream.Error
            Names file and reason; the old file stays. Also where the render had no deep picture.
        """
        if self.deep is None:
            raise _core.Error(f"cannot write '{os.fspath(file)}': the render has no deep picture (the setting deep)")
        _core.WriteDeepImage(os.fspath(file), self.deep, isHalf, self._Metadata(texts))

    def _Metadata(self, texts):
        metadata = MakeMetadata(self._settings, self._camera, self._frameTime)
        metadata.samples = self.samples
        metadata.texts = dict(texts or {})
        return metadata

    def _repr_png_(self):
        """Shown by notebooks."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "image.png")
            self.Write(file, "sRGB")
            with open(file, "rb") as stream:
                return stream.read()
