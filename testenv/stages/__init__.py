# SPDX-License-Identifier: Apache-2.0
"""Generators of hdStream's own stages: the demo, the verification cases and the bench scenes.

Everything is procedural and deterministic; usd-core and numpy are the only requirements. Run as
`python testenv/stages NAME OUT.usdc` or import as `stages` with testenv/ on sys.path.
Explained in docs/verification.md.
"""
