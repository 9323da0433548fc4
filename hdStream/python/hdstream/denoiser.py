# SPDX-License-Identifier: Apache-2.0
"""Where Open Image Denoise is: in the package pyoidn, else where the system's loader looks."""

import importlib.util
import pathlib

from hdstream import _core

_LIBRARY = "oidn/lib/libOpenImageDenoise.so.2"


def FindDenoiser():
    """Lets the core find Open Image Denoise. Nothing is imported or loaded. Any thread."""
    package = importlib.util.find_spec("pyoidn")
    for folder in package.submodule_search_locations or () if package else ():
        if (pathlib.Path(folder) / _LIBRARY).exists():
            _core.AddDenoiserLibrary(str(pathlib.Path(folder) / _LIBRARY))
