# SPDX-License-Identifier: Apache-2.0
"""Which of Blender's passes come from which outputs of the plug-in. docs/blender.md says how each compares with Cycles'."""

from typing import NamedTuple


class Pass(NamedTuple):
    name: str  # Blender's
    channels: str
    kind: str  # of the compositor's socket
    output: str  # of the plug-in
    isBuiltIn: bool  # Blender makes it by itself where its switch is on


_COMBINED = Pass("Combined", "RGBA", "COLOR", "color", True)
_BY_SWITCH = {
    "use_pass_z": Pass("Depth", "Z", "VALUE", "cameraDepth", True),
    "use_pass_position": Pass("Position", "XYZ", "VECTOR", "position", True),
    "use_pass_normal": Pass("Normal", "XYZ", "VECTOR", "normal", True),
    "use_pass_uv": Pass("UV", "UVA", "VECTOR", "primvars_st", True),
}
SWITCHES = tuple(_BY_SWITCH)
_DENOISING = (
    Pass("Denoising Normal", "XYZ", "VECTOR", "Neye", False),
    Pass("Denoising Albedo", "RGB", "COLOR", "albedo", False),
)
_NOISY = Pass("Noisy Image", "RGBA", "COLOR", "noisy", False)
_FAR = 1e10  # Cycles' depth where nothing is hit; ours is infinite


def Of(scene, layer):
    """The passes of a view layer."""
    passes = [_COMBINED] + [item for switch, item in _BY_SWITCH.items() if getattr(layer, switch)]
    if layer.hdstream.use_denoising_data:
        passes += _DENOISING
        if scene.hdstream.final.denoise:
            passes.append(_NOISY)
    return passes


def Finish(layer):
    """Makes of what the plug-in has written in a layer of the result what Blender expects there."""
    import numpy as np

    for item in layer.passes:
        if item.name not in ("Depth", "Denoising Normal", "UV"):
            continue
        pixels = np.empty((len(item.rect), item.channels), np.float32)
        item.rect.foreach_get(pixels.reshape(-1))
        if item.name == "UV":
            pixels[:, 2] = (pixels[:, :2] != 0.0).any(1)  # its third channel is coverage
        elif item.name == "Denoising Normal":
            pixels[:, 2] *= -1.0  # Cycles' camera looks along +Z
        else:
            pixels[np.isinf(pixels)] = _FAR
        item.rect.foreach_set(pixels.reshape(-1))
