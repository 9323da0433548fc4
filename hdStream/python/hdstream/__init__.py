# SPDX-License-Identifier: Apache-2.0
"""hdStream for Python: the command line `hdstream` and the translation of USD stages.

`hdstream._core` is the core (C++); `hdstream.translate` fills its Session from a UsdStage.
Importing this package imports neither, so that `hdstream --help` answers at once.
"""
