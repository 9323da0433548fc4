# SPDX-License-Identifier: Apache-2.0
"""The sections of docs/performance.md, a module each: `Run(bench)` measures and returns what its block shows (run.py)."""
