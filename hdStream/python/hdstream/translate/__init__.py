# SPDX-License-Identifier: Apache-2.0
"""A USD stage as the core's scene: names and types are translated, nothing is interpreted.

Triangulation, normals, subdivision, instancing, shading and light units are the core's work, so
that this front end and the Hydra plug-in give the same scene.
"""

from hdstream.translate.stageTranslator import StageTranslator, TranslateStage

__all__ = ["StageTranslator", "TranslateStage"]
