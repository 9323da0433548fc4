# SPDX-License-Identifier: Apache-2.0
"""Materials of surface models with random inputs, as MaterialX documents: nobody has tuned them.

A lobe is there by chance, and what it has then is drawn from the range that artists use. Each material is a function of the
seed, its model and its number alone.
"""

import MaterialX as mx
import numpy as np

from . import surfaceGraphs

_COLOR = "color"


def _Lobe(chance, **inputs):
    """Inputs that a material has together, by a chance: ranges, a color, or a tuple of values to choose from."""
    return chance, inputs


# Each input: (least, most), a color, or [values].
MODELS = {
    "standard_surface": [
        _Lobe(1.0, base=(0.5, 1.0), base_color=_COLOR, specular=(0.3, 1.0), specular_roughness=(0.15, 0.8), specular_IOR=(1.2, 2.0)),
        _Lobe(0.4, diffuse_roughness=(0.0, 1.0)),
        _Lobe(0.35, specular_color=_COLOR),
        _Lobe(0.35, metalness=[0.3, 0.7, 1.0]),
        _Lobe(0.25, specular_anisotropy=(0.2, 0.8), specular_rotation=(0.0, 1.0)),
        _Lobe(0.3, transmission=(0.2, 1.0), transmission_color=_COLOR),
        _Lobe(0.15, transmission_depth=(0.3, 2.0)),
        _Lobe(0.15, transmission_depth=(0.3, 2.0), transmission_scatter=_COLOR, transmission_scatter_anisotropy=(-0.5, 0.8)),
        _Lobe(0.35, subsurface=(0.2, 1.0), subsurface_color=_COLOR, subsurface_radius=_COLOR, subsurface_scale=(0.05, 0.4),
              subsurface_anisotropy=(-0.3, 0.6)),
        _Lobe(0.35, sheen=(0.2, 1.0), sheen_color=_COLOR, sheen_roughness=(0.1, 0.8)),
        _Lobe(0.45, coat=(0.2, 1.0), coat_color=_COLOR, coat_roughness=(0.05, 0.5), coat_IOR=(1.2, 1.9)),
        _Lobe(0.2, coat_anisotropy=(0.2, 0.8), coat_rotation=(0.0, 1.0)),
        _Lobe(0.2, coat_affect_color=(0.0, 1.0), coat_affect_roughness=(0.0, 1.0)),
        _Lobe(0.25, thin_film_thickness=(100.0, 900.0), thin_film_IOR=(1.2, 2.0)),
        _Lobe(0.2, emission=(0.1, 1.0), emission_color=_COLOR),
        _Lobe(0.1, opacity=_COLOR),
        _Lobe(0.1, thin_walled=[True]),
    ],
    "open_pbr_surface": [
        _Lobe(1.0, base_weight=(0.5, 1.0), base_color=_COLOR, specular_weight=(0.3, 1.0), specular_roughness=(0.15, 0.8),
              specular_ior=(1.2, 2.0)),
        _Lobe(0.4, base_diffuse_roughness=(0.0, 1.0)),
        _Lobe(0.35, specular_color=_COLOR),
        _Lobe(0.35, base_metalness=[0.3, 0.7, 1.0]),
        _Lobe(0.25, specular_roughness_anisotropy=(0.2, 0.8)),
        _Lobe(0.3, transmission_weight=(0.2, 1.0), transmission_color=_COLOR),
        _Lobe(0.15, transmission_depth=(0.3, 2.0)),
        _Lobe(0.15, transmission_depth=(0.3, 2.0), transmission_scatter=_COLOR, transmission_scatter_anisotropy=(-0.5, 0.8)),
        _Lobe(0.35, subsurface_weight=(0.2, 1.0), subsurface_color=_COLOR, subsurface_radius=(0.05, 0.4),
              subsurface_radius_scale=_COLOR, subsurface_scatter_anisotropy=(-0.3, 0.6)),
        _Lobe(0.35, fuzz_weight=(0.2, 1.0), fuzz_color=_COLOR, fuzz_roughness=(0.1, 0.9)),
        _Lobe(0.45, coat_weight=(0.2, 1.0), coat_color=_COLOR, coat_roughness=(0.05, 0.5), coat_ior=(1.2, 1.9), coat_darkening=(0.0, 1.0)),
        _Lobe(0.2, coat_roughness_anisotropy=(0.2, 0.8)),
        _Lobe(0.25, thin_film_weight=(0.3, 1.0), thin_film_thickness=(0.1, 0.9), thin_film_ior=(1.2, 2.0)),
        _Lobe(0.2, emission_luminance=(0.1, 1.0), emission_color=_COLOR),
        _Lobe(0.1, geometry_opacity=(0.3, 0.9)),
        _Lobe(0.1, geometry_thin_walled=[True]),
    ],
    "gltf_pbr": [
        _Lobe(1.0, base_color=_COLOR, metallic=[0.0, 0.0, 0.5, 1.0], roughness=(0.15, 0.9), ior=(1.2, 2.0), specular=(0.3, 1.0)),
        _Lobe(0.35, specular_color=_COLOR),
        _Lobe(0.35, sheen_color=_COLOR, sheen_roughness=(0.1, 0.8)),
        _Lobe(0.45, clearcoat=(0.2, 1.0), clearcoat_roughness=(0.05, 0.5)),
        _Lobe(0.25, anisotropy_strength=(0.2, 0.8), anisotropy_rotation=(0.0, 6.0)),
        _Lobe(0.25, iridescence=(0.3, 1.0), iridescence_ior=(1.2, 2.0), iridescence_thickness=(100.0, 900.0)),
        _Lobe(0.2, emissive=_COLOR, emissive_strength=(0.1, 1.0)),
        _Lobe(0.1, alpha=(0.3, 0.9), alpha_mode=[2]),
    ],
    "disney_principled": [
        _Lobe(1.0, baseColor=_COLOR, metallic=[0.0, 0.0, 0.5, 1.0], roughness=(0.2, 0.9), specular=(0.2, 1.0), ior=(1.2, 2.0)),
        _Lobe(0.35, specularTint=(0.0, 1.0)),
        _Lobe(0.25, anisotropic=(0.2, 0.8)),
        _Lobe(0.35, sheen=(0.2, 1.0), sheenTint=(0.0, 1.0)),
        _Lobe(0.45, clearcoat=(0.2, 1.0), clearcoatGloss=(0.3, 1.0)),
        _Lobe(0.3, specTrans=(0.2, 1.0)),
        _Lobe(0.35, subsurface=(0.2, 1.0), subsurfaceDistance=_COLOR),
    ],
    # Opaque: what is behind would show.
    "UsdPreviewSurface": [
        _Lobe(1.0, diffuseColor=_COLOR, metallic=[0.0, 0.0, 0.5, 1.0], roughness=(0.15, 0.9), ior=(1.2, 2.0)),
        _Lobe(0.3, useSpecularWorkflow=[1], specularColor=_COLOR),
        _Lobe(0.45, clearcoat=(0.2, 1.0), clearcoatRoughness=(0.05, 0.5)),
        _Lobe(0.2, emissiveColor=_COLOR),
    ],
}


def Inputs(model: str, seed: int, index: int) -> dict:
    """{input: value} of a material: floats, booleans, integers and triples."""
    rng = np.random.default_rng([seed, sorted(MODELS, key=str.lower).index(model), index])
    found = {}
    for chance, inputs in MODELS[model]:
        isThere = rng.random() < chance
        for name, values in inputs.items():
            if values == _COLOR:
                value = tuple(float(round(v, 3)) for v in rng.uniform(0.05, 0.95, 3))
            elif isinstance(values, list):
                value = values[rng.integers(len(values))]
            else:
                value = float(round(rng.uniform(*values), 3))
            if isThere:
                found[name] = value
    return found


def Document(model: str, inputs: dict):
    """A document with one material, "Look"."""
    document = surfaceGraphs.NewDocument()
    surface = document.addNode(model, "Surface", "surfaceshader")
    definition = surface.getNodeDef()
    for name, value in inputs.items():
        kind = definition.getActiveInput(name).getType()
        if kind in ("color3", "vector3"):
            value = (mx.Color3 if kind == "color3" else mx.Vector3)(*value)
        surface.setInputValue(name, value, kind)
    document.addMaterialNode("Look", surface)
    return document
