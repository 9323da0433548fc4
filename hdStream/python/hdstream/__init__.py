# SPDX-License-Identifier: Apache-2.0
"""hdStream for Python: pictures of USD stages as arrays (docs/python.md), and the command line `hdstream`.

`hdstream._core` is the core (C++); `hdstream.translate` fills its Session from a UsdStage. Importing this package
imports neither, so that `hdstream --help` answers at once: the names below are found when they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hdstream import bundle as _bundle

if TYPE_CHECKING:
    from hdstream._core import Error, FilmSums, UsageError
    from hdstream.renderer import Image, Progress, Render, Renderer, RenderWarning

__all__ = ["Error", "FilmSums", "Image", "Progress", "Render", "RenderWarning", "Renderer", "UsageError"]
_OF_CORE = ("Error", "FilmSums", "UsageError")
_bundle.Prepare()


def __getattr__(name):
    if name not in __all__:
        raise AttributeError(f"module 'hdstream' has no attribute '{name}'")
    from importlib import import_module
    return getattr(import_module("hdstream._core" if name in _OF_CORE else "hdstream.renderer"), name)


def __dir__():
    return sorted([*globals(), *__all__])
