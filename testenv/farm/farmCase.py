# SPDX-License-Identifier: Apache-2.0
"""Pictures compared to the bit."""

OPTIONS = ["-w", "24", "--maxDepth", "2", "--aovs", "color,variance,depth,primId"]


def SameImages(file, reference):
    """Equal layers, to the bit."""
    from hdstream import _core
    difference = _core.CompareImages(str(file), str(reference))
    assert not difference.error, difference.error
    assert len(difference.layers) == 4
    return all(layer.numDifferingPixels == 0 for layer in difference.layers)
