# SPDX-License-Identifier: Apache-2.0
"""One fibre under a light, column by column, by Mitsuba 3's BSDF `hair`: `python testenv/render/hairMitsuba.py` writes
hairMitsuba.json beside it, with a Python that has Mitsuba.

Roughness is chosen so that Mitsuba's series of the Bessel function is good to 0.4 %, which it is not near an argument of 12, and
that no variance is above 1, where MaterialX's are clamped.
"""

import json
import pathlib
import tempfile

import numpy as np

FILE = pathlib.Path(__file__).with_suffix(".json")
COLUMNS = 8
ABSORPTION, IOR, CUTICLE = (0.1, 0.5, 2.0), 1.45, 3.0  # degrees
ROUGHNESS = {"smooth": (0.2, 0.25), "rough": (0.4, 0.6)}
TILTS = (0.0, -10.0)  # degrees of the fibre, from y towards the camera
LIGHTS = {"front": (-10.0, 30.0), "side": (5.0, 80.0), "back": (-12.0, 165.0), "sky": None}  # rotations about x and y, degrees


def Cases() -> dict:
    return {f"{name}_{light}_{tilt:g}": (ROUGHNESS[name], tilt, LIGHTS[light]) for name in ROUGHNESS for light in LIGHTS for tilt in TILTS}


def Columns(roughness, tilt, light, samples=1 << 14) -> np.ndarray:
    """Means of the columns [COLUMNS][3] of a fibre as wide as the picture."""
    import mitsuba as mi

    along = np.array([0.0, np.cos(np.radians(tilt)), np.sin(np.radians(tilt))])
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.writelines("{} {} {} 0.5\n".format(*(step * along)) for step in np.linspace(-20, 20, 8))
        file.flush()
        if light is None:
            emitter = {"type": "constant", "radiance": {"type": "rgb", "value": [1, 1, 1]}}
        else:
            x, y = np.radians(light)
            direction = [-np.cos(x) * np.sin(y), np.sin(x), -np.cos(x) * np.cos(y)]
            emitter = {"type": "directional", "direction": direction, "irradiance": {"type": "rgb", "value": [1, 1, 1]}}
        view = mi.ScalarTransform4f().look_at(origin=[0, 0, 40], target=[0, 0, 0], up=[0, 1, 0])
        scene = mi.load_dict({
            "type": "scene", "light": emitter, "integrator": {"type": "path", "max_depth": 2, "hide_emitters": True},
            "sensor": {"type": "orthographic", "to_world": view @ mi.ScalarTransform4f().scale([0.5, 0.5, 1]),
                       "sampler": {"type": "multijitter"},
                       "film": {"type": "hdrfilm", "width": COLUMNS, "height": COLUMNS, "rfilter": {"type": "box"}, "pixel_format": "rgb",
                                "component_format": "float32"}},
            "fibre": {"type": "bsplinecurve", "filename": file.name,
                      "bsdf": {"type": "hair", "longitudinal_roughness": roughness[0], "azimuthal_roughness": roughness[1],
                               "scale_tilt": CUTICLE, "int_ior": IOR, "sigma_a": {"type": "rgb", "value": list(ABSORPTION)}}}})
        return np.array(mi.render(scene, spp=samples), np.float64).mean(0)


def UseMitsuba() -> None:
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")


if __name__ == "__main__":
    UseMitsuba()
    values = {name: np.round(Columns(*case), 5).tolist() for name, case in Cases().items()}
    FILE.write_text(json.dumps(values, indent=0).replace("\n", " ").replace("] ] ]", "]]]") + "\n")
