# SPDX-License-Identifier: Apache-2.0
"""Pictures for docs/gallery.md, made from formulas: one module a stage, each with `Write(folder, size)`, which writes
`stage.usdc` and its images into the folder. `size` from 0 to 1 scales what there is much of; 1 is the gallery's.
"""
