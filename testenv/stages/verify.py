# SPDX-License-Identifier: Apache-2.0
"""All verification cases, by name."""

from . import cameraCases, geometryCases, lightCases, materialCases  # noqa: F401  (they register)
from .cases import CASES, Case

__all__ = ["CASES", "Case"]
